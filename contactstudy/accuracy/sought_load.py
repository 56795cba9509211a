"""Errors of contacts that cells of twice the size show: with adhesion, or under a given approach."""

from bisect import bisect_left
from dataclasses import dataclass
from math import inf, log

from contactstudy.accuracy.coarser import ADHESIVE_TOLERANCE, change, coarse_solution, halved
from contactstudy.domain.errors import ErrorParts
from contactstudy.scene.scene import PosedScene
from contactstudy.solvers.solution import CohesiveTraction, Solution
from contactstudy.solvers.solve import SolveOptions

# Pull-off load of a cylinder over that in the limit of short ranges, by Tabor's parameter, for the exponential law;
# found on grids of 1024 to 4096 cells.
PULL_OFF = (
    (0.0536, 0.3304),
    (0.1073, 0.4615),
    (0.268, 0.6900),
    (0.536, 0.8594),
    (1.073, 0.9581),
    (2.145, 0.9920),
    (4.290, 0.9991),
)
# Errors fall in proportion to the cell, so that the change from cells of twice the size is the error of these.
MARGIN = 1.5
# The part of a pull-off load that the cells may add by trapping the edge of the contact, by the cells in the zone.
TRAPPED = ((5.0, 2e-3), (2.7, 1e-2), (0.0, 3e-2))


@dataclass(frozen=True)
class Compared:
    """Relative errors of a contact by the cells, and the load on cells of twice the size [N/m]."""

    l1: float
    peak_pressure: float
    contact_area: float
    mean_gap: float
    load: float
    warnings: tuple[str, ...] = ()


def compared(solution: Solution, coarse: Solution | None) -> Compared:
    """Return the errors of `solution` by its change from cells of twice the size; infinite where these do not touch."""
    attraction = None if solution.adhesion is None else solution.adhesion.traction
    coarse = coarse or coarse_solution(solution.problem, solution.pressure, attraction)
    if coarse is None or coarse.status.is_failure or not coarse.pressure.any():
        why = "there is no solution" if coarse is None else "the bodies do not touch"
        reason = f"No bound for the discretisation error: on cells of twice the size {why}, give more cells."
        return Compared(inf, inf, inf, inf, inf, (reason,))
    changes = change(solution, coarse)
    own, other = solution.load_per_length, coarse.load_per_length
    return Compared(
        MARGIN * changes.l1,
        MARGIN * abs(changes.peak_pressure),
        MARGIN * changes.contact_area,
        MARGIN * changes.mean_gap,
        MARGIN * abs(own - other) / abs(own) if own else inf,
        range_warning(solution),
    )


def range_warning(solution: Solution) -> tuple[str, ...]:
    """Return a sentence on how far the attraction is from the limit of short ranges, where it stands for that."""
    adhesion = solution.adhesion
    if adhesion is None or not adhesion.regularised or adhesion.tabor is None:
        return ()
    return (
        f"The range of the attraction, {adhesion.range:.3g} m, is the shortest that this grid can hold: the pull-off "
        f"load of a cylinder with this Tabor parameter, {adhesion.tabor:.3g}, is {short_of_limit(adhesion.tabor):.1%} "
        "below the JKR limit.",
    )


def pull_off_error(solution: Solution, load: float) -> ErrorParts:
    """Return the error of the load of separation of `solution`, whose relative error by the cells is `load`."""
    adhesion, held = solution.adhesion, solution.load_per_length
    assert adhesion is not None
    assert adhesion.lost is not None
    trapped = next(share for cells, share in TRAPPED if adhesion.cells_in_zone >= cells)
    return ErrorParts(
        discretisation=load + trapped,
        residual=abs(held - adhesion.lost) / abs(held) if held else inf,
        range=_range_error(solution, adhesion, held),
        reason=""
        if load < inf and held
        else "No bound for the discretisation error: give more cells.",
    )


def _range_error(solution: Solution, adhesion: CohesiveTraction, held: float) -> float | None:
    """Return the error of a load of separation by a range that stands for the limit of short ones; None for others.

    It is that of a cylinder with this Tabor parameter, or the change from the range of cells of twice the size, which on
    other surfaces decides over more than the edge of one contact.
    """
    problem = solution.problem
    posed = problem.description
    if not adhesion.regularised or not isinstance(posed, PosedScene):
        return None
    longer = SolveOptions(ADHESIVE_TOLERANCE).solved(
        posed.scene.problem(halved(problem.grid), posed.padding)
    )
    changed = abs(longer.load_per_length - held) / abs(held) if held else inf
    return max(changed, short_of_limit(adhesion.tabor) if adhesion.tabor else 0.0)


def short_of_limit(tabor: float) -> float:
    """Return by how much the pull-off load of a cylinder is below the limit of short ranges, relative to it."""
    known = [parameter for parameter, _ in PULL_OFF]
    place = min(max(bisect_left(known, tabor), 1), len(known) - 1)
    (low, below), (high, above) = PULL_OFF[place - 1 : place + 1]
    # 1 - ratio between two values is a power of the parameter
    first, last = 1 - below, 1 - above
    power = log(last / first) / log(high / low)
    return float(min(1.0, first * (tabor / low) ** power))
