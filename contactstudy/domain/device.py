"""Where a problem is solved: on cores of this machine."""

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass

from contactstudy.domain.checks import InvalidInput, set_fields, whole


@dataclass(frozen=True)
class Cpu:
    """So many ``threads`` of this machine's processor. An answer does not depend on their number."""

    threads: int = 1

    def __post_init__(self) -> None:
        threads = whole("Cpu.threads", self.threads, 1, "give a whole number of threads from 1 on")
        set_fields(self, threads=threads)


ONE_THREAD = Cpu()
_DEVICE: ContextVar[Cpu] = ContextVar("device", default=ONE_THREAD)


def device() -> Cpu:
    """The device that the solve around this call was given."""
    return _DEVICE.get()


@contextmanager
def using(chosen: Cpu) -> Iterator[None]:
    """Work on the ``chosen`` device."""
    if not isinstance(chosen, Cpu):
        raise InvalidInput(f"solve.on is {chosen!r}: give Cpu(threads=2), or leave it out.")
    token = _DEVICE.set(chosen)
    try:
        yield
    finally:
        _DEVICE.reset(token)
