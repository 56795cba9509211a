"""Errors of the approach, and of stresses below the surface that grids do not show."""

from dataclasses import replace
from math import inf

import numpy as np

from contactstudy.accuracy.discretisation.bound import CONSTANTS as ONE_GRID
from contactstudy.accuracy.discretisation.bound import has_isolated_cells
from contactstudy.accuracy.image_errors import IMAGES_REMEDY, with_all_images
from contactstudy.accuracy.range_errors import root_of_pull_off
from contactstudy.domain.errors import MARGIN, ErrorEstimate, ErrorParts
from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid, Paddings
from contactstudy.solvers.solution import Solution, Status

# Error of the approach by a range that was chosen for the grid, over that range times the relative error of the area by
# it: at most 0.07 on 21 cylinders against the JKR limit.
APPROACH_BY_RANGE = 0.2
NO_DATUM = (
    "No bound for the approach: it counts from a place that depends on the images that the padding leaves out, "
    f"{IMAGES_REMEDY}."
)
ZERO_APPROACH = "No bound for the approach: it is zero, and its error is relative to it."
TOO_FEW_CELLS = "No bound for the stress: too few cells in contact are neighbours, give more cells."
NO_STRESS_LIMIT = (
    "No bound for the stress: in the JKR limit it grows without limit towards the edges of the contact, give "
    "Adhesion.range."
)


def approach_error(solution: Solution, estimate: ErrorEstimate, coarse: Solution | None) -> ErrorParts:
    """Return the relative error of the approach.

    By the cells it is the larger of that by the L1 error of the pressure and of the change from larger cells, of which
    errors of first order, with adhesion and of a roller that ends, are a multiple. A range of attraction that was chosen
    for the grid adds `APPROACH_BY_RANGE`. It is infinite, with the reason, where images are left out or the approach is
    zero.

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
    source = solution.problem.source
    if solution.adhesion is not None or (source is not None and source.ends_along):
        change *= MARGIN
    varies = float(solution.displacement.std())
    cells, residual = estimate.l1.discretisation or 0.0, estimate.l1.residual or 0.0
    shift = max(change, ONE_GRID.gap_error * cells * varies)
    if solution.adhesion is not None and (root := root_of_pull_off(estimate.pull_off)):
        shift += root * max(size, solution.adhesion.range)
    reason = next(iter(estimate.warnings), "") if shift == inf else ""
    by_range = None
    if solution.adhesion is not None and estimate.contact_area is not None:
        moved = estimate.contact_area.range
        by_range = moved and APPROACH_BY_RANGE * solution.adhesion.range * moved / size
    return ErrorParts(0.0, shift / size, residual * varies / size, range=by_range, reason=reason)


def stress_error(solution: Solution, von_mises: Array, depths: Array, estimate: ErrorEstimate) -> ErrorParts:
    """Return the relative error of largest stresses that their changes between grids do not show.

    The error of the peak pressure counts at the surface, where it has no bound by as much as the peak itself, and falls
    like the stress of a wave of two cells along the axis with the longer ones (Johnson 1985, sect. 13.2). Images that
    the padding leaves out lack with their own stress. The error is infinite, with the reason, where too few cells in
    contact are neighbours, where the grid cuts the contact off, and where the range of an attraction was chosen for the
    grid.

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
    """
    if has_isolated_cells(solution):
        return ErrorParts(discretisation=inf, reason=TOO_FEW_CELLS)
    if solution.status is Status.CONTACT_AT_EDGE:
        return ErrorParts(discretisation=inf, reason=next(iter(estimate.warnings), ""))
    if solution.regularised:
        return ErrorParts(range=inf, reason=NO_STRESS_LIMIT)
    grid, largest = solution.problem.grid, von_mises.max(axis=(1, 2))
    assert estimate.peak_pressure is not None
    peak = min(estimate.peak_pressure.total, 1.0)
    decay = np.pi * depths / _longest_cell(grid)
    at_depths = largest * (1 + peak * (1 + decay) * np.exp(-decay))
    cells, images = float(at_depths.max() / largest.max()) - 1, 0.0
    if estimate.l1.images:
        assert solution.problem.paddings is not None
        every_image = with_all_images(solution.problem.paddings)
        whole = [_largest_at(solution, float(depth), every_image) for depth in depths]
        images = float(np.abs(whole - largest).max() / largest.max())
    return ErrorParts(images, cells)


def unbounded_by_peak(estimate: ErrorEstimate, depths: Array, grid: Grid) -> ErrorParts | None:
    """Return why largest stresses have no bound, where the peak pressure alone has none; None where they have one.

    Where the pressure is infinite, as at a roller's sharp end, the stress below grows without limit towards the surface,
    and coarse cells may show the largest elsewhere. At given `depths` (z,) [m] of a cell and more it is finite.
    """
    peak = estimate.peak_pressure
    if peak is None or peak.discretisation != inf or estimate.l1.total == inf:
        return None
    if depths.min() >= _longest_cell(grid):
        return None
    reason = peak.reason.replace("the peak pressure", "the largest stress")
    return ErrorParts(discretisation=inf, reason=reason)


def unresolved_interface(grid: Grid, thickness: float) -> ErrorParts | None:
    """Return why the shear stress at an interface has no bound on a grid; None where it has one.

    It lies beside an edge of the contact, over a length of the `thickness` [m] of the layer above, so that it has a
    bound on cells of up to half of that.
    """
    cell, largest = grid.cell_size[0], thickness * ONE_GRID.cell_at_interface
    if cell <= largest * (1 + 1e-9):
        return None
    reason = (
        f"No bound for the shear stress at the interface: the grid has {thickness / cell:.2g} cells in the coating, "
        f"give {int(np.ceil(grid.extent[0] / largest))} cells across."
    )
    return ErrorParts(discretisation=inf, reason=reason)


def interface_shear(stress: Array) -> Array:
    """Return the shear stress (x, y) on planes of constant depth, from stress (component, x, y)."""
    return np.asarray(np.hypot(stress[3], stress[4]))


def _longest_cell(grid: Grid) -> float:
    """Return the longer side [m] of a cell, along axes of several cells."""
    return max(size for size, count in zip(grid.cell_size, grid.cells, strict=True) if count > 1)


def _largest_at(solution: Solution, depth: float, paddings: Paddings) -> float:
    """Return the largest von Mises stress [Pa] at a `depth` [m] in the first body with one, with other `paddings`."""
    from contactstudy.scene.stress import (  # imported only where it is named
        SubsurfaceStressOperator,
        von_mises,
    )

    outputs = solution.problem.outputs
    operator = next(each for each in outputs if isinstance(each, SubsurfaceStressOperator))
    below = replace(operator, depths=(depth,), paddings=paddings)
    if solution.traction is not None:
        below = below.with_shear(solution.traction.shear, solution.traction.bulk)
    return float(von_mises(below(solution.net_pressure)[:, 0]).max())
