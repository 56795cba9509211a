"""Where and in which numbers a problem is solved: the cores of this machine, a graphics processor, another library."""

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from enum import Enum
from importlib import import_module
from typing import Any, Protocol, cast, runtime_checkable

import numpy as np
from numpy.typing import DTypeLike, NDArray

from contactstudy.domain.checks import InvalidInput, set_fields, whole
from contactstudy.domain.memory import available_bytes

# In a solve, an array of the device's own library. Others: an array of any numbers, one of a single element.
Array = NDArray[np.floating[Any]]
Field = Any
Scalar = Any


class Transforms(Protocol):
    """The extension for Fourier transforms."""

    def rfft(self, x: Field, /, *, n: int, axis: int) -> Field: ...
    def irfft(self, x: Field, /, *, n: int, axis: int) -> Field: ...
    def fft(self, x: Field, /, *, n: int, axis: int) -> Field: ...
    def ifft(self, x: Field, /, *, axis: int) -> Field: ...


# The standard says what each does: https://data-apis.org/array-api/2024.12
# ruff: noqa: D102
class Namespace(Protocol):
    """Part of the array API standard, version 2024.12; numpy itself follows it."""

    float64: Any

    @property
    def fft(self) -> Transforms: ...

    def abs(self, x: Field, /) -> Array: ...
    def all(self, x: Field, /) -> Scalar: ...
    def any(self, x: Field, /) -> Scalar: ...
    def arange(self, start: float, /, stop: float, *, dtype: Any = None) -> Array: ...
    def argsort(self, x: Field, /, *, stable: bool) -> Field: ...
    def asarray(self, x: Field, /, *, copy: bool | None = None) -> Array: ...
    def astype(self, x: Field, dtype: Any, /, *, copy: bool = True) -> Array: ...
    def clip(self, x: Field, low: float, high: float, /) -> Array: ...
    def concat(self, arrays: list[Field], /) -> Array: ...
    def count_nonzero(self, x: Field, /) -> Scalar: ...
    def cumulative_sum(self, x: Field, /) -> Array: ...
    def diff(self, x: Field, /) -> Array: ...
    def empty(self, shape: tuple[int, ...], *, dtype: Any) -> Array: ...
    def empty_like(self, x: Field, /) -> Array: ...
    def finfo(self, dtype: Any, /) -> Any: ...
    def flip(self, x: Field, /, *, axis: int) -> Array: ...
    def full_like(self, x: Field, /, fill_value: float) -> Array: ...
    def maximum(self, x1: Field, x2: float, /) -> Array: ...
    def max(self, x: Field, /) -> Scalar: ...
    def minimum(self, x1: Field, x2: float, /) -> Array: ...
    def min(self, x: Field, /) -> Scalar: ...
    def repeat(self, x: Field, repeats: int, /, *, axis: int) -> Array: ...
    def reshape(self, x: Field, /, shape: tuple[int, ...]) -> Array: ...
    def searchsorted(self, x1: Field, x2: Field, /) -> Scalar: ...
    def sort(self, x: Field, /) -> Array: ...
    def sum(self, x: Field, /) -> Scalar: ...
    def take(self, x: Field, indices: Field, /, *, axis: int) -> Array: ...
    def vecdot(self, x1: Field, x2: Field, /) -> Array: ...
    def where(self, condition: Field, x1: Any, x2: Any, /) -> Array: ...
    def zeros_like(self, x: Field, /) -> Array: ...


class Precision(Enum):
    """Single or double precision; the residual cannot fall far below the rounding of either.

    SINGLE has about 7 digits and takes half the memory; DOUBLE has about 16. Influence coefficients are computed in
    double precision for both, and rounded once.
    """

    SINGLE = "single"
    DOUBLE = "double"

    @classmethod
    def named(cls, value: "Precision | str") -> "Precision":
        """``value``, or the precision of that name; :class:`~contactstudy.InvalidInput` for any other."""
        if isinstance(value, Precision):
            return value
        names = {member.value: member for member in cls}
        if value not in names:
            raise InvalidInput(f"precision is {value!r}: give 'single' or 'double'.")
        return names[value]

    @property
    def real(self) -> DTypeLike:
        """The type of fields."""
        return np.float32 if self is Precision.SINGLE else np.float64

    @property
    def bytes(self) -> int:
        """Size of a number [bytes]."""
        return np.dtype(self.real).itemsize


Numbers = NDArray[Any]


@runtime_checkable
class Device(Protocol):
    """An array library that follows the array API standard, and the way to its arrays and back."""

    @property
    def arrays(self) -> Namespace:
        """The functions of the library."""
        ...

    @property
    def available_bytes(self) -> float:
        """Memory that it has left [bytes]."""
        ...

    def put(self, field: Numbers) -> Numbers:
        """A numpy array there."""
        ...

    def take(self, field: Numbers) -> Numbers:
        """An array of the library as a numpy array here."""
        ...


@dataclass(frozen=True)
class Cpu:
    """So many ``threads`` of this machine's processor. An answer does not depend on their number."""

    threads: int = 1

    def __post_init__(self) -> None:
        threads = whole("Cpu.threads", self.threads, 1, "give a whole number of threads from 1 on")
        set_fields(self, threads=threads)

    @property
    def arrays(self) -> Namespace:
        """numpy."""
        return _NUMPY

    @property
    def available_bytes(self) -> float:
        """Memory of this machine."""
        return available_bytes()

    def put(self, field: Numbers) -> Numbers:
        """Return the array as it is."""
        return field

    def take(self, field: Numbers) -> Numbers:
        """Return the array as it is."""
        return field


@dataclass(frozen=True)
class Library:
    """Any library of the array API standard (2024.12) whose arrays are on this machine's processor.

    ``arrays`` is its namespace. Its arrays can be changed in place, and slices of them are views.
    """

    arrays: Namespace

    @property
    def available_bytes(self) -> float:
        """Memory of this machine."""
        return available_bytes()

    def put(self, field: Numbers) -> Numbers:
        """A copy of a numpy array."""
        return cast(Numbers, self.arrays.asarray(field, copy=True))

    def take(self, field: Numbers) -> Numbers:
        """A copy as a numpy array."""
        return np.array(np.from_dlpack(field))


_NUMPY = cast(Namespace, np)
ONE_THREAD = Cpu()
_DEVICE: ContextVar[Device] = ContextVar("device", default=ONE_THREAD)


def checked(chosen: Device, field: str) -> Device:
    """``chosen``, if it is a device; else :class:`~contactstudy.InvalidInput`."""
    if isinstance(
        chosen, Cpu
    ):  # to see whether it has all of a device's properties takes as long as a small solve
        return chosen
    if isinstance(chosen, type) or not isinstance(chosen, Device):
        raise InvalidInput(f"{field} is {chosen!r}: give Cpu(threads=2) or Gpu(), or leave it out.")
    return chosen


def device() -> Device:
    """The device that the solve around this call was given."""
    return _DEVICE.get()


def arrays() -> Namespace:
    """The functions of its array library."""
    return _DEVICE.get().arrays


def threads() -> int:
    """Number of threads that share the work on numpy's arrays."""
    chosen = _DEVICE.get()
    return chosen.threads if isinstance(chosen, Cpu) else 1


@contextmanager
def using(chosen: Device) -> Iterator[None]:
    """Work on the ``chosen`` device."""
    token = _DEVICE.set(checked(chosen, "solve.on"))
    try:
        yield
    finally:
        _DEVICE.reset(token)


@dataclass(frozen=True)
class Gpu:
    """The graphics processor of this machine, through CuPy (extra ``gpu``).

    Influence coefficients are computed on the processor in double precision and moved once; a solution's fields are
    numpy arrays. Of several graphics processors it is CuPy's current one. Raises
    :class:`~contactstudy.InvalidInput` where there is none, or no CuPy.
    """

    def __post_init__(self) -> None:
        try:
            _ = self.arrays
            count = _cupy().cuda.runtime.getDeviceCount()
        except ImportError as missing:
            raise InvalidInput(
                f"Gpu needs CuPy, which cannot be imported ({missing}): "
                "pip install 'contactstudy[gpu]', or give Cpu()."
            ) from missing
        except _cupy().cuda.runtime.CUDARuntimeError as failed:
            raise InvalidInput(
                f"Gpu found no graphics processor ({failed}): give Cpu()."
            ) from failed
        if count == 0:
            raise InvalidInput("Gpu found no graphics processor: give Cpu().")

    @property
    def arrays(self) -> Namespace:
        """CuPy, with the names of the array API standard."""
        namespace: Namespace = import_module("array_api_compat.cupy")
        return namespace

    def put(self, field: Numbers) -> Numbers:
        """A copy of a numpy array there."""
        array: Numbers = _cupy().asarray(field)
        return array

    def take(self, field: Numbers) -> Numbers:
        """A copy as a numpy array."""
        array: Numbers = _cupy().asnumpy(field)
        return array

    @property
    def available_bytes(self) -> float:
        """Memory there that is free, or that CuPy keeps for the next arrays."""
        free, _ = _cupy().cuda.runtime.memGetInfo()
        return float(free + _cupy().get_default_memory_pool().free_bytes())


def _cupy() -> Any:
    return import_module("cupy")
