"""What a supervisor asks of its worker."""

from dataclasses import dataclass
from typing import Literal

from studies.engine.workers.channel import KEY

# requests come from one process only, and are addressed with this
REQUEST_KEY, REQUEST = b"\0" * KEY, -1
SETUP = -2

Task = Literal["compute", "clock"]


@dataclass(frozen=True)
class Setup:
    """The supervisor's import paths, and the ``work`` (pickled) from here on; the answer is empty, or an error."""

    path: tuple[str, ...]
    work: bytes
    key: bytes


@dataclass(frozen=True)
class Order:
    """A ``case`` (pickled) by its ``number``: to compute, or to run once against the clock.

    The answer, sealed with ``key``, is an Outcome, or a Sample or the Failure in its place. ``limit`` [s].
    """

    number: int
    case: bytes
    key: bytes
    task: Task
    limit: float | None
