"""Least-recently-used cache of arrays: a small one, or that of a caller."""

from collections import OrderedDict
from collections.abc import Callable, Hashable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from threading import Lock

from contactstudy.domain.device import Numbers


class ArrayCache:
    """Arrays by the values that they follow from, the last ones used, up to a number of bytes.

    Parameters
    ----------
    max_bytes
        Largest size of all arrays together [bytes].
    """

    def __init__(self, max_bytes: int) -> None:
        self.max_bytes, self._lock = max_bytes, Lock()
        self._arrays: OrderedDict[Hashable, Numbers] = OrderedDict()
        self._bytes = 0

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
                if key not in self._arrays:
                    self._bytes += array.nbytes
                    self._arrays[key] = array
                while self._bytes > self.max_bytes:
                    self._bytes -= self._arrays.popitem(last=False)[1].nbytes
        return array


# The coefficients of 700 x 700 cells that are periodic along their length, which loads on one grid share. Larger arrays
# take long beside them, and fresh memory costs as much as the coefficients of some thousand cells.
_SMALL = ArrayCache(2**22)
_CACHE: ContextVar[ArrayCache | None] = ContextVar("array_cache", default=_SMALL)


def cache_of(size: int) -> ArrayCache:
    """Return the cache in use, or one of this `size` [bytes] if that is smaller or there is none."""
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
