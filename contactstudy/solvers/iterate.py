"""The state in which an iteration stopped."""

from dataclasses import dataclass

from contactstudy.domain.fields import Array


@dataclass(frozen=True, eq=False)
class Iterate:
    """All dimensionless; ``convolutions`` in transform pairs of the full grid, also for smaller ones.

    ``note`` is a sentence about an unusual course of the iteration, or empty.
    """

    pressure: Array
    displacement: Array
    approach: float
    residual: float
    iterations: int
    convolutions: float
    note: str = ""


class Stall:
    """Detects a stalled residual: no halving within the given number of iterations."""

    def __init__(self, patience: int) -> None:
        self.patience, self.best, self.since = patience, float("inf"), 0

    def sees(self, residual: float) -> bool:
        """Whether the iteration has stalled, with the next residual."""
        if residual < self.best / 2:
            self.best, self.since = residual, 0
        else:
            self.since += 1
        return self.since >= self.patience
