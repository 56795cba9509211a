"""Least-recently-used cache of arrays, which a caller provides; without one, nothing is kept."""

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
                while sum(stored.nbytes for stored in self._arrays.values()) > self.max_bytes:
                    self._arrays.popitem(last=False)
        return array


_CACHE: ContextVar[ArrayCache | None] = ContextVar("array_cache", default=None)


def current_cache() -> ArrayCache | None:
    """Return the cache in use, or None."""
    return _CACHE.get()


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
    cache = current_cache()
    return compute() if cache is None else cache.array(key, compute)
