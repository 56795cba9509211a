"""Devices and precision of a solve: the cores of this machine, a GPU, or your own; and a cache of arrays on them.

A solve uses one device, and its functions call :func:`arrays` for the array library of that device: numpy's own on a
:class:`Cpu`, else one that follows the array API standard. Device, library and cache in use are context variables, so
that solves in several threads do not meet.
"""

from collections import OrderedDict
from collections.abc import Callable, Hashable, Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from dataclasses import dataclass
from enum import Enum
from importlib import import_module
from math import inf
from pathlib import Path
from threading import Lock
from types import SimpleNamespace
from typing import Annotated, Any, Protocol, cast, runtime_checkable

import numpy as np
from numpy.typing import DTypeLike, NDArray

from contactstudy.domain.validation import InvalidInput, at_least, validated

# Type of a field of floats. During a solve such a field is an array of the library of the device in use.
Array = NDArray[np.floating[Any]]
# Type of an array of any numbers, floats, complex ones, integers or booleans.
Numbers = NDArray[Any]


class Namespace(Protocol):
    """Functions of the array API standard (https://data-apis.org/array-api/2024.12), which numpy follows."""

    float64: Any
    finfo: Callable[..., Any]
    fft: Any

    def __getattr__(self, name: str) -> Callable[..., Array]:
        """Return a function of the standard."""


class Precision(Enum):
    """Floating-point precision of a solve.

    SINGLE has about 7 digits and takes half the memory; DOUBLE has about 16. The residual cannot fall far below the
    rounding of either. Influence coefficients are computed in double precision for both, and rounded once.
    """

    SINGLE = "single"
    DOUBLE = "double"

    @property
    def real(self) -> DTypeLike:
        """Type of the numbers in numpy's arrays."""
        return np.float32 if self is Precision.SINGLE else np.float64

    @property
    def on_device(self) -> Any:
        """Type of the numbers in arrays of the device in use."""
        return getattr(arrays(), np.dtype(self.real).name)

    @property
    def bytes(self) -> int:
        """Size of a number [bytes]."""
        return np.dtype(self.real).itemsize


@runtime_checkable
class Device(Protocol):
    """Device with an array library that follows the array API standard, and copies of arrays to it and back."""

    @property
    def arrays(self) -> Namespace:
        """Functions of the library."""

    @property
    def available_bytes(self) -> float:
        """Memory left on the device [bytes]."""

    def to_device(self, field: Numbers) -> Numbers:
        """Return a numpy array as an array of the library."""

    def to_numpy(self, field: Numbers) -> Numbers:
        """Return an array of the library as a numpy array."""


@validated
class Cpu:
    """Processor of this machine.

    Parameters
    ----------
    threads
        Number of threads that share the work, at least 1. Answers differ by the rounding of transforms alone.

    Raises
    ------
    InvalidInput
        If the number of threads is not a whole number of at least 1.
    """

    threads: Annotated[int, at_least(1)] = 1

    @property
    def arrays(self) -> Namespace:
        """Functions of numpy."""
        return _NUMPY

    @property
    def available_bytes(self) -> float:
        """Memory left on this machine [bytes]."""
        return available_bytes()

    def to_device(self, field: Numbers) -> Numbers:
        """Return the array as it is."""
        return field

    def to_numpy(self, field: Numbers) -> Numbers:
        """Return the array as it is."""
        return field


# Functions of numpy for which its arrays have methods. The methods return what the functions of the same names do, in
# half the time on a small field.
_METHODS = "all", "any", "astype", "max", "min", "repeat", "reshape", "sum", "take"
_NUMPY = cast(Namespace, SimpleNamespace(**vars(np) | {name: getattr(np.ndarray, name) for name in _METHODS}))
ONE_THREAD = Cpu()
_DEVICE: ContextVar[Device] = ContextVar("device", default=ONE_THREAD)
_ARRAYS: ContextVar[Namespace] = ContextVar("arrays", default=_NUMPY)
# Returns the functions of the array library of the device in use, without the cost of a function of Python.
arrays = _ARRAYS.get


def checked(chosen: Device, field: str) -> Device:
    """Return the `chosen` device; raise InvalidInput, which names the `field`, for what is no device."""
    if isinstance(chosen, Cpu):  # a check of its protocol takes as long as a small solve
        return chosen
    if isinstance(chosen, type) or not isinstance(chosen, Device):
        raise InvalidInput(f"{field} is {chosen!r}: give Cpu(threads=2) or Gpu(), or leave it out.")
    return chosen


def device() -> Device:
    """Return the device that the solve around this call was given."""
    return _DEVICE.get()


def threads() -> int:
    """Return the number of threads that share the work on numpy's arrays."""
    chosen = _DEVICE.get()
    return chosen.threads if isinstance(chosen, Cpu) else 1


@contextmanager
def using(chosen: Device) -> Iterator[None]:
    """Use the `chosen` device inside a ``with`` block."""
    token, library = _DEVICE.set(checked(chosen, "solve.device")), _ARRAYS.set(chosen.arrays)
    try:
        yield
    finally:
        _DEVICE.reset(token)
        _ARRAYS.reset(library)


@dataclass(frozen=True)
class Gpu:
    """GPU of this machine, through CuPy (extra ``gpu``).

    Influence coefficients are computed on the CPU in double precision and copied once; a solution's fields are
    numpy arrays. Of several GPUs it is CuPy's current one.

    Raises
    ------
    InvalidInput
        If there is no GPU, or no CuPy.
    """

    def __post_init__(self) -> None:
        try:
            _ = self.arrays
            count = _cupy().cuda.runtime.getDeviceCount()
        except ImportError as missing:
            raise InvalidInput(
                f"Gpu needs CuPy, which cannot be imported ({missing}): pip install 'contactstudy[gpu]', or give Cpu()."
            ) from missing
        except _cupy().cuda.runtime.CUDARuntimeError as failed:
            raise InvalidInput(f"Gpu found no GPU ({failed}): give Cpu().") from failed
        if count == 0:
            raise InvalidInput("Gpu found no GPU: give Cpu().")

    @property
    def loops(self) -> Any:
        """Kernels that :func:`~contactstudy.domain.grid.device_loops` returns; devices without any use their arrays."""
        return import_module("contactstudy.domain.loops.gpu").LOOPS

    @property
    def arrays(self) -> Namespace:
        """Functions of CuPy, with the names of the array API standard."""
        namespace: Namespace = import_module("array_api_compat.cupy")
        return namespace

    def to_device(self, field: Numbers) -> Numbers:
        """Return a numpy array copied to the GPU."""
        array: Numbers = _cupy().asarray(field)
        return array

    def to_numpy(self, field: Numbers) -> Numbers:
        """Return an array of the GPU as a numpy array."""
        # page-locked memory, which CuPy keeps for the next arrays: fresh pages of the host cost ten times the copy
        array: Numbers = import_module("cupyx").empty_pinned(field.shape, field.dtype)
        _cupy().asnumpy(field, out=array)
        return array

    @property
    def available_bytes(self) -> float:
        """Memory that is free on the GPU, or that CuPy keeps for the next arrays [bytes]."""
        free, _ = _cupy().cuda.runtime.memGetInfo()
        return float(free + _cupy().get_default_memory_pool().free_bytes())


def _cupy() -> Any:
    """Return CuPy, imported on first use."""
    return import_module("cupy")


# Folder in which Linux shows limits of a container (cgroup, version 2).
CGROUP = Path("/sys/fs/cgroup")


def available_bytes() -> float:
    """Return the memory that this process may still take [bytes]; infinite where the system does not say."""
    return max(min(_free_in_system(), _left_in_container(), _left_to_process()), 0.0)


def _free_in_system() -> float:
    """Return free memory and swap [bytes]; infinite where neither Linux nor the package psutil says them."""
    with suppress(OSError, ValueError, IndexError, KeyError):
        lines = Path("/proc/meminfo").read_text(encoding="utf-8").splitlines()
        amounts = {name: amount.split() for name, _, amount in (line.partition(":") for line in lines)}
        return 1024 * sum(float(amounts[name][0]) for name in ("MemAvailable", "SwapFree"))
    with suppress(ImportError, OSError):
        psutil = import_module("psutil")
        return float(psutil.virtual_memory().available + psutil.swap_memory().free)
    return inf


def _left_in_container() -> float:
    """Return the memory left in a container [bytes]; infinite where there is no limit.

    Pages of files that were not read lately count as free: the system takes them back when memory is short.
    """
    with suppress(OSError, ValueError):
        limit, used, statistics = (
            (CGROUP / f"memory.{name}").read_text(encoding="utf-8") for name in ("max", "current", "stat")
        )
        amounts = dict(line.split() for line in statistics.splitlines())
        return float(limit) - float(used) + float(amounts.get("inactive_file", 0))
    return inf


def _left_to_process() -> float:
    """Return the memory [bytes] left below the limit of the address space; infinite without a limit."""
    with suppress(ImportError, OSError, ValueError, IndexError):
        resource = import_module("resource")
        soft, _ = resource.getrlimit(resource.RLIMIT_AS)
        if soft != resource.RLIM_INFINITY:
            pages = int(Path("/proc/self/statm").read_text(encoding="utf-8").split()[0])
            return float(soft - pages * resource.getpagesize())
    return inf


class ArrayCache:
    """Cache of arrays by the values that they follow from: of all, the ones used last, up to a number of bytes.

    Parameters
    ----------
    max_bytes
        Largest size of all arrays together [bytes].
    """

    def __init__(self, max_bytes: int) -> None:
        self.max_bytes, self._lock = max_bytes, Lock()
        self._arrays: OrderedDict[Hashable, Numbers] = OrderedDict()

    def array(self, key: Hashable, compute: Callable[[], Numbers]) -> Numbers:
        """Return the array stored for an equal `key`, or that of `compute`, which is stored as read-only."""
        with self._lock:
            if key in self._arrays:
                self._arrays.move_to_end(key)
                return self._arrays[key]
        array = compute()
        if array.nbytes <= self.max_bytes:
            array.flags.writeable = False
            with self._lock:
                self._arrays[key] = array
                while sum(kept.nbytes for kept in self._arrays.values()) > self.max_bytes:
                    self._arrays.popitem(last=False)
        return array


# The default cache, of the size of the coefficients of 700 x 700 cells that are periodic along their length, which loads
# on one grid share. The solve of a larger grid takes long beside its coefficients.
_SMALL = ArrayCache(2**22)
_CACHE: ContextVar[ArrayCache | None] = ContextVar("array_cache", default=_SMALL)


def cache_of(size: int) -> ArrayCache:
    """Return the cache in use, or a new one of `size` [bytes] if the one in use is smaller or there is none."""
    cache = _CACHE.get()
    return cache if cache is not None and cache.max_bytes >= size else ArrayCache(size)


@contextmanager
def caching(cache: ArrayCache | None) -> Iterator[None]:
    """Take equal arrays from `cache` within a ``with`` block; None recomputes all of them."""
    token = _CACHE.set(cache)
    try:
        yield
    finally:
        _CACHE.reset(token)


def cached_array(key: Hashable, compute: Callable[[], Numbers]) -> Numbers:
    """Return the array stored for an equal `key` in the cache in use, else that of `compute`.

    The key holds all that the array depends on. The array must not be changed.
    """
    cache = _CACHE.get()
    return compute() if cache is None else cache.array(key, compute)
