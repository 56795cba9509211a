"""Grids of steady lubricated contacts for an error of the film thickness."""

from collections.abc import Mapping
from math import ceil, inf, isfinite, sqrt

from contactstudy.domain.errors import ErrorParts
from contactstudy.domain.grid import Grid
from contactstudy.domain.validation import InvalidInput
from contactstudy.lubrication.film_equation import FilmScales
from contactstudy.lubrication.posed_film import ROW_MULTIPLE, dry_reach, lubricated_scales
from contactstudy.lubrication.steady_film import INLET_ERROR, SWEEP
from contactstudy.scene.scene import Scene

# On cells of half an inlet pressure sweep the minimum film has this relative error, as at M = 200, L = 5; on cells of a
# whole one it has six times as much.
HALF_SWEEP_ERROR = 0.02
# Least distance of the inlet's edge from the axis [a], above MIN_WIDTH, and the largest inlet sweep over the half-width
# of the pressure: a light load has no pressure spike, and its pressure rises over the half-width.
INLET, INLET_SWEEP_FRACTION = 1.25, 0.1
# The most cells across of plane strain, by default and for a requested error: some seconds, and a minute.
MAX_CELLS, MAX_REQUESTED_CELLS = 3200, 6400
# Least factor on the error that is aimed at where one takes more cells than are allowed.
AIMED_STEP = 1.05
# Length [m] of a grid in plane strain, where none is given: it has no effect.
PERIOD = 1e-3
# Cells along the length on which the dry contact of a shape that varies along it is solved.
DRY_CELLS_ALONG = 16
# Factor on the cells that the film needs, from which cells are not refined for friction, heat and load fraction.
REFINED_FOR_MOTION = 2.0
# Cells for the shortest wavelength of a surface, and along a roller with ends, a crown, a profile or a tilt.
CELLS_PER_WAVE, CELLS_ALONG_ROLLER = 8, 48


def film_grid(
    scene: Scene,
    error: float = 1e-2,
    period: float = PERIOD,
    *,
    shortest_wavelengths: tuple[float, float] = (inf, inf),
    longer: float = 1.0,
    most_cells: int = MAX_CELLS,
) -> Grid:
    """Return a grid on which central and minimum film of a smooth contact are within a relative ``error``.

    Parameters
    ----------
    scene
        A lubricated scene.
    error
        Half of it is the error by the inlet's finite length, half that by the cells, which resolve the inlet sweep.
    period
        Period along the length [m], which has no effect on the film in plane strain.
    shortest_wavelengths
        Shortest wavelengths (across, along) of the surfaces [m]; ``CELLS_PER_WAVE`` cells each. Along a roller
        ``CELLS_ALONG_ROLLER``, and one where nothing varies along the length.
    longer
        Factor by which the inlet is longer.
    most_cells
        Cells across at most. Where the error takes more, the grid is that of the smallest error which they allow.

    Raises
    ------
    InvalidInput
        For a scene without a curvature.
    """
    scales = lubricated_scales(scene)
    film, a = scales.expected_film, scales.hertz.half_width
    reach = dry_reach(scene, period, DRY_CELLS_ALONG if any(map(varies_along, scene.shapes)) else 1)
    sweep = inlet_sweep(scales)
    aimed = error
    while True:
        inlet = longer * max(INLET * reach, reach + sqrt(2 * INLET_ERROR * film / aimed))
        cell = sweep / 2 * min(1.0, sqrt(aimed / 2 / HALF_SWEEP_ERROR))
        cell = min(cell, shortest_wavelengths[0] / a / CELLS_PER_WAVE)
        across = ROW_MULTIPLE * ceil(2 * inlet / cell / ROW_MULTIPLE)
        if across <= most_cells or aimed >= 2 * HALF_SWEEP_ERROR:
            break
        aimed *= max(across / most_cells, AIMED_STEP)  # a shorter inlet, and larger cells
    across = most_cells if aimed > error else min(across, most_cells)
    along = 1
    if shortest_wavelengths[1] < inf:
        along = ROW_MULTIPLE * ceil(CELLS_PER_WAVE * period / shortest_wavelengths[1] / ROW_MULTIPLE)
    if scene.roller_length is not None:
        along = max(along, ROW_MULTIPLE * ceil(CELLS_ALONG_ROLLER / ROW_MULTIPLE))
    return Grid((across, along), (2 * inlet * a, period))


def inlet_sweep(scales: FilmScales) -> float:
    """Return the length [a] over which the pressure rises in the inlet, by the film of Moes."""
    return float(min((scales.expected_film / SWEEP) ** (2 / 3), INLET_SWEEP_FRACTION * scales.relative_half_width))


def expected_error(scene: Scene, grid: Grid) -> float:
    """Return the relative error that the film of a smooth cylinder is expected to have on a grid: by cells and inlet."""
    scales = lubricated_scales(scene)
    cell, inlet = (length / scales.hertz.half_width for length in (grid.cell_size[0], grid.extent[0] / 2))
    by_cells = HALF_SWEEP_ERROR * (2 * cell / inlet_sweep(scales)) ** 2
    return by_cells + INLET_ERROR * scales.expected_film / (inlet - 1) ** 2


def finer_film_grid(
    grid: Grid, first: Grid, errors: Mapping[str, ErrorParts], error: float, most_cells: int, given: Grid | None
) -> Grid | None:
    """Return the grid to solve next for an error of the film; None where it is met, or no finer grid is allowed.

    With up to twice the cells of the first grid it is also for friction, temperatures and the load of asperities.

    Parameters
    ----------
    grid, first
        The last grid and the first.
    errors
        Errors of the numbers that a scene asks for on the last grid, by name.
    error
        Relative error not to exceed.
    most_cells
        Cells across at most.
    given
        Grid whose extent is kept, and in plane strain alone refined; None where the inlet may become longer.
    """
    (nx, ny), (width, period) = grid.cells, grid.extent
    bounded = [errors["central_film"], errors["minimum_film"]]
    if first.cell_size[0] < REFINED_FOR_MOTION * grid.cell_size[0]:
        bounded += [parts for parts in errors.values() if isfinite(parts.total)]
    inlet, cells = (max(getattr(parts, cause) or 0.0 for parts in bounded) for cause in ("inlet", "discretisation"))
    remaining, longer = error, min(max(1.0, sqrt(2 * inlet / error)), 2.0)
    if given is not None:  # the error of the inlet remains
        remaining, longer = 2 * (error - inlet) if inlet <= error / 2 else error, 1.0
        if ny > 1 or cells <= remaining / 2:
            return None
    if inlet + cells <= error or nx >= most_cells:
        return None
    finer = min(max(1.0, sqrt(2.5 * cells / remaining)), 2.0)
    # a multiple, so that the cells of the coarser grids are unions of cells
    across = min(ROW_MULTIPLE * ceil(nx * longer * finer / ROW_MULTIPLE), most_cells)
    return Grid((across, ny), (longer * width, period))


def varies_along(shape: object) -> bool:
    """Return whether a shape varies along the length by its length scales; True if it has none."""
    scales = getattr(shape, "length_scales", None)
    return scales is None or scales.shortest_wavelengths[1] < inf or scales.roller > 0


def check_varies_on(scene: Scene, grid: Grid) -> None:
    """Raise :class:`~contactstudy.InvalidInput` where a shape varies along the length, and one cell does not show it."""
    varying = [type(shape).__name__ for shape in scene.shapes if varies_along(shape)]
    if varying and grid.cells[1] == 1:
        raise InvalidInput(
            f"Grid.cells[1] is 1, and the film varies along the length with the {varying[0]}: give {CELLS_ALONG_ROLLER} "
            "cells along or more, or leave the grid out."
        )
