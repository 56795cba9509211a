"""Steady film on one grid: coarser grids first, higher speeds where a cold start fails, and the contact in SI units."""

from dataclasses import replace
from math import inf, sqrt

import numpy as np

from contactstudy.domain.grid import Grid, Padding, Paddings
from contactstudy.lubrication.along_length import KrylovStep
from contactstudy.lubrication.film_equation import Film, Mask
from contactstudy.lubrication.lubricated_contact import (
    FilmStatus,
    LubricatedContact,
    rise_beside_lowest,
    shear_stress,
)
from contactstudy.lubrication.plane_strain import DirectStep
from contactstudy.lubrication.posed_film import PosedFilm, hertz_start, pose, refined, restart
from contactstudy.lubrication.pseudo_time import (
    FilmControls,
    FilmIteration,
    StepSolver,
    iterate,
)
from contactstudy.scene.scene import Scene

# The inlet sweep over the half-width is (H / 0.94)^(2/3), of the film in Hertz units H. An inlet of x_a half-widths
# gives a film that is too thin by 0.9 H / x_a^2.
SWEEP, INLET_ERROR = 0.94, 0.9
# A film that is more than this too thin is starved. Cells that are one inlet sweep wide, or across which the film rises
# by this share beside its lowest cell, do not resolve it.
STARVED, STEEP = 0.05, 0.5
# The first step in pseudo-time after a coarser grid, and the change of ln(eta) in a step that is not shortened: in plane
# strain, and where the film varies along its length.
REFINED_STEP, REFINED_ROUGH_STEP, ROUGH_CHANGE = 0.3, 0.003, 6.0
# Where a cold start fails: factors in speed to go up by, how often at most, and the least one to come down by.
SPEED_STEP, FASTEST, LEAST_SPEED_STEP = 10.0, 4, 1.05


def solve_on(
    scene: Scene,
    grid: Grid,
    padding: Padding | Paddings,
    controls: FilmControls,
    start: LubricatedContact | None = None,
) -> LubricatedContact:
    """Solve the film on one grid, from a cold start, or from another contact where that converges."""
    posed = pose(scene, grid, padding)
    last = None
    if start is not None and start.status is not FilmStatus.NOT_CONVERGED:
        film, cavitated = restart(posed, start)
        same = start.grid == grid
        last = _iterated(posed, film, controls if same else _refining(posed, controls), cavitated)
    if last is None or not last.converged(controls.tolerance):
        last = continued(posed, controls)
    return contact_of(scene, grid, padding, posed, last, controls.tolerance)


def step_solver(posed: PosedFilm) -> StepSolver:
    """Return how steps are solved: directly in plane strain, else by GMRES."""
    if posed.upstream.cells[1] == 1:
        return DirectStep.for_equation(posed.equation)
    return KrylovStep(posed.deflection)


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
    return _iterated(posed, film, _refining(posed, controls), cavitated)


def _refining(posed: PosedFilm, controls: FilmControls) -> FilmControls:
    """Return the controls after a coarser grid."""
    smooth = posed.upstream.cells[1] == 1
    return replace(controls, time_step=REFINED_STEP if smooth else REFINED_ROUGH_STEP)


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
    filled[: rows - 1] = equation.filled(last.film)[:-1]
    content = equation.content(last.film)[-2] * scales.film
    filled[rows - 1 :] = np.minimum(content / film[rows - 1 :], 1) if equation.conserves else 1
    flow = last.linear.flux[2:-1].mean(axis=1)
    if not equation.conserves:  # where the film opens for good, any flow may appear
        flow = flow[: np.flatnonzero((last.film.pressure > 0).any(axis=1))[-1] - 1]
    mean_speed = equation.speed * scales.lubrication.largest_speed
    return LubricatedContact(
        scene=scene,
        grid=grid,
        padding=padding,
        scales=scales,
        pressure=pressure,
        film=film,
        film_fraction=filled,
        shear=shear_stress(scales, mean_speed, pressure, film, filled),
        mean_speed=mean_speed,
        separation=separation,
        status=_status(posed, last, tolerance),
        iterations=last.iterations,
        linear_iterations=last.linear_iterations,
        residual=last.residual,
        flow=float(flow.mean()) * scales.film * scales.lubrication.largest_speed,
        flux_spread=float(np.ptp(flow) / abs(flow.mean())) if flow.any() else inf,
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
