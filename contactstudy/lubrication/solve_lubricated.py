"""Scene -> lubricated contact: the grid, nested grids, and what the film can be trusted for."""

from dataclasses import replace
from math import ceil, inf, sqrt

import numpy as np

from contactstudy.domain.checks import InvalidInput, positive, whole
from contactstudy.domain.grid import Grid
from contactstudy.domain.padding import ExactPeriodicity, Padding, Paddings
from contactstudy.lubrication.along_length import KrylovStep
from contactstudy.lubrication.film_equation import Film, Mask
from contactstudy.lubrication.lubricated_contact import (
    FilmStatus,
    LubricatedContact,
    rise_beside_lowest,
    shear_stress,
)
from contactstudy.lubrication.plane_strain import DirectStep
from contactstudy.lubrication.posed_film import (
    LEVELS,
    PosedFilm,
    hertz_start,
    lubricated_scales,
    pose,
    refined,
    restart,
)
from contactstudy.lubrication.pseudo_time import (
    FilmControls,
    FilmIteration,
    StepSolver,
    iterate,
)
from contactstudy.scene.load import ConstantLoad
from contactstudy.scene.scene import Scene
from contactstudy.scene.shapes.carried import Carried

# Of the film in Hertz units H, the inlet sweep is (H / 0.94)^(2/3) a wide. Half of it per cell gives the smallest
# film within 2 %, and an inlet of x_a half-widths a film that is too thin by 0.9 H / x_a^2.
SWEEP, HALF_SWEEP_ERROR, INLET_ERROR = 0.94, 0.02, 0.9
# An inlet is no shorter than this [a].
INLET = 3.0
# A film that is more than this too thin is starved. Cells that are one inlet sweep wide, or across which the film rises
# by this share beside its lowest cell, do not resolve it.
STARVED, STEEP = 0.05, 0.5
# Rounds of refinement towards an error, and the most cells across of plane strain.
REFINEMENTS, MOST_CELLS = 4, 3200
# Cells for the shortest wave of a surface.
PER_WAVE = 8
# The first step in pseudo-time after a coarser grid, and the change of ln(eta) in a step that is not shortened: in plane
# strain, and where the film varies along its length.
REFINED_STEP, REFINED_ROUGH_STEP, ROUGH_CHANGE = 0.3, 0.003, 6.0
# Where a cold start fails: factors in speed to go up by, how often at most, and the least one to come down by.
SPEED_STEP, FASTEST, LEAST_SPEED_STEP = 10.0, 4, 1.05


def film_grid(
    scene: Scene,
    error: float = 1e-2,
    period: float = 1e-3,
    *,
    finest: tuple[float, float] = (inf, inf),
    longer: float = 1.0,
    finer: float = 1.0,
) -> Grid:
    """Return a grid on which central and smallest film of a smooth contact are within a relative ``error``.

    Parameters
    ----------
    scene
        A lubricated scene.
    error
        One half of it is the inlet's, one that of the cells, which resolve the inlet sweep.
    period
        Length [m], which does not bear on the film in plane strain.
    finest
        Shortest wavelengths (across, along) of the surfaces [m]; ``PER_WAVE`` cells each. One cell along the length
        where nothing varies along it.
    longer, finer
        Factors by which the inlet is longer and the cells are finer.
    """
    scales = lubricated_scales(scene)
    film, a = scales.expected_film, scales.hertz.half_width
    inlet = longer * max(INLET, sqrt(2 * INLET_ERROR * film / error))
    sweep = (film / SWEEP) ** (2 / 3)
    cell = sweep / 2 * min(1.0, sqrt(error / 2 / HALF_SWEEP_ERROR)) / finer
    cell = min(cell, 0.05, finest[0] / a / PER_WAVE)
    across = min(LEVELS * ceil(2 * inlet / cell / LEVELS), MOST_CELLS)
    along = 1 if finest[1] == inf else LEVELS * ceil(PER_WAVE * period / finest[1] / LEVELS)
    return Grid((across, along), (2 * inlet * a, period))


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
    if isinstance(scene, Scene):
        _steady(scene)
    controls = FilmControls(tolerance=tolerance, max_iterations=max_iterations)
    if error is None and grid is not None:
        return _solve(scene, grid, padding, controls, start)
    from contactstudy.lubrication.film_error import film_error

    if grid is None and any(varies_along(shape) for shape in scene.shapes):
        raise InvalidInput(
            "solve_lubricated.grid is None, and Scene.shapes vary along the length: give a grid, such as "
            "contactstudy.plan(scene).grid."
        )
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
        finest = fitting.cells[0] == MOST_CELLS
        if grid is not None or finest or inlet + cells <= error:
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
    last = continued(posed, controls) if film is None else _iterated(posed, film, controls)
    return contact_of(scene, grid, padding, posed, last, controls.tolerance)


def step_solver(posed: PosedFilm) -> StepSolver:
    """Return how steps are solved: directly in plane strain, else by GMRES."""
    if posed.upstream.cells[1] == 1:
        return DirectStep.for_equation(posed.equation)
    return KrylovStep(posed.deflection)


def _steady(scene: Scene) -> None:
    """Refuse a scene whose film changes in time."""
    remedy = "and this film is a steady one: call contactstudy.evolve_lubricated"
    if not isinstance(scene.load, ConstantLoad):
        raise InvalidInput(f"Scene.load changes in time, {remedy}, or give a LineLoad.")
    for number, shape in enumerate(scene.shapes):
        if isinstance(shape, Carried):
            raise InvalidInput(f"Scene.shapes[{number}] moves with a body, {remedy}.")


def varies_along(shape: object) -> bool:
    """Return whether a shape varies along the length, as far as its detail says."""
    detail = getattr(shape, "detail", None)
    return detail is None or detail.finest[1] < inf or detail.roller > 0


def continued(posed: PosedFilm, controls: FilmControls) -> FilmIteration:
    """Iterate from a cold start, or where that fails from the film at higher speeds down to this one."""
    last = first = _nested(posed, controls)
    resistance = faster = posed.equation.resistance
    for _ in range(FASTEST):
        if last.converged(controls.tolerance):
            break
        faster *= SPEED_STEP
        last = _nested(posed.at(faster), controls)
    else:
        return first
    step = SPEED_STEP
    while faster > resistance and step > LEAST_SPEED_STEP:
        slower = max(faster / step, resistance)
        trial = _iterated(posed.at(slower), last.film, controls, last.cavitated)
        if trial.converged(controls.tolerance):
            last, faster = trial, slower
        else:
            step = sqrt(step)
    return last if faster == resistance else first


def _nested(posed: PosedFilm, controls: FilmControls) -> FilmIteration:
    """Iterate on coarser grids first, where a distant start costs little."""
    coarser = posed.coarser()
    if coarser is None:
        return _iterated(posed, hertz_start(posed), controls)
    coarse = _nested(coarser, controls)
    film, cavitated = refined(posed.equation, coarse)
    smooth = posed.upstream.cells[1] == 1
    time_step = REFINED_STEP if smooth else REFINED_ROUGH_STEP
    return _iterated(posed, film, replace(controls, time_step=time_step), cavitated)


def _iterated(
    posed: PosedFilm, film: Film, controls: FilmControls, cavitated: Mask | None = None
) -> FilmIteration:
    if posed.upstream.cells[1] > 1:
        controls = replace(controls, viscosity_change=ROUGH_CHANGE)
    return iterate(posed.equation, film, step_solver(posed), controls, cavitated=cavitated)


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
    separation = last.film.separation * scales.film
    film = separation + posed.problem.undeformed_gap + posed.problem.operator(pressure)
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
        flow=float(flow.mean()) * scales.film * scales.lubrication.mean_speed,
        flux_spread=float(np.ptp(flow) / flow.mean()),
    )


def _status(posed: PosedFilm, last: FilmIteration, tolerance: float) -> FilmStatus:
    if not last.converged(tolerance):
        return FilmStatus.NOT_CONVERGED
    equation = posed.equation
    axis = int(np.argmin(np.abs(posed.x)))
    film = float(last.film.film[axis].mean())
    if film < SWEEP * equation.cell[0] ** 1.5 or rise_beside_lowest(last.film.film) > STEEP:
        return FilmStatus.FILM_BELOW_CELL
    if INLET_ERROR * film > STARVED * posed.x[0] ** 2:
        return FilmStatus.STARVED_INLET
    return FilmStatus.CONVERGED
