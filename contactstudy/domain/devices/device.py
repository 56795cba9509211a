"""Where a problem is solved: on cores of this machine, or wherever an array library keeps its arrays."""

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from importlib.util import find_spec
from typing import Any, Protocol, cast, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from contactstudy.domain.checks import InvalidInput, set_fields, whole
from contactstudy.domain.devices.namespace import Namespace
from contactstudy.domain.memory import available_bytes

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
        """The same array."""
        return field

    def take(self, field: Numbers) -> Numbers:
        """The same array."""
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
# From so many cells on, compiled passes save more in a few solves than it takes to load them.
LARGE = 2**18
ONE_THREAD = Cpu()
_DEVICE: ContextVar[Device] = ContextVar("device", default=ONE_THREAD)
_FUSED: ContextVar[Any] = ContextVar("fused", default=None)


def checked(chosen: Device, field: str) -> Device:
    """``chosen``, if it is a device; else :class:`~contactstudy.InvalidInput`."""
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
    """How many threads share the work on numpy's arrays."""
    chosen = _DEVICE.get()
    return chosen.threads if isinstance(chosen, Cpu) else 1


def fused() -> Any:
    """Compiled passes over fields, :mod:`~contactstudy.domain.devices.fused`; None where there are none or none pay."""
    return _FUSED.get()


@cache
def _compiled() -> Any:
    if find_spec("numba") is None:
        return None
    # either of a numba for another numpy, or without a folder to keep what is compiled
    with suppress(ImportError, RuntimeError):
        return import_module("contactstudy.domain.devices.fused")
    return None


@contextmanager
def using(chosen: Device, cells: int = 0) -> Iterator[None]:
    """Work on the ``chosen`` device, with compiled passes where fields have so many ``cells`` that they pay."""
    pays = isinstance(checked(chosen, "solve.on"), Cpu) and cells >= LARGE
    token, passes = _DEVICE.set(chosen), _FUSED.set(_compiled() if pays else None)
    try:
        yield
    finally:
        _FUSED.reset(passes)
        _DEVICE.reset(token)
