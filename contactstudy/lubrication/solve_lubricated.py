"""Scene -> lubricated contact: the grid, nested grids, and what the film can be trusted for."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import ceil, sqrt
from typing import Literal

import numpy as np

from contactstudy.domain.checks import InvalidInput, NotDefined, positive, whole
from contactstudy.domain.device import Precision
from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid
from contactstudy.domain.padding import ExactPeriodicity, Padding, Paddings, across_and_along
from contactstudy.elasticity.convolution import Convolution, superposed
from contactstudy.lubrication.film_equation import Film, FilmEquation, Mask
from contactstudy.lubrication.lubricated_contact import (
    FilmScales,
    FilmStatus,
    LubricatedContact,
    rise_beside_lowest,
    shear_stress,
)
from contactstudy.lubrication.plane_strain import DirectStep
from contactstudy.lubrication.pseudo_time import FilmControls, FilmIteration, iterate
from contactstudy.scene.bodies import response
from contactstudy.scene.load import ConstantLoad
from contactstudy.scene.scene import Scene

# Of the film in Hertz units H, the inlet sweep is (H / 0.94)^(2/3) a wide. Half of it per cell gives the smallest
# film within 2 %, and an inlet of x_a half-widths a film that is too thin by 0.9 H / x_a^2.
SWEEP, HALF_SWEEP_ERROR, INLET_ERROR = 0.94, 0.02, 0.9
# An inlet is no shorter than this, an outlet reaches this far or further by so many times sqrt(2 H) [a].
INLET, OUTLET, OUTLET_GROWTH = 3.0, 1.5, 2.5
# A film that is more than this too thin is starved. Cells that are one inlet sweep wide, or across which the film rises
# by this share beside its lowest cell, do not resolve it.
STARVED, STEEP = 0.05, 0.5
# Rounds of refinement towards an error, and the most cells across of plane strain.
REFINEMENTS, MOST_CELLS = 4, 3200
# Grids are halved down to so many cells: across in plane strain, across and along else. Rows divide by LEVELS.
COARSEST, COARSEST_ROUGH, COARSEST_ALONG, LEVELS = 200, 48, 16, 8
# The first step in pseudo-time after a coarser grid.
REFINED_STEP = 0.3


def lubricated_scales(scene: Scene) -> FilmScales:
    """Return the units of a lubricated ``scene``.

    Raises :class:`~contactstudy.InvalidInput` for a scene that is not lubricated, and for what no film is known with.
    """
    if not isinstance(scene, Scene) or scene.lubrication is None:
        raise InvalidInput(
            "solve_lubricated.scene has no lubrication: give Scene.lubrication a "
            "Lubrication(lubricant, mean_speed=...), or call contactstudy.solve."
        )
    if scene.hertz is None:
        raise NotDefined(
            "Scene.shapes have no curvature, so that no inlet draws lubricant in: give a Cylinder."
        )
    if not isinstance(scene.load, ConstantLoad):
        raise InvalidInput(
            "Scene.load changes in time, and this film is a steady one: give a LineLoad, or call "
            "contactstudy.evolve_lubricated with the history of its speed and load."
        )
    return FilmScales(scene.hertz, scene.lubrication)


def film_grid(
    scene: Scene,
    error: float = 1e-2,
    period: float = 1e-3,
    *,
    longer: float = 1.0,
    finer: float = 1.0,
) -> Grid:
    """Return the grid of plane strain on which central and smallest film are within a relative ``error``.

    One half of the error is the inlet's, one that of the cells; the cells resolve the inlet sweep. The inlet is
    ``longer`` and the cells are ``finer`` by a factor. ``period`` [m] does not bear on the answer.
    """
    scales = lubricated_scales(scene)
    film = scales.expected_film
    inlet = longer * max(INLET, sqrt(2 * INLET_ERROR * film / error))
    sweep = (film / SWEEP) ** (2 / 3)
    cell = sweep / 2 * min(1.0, sqrt(error / 2 / HALF_SWEEP_ERROR)) / finer
    cells = min(LEVELS * ceil(2 * inlet / min(cell, 0.05) / LEVELS), MOST_CELLS)
    return Grid((cells, 1), (2 * inlet * scales.hertz.half_width, period))


@dataclass(frozen=True, eq=False)
class PosedFilm:
    """A film equation in Hertz units on an ``upstream`` grid: beyond it the outlet is cavitated throughout.

    ``operator_on`` makes the deflection on another grid.
    """

    equation: FilmEquation
    upstream: Grid
    scales: FilmScales
    operator_on: Callable[[Grid], Convolution]

    def coarser(self) -> "PosedFilm | None":
        """Return the same with half the cells along each axis that is long and even; None if neither is."""
        (nx, ny), equation = self.upstream.cells, self.equation
        least = COARSEST if ny == 1 else COARSEST_ROUGH
        across = 2 if nx % 2 == 0 and nx >= 2 * least else 1
        along = 2 if ny % 2 == 0 and ny >= 2 * COARSEST_ALONG else 1
        if across * along == 1:
            return None
        nx, ny = nx // across, ny // along
        grid = Grid((nx, ny), self.upstream.extent)
        coarse = replace(
            equation,
            gap=equation.gap.reshape(nx, across, ny, along).mean(axis=(1, 3)),
            deflection=self.operator_on(grid),
            cell=(equation.cell[0] * across, equation.cell[1] * along),
        )
        return replace(self, equation=coarse, upstream=grid)


def pose(scene: Scene, grid: Grid, padding: Padding | Paddings) -> PosedFilm:
    """Return the film equation of ``scene`` on ``grid``, up to where the outlet holds no pressure any more."""
    scales = lubricated_scales(scene)
    paddings = across_and_along(padding)
    if paddings[0].wraps or (grid.cells[1] > 1 and not paddings[1].wraps):
        raise InvalidInput(
            f"padding is {padding!r}: a film flows in at one side and out at the other, and is periodic along the "
            "length, give one for the length that wraps, such as ExactPeriodicity()."
        )
    problem = replace(scene, lubrication=None, outputs=()).problem(grid, paddings)
    hertz = scales.hertz
    outlet = max(OUTLET, 1 + OUTLET_GROWTH * sqrt(2 * scales.expected_film)) * hertz.half_width
    rows = min(LEVELS * ceil(np.count_nonzero(grid.x < outlet) / LEVELS), grid.cells[0])
    oil, peak = scales.lubrication.lubricant, hertz.peak_pressure
    weights = response(scene.solids, problem.scales.length)

    def operator_on(upstream: Grid) -> Convolution:
        operator = superposed(weights, upstream, paddings)
        return operator.scaled(peak / scales.film, Precision.DOUBLE)

    def log_viscosity(pressure: Array) -> tuple[Array, Array]:
        value, slope = oil.viscosity_law.log_ratio(peak * pressure, oil.pressure_viscosity)
        return value, peak * slope

    def density(pressure: Array) -> tuple[Array, Array]:
        value, slope = oil.density.ratio(peak * pressure)
        return value, peak * slope

    upstream = Grid((rows, grid.cells[1]), (rows * grid.cell[0], grid.period))
    equation = FilmEquation(
        gap=problem.undeformed_gap[:rows] / scales.film,
        deflection=operator_on(upstream),
        cell=(grid.cell[0] / hertz.half_width, grid.cell[1] / hertz.half_width),
        resistance=scales.resistance,
        load=hertz.load_per_length / (hertz.half_width * peak),
        log_viscosity=log_viscosity,
        density=density,
    )
    return PosedFilm(equation, upstream, scales, operator_on)


def solve_lubricated(
    scene: Scene,
    grid: Grid | None = None,
    padding: Padding | Paddings = ExactPeriodicity(),  # noqa: B008 (a frozen value)
    *,
    error: float | None = None,
    tolerance: float = 1e-8,
    max_iterations: int = 300,
    start: LubricatedContact | None = None,
) -> LubricatedContact:
    """Solve the steady, isothermal, fully flooded film of ``scene``, with mass-conserving cavitation.

    Parameters
    ----------
    scene
        A scene with ``lubrication``.
    grid
        Cells (x, y); one cell along the length is plane strain. Lubricant enters at smaller x. Chosen for the ``error``
        where none is given.
    padding
        Along the length, one that wraps.
    error
        Relative error of central and smallest film to reach, 1 % without a grid. With it the contact has an
        estimate of its errors as ``error``, found on further grids.
    tolerance, max_iterations
        Where the iteration stops: a residual, and a number of steps.
    start
        A contact on the same grid to go on from, such as that at a somewhat higher speed.

    Returns
    -------
    LubricatedContact
        Pressure, film and film fraction (x, y) and a status.

    Raises
    ------
    InvalidInput
        For a scene without lubrication, or with what no film is known with.
    """
    positive("solve_lubricated.tolerance", tolerance, "give a tolerance above 0, such as 1e-8")
    whole("solve_lubricated.max_iterations", max_iterations, 0, "give a whole number from 0 on")
    controls = FilmControls(tolerance=tolerance, max_iterations=max_iterations)
    if error is None and grid is not None:
        return _solve(scene, grid, padding, controls, start)
    from contactstudy.lubrication.film_error import film_error

    error = positive("solve_lubricated.error", 1e-2 if error is None else error, "give one above 0")
    longer = finer = 1.0
    for _ in range(REFINEMENTS):
        fitting = grid or film_grid(scene, error, longer=longer, finer=finer)
        contact = _solve(scene, fitting, padding, controls, start)
        contact = replace(contact, error=film_error(contact))
        assert contact.error is not None
        films = contact.error.central_film, contact.error.minimum_film
        inlet = max(parts.inlet for parts in films)
        cells = max(parts.discretisation for parts in films)
        if grid is not None or inlet + cells <= error:
            break
        longer *= min(max(1.0, sqrt(2 * inlet / error)), 2.0)
        finer *= min(max(1.0, sqrt(2.5 * cells / error)), 2.0)
    return contact


def _solve(
    scene: Scene,
    grid: Grid,
    padding: Padding | Paddings,
    controls: FilmControls,
    start: LubricatedContact | None,
) -> LubricatedContact:
    posed = pose(scene, grid, padding)
    film = None if start is None else restart(posed, start)
    last = _nested(posed, controls) if film is None else _iterated(posed, film, controls)
    return contact_of(scene, grid, padding, posed, last, controls.tolerance)


def _nested(posed: PosedFilm, controls: FilmControls) -> FilmIteration:
    """Iterate on coarser grids first, where a distant start costs little."""
    coarser = posed.coarser()
    if coarser is None:
        return _iterated(posed, hertz_start(posed), controls)
    coarse = _nested(coarser, controls)
    film, cavitated = _refined(posed.equation, coarse)
    return _iterated(posed, film, replace(controls, time_step=REFINED_STEP), cavitated)


def _iterated(
    posed: PosedFilm, film: Film, controls: FilmControls, cavitated: Mask | None = None
) -> FilmIteration:
    solver = DirectStep.for_equation(posed.equation)
    return iterate(posed.equation, film, solver, controls, cavitated=cavitated)


def _refined(equation: FilmEquation, coarse: FilmIteration) -> tuple[Film, Mask]:
    """Return a film on a finer grid, raised so that it is nowhere below half the coarse one, and its cavitated cells."""
    shape = equation.gap.shape
    pressure = coarse.film.pressure
    modes: tuple[Literal["edge", "wrap"], ...] = ("edge", "wrap")
    for axis, ends in enumerate(modes):
        if shape[axis] > pressure.shape[axis]:
            pressure = _halved(pressure, axis, ends)
    blocks = [fine // wide for fine, wide in zip(shape, coarse.film.pressure.shape, strict=True)]
    cavitated = coarse.cavitated.repeat(blocks[0], axis=0).repeat(blocks[1], axis=1)
    void = coarse.film.void.repeat(blocks[0], axis=0).repeat(blocks[1], axis=1)
    cavitated &= ~equation.fixed
    pressure = np.where(cavitated | equation.fixed, 0, pressure)
    void = np.where(cavitated, void, 0)
    film = equation.film_of(pressure, void, coarse.film.separation)
    lowest = float(coarse.film.film.min()) / 2
    rise = max(0.0, lowest - float(film.film.min()))
    return equation.film_of(pressure, void, film.separation + rise), cavitated


def _halved(values: Array, axis: int, ends: Literal["edge", "wrap"]) -> Array:
    """Return values at the middles of cells half as long, linear between those of the cells."""
    width = [(0, 0), (0, 0)]
    width[axis] = (1, 1)
    around = np.moveaxis(np.pad(values, width, mode=ends), axis, 0)
    middle = around[1:-1]
    fine = np.stack((3 * middle + around[:-2], 3 * middle + around[2:]), axis=1) / 4
    return np.moveaxis(fine.reshape(-1, fine.shape[2]), 0, axis)


def hertz_start(posed: PosedFilm) -> Film:
    """Return Hertz's pressure, and a separation at which the smallest film is that of Moes."""
    equation = posed.equation
    x = equation.cell[0] * np.arange(len(equation.gap))
    # the axis, where the gap of a symmetric contact has its least mean over the length
    x -= x[np.argmin(equation.gap.mean(axis=1))]
    pressure = np.broadcast_to(
        np.sqrt(np.clip(1 - x**2, 0, None))[:, None], equation.gap.shape
    ).copy()
    pressure[equation.fixed] = 0
    pressure *= equation.load / (pressure.sum() * equation.cell[0] / pressure.shape[1])
    void = np.zeros_like(pressure)
    below = (equation.gap + equation.deflection(pressure)).min()
    return equation.film_of(pressure, void, posed.scales.expected_film - below)


def restart(posed: PosedFilm, contact: LubricatedContact) -> Film:
    """Return the film of another contact on the same grid, in the units of this one."""
    scales, shape = posed.scales, posed.equation.gap.shape
    rows = shape[0]
    if contact.pressure[:rows].shape != shape:
        raise InvalidInput(
            f"solve_lubricated.start has the shape {contact.pressure.shape}: give a contact on this grid."
        )
    pressure = contact.pressure[:rows] / scales.hertz.peak_pressure
    pressure[posed.equation.fixed] = 0
    void = np.where(pressure > 0, 0.0, 1 - contact.film_fraction[:rows])
    return posed.equation.film_of(pressure, void, contact.separation / scales.film)


def contact_of(
    scene: Scene,
    grid: Grid,
    padding: Padding | Paddings,
    posed: PosedFilm,
    last: FilmIteration,
    tolerance: float,
) -> LubricatedContact:
    """Return the contact of an iteration in SI units, on the whole grid."""
    equation, scales, rows = posed.equation, posed.scales, posed.upstream.cells[0]
    pressure = np.zeros(grid.cells)
    pressure[:rows] = last.film.pressure * scales.hertz.peak_pressure
    problem = replace(scene, lubrication=None, outputs=()).problem(grid, across_and_along(padding))
    separation = last.film.separation * scales.film
    film = separation + problem.undeformed_gap + problem.operator(pressure)
    # downstream of the last balance streamers carry what left it
    filled = np.zeros(grid.cells)
    filled[: rows - 1] = 1 - last.film.void[:-1]
    content = equation.content(last.film)[-2] * scales.film
    filled[rows - 1 :] = np.minimum(content / film[rows - 1 :], 1)
    flow = last.linear.flux[2:-1].mean(axis=1)
    return LubricatedContact(
        scene=scene,
        grid=grid,
        padding=padding,
        scales=scales,
        pressure=pressure,
        film=film,
        film_fraction=filled,
        shear=shear_stress(scales, pressure, film, filled),
        separation=separation,
        status=_status(posed, last, tolerance),
        iterations=last.iterations,
        linear_iterations=last.linear_iterations,
        residual=last.residual,
        flux_spread=float(np.ptp(flow) / flow.mean()),
    )


def _status(posed: PosedFilm, last: FilmIteration, tolerance: float) -> FilmStatus:
    if not last.converged(tolerance):
        return FilmStatus.NOT_CONVERGED
    equation = posed.equation
    axis = int(np.argmin(equation.gap.mean(axis=1)))
    film = float(last.film.film[axis].mean())
    if film < SWEEP * equation.cell[0] ** 1.5 or rise_beside_lowest(last.film.film) > STEEP:
        return FilmStatus.FILM_BELOW_CELL
    if INLET_ERROR * film > STARVED * (axis * equation.cell[0]) ** 2:
        return FilmStatus.STARVED_INLET
    return FilmStatus.CONVERGED
