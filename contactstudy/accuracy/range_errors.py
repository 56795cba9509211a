"""Range errors: errors due to a range of the attraction that is chosen for the grid, in place of the JKR limit.

The JKR limit (Johnson, Kendall & Roberts 1971) is that of an attraction of a given work of adhesion and a range of
zero. The range is the work of adhesion over the largest traction. Such an adhesion is called ``regularised``.
"""

from bisect import bisect_left
from math import inf, log, sqrt
from typing import Any, NamedTuple

import numpy as np

from contactstudy.accuracy.discretisation.cells import contact_perimeter
from contactstudy.accuracy.discretisation.coarser import ADHESIVE_TOLERANCE, halved
from contactstudy.domain.errors import ErrorParts
from contactstudy.domain.units import readable
from contactstudy.scene.scene import PosedScene, scene_of
from contactstudy.scene.solids.bodies import contact_modulus
from contactstudy.solvers.cohesive_law import zone_length
from contactstudy.solvers.solution import AdhesiveTraction, Solution
from contactstudy.solvers.solve import SolveOptions, solve_contact

# Pull-off load of a cylinder over its JKR limit (large Tabor parameter), by that parameter, for the exponential law;
# found on grids of 1024 to 4096 cells.
PULL_OFF_OVER_JKR = (
    (0.0536, 0.3304),
    (0.1073, 0.4615),
    (0.268, 0.6900),
    (0.536, 0.8594),
    (1.073, 0.9581),
    (2.145, 0.9920),
    (4.290, 0.9991),
)
# Factor on the errors due to a finite range: for cylinders of a Tabor parameter of 0.4 to 6.4 the difference from the
# JKR limit was at most 1.09 times what :func:`range_errors` has without this factor, most at the largest parameter.
RANGE_MARGIN = 1.25
# Error of the peak net pressure over that of the area times the peak and the mean net pressure: at most 0.06 for 15
# cylinders, from near pull-off to loads of many times it, on 152 to 2432 cells.
PEAK_BY_RANGE = 0.25
NO_LIMIT = (
    "No bound: in the JKR limit the repulsive part of the pressure and the attraction grow without limit, give "
    "Adhesion.range."
)
NO_PULL_OFF_OF_LAW = (
    "No bound for the pull-off load: how far it is from the JKR limit is known for the exponential law alone, give "
    "Adhesion.range."
)
NO_LONGER_RANGE = (
    "No bound for the pull-off load: on cells of twice the size, with the longer range that they hold, none was found, "
    "give more cells."
)
PRESSED_FLAT = (
    "No bound for the pull-off load: the surface is pressed flat, and without an edge of the contact the load at which "
    "it opens grows without limit as the range of the attraction shrinks, give Adhesion.range."
)
# Largest gap over the range of the attraction, up to which no part of a surface is free of it: waves pressed flat on
# fine grids have at most 1.2 on coarse ones, others 2.4 and more.
FLAT_GAP = 2.0
# Error of the load at a given approach, over the L1 norm of the net traction and the error of the area by the range: at
# most 0.015 for cylinders on 96 to 384 cells, before and after contact is made by the load.
LOAD_BY_RANGE = 0.03
ZERO_PULL_OFF = "No bound for the pull-off load: it is zero, and its error is relative to it."
# Least number of cells in the cohesive zone, and the fraction of the pull-off load that coarse cells may add there, as
# they trap the edge of the contact. With the exponential law it was at most 0.2 % on 5 cells and more, 1 % on 2.7 cells
# and 3 % on 1.3 cells.
TRAPPED_FRACTION = ((5.0, 2e-3), (2.7, 1e-2), (0.0, 3e-2))


class RangeErrors(NamedTuple):
    """Relative errors of the L1 pressure and of the contact area due to a range that was chosen for the grid."""

    l1: float
    area: float


def range_errors(solution: Solution) -> RangeErrors | None:
    """Return the relative errors of the L1 pressure and of the contact area due to a range that was chosen for the grid.

    It is None for a range that is given. In the JKR limit the traction has an inverse square-root singularity at the
    edge of the contact, which a range r replaces by a cohesive zone. That moves a force E* r per length of edge, where
    E* is the contact modulus, and the edge by at most the length of the zone (Maugis 1992). As r goes to zero, pressure
    and attraction grow without limit at the edge, and only their difference, the net traction, converges. The L1 error
    is the error of the net traction, and the peak pressure has no bound.
    """
    adhesion, problem = solution.adhesion, solution.problem
    scene = scene_of(problem)
    if adhesion is None or not adhesion.regularised or scene is None:
        return None
    assert scene.adhesion is not None
    touching, grid = solution.pressure > 0, problem.grid
    modulus = contact_modulus(scene.solids, adhesion.cells_in_zone * grid.cell_size[0])
    work = scene.adhesion.work
    zone = zone_length(modulus, work, work / adhesion.range)
    perimeter = contact_perimeter(touching, grid, problem.paddings)
    net_force = grid.cell_area * float(np.abs(solution.pressure - adhesion.attraction).sum())
    area_error = RANGE_MARGIN * perimeter * zone / (grid.cell_area * int(touching.sum()))
    return RangeErrors(l1_range_error(perimeter, modulus, adhesion.range, net_force), area_error)


def peak_range_error(solution: Solution, area_error: float) -> float:
    """Return the relative error of the peak net pressure due to a range that was chosen for the grid.

    `area_error` is the relative error of the contact area due to it.
    """
    mean = float(np.abs(solution.net_pressure).sum() / np.count_nonzero(solution.pressure))
    peak = abs(solution.peak_pressure)
    return PEAK_BY_RANGE * area_error * (peak + mean) / peak if peak else inf


def load_range_error(solution: Solution) -> float | None:
    """Return the relative error of the load at a given approach due to a range that was chosen for the grid, or None.

    In the JKR limit the bodies do not attract each other across a gap, so that without contact the error is all of the
    load. It is None for a range that is given, and infinite without a scene.
    """
    adhesion = solution.adhesion
    if adhesion is None or not adhesion.regularised:
        return None
    if not solution.pressure.any():
        return 1.0
    if (errors := range_errors(solution)) is None:
        return inf
    load = abs(float(solution.net_pressure.sum()))
    norm = float(np.abs(solution.net_pressure).sum())
    return LOAD_BY_RANGE * errors.area * norm / load if load else inf


def l1_range_error(perimeter: float, modulus: float, attraction_range: float, force: float) -> float:
    """Return the L1 error due to the range of the net traction of a contact of this `perimeter` [m].

    It is relative to a `force` [N], the integral of the size of the net traction. `modulus` is E* [Pa] at the length of
    the cohesive zone, `attraction_range` [m] the range chosen for the grid.
    """
    return RANGE_MARGIN * perimeter * modulus * attraction_range / force


def range_warning(solution: Solution) -> tuple[str, ...]:
    """Return a sentence on how far the adhesion is from the JKR limit, where its range was chosen for the grid."""
    adhesion = solution.adhesion
    if adhesion is None or not adhesion.regularised or adhesion.tabor is None:
        return ()
    shortest = f"The range of the attraction, {readable(adhesion.range)}, is the shortest that this grid can hold"
    if not _follows_table(solution):
        return (f"{shortest}.",)
    below = reduction_below_jkr(adhesion.tabor)
    return (
        f"{shortest}: the pull-off load of a cylinder with this Tabor parameter, {adhesion.tabor:.3g}, is {below:.1%} "
        "below the JKR limit.",
    )


def _follows_table(solution: Solution) -> bool:
    """Return whether the attraction of `solution` follows the law that :data:`PULL_OFF_OVER_JKR` is for."""
    adhesion = getattr(scene_of(solution.problem), "adhesion", None)
    return adhesion is not None and adhesion.law == "exponential"


def pull_off_error(solution: Solution, discretisation: float, reason: str) -> ErrorParts:
    """Return the error of the pull-off load of `solution`, by its relative error `discretisation`.

    The `reason` says why that is infinite where it is. The residual is the distance between the last load in
    equilibrium and the first one without.
    """
    adhesion, pull_off = solution.adhesion, solution.load_per_length
    assert adhesion is not None
    assert adhesion.first_unstable_load is not None
    trapped = next(fraction for cells, fraction in TRAPPED_FRACTION if adhesion.cells_in_zone >= cells)
    is_flat = adhesion.regularised and _is_pressed_flat(solution)
    by_range = inf if is_flat else _pull_off_range_error(solution, adhesion, pull_off)
    if is_flat:
        reason = PRESSED_FLAT
    elif by_range == inf:
        reason = reason or (NO_LONGER_RANGE if _follows_table(solution) else NO_PULL_OFF_OF_LAW)
    return ErrorParts(
        discretisation=discretisation + trapped,
        residual=abs(pull_off - adhesion.first_unstable_load) / abs(pull_off) if pull_off else inf,
        range=by_range,
        reason=reason if pull_off else ZERO_PULL_OFF,
    )


def root_of_pull_off(pull_off: ErrorParts | None) -> float:
    """Return the relative error of pressure and approach at pull-off by that of the load, apart from its range.

    A load that is stationary there changes by the square of what they change by. It is 0 of a contact that is not pulled
    off.
    """
    if pull_off is None:
        return 0.0
    return sqrt((pull_off.discretisation or 0.0) + (pull_off.residual or 0.0))


def _is_pressed_flat(solution: Solution) -> bool:
    """Return whether no part of a surface that is periodic both ways is free of attraction, under the preload."""
    problem = solution.problem
    posed = problem.description
    assert problem.paddings is not None
    if not isinstance(posed, PosedScene) or not all(padding.wraps for padding in problem.paddings):
        return False
    load: Any = posed.scene.load
    scene = posed.scene.under(load.preload)
    pressed = solve_contact(scene.problem(problem.grid, posed.padding), SolveOptions(ADHESIVE_TOLERANCE))
    assert solution.adhesion is not None
    least = min(float(pressed.gap.max()), float(solution.gap.max()))
    return least < FLAT_GAP * solution.adhesion.range


def _pull_off_range_error(solution: Solution, adhesion: AdhesiveTraction, pull_off: float) -> float | None:
    """Return the error of a pull-off load due to a range chosen for the grid in place of the JKR limit, or None.

    It is the larger of two: that of a cylinder with this Tabor parameter, and the change from cells of twice the size,
    whose range is longer. On other surfaces than cylinders that change counts more than the edge of one contact. It is
    infinite for a law other than the exponential one, and where no pull-off load is found on the larger cells. It is
    None for a range that is given.
    """
    problem = solution.problem
    posed = problem.description
    if not adhesion.regularised or not isinstance(posed, PosedScene):
        return None
    if not _follows_table(solution):
        return inf
    longer = solve_contact(posed.scene.problem(halved(problem.grid), posed.padding), SolveOptions(ADHESIVE_TOLERANCE))
    found = longer.status.has_converged and pull_off
    changed = abs(longer.load_per_length - pull_off) / abs(pull_off) if found else inf
    return max(changed, reduction_below_jkr(adhesion.tabor) if adhesion.tabor else 0.0)


def reduction_below_jkr(tabor: float) -> float:
    """Return by how much the pull-off load of a cylinder is below its JKR limit, relative to it.

    `tabor` is Tabor's parameter. The result follows a power law between the values of the table
    :data:`PULL_OFF_OVER_JKR`, and beyond its ends.
    """
    parameters = [parameter for parameter, _ in PULL_OFF_OVER_JKR]
    index = min(max(bisect_left(parameters, tabor), 1), len(parameters) - 1)
    (low, below), (high, above) = PULL_OFF_OVER_JKR[index - 1 : index + 1]
    # 1 - ratio between two values is a power of the parameter
    first, last = 1 - below, 1 - above
    power = log(last / first) / log(high / low)
    return float(min(1.0, first * (tabor / low) ** power))
