"""Progress of a solve as its caller gets it, and the reporter that methods of solution call.

A method calls the one function of :class:`Reporter` for its kind of step, such as `iteration` or `time`.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from math import isfinite, log
from typing import TYPE_CHECKING

import numpy as np

from contactstudy.domain.grid import Array, Grid, cells_text
from contactstudy.problem.problem import Problem

if TYPE_CHECKING:
    from contactstudy.lubrication.pseudo_time import FilmIteration
    from contactstudy.solvers.solution import Solution


@dataclass(frozen=True)
class Progress:
    """Progress of a solve.

    Attributes
    ----------
    fraction
        Fraction of the solve that is done, from 0 to 1. A solve on several grids may count it anew on each of them.
    text
        What has been reached, in words.
    pressure
        Latest pressure (x, y) [Pa] of a static contact, to start again from; None for others.
    grid
        Grid of that pressure; None for others.
    """

    fraction: float
    text: str
    pressure: Array | None = None
    grid: Grid | None = None


@dataclass
class Reporter:
    """Reporter that turns what each method reports into :class:`Progress`.

    Parameters
    ----------
    report
        Function that gets the progress.
    target
        Residual at which the method stops, for `iteration` and `film_step`, or relative error in L1 that a refinement
        has to reach, for `grid`.
    problem
        Problem whose iterations `iteration` reports; None for other methods.
    """

    report: Callable[[Progress], object]
    target: float = 0.0
    problem: Problem | None = None
    first_residual: float = field(default=0.0, init=False)  # 0 until one is reported

    def iteration(self, residual: float, pressure: Array) -> None:
        """Report the residual and the dimensionless pressure (x, y) after an iteration of one static contact."""
        assert self.problem is not None
        text = f"residual {residual:.1e} of {self.target:.1e}"
        dimensional = np.array(pressure, dtype=np.float64) * self.problem.scales.pressure
        self.report(Progress(self._fallen(residual, self.target), text, dimensional, self.problem.grid))

    def grid(self, solution: "Solution", bound: float) -> None:
        """Report the solution on one grid of a refinement, and the bound of its relative error in L1."""
        grid = solution.problem.grid
        text = f"{cells_text(grid.cells)}: {100 * bound:.2g} % in L1"
        self.report(Progress(min(self.target / bound, 1.0), text, solution.pressure, grid))

    def bounds(self, grid: Grid, pressure: Array | None) -> None:
        """Report that the outputs and the bounds of an answer are computed, on its grid and on coarser ones."""
        text = f"{cells_text(grid.cells)} solved: outputs and bounds, by 1/2, 1/3 and 1/4 of them along each axis"
        self.report(Progress(1.0, text, pressure, grid))

    def change(self, change: float, allowed: float) -> None:
        """Report the change of the gap, over its scale, in an outer iteration, and the one at which they stop."""
        text = f"change of the gap {change:.1e} of {allowed:.1e}"
        self.report(Progress(self._fallen(change, allowed), text))

    def passes(self, done: float, passes: int) -> None:
        """Report how many passes of a rolling contact are done, of all `passes`."""
        self.report(Progress(done / passes, f"{done:.3g} of {passes} passes"))

    def time(self, done: float, whole: float) -> None:
        """Report the time that is computed, from the start, and the time at the end of the evolution [s]."""
        self.report(Progress(done / whole if whole else 1.0, f"{done:.3g} s of {whole:.3g} s"))

    def film_step(self, last: "FilmIteration") -> None:
        """Report the iteration of a steady film after one of its steps."""
        if last.iterations == 1:  # a film on another grid begins
            self.first_residual = 0.0
        text = f"{cells_text(last.film.pressure.shape)}: residual {last.residual:.1e} of {self.target:.1e}"
        self.report(Progress(self._fallen(last.residual, self.target), text))

    def _fallen(self, residual: float, target: float) -> float:
        """Return the fraction, in logarithms, that a residual has fallen from the first one to its target."""
        if not isfinite(residual) or residual <= 0:
            return float(residual == 0)
        # at least ten times the target, so that the fraction is defined where the first residual is below the target
        first = self.first_residual = self.first_residual or max(residual, 10 * target)
        return min(max(log(first / residual) / log(first / target), 0.0), 1.0)
