"""Errors of the approach, and of the largest von Mises stress below the surface and its depth."""

from dataclasses import replace
from itertools import pairwise
from math import inf

import numpy as np

from contactstudy.accuracy.discretisation.bound import CONSTANTS as ONE_GRID
from contactstudy.accuracy.discretisation.bound import has_isolated_cells
from contactstudy.accuracy.discretisation.coarser import FIRST_ORDER_MARGIN
from contactstudy.accuracy.estimate import CONSTANTS as COATING
from contactstudy.accuracy.image_errors import IMAGES_REMEDY, with_all_images
from contactstudy.domain.errors import ErrorEstimate, ErrorParts
from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Paddings
from contactstudy.solvers.friction.rolling_traction import RollingTraction
from contactstudy.solvers.solution import Solution, TangentialTraction

# Error of the shear stress at an interface over its change from cells of twice the size: at most 1.5 on five thin and
# thick coatings, of 0.25 to 5 times the stiffness, on cells of half the thickness and less.
INTERFACE_MARGIN = 2.0
# Error of the largest stress over the L1 error of the pressure.
STRESS_ERROR = 0.5
# Error of the approach by a range that was chosen for the grid, over that range times the relative error of the area by
# it: at most 0.07 on 21 cylinders against the JKR limit.
APPROACH_BY_RANGE = 0.2
# Error of the stress at the surface over the largest step of the tangential traction from one cell to the next, beside
# the other errors by the cells: at most 0.025 in 50 smooth contacts, and 0.8 in 25 of tractive rolling, whose stick-slip
# boundary is uncertain by a cell.
STEP_ERROR, ROLLING_STEP_ERROR = 0.05, 1.0
# Error of the stress below a loaded end of a roller, over the change from cells of twice the size: the load that larger
# cells miss there falls like their size to the power 0.77 beside free faces, 1/2 on a half-space.
SHARP_END_MARGIN = 2.4
NO_DATUM = (
    "No bound for the approach: it counts from a place that depends on the images that the padding leaves out, "
    f"{IMAGES_REMEDY}."
)
ZERO_APPROACH = "No bound for the approach: it is zero, and its error is relative to it."
AT_SURFACE = "No bound for the depth: the largest stress lies at the surface."
NO_COARSER = (
    "No bound for the stress: there is no solution on cells of twice the size to compare with."
)
TOO_FEW_CELLS = "No bound for the stress: too few cells in contact are neighbours, give more cells."
NO_STRESS_LIMIT = (
    "No bound for the stress: in the JKR limit it grows without limit towards the edges of the contact, give "
    "Adhesion.range."
)


def approach_error(
    solution: Solution, estimate: ErrorEstimate, coarse: Solution | None
) -> ErrorParts:
    """Return the relative error of the approach.

    By the cells it is the larger of that by the L1 error of the pressure and of the change from larger cells. A range of
    attraction that was chosen for the grid adds `APPROACH_BY_RANGE`. It is infinite, with the reason, where images are
    left out or the approach is zero.

    Parameters
    ----------
    solution
        The solution.
    estimate
        Errors of its pressure.
    coarse
        The same contact on cells of twice the size; None where none was solved.
    """
    size = abs(solution.approach)
    if estimate.l1.images:
        return ErrorParts(images=inf, reason=NO_DATUM)
    if not size:
        return ErrorParts(discretisation=inf, reason=ZERO_APPROACH)
    change = 0.0 if coarse is None else abs(solution.approach - coarse.approach)
    if solution.adhesion is not None:
        change *= FIRST_ORDER_MARGIN
    varies = float(solution.displacement.std())
    cells, residual = estimate.l1.discretisation or 0.0, estimate.l1.residual or 0.0
    shift = max(change, ONE_GRID.gap_error * cells * varies)
    reason = next(iter(estimate.warnings), "") if shift == inf else ""
    by_range = None
    if solution.adhesion is not None and estimate.contact_area is not None:
        moved = estimate.contact_area.range
        by_range = moved and APPROACH_BY_RANGE * solution.adhesion.range * moved / size
    return ErrorParts(0.0, shift / size, residual * varies / size, range=by_range, reason=reason)


def stress_errors(
    solution: Solution,
    von_mises: Array,
    depths: Array,
    estimate: ErrorEstimate,
    coarse: Solution | None,
    weights: Array | None = None,
) -> tuple[ErrorParts, ErrorParts]:
    """Return the relative errors of the largest von Mises stress at some depths, and of its depth.

    The stress at a depth shows no waves of the pressure that are much shorter. So the error of the peak pressure by the
    cells and by the residual counts at the surface, and falls like the stress of a wave of two cells; that in L1 counts
    everywhere, as does the change from larger cells. Steps of the tangential traction, at edges and at the stick-slip
    boundary, count as the peak pressure does. Images that the padding leaves out change the pressure, and lack
    with their own stress: it is computed with all of them. Between cells and between depths the maximum lies above the
    largest value by the parabola through three of them. Any depth may be that of the largest stress where the stress
    comes as near to it as its errors; a single depth is given, and has none. Both are infinite where the range of an
    attraction was chosen for the grid.

    Parameters
    ----------
    solution
        The solution.
    von_mises
        Von Mises stress (z, x, y) [Pa] below it.
    depths
        Depths (z,) [m], growing.
    estimate
        Errors of its pressure.
    coarse
        The same contact on cells of twice the size; None where there is none.
    weights
        Factor on the stress at each depth (z,), such as one over the yield stress; None for 1.
    """
    weights = np.ones(len(depths)) if weights is None else weights
    von_mises = von_mises * weights[:, None, None]
    if has_isolated_cells(solution):
        no_bound = ErrorParts(discretisation=inf, reason=TOO_FEW_CELLS)
        return no_bound, no_bound
    largest = von_mises.max(axis=(1, 2))
    level, x, y = np.unravel_index(int(von_mises.argmax()), von_mises.shape)
    peak = float(largest[level])
    if coarse is None or not peak > 0:
        no_bound = ErrorParts(discretisation=inf, reason=NO_COARSER)
        return no_bound, no_bound
    if solution.regularised:
        no_bound = ErrorParts(range=inf, reason=NO_STRESS_LIMIT)
        return no_bound, no_bound
    images = estimate.l1.images or 0.0
    if images:
        assert solution.problem.paddings is not None
        every_image = with_all_images(solution.problem.paddings)
        whole = [_largest_at(solution, float(depth), solution, every_image) for depth in depths]
        images += float(np.abs(weights * whole - largest).max()) / peak
    on_coarse = _largest_at(solution, float(depths[level]), coarse)
    change = abs(weights[level] * on_coarse / peak - 1)
    source, at_end = solution.problem.source, estimate.peak_pressure
    if source is not None and source.ends_along and at_end is not None:
        change *= SHARP_END_MARGIN if at_end.discretisation == inf else 1.0
    paddings = solution.problem.paddings
    wraps_x, wraps_y = (False, False) if paddings is None else [axis.wraps for axis in paddings]
    between = (
        _parabola_excess(von_mises[level, :, y], int(x), wraps=wraps_x)
        + _parabola_excess(von_mises[level, x], int(y), wraps=wraps_y)
        + _parabola_excess(largest, int(level), wraps=False)
    )
    decay = np.pi * depths / min(_cells(solution))
    of_peak = (1 + decay) * np.exp(-decay)
    local = _part(estimate.peak_pressure, "discretisation") * of_peak
    unsolved = (estimate.l1.residual or 0.0) + _part(estimate.peak_pressure, "residual") * of_peak
    usual = max(change, STRESS_ERROR * (estimate.l1.discretisation or 0.0)) + between / peak
    upper_stress = largest * (1 + usual + local)
    upper_stress += _error_at_steps(solution.traction) * of_peak
    cells = float(upper_stress.max() / peak - 1)
    residual = float((largest * (1 + unsolved)).max() / peak - 1)
    reason = next(iter(estimate.warnings), NO_COARSER) if max(cells, images) == inf else ""
    stress = ErrorParts(images, cells, residual, reason=reason)
    if len(depths) == 1:
        return stress, ErrorParts(0.0, 0.0, 0.0)
    if not (depth := float(depths[level])):
        return stress, ErrorParts(discretisation=inf, reason=AT_SURFACE)
    # how far away the stress comes as near to the largest as its errors, with one cause after the other
    away = []
    for other in (0.0, images, images + residual):
        near = np.flatnonzero(upper_stress * (1 + other) >= (1 - usual - other) * peak)
        # the depth may lie up to the neighbouring ones
        first, last = max(near[0] - 1, 0), min(near[-1] + 1, len(depths) - 1)
        away.append(max(depth - depths[first], depths[last] - depth) / depth)
    by_images, by_residual = (float(wider - narrow) for narrow, wider in pairwise(away))
    return stress, ErrorParts(by_images, float(away[0]), by_residual)


def _error_at_steps(traction: TangentialTraction | None) -> float:
    """Return the error of the stress at the surface [Pa] by the largest step of a tangential traction between cells."""
    if traction is None:
        return 0.0
    largest = max(
        float(np.abs(np.diff(traction.shear, axis=axis)).max(initial=0.0)) for axis in (1, 2)
    )
    rolls = isinstance(traction, RollingTraction)
    return largest * (ROLLING_STEP_ERROR if rolls else STEP_ERROR)


def _cells(solution: Solution) -> list[float]:
    """Return the sizes of a cell [m] along the axes with more than one."""
    grid = solution.problem.grid
    return [size for size, count in zip(grid.cell_size, grid.cells, strict=True) if count > 1]


def _part(parts: ErrorParts | None, cause: str) -> float:
    """Return the error by a cause; 1 where it has no bound, 0 where the cause does not apply."""
    error = 1.0 if parts is None else getattr(parts, cause) or 0.0
    return float(error) if error < inf else 1.0


def _parabola_excess(values: Array, index: int, *, wraps: bool) -> float:
    """Return by how much the parabola through a largest value and its neighbours rises above it, 0 at an open end."""
    if not (wraps or 0 < index < len(values) - 1):
        return 0.0
    before, centre, after = values.take([index - 1, index, index + 1], mode="wrap").tolist()
    bend = 2 * centre - before - after
    return (after - before) ** 2 / (8 * bend) if bend > 0 else 0.0


def interface_error(
    solution: Solution,
    thickness: float,
    depth: float,
    shear: float,
    estimate: ErrorEstimate,
    coarse: Solution | None,
) -> ErrorParts:
    """Return the relative error of the largest `shear` stress [Pa] at an interface at a `depth` [m].

    It lies beside an edge of the contact, over a length of the `thickness` [m] of the layer above, so that it has a
    bound on cells of up to half of that.
    """
    cell, extent = solution.problem.grid.cell_size[0], solution.problem.grid.extent[0]
    largest = thickness * COATING.cell_at_interface
    reason = ""
    if cell > largest * (1 + 1e-9):
        reason = (
            f"No bound for the shear stress at the interface: the grid has {thickness / cell:.2g} cells in the coating, "
            f"give {int(np.ceil(extent / largest))} cells across."
        )
    elif solution.regularised:
        reason = NO_STRESS_LIMIT
    elif coarse is None or not shear or has_isolated_cells(solution):
        reason = NO_COARSER
    if reason:
        return ErrorParts(discretisation=inf, reason=reason)
    assert coarse is not None
    stress = _stress_at(solution, depth, coarse)
    change = INTERFACE_MARGIN * abs(float(interface_shear(stress).max()) / shear - 1)
    l1 = estimate.l1
    at_steps = _error_at_steps(solution.traction) / shear * np.exp(-np.pi * depth / cell)
    cells = change + STRESS_ERROR * (l1.discretisation or 0.0) + float(at_steps)
    return ErrorParts(l1.images, cells, l1.residual, reason=l1.reason)


def interface_shear(stress: Array) -> Array:
    """Return the shear stress (x, y) on planes of constant depth, from stress (component, x, y)."""
    return np.asarray(np.hypot(stress[3], stress[4]))


def _largest_at(
    solution: Solution, depth: float, on: Solution, paddings: Paddings | None = None
) -> float:
    """Return the largest von Mises stress [Pa] at a `depth` [m], see :func:`_stress_at`."""
    from contactstudy.scene.stress import von_mises  # imported only where it is named

    return float(von_mises(_stress_at(solution, depth, on, paddings)).max())


def _stress_at(
    solution: Solution, depth: float, on: Solution, paddings: Paddings | None = None
) -> Array:
    """Return the stress (component, x, y) [Pa] at a `depth` [m] below a contact `on` a grid.

    It is that of the body whose stress `solution` names, and 0 if it names none. The images are those of `paddings`;
    None takes those of the contact.
    """
    from contactstudy.scene.stress import SubsurfaceStressOperator

    kind = SubsurfaceStressOperator
    signs = [each.sign for each in solution.problem.outputs if isinstance(each, kind)]
    for output in on.problem.outputs:
        if isinstance(output, kind) and output.sign in signs[:1]:
            below = replace(output, depths=(depth,), paddings=paddings or output.paddings)
            if on.traction is not None:
                below = below.with_shear(on.traction.shear, on.traction.bulk)
            return below(on.net_pressure)[:, 0]
    return np.zeros((6, *on.problem.grid.cells))
