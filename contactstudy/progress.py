"""Progress of a solve, and what turns the reports of each method into it."""

from collections.abc import Callable
from dataclasses import dataclass
from math import isfinite, log
from typing import TYPE_CHECKING

import numpy as np

from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid, cells_text
from contactstudy.problem.problem import Problem

if TYPE_CHECKING:
    from contactstudy.lubrication.newton.pseudo_time import FilmIteration
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


Report = Callable[[Progress], object]


def of_iterations(report: Report, problem: Problem, tolerance: float) -> Callable[[float, Array], None]:
    """Return a function of residual and dimensionless pressure (x, y), for the iterations of one contact."""
    fraction = fraction_of_fall()

    def report_residual(residual: float, pressure: Array) -> None:
        text = f"residual {residual:.1e} of {tolerance:.1e}"
        field = np.array(pressure, dtype=np.float64) * problem.scales.pressure
        report(Progress(fraction(residual, tolerance), text, field, problem.grid))

    return report_residual


def of_grids(report: Report, error: float) -> "Callable[[Solution, float], None]":
    """Return a function of the solution on each grid of a refinement to a relative L1 `error`, and of its bound."""

    def report_grid(solution: "Solution", bound: float) -> None:
        grid = solution.problem.grid
        text = f"{cells_text(grid.cells)}: {100 * bound:.2g} % in L1"
        report(Progress(min(error / bound, 1.0), text, solution.pressure, grid))

    return report_grid


def of_changes(report: Report) -> Callable[[float, float], None]:
    """Return a function of the last change of the pressure and the allowed one, for outer iterations."""
    fraction = fraction_of_fall()

    def report_change(change: float, allowed: float) -> None:
        text = f"change of the pressure {change:.1e} of {allowed:.1e}"
        report(Progress(fraction(change, allowed), text))

    return report_change


def of_passes(report: Report) -> Callable[[float, int], None]:
    """Return a function of the number of passes done and the number in all, for repeated rolling."""

    def report_passes(done: float, passes: int) -> None:
        report(Progress(done / passes, f"{done:.3g} of {passes} passes"))

    return report_passes


def of_time(report: Report) -> Callable[[float, float], None]:
    """Return a function of the time since the start and that of the whole [s], for a scene that changes in time."""

    def report_time(done: float, whole: float) -> None:
        report(Progress(done / whole if whole else 1.0, f"{done:.3g} s of {whole:.3g} s"))

    return report_time


def of_film_steps(report: Report, tolerance: float) -> "Callable[[FilmIteration], None]":
    """Return a function of the iteration of a steady film after each of its steps."""
    fraction = fraction_of_fall()

    def report_step(last: "FilmIteration") -> None:
        nonlocal fraction
        if last.iterations == 1:  # the first step on another grid
            fraction = fraction_of_fall()
        cells = cells_text(last.film.pressure.shape)
        text = f"{cells}: residual {last.residual:.1e} of {tolerance:.1e}"
        report(Progress(fraction(last.residual, tolerance), text))

    return report_step


def fraction_of_fall() -> Callable[[float, float], float]:
    """Return a function of a residual and its target: how far it has fallen from the first one, in logarithms."""
    first = 0.0

    def fraction(residual: float, target: float) -> float:
        nonlocal first
        if not isfinite(residual) or residual <= 0:
            return float(residual == 0)
        first = first or max(residual, 10 * target)
        return min(max(log(first / residual) / log(first / target), 0.0), 1.0)

    return fraction
