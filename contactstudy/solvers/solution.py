"""What a solver gives back: fields, and a status that says how far they can be trusted."""

from dataclasses import dataclass
from enum import Enum

from contactstudy.domain.arrays import Array
from contactstudy.problem.problem import Problem


class Status(Enum):
    """The outcome of a solve; ``str(status)`` is a sentence with the cause and the remedy."""

    CONVERGED = "the residual is below the tolerance"
    CONTACT_AT_EDGE = (
        "converged, but the contact reaches the edge of the width, or the end of a free length, and is "
        "cut off there: give Grid.extent a larger width or length"
    )
    ITERATION_LIMIT = (
        "max_iterations was reached before the tolerance: "
        "allow more iterations or a larger tolerance"
    )
    PRECISION_LIMIT = (
        "the residual is as small as rounding lets it be, and above the tolerance: "
        "give a tolerance no smaller than the residual reached, or solve in double precision"
    )
    STALLED = (
        "the residual stopped falling above the tolerance: give a tolerance no smaller than the "
        "residual reached, check the heights for values far beyond the contact's own scale, and the grid "
        "for cells a thousand times as long as wide or more"
    )
    NO_ADMISSIBLE_PRESSURE = (
        "the hardness everywhere would not carry the load: "
        "give a larger hardness, a smaller load or a larger width"
    )
    NOT_FINITE = (
        "the iteration left the range of floating-point numbers: "
        "check the heights for nan and for values far beyond the contact's own scale"
    )

    def __str__(self) -> str:
        return f"{self.name}: {self.value}."


@dataclass(frozen=True, eq=False)
class Solution:
    """Fields of shape (width, length): ``pressure`` [Pa], ``displacement`` [m], ``gap`` [m].

    ``gap = undeformed gap + displacement - approach`` holds to rounding, so in the contact ``gap``
    shows what the solver left over. ``approach`` [m] is counted from the same datum as the
    displacement. ``residual`` is dimensionless (see :func:`~contactstudy.solve`); ``convolutions``
    counts transform pairs of the full grid, smaller ones in proportion. ``note`` is empty, or says how
    the solver went on after a stall.
    """

    problem: Problem
    pressure: Array
    displacement: Array
    gap: Array
    approach: float
    status: Status
    iterations: int
    convolutions: float
    residual: float
    note: str = ""
