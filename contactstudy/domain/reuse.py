"""Arrays kept for equal arguments, in a store that a caller opens; without one, nothing is kept."""

from collections import OrderedDict
from collections.abc import Callable, Hashable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from threading import Lock

from contactstudy.domain.device import Numbers


class ArrayStore:
    """Arrays by the values that they follow from, the last ones used, up to a number of bytes.

    Parameters
    ----------
    most_bytes
        Largest size of all arrays together [bytes].
    """

    def __init__(self, most_bytes: int) -> None:
        self.most_bytes, self._lock = most_bytes, Lock()
        self._arrays: OrderedDict[Hashable, Numbers] = OrderedDict()

    def array(self, key: Hashable, compute: Callable[[], Numbers]) -> Numbers:
        """Return the array stored for an equal `key`, or that of `compute`, which is stored as read-only."""
        with self._lock:
            if key in self._arrays:
                self._arrays.move_to_end(key)
                return self._arrays[key]
        array = compute()
        if array.nbytes <= self.most_bytes:
            array.flags.writeable = False
            with self._lock:
                self._arrays[key] = array
                while sum(stored.nbytes for stored in self._arrays.values()) > self.most_bytes:
                    self._arrays.popitem(last=False)
        return array


_STORE: ContextVar[ArrayStore | None] = ContextVar("array_store", default=None)


def open_store() -> ArrayStore | None:
    """Return the store in use, or None."""
    return _STORE.get()


@contextmanager
def reusing(store: ArrayStore | None) -> Iterator[None]:
    """Take equal arrays from `store` within a ``with`` block; None computes all of them anew."""
    token = _STORE.set(store)
    try:
        yield
    finally:
        _STORE.reset(token)


def reused(key: Hashable, compute: Callable[[], Numbers]) -> Numbers:
    """Return the array stored for an equal `key` where a store is open, else that of `compute`.

    The key holds all that the array depends on. The array must not be changed.
    """
    store = open_store()
    return compute() if store is None else store.array(key, compute)
