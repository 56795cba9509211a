"""Plan of a lubricated scene: the grid on which its film has a requested error, the next finer one, and the cost.

[a] is Hertz's half-width, M and L are the load and the material parameter of Moes (1992). The inlet sweep is the length
over which the pressure rises in the inlet.
"""

from collections.abc import Mapping
from dataclasses import replace
from math import ceil, inf, isfinite, prod, sqrt

import numpy as np

from contactstudy.domain.errors import DEFAULT_ERROR, ErrorParts
from contactstudy.domain.grid import ExactPeriodicity, Grid, Padding, Paddings, across_and_along
from contactstudy.domain.validation import InvalidInput, readable
from contactstudy.lubrication.film_equation import FilmScales
from contactstudy.lubrication.posed_film import (
    DRY_TOLERANCE,
    MIN_WIDTH,
    ROW_MULTIPLE,
    check_film_padding,
    lubricated_scales,
)
from contactstudy.lubrication.steady_film import INLET_ERROR, SWEEP
from contactstudy.planning.grid_requirements import grid_requirements
from contactstudy.planning.planned import Plan
from contactstudy.scene.loads import ConstantLoad, LineLoad
from contactstudy.scene.scene import Scene
from contactstudy.scene.shapes.roller import Cylinder
from contactstudy.scene.solids.bodies import instantaneous
from contactstudy.solvers.solve import SolveOptions, solve_contact

# Factor on the error that the most cells reach, which is then said in two digits.
ROUNDED_UP = 1.1
# Matrices (x, x) of double precision held in plane strain, and of a film that varies along its length, where the Fourier
# stage of its linear solver has several for each harmonic while they are inverted.
LINE_MATRICES, FOURIER_MATRICES = 6, 50
# Floats held per cell of such a film: 120 in the basis of GMRES, and some 60 of fields and their derivatives.
FLOATS_PER_CELL = 180
# On cells of half an inlet pressure sweep films have this relative error, and as in second order four times as much on
# a whole one: at M = 20 to 200, L = 2 to 10 central and minimum films had up to 0.023 and 0.08, and 0.012 on a quarter.
HALF_SWEEP_ERROR = 0.02
# Least distance of the inlet's edge from the axis [a], somewhat above the MIN_WIDTH of a grid on which a film is solved,
# and the largest inlet sweep over the half-width of the pressure: a light load has no pressure spike, and its pressure
# rises over the half-width. With half or twice that fraction, twice or half the cells, films changed by 0.14 % at most.
INLET, INLET_SWEEP_FRACTION = 1.25, 0.1
# The most cells across of plane strain, by default and for a requested error: some seconds, and a minute.
MAX_CELLS, MAX_REQUESTED_CELLS = 3200, 6400
# Least factor on the error that is aimed at where one takes more cells than are allowed: the error that they reach is
# met within it.
AIMED_STEP = 1.05
# Length [m] of a grid in plane strain, where none is given: it has no effect.
PERIOD = 1e-3
# Cells along the length on which the dry contact of a shape that varies along it is solved, to tell its width alone.
DRY_CELLS_ALONG = 16
# Factor on the cells that the film needs, from which cells are not refined for friction, heat and load fraction: the
# friction below a pressure spike would take any number of them.
REFINED_FOR_FRICTION = 2.0
# Cells for the shortest wavelength of a surface, which show its height to 3 %, and along a roller with ends, a crown, a
# profile or a tilt: with half of these the films of three rollers changed by 0.1 % at most, with twice by 0.01 %.
CELLS_PER_WAVE, CELLS_ALONG_ROLLER = 8, 48
# The dry contact that tells how far a rough film reaches: its cells across, its largest width over the half-width of
# Hertz, and the fraction of the load that asperities further out must carry to count. With half or twice of each, the
# reach of eight rough contacts changed by 0.05 half-widths at most.
REACH_CELLS, MAX_REACH, LIGHTLY_LOADED = 256, 64, 1e-3


def plan_of_film(
    scene: Scene,
    error: float | None,
    period: float | None,
    grid: Grid | None,
    padding: Padding | Paddings | None = None,
) -> Plan:
    """Return the plan of a lubricated scene.

    Parameters
    ----------
    scene
        The lubricated scene.
    error
        Relative error of the central and the minimum film thickness, friction, temperatures and the fraction of
        the load that asperities carry. None is DEFAULT_ERROR, on MAX_CELLS across at most, not MAX_REQUESTED_CELLS.
    period
        Length of the grid [m]; chosen if None.
    grid
        Grid to keep; chosen if None.
    padding
        Boundary conditions to keep; all images are summed if None.

    Raises
    ------
    InvalidInput
        For a padding on which a film cannot be solved.
    """
    padding = padding or ExactPeriodicity()
    requirements, scales = grid_requirements(scene, padding), lubricated_scales(scene)
    warnings = []
    most_cells = MAX_CELLS if error is None else MAX_REQUESTED_CELLS
    error = error or DEFAULT_ERROR
    if grid is not None:
        warnings.append("The grid is given, so its error is not predicted: solve, and read answer.error.")
    else:
        if not requirements.varies and period is None:
            period = PERIOD
        inlet_width = film_grid(scene, error, requirements.extent(period)[1]).extent[0]
        width = requirements.width(inlet_width)
        grid = film_grid(
            scene,
            error,
            requirements.length(period, width),
            shortest_wavelengths=requirements.shortest_wavelengths,
            longer=width / inlet_width,
            most_cells=most_cells,
        )
        if grid.cells[0] >= most_cells:
            warnings.append(
                f"plan.error is {error:.2g}: a film has {most_cells} cells across at most, give about "
                f"{ROUNDED_UP * expected_error(scene, grid):.2g}, which they reach."
            )
    (nx, ny), width = grid.cells, grid.extent[0]
    check_film_padding(padding, ny)
    if across_and_along(padding)[1].window is not None:
        warnings.append(
            f"padding is {padding!r}: the error of a film by the images that it leaves out is not predicted, give "
            "ExactPeriodicity()."
        )
    reasons = [
        f"the formula of Moes gives a film of {readable(scales.expected_film * scales.film)} at "
        f"M = {scales.load_parameter:.3g}, L = {scales.viscosity_parameter:.3g}",
        f"the inlet begins {width / 2 / scales.hertz.half_width:.2g} half-widths from the axis: the error of cutting it "
        "off there falls with the square of the distance",
    ]
    floats = LINE_MATRICES * nx**2
    if ny > 1:
        warnings.append(
            "The error of a film that varies along its length is not predicted: solve, and read answer.error."
        )
        floats = FLOATS_PER_CELL * prod(grid.cells) + FOURIER_MATRICES * nx**2
    is_predicted = not warnings  # each of them says why the film may not have the error requested
    return Plan(
        scene=scene,
        grid=grid,
        padding=padding,
        error=error if is_predicted else inf,
        bytes=8 * floats,
        reasons=tuple(reasons),
        warnings=tuple(warnings),
    )


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
        Factor by which the inlet is longer than the error takes.
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
        if across <= most_cells or aimed >= 2 * HALF_SWEEP_ERROR:  # beyond that cells are no larger
            break
        aimed *= max(across / most_cells, AIMED_STEP)  # a shorter inlet, and larger cells
    across = most_cells if aimed > error else min(across, most_cells)
    along = 1
    if shortest_wavelengths[1] < inf:
        along = ROW_MULTIPLE * ceil(CELLS_PER_WAVE * period / shortest_wavelengths[1] / ROW_MULTIPLE)
    if scene.roller_length is not None:
        along = max(along, CELLS_ALONG_ROLLER)
    return Grid((across, along), (2 * inlet * a, period))


def dry_reach(scene: Scene, period: float, cells_along: int) -> float:
    """Return how far the dry contact reaches from x = 0, over Hertz's half-width and at least that.

    Asperities further out that carry less than the fraction ``LIGHTLY_LOADED`` of the load do not count. The contact is
    solved over a ``period`` [m], on wider and wider grids until it fits.
    """
    if scene.hertz is None or all(isinstance(shape, Cylinder) for shape in scene.shapes):
        return 1.0
    load = scene.load if isinstance(scene.load, ConstantLoad) else LineLoad(scene.largest_load)
    solids, a = instantaneous(scene.solids), scene.hertz.half_width
    dry = replace(scene, load=load, solids=solids, lubrication=None, wear=None, outputs=())
    reach, width = 1.0, 2
    while width < MAX_REACH and width < 2 * MIN_WIDTH * reach:
        width *= 2
        grid = Grid((REACH_CELLS, cells_along), (width * a, period))
        problem = dry.problem(grid, ExactPeriodicity())
        pressure = solve_contact(problem, SolveOptions(tolerance=DRY_TOLERANCE)).pressure
        carried = pressure.sum(axis=1)
        outside = np.cumsum(carried + carried[::-1])[: REACH_CELLS // 2]
        light = np.count_nonzero(outside < LIGHTLY_LOADED * carried.sum())
        reach = max(1.0, float(grid.x[-1 - light]) / a)
    return reach


def inlet_sweep(scales: FilmScales) -> float:
    """Return the length [a] over which the pressure rises in the inlet: there the gap of Hertz is the film of Moes."""
    return float(min((scales.expected_film / SWEEP) ** (2 / 3), INLET_SWEEP_FRACTION * scales.relative_half_width))


def expected_error(scene: Scene, grid: Grid) -> float:
    """Return the relative error that the film of a smooth cylinder is expected to have on a grid: by cells and inlet.

    The inlet counts from the edge of Hertz's contact, not from the axis, by which its error is rather over-estimated.
    """
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
    if first.cell_size[0] < REFINED_FOR_FRICTION * grid.cell_size[0]:
        bounded += [parts for parts in errors.values() if isfinite(parts.total)]
    inlet, cells = (max(getattr(parts, cause) or 0.0 for parts in bounded) for cause in ("inlet", "discretisation"))
    remaining, longer = error, min(max(1.0, sqrt(2 * inlet / error)), 2.0)
    if given is not None:  # the error of the inlet remains: half of `remaining` is left to cells, or nothing meets it
        remaining, longer = 2 * (error - inlet) if inlet < error else error, 1.0
        if ny > 1 or cells <= remaining / 2:
            return None
    if inlet + cells <= error or nx >= most_cells:
        return None
    # errors of second order, on cells for four fifths of half the remaining error; at most doubled at once
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
