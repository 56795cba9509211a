"""The result of a solve: fields, and a status that says how far they can be trusted."""

from dataclasses import dataclass
from enum import Enum
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from contactstudy.domain.checks import NotDefined
from contactstudy.domain.fields import Array
from contactstudy.domain.imports import presentation
from contactstudy.problem.problem import Problem

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


class Status(Enum):
    """The outcome of a solve; ``str(status)`` is a sentence with cause and remedy."""

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
    NOT_CONVERGED = (
        "pressure and plastic strain did not settle together to the tolerance, as far as the residual says: "
        "give shorter steps in load, or a larger tolerance"
    )
    YIELD_AT_EDGE = (
        "converged, but plastic strain reaches the edge of the width and is cut off there: "
        "give Grid.extent a larger width"
    )
    NOT_FINITE = (
        "the iteration left the range of floating-point numbers: "
        "check the heights for nan and for values far beyond the contact's own scale"
    )

    def __str__(self) -> str:
        """Return name, cause and remedy as a sentence."""
        return f"{self.name}: {self.value}."


@dataclass(frozen=True, eq=False)
class Traction:
    """Shear on the first body.

    Parameters
    ----------
    shear
        Shear (component, x, y) [Pa] along x and y.
    stick
        Cells (x, y) that stick.
    method
        Method, in words.
    passes
        Number of passes or iterations it took.
    """

    shear: Array
    stick: NDArray[np.bool_]
    method: str
    passes: int


@dataclass(frozen=True, eq=False)
class Solution:
    """Solved contact: fields (x, y) and a status.

    ``gap = undeformed gap + displacement - approach`` holds to rounding, so that `gap` in the contact shows the
    remaining error of the solver.

    Parameters
    ----------
    problem
        The problem that was solved.
    pressure
        Contact pressure [Pa].
    displacement
        Normal displacement of both bodies together [m].
    gap
        Gap between the deformed bodies [m].
    approach
        Approach of the bodies [m], counted from the same datum as the displacement.
    status
        Outcome of the solve, with cause and remedy.
    iterations
        Number of iterations.
    convolutions
        Number of transform pairs of the full grid; smaller ones count in proportion.
    residual
        Dimensionless residual, see :func:`~contactstudy.solve`.
    note
        Empty, or how the solver went on after a stall.
    traction
        Shear of a scene with friction; None without.
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
    traction: Traction | None = None

    @property
    def mean_gap(self) -> float:
        """Mean gap [m] over the length that both bodies have in common."""
        lengths = self.problem.row_lengths
        return float(
            self.gap.mean()
            if lengths is None
            else np.average(self.gap.mean(axis=0), weights=lengths)
        )

    @property
    def shear(self) -> Array:
        """Shear on the first body (component, x, y) [Pa], along x and y.

        Raises
        ------
        NotDefined
            If the scene has no friction.
        """
        return self._traction.shear

    @property
    def stick(self) -> NDArray[np.bool_]:
        """Cells (x, y) in contact that stick.

        Raises
        ------
        NotDefined
            If the scene has no friction.
        """
        return self._traction.stick

    @property
    def _traction(self) -> Traction:
        """Shear of the solution; raises NotDefined without friction."""
        if self.traction is None:
            raise NotDefined(
                "This solution has no shear: give Scene.friction, such as Sliding(coefficient=0.1)."
            )
        return self.traction

    def __repr__(self) -> str:
        nx, ny = self.pressure.shape
        return (
            f"<Solution {self.status.name}: {nx} x {ny} cells, peak pressure "
            f"{self.pressure.max():.4g} Pa, {self.iterations} iterations, residual {self.residual:.1e}>"
        )

    def _repr_html_(self) -> str:
        return str(presentation("Solution in a notebook")(self))

    def to_dataset(self, *, error: Any = None) -> "xr.Dataset":
        """Return the fields as a labelled dataset, see :func:`~contactstudy.to_dataset`.

        Parameters
        ----------
        error
            An :class:`~contactstudy.ErrorEstimate` to store with the fields, or None.
        """
        dataset: xr.Dataset = presentation("Solution.to_dataset")(self, error)
        return dataset

    def plot(self) -> "Figure":
        """Return a picture of pressure, gap and stress as a matplotlib figure."""
        figure: Figure = presentation("Solution.plot")(self.to_dataset())
        return figure
