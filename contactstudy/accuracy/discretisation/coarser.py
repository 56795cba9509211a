"""The same contact on coarser cells: its problem, its solution, and what changes from one grid to the other."""

from dataclasses import dataclass, replace
from math import inf
from typing import Any

import numpy as np

from contactstudy.accuracy.discretisation.cells import contact_area_in_cells
from contactstudy.domain.checks import InvalidInput
from contactstudy.domain.errors import MARGIN
from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid, edge_fraction, on_cells
from contactstudy.problem.problem import Problem, Source
from contactstudy.solvers.cohesive_law import Dugdale, Exponential
from contactstudy.solvers.solution import Branch, Solution, Status
from contactstudy.solvers.solve import SolveOptions, solve_contact

# Tolerance of the coarse solution. It begins with the means of the fine one, which on several hundred cells are within
# 1e-4 of it, and would then be taken for it.
COARSE_TOLERANCE = 1e-6
# That of one with adhesion, whose states near separation differ by slow changes alone.
ADHESIVE_TOLERANCE = 1e-7
# Error of the work of adhesion by which cells trap the edge of a contact, times the cells in the cohesive zone.
TRAPPED_WORK: dict[type, float] = {Exponential: 0.06, Dugdale: 0.16}


@dataclass(frozen=True)
class DiscretisationErrors:
    """Relative errors due to the cells, or changes of a solution from other cells.

    Attributes
    ----------
    l1
        Of the net pressure in L1; a change is that of its means over the coarser cells.
    peak_pressure, contact_area, mean_gap, load
        Of these numbers; the `load` is None where it is given.
    warnings
        A sentence for each infinite error, or on what to change.
    """

    l1: float
    peak_pressure: float
    contact_area: float
    mean_gap: float
    load: float | None = None
    warnings: tuple[str, ...] = ()

    @classmethod
    def unbounded(cls, reason: str, load: float | None = None) -> "DiscretisationErrors":
        """Return infinite errors with their reason."""
        return cls(inf, inf, inf, inf, load, (reason,))


def halved(grid: Grid) -> Grid:
    """Return a grid of the same extent with half as many cells along each axis, rounded up, at least 2 across."""
    nx, ny = grid.cells
    return Grid((max(2, (nx + 1) // 2), (ny + 1) // 2), grid.extent)


def coarser_problem(problem: Problem) -> Problem | None:
    """Return `problem` on cells of about twice the size.

    It is None without a source, where the source refuses such cells, and where the grid is two cells wide.

    Heights that the source does not contain are averaged over the larger cells. Constraint and control are those of
    `problem`, but with adhesion, whose law may belong to the grid.
    """
    source = problem.source
    if source is None or problem.grid.cells[0] == 2:
        return None
    try:
        coarse = source.problem(halved(problem.grid))
    except InvalidInput:
        return None
    if problem.adhesion is None:
        cells = problem.grid.cell_area / coarse.grid.cell_area
        control = problem.control.scaled(cells)
        coarse = replace(coarse, constraint=problem.constraint, control=control)
    added = _added_heights(source, problem)
    if added is None:
        return coarse
    gap = coarse.undeformed_gap + on_cells(added, coarse.grid.cells)
    return replace(coarse, undeformed_gap=gap)


def change_between_grids(fine: Solution, coarse: Solution) -> DiscretisationErrors:
    """Return the relative changes from `coarse`, the same contact on larger cells, to `fine`."""
    net = fine.net_pressure
    means = on_cells(net, coarse.pressure.shape)
    areas = [touching_fraction(solution) for solution in (fine, coarse)]
    gaps = [solution.mean_gap for solution in (fine, coarse)]
    loads = [solution.load_per_length for solution in (fine, coarse)]
    return DiscretisationErrors(
        float(np.abs(means - coarse.net_pressure).sum() / np.abs(means).sum()),
        abs(fine.peak_pressure / coarse.peak_pressure - 1) if coarse.peak_pressure else inf,
        abs(areas[1] / areas[0] - 1),
        abs(gaps[1] / gaps[0] - 1) if gaps[0] else inf,
        abs(loads[0] - loads[1]) / abs(loads[0]) if loads[0] else inf,
    )


def touching_fraction(solution: Solution) -> float:
    """Return the part of the grid in contact, with the edges inside their cells but of an attraction."""
    pressure, paddings = solution.pressure, solution.problem.paddings
    if solution.adhesion is not None or paddings is None:
        return float((pressure > 0).mean())
    wraps = paddings[0].wraps, paddings[1].wraps
    return contact_area_in_cells(pressure, wraps) / pressure.size


def comparable(coarse: Solution | None) -> Solution | None:
    """Return a `coarse` solution that others can be compared with, else None.

    It converged, is as accurate as rounding lets it be, or found that the bodies do not touch.
    """
    if coarse is None:
        return None
    ended = coarse.status in (Status.PRECISION_LIMIT, Status.DETACHED)
    return coarse if ended or coarse.status.has_converged else None


def error_by_change(solution: Solution, coarse: Solution | None) -> DiscretisationErrors:
    """Return the errors of `solution` by its change from cells of twice the size.

    `coarse` is the solution on those; None solves for it. The errors are infinite where that fails, or where the bodies
    do not touch on those cells. Under a given load the change itself counts; with adhesion or at a given approach
    errors fall less steeply.
    """
    start = solution.pressure, solution.attraction
    coarse = comparable(coarse or coarse_solution(solution.problem, *start))
    if coarse is None or not coarse.pressure.any():
        why = "there is no solution" if coarse is None else "the bodies do not touch"
        reason = f"No bound for the discretisation error: on cells of twice the size {why}, give more cells."
        return DiscretisationErrors.unbounded(reason, load=inf)
    change = change_between_grids(solution, coarse)
    if solution.adhesion is None and solution.problem.control.approach is None:
        return change
    assert change.load is not None
    errors = DiscretisationErrors(
        MARGIN * change.l1,
        MARGIN * change.peak_pressure,
        max(MARGIN * change.contact_area, edge_fraction(solution.pressure > 0)),
        MARGIN * change.mean_gap,
        MARGIN * change.load,
    )
    return errors if solution.adhesion is None else _with_trapping(errors, solution)


def _with_trapping(errors: DiscretisationErrors, solution: Solution) -> DiscretisationErrors:
    """Return the `errors` of a contact with adhesion with those by trapping of its edge.

    Cells hold the edge of the contact as if the work of adhesion were off by a fraction that falls with the cells in the
    cohesive zone: less where the bodies came from afar, more where they came from full contact. The errors are the
    changes where the work is changed back; infinite where the bodies then come apart, or have no other solution.
    """
    problem, adhesion = solution.problem, solution.adhesion
    assert adhesion is not None
    if adhesion.first_unstable_load is not None:  # the search for a pull-off load has its own part
        return errors
    solver: Any = problem.adhesion
    fraction = TRAPPED_WORK[type(solver.law)] / adhesion.cells_in_zone
    signs = {Branch.FROM_AFAR: (1,), Branch.FROM_FULL_CONTACT: (-1,)}.get(solver.branch, (1, -1))
    changes = []
    for sign in signs:
        factor = 1 + sign * fraction
        law = replace(solver.law, work=factor * solver.law.work, range=factor * solver.law.range)
        other = solve_contact(
            replace(
                problem,
                friction=None,
                adhesion=replace(solver.continued(adhesion.attraction), law=law),
            ),
            SolveOptions(ADHESIVE_TOLERANCE),
            solution.pressure,
        )
        if comparable(other) is None or not other.pressure.any():
            reason = (
                f"No bound for the discretisation error: the cells hold the edge of the contact as a work of adhesion "
                f"that is off by {fraction:.1%}, with which the bodies come apart, give more cells."
            )
            return DiscretisationErrors.unbounded(reason, load=inf)
        changes.append(change_between_grids(solution, other))
    return replace(
        errors,
        **{
            name: getattr(errors, name) + max(getattr(change, name) for change in changes)
            for name in ("l1", "peak_pressure", "contact_area", "mean_gap", "load")
        },
    )


def coarse_solution(
    problem: Problem, pressure: Array | None = None, attraction: Array | None = None
) -> Solution | None:
    """Return the solution on cells of twice the size, as accurate as a comparison needs where it converges.

    It begins with the means of a `pressure` and an `attraction` (x, y) [Pa] on the grid of `problem`, if they are given.
    It is None where `coarser_problem` is.
    """
    coarse = coarser_problem(problem)
    if coarse is None:
        return None
    start = None if pressure is None else on_cells(pressure, coarse.grid.cells)
    if coarse.adhesion is not None and attraction is not None:
        adhesion = coarse.adhesion.continued(on_cells(attraction, coarse.grid.cells))
        coarse = replace(coarse, adhesion=adhesion)
    tolerance = COARSE_TOLERANCE if coarse.adhesion is None else ADHESIVE_TOLERANCE
    return solve_contact(coarse, SolveOptions(tolerance), start)


def _added_heights(source: Source, problem: Problem) -> Array | None:
    """Return the heights (x, y) [m] in `problem` that its source does not contain; None where there are none."""
    heights = source.gap(problem.grid)
    if problem.undeformed_gap is heights:
        return None
    added = problem.undeformed_gap - heights
    if not added.any():
        return None
    largest_gap = np.abs(problem.undeformed_gap).max()
    return added if np.abs(added).max() > 1e-9 * largest_gap else None
