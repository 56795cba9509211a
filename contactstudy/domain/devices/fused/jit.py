"""How passes are compiled: once for each kind of numbers, kept on disk, without Python's lock."""

from collections.abc import Callable
from typing import Any, TypeVar, cast

from numba import njit

Pass = TypeVar("Pass", bound=Callable[..., Any])

# Reordered sums; nan and inf keep their meaning.
SUMS = {"reassoc", "nsz"}


def exact(function: Pass) -> Pass:
    """In the order that is written."""
    return cast(Pass, njit(cache=True, nogil=True, error_model="numpy")(function))


def summing(function: Pass) -> Pass:
    """With sums in any order."""
    return cast(Pass, njit(cache=True, nogil=True, error_model="numpy", fastmath=SUMS)(function))
