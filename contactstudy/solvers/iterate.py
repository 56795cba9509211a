"""Where an iteration stopped."""

from dataclasses import dataclass

from contactstudy.domain.arrays import Array


@dataclass(frozen=True, eq=False)
class Iterate:
    """All dimensionless; ``convolutions`` in transform pairs of the full grid, also for smaller ones.

    ``note`` is a sentence about how it went, where that was not as usual.
    """

    pressure: Array
    displacement: Array
    approach: float
    residual: float
    iterations: int
    convolutions: float
    note: str = ""


class Stall:
    """Tells when a residual has stopped falling: no new half in as many iterations as are given."""

    def __init__(self, patience: int) -> None:
        self.patience, self.best, self.since = patience, float("inf"), 0

    def sees(self, residual: float) -> bool:
        """Takes the next residual; True when it has stalled."""
        if residual < self.best / 2:
            self.best, self.since = residual, 0
        else:
            self.since += 1
        return self.since >= self.patience
