"""The state in which an iteration stopped."""

from dataclasses import dataclass

from contactstudy.domain.fields import Array


@dataclass(frozen=True, eq=False)
class Iterate:
    """State in which an iteration stopped, dimensionless.

    Parameters
    ----------
    pressure, displacement
        Fields (x, y).
    approach
        Approach of the bodies, counted from the reference height of the problem.
    residual
        Violation of the complementarity conditions, or error of the load, see :class:`~contactstudy.SolveOptions`.
    iterations
        Number of iterations.
    convolutions
        Number of FFT convolutions of the full grid; those of smaller grids count in proportion.
    note
        Sentence about an unusual course of the iteration, or empty.
    """

    pressure: Array
    displacement: Array
    approach: float
    residual: float
    iterations: int
    convolutions: float
    note: str = ""


class Stall:
    """Detector of a stalled residual: one that is not halved within `patience` iterations."""

    def __init__(self, patience: int) -> None:
        self.patience, self.best, self.since = patience, float("inf"), 0

    def stalled(self, residual: float) -> bool:
        """Record the next `residual` and return whether the iteration has stalled."""
        if residual < self.best / 2:
            self.best, self.since = residual, 0
        else:
            self.since += 1
        return self.since >= self.patience
