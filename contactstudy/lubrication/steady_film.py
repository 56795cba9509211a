"""Steady film on one grid: nested grids, continuation in speed where a cold start fails, and the contact in SI units."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import ceil, inf, log

import numpy as np

from contactstudy.domain.grid import Array, Grid, Padding, Paddings
from contactstudy.lubrication.film_equation import INLET_CELLS, OUTLET_CELLS, Film, FilmEquation, Mask
from contactstudy.lubrication.lubricated_contact import FilmSolution, ShearedFilm, rise_beside_lowest
from contactstudy.lubrication.mixed import SpeedSteps, from_higher_speeds, other_films, solve_mixed
from contactstudy.lubrication.newton.pseudo_time import FilmControls, FilmIteration, iterate
from contactstudy.lubrication.posed_film import (
    OUTLET,
    PosedFilm,
    hertz_start,
    linear_solver,
    pose,
    prolongated,
    start_from,
    with_minimum_film,
)
from contactstudy.scene.scene import Scene
from contactstudy.solvers.solution import Status

# The inlet pressure sweep over the half-width is (H / SWEEP)^(2/3) with the film thickness H in Hertz units: there the
# gap beside Hertz's contact, (2 sqrt(2) / 3) x^(3/2), is the film. An inlet of x_a half-widths gives a film that is too
# thin by the fraction INLET_ERROR H / x_a^2, as at Moes's load parameter M = 2 and material parameter L = 0; heavier
# loads lose less.
SWEEP, INLET_ERROR = 0.94, 0.9
# An inlet whose length makes the film thinner by more than the fraction STARVED counts as starved. A film is unresolved
# on cells wider than the inlet sweep, or if it rises by more than UNRESOLVED_RISE of itself from its lowest cell to the
# next.
STARVED, UNRESOLVED_RISE = 0.05, 0.5


@dataclass(frozen=True)
class SteadyTuning:
    """Tuning constants of the starts, chosen by counts of steps on smooth and rough films.

    Attributes
    ----------
    step_after_prolongation
        First step in pseudo-time after a coarser grid. On rough films a hundredth of it took 1.3 to 4 times as long,
        and ten times it needed hundreds of linear iterations in its first steps.
    rough_change
        Largest change of ln(eta) in a step of a film that varies along its length; plane strain needs no limit.
    relative_roughness, growth
        In plane strain a second film is sought where the rms height is more than ``relative_roughness`` times the film,
        by heights that grow from that by the factor ``growth``.
    distinct
        Relative difference of the mean thickness, or part of the load that asperities carry in one film alone, by which
        two films are distinct.
    speeds
        Speeds of the continuation where a cold start fails.
    """

    step_after_prolongation: float = 0.3
    rough_change: float = 6.0
    relative_roughness: float = 2.0
    growth: float = 1.25
    distinct: float = 0.01
    speeds: SpeedSteps = SpeedSteps(10.0, 4, 1.05)  # noqa: RUF009 (a frozen value)


TUNING = SteadyTuning()


def solve_on(
    scene: Scene,
    grid: Grid,
    padding: Padding | Paddings,
    controls: FilmControls,
    start: FilmSolution | None = None,
    outlet: float = OUTLET,
) -> FilmSolution:
    """Return the film on one grid, from another contact where that converges, else from a cold start.

    Where its pressure reaches the outlet, the outlet is moved to the end of the grid. In plane strain, where the rms
    height is more than `SteadyTuning.relative_roughness` times the film, a second film is sought, and the status says if
    it exists.
    """
    posed = pose(scene, grid, padding, outlet)
    before = None if start is None or start.status is Status.FILM_NOT_CONVERGED else start
    if posed.equation.boundary_film:
        last, is_cold = _mixed_film(posed, controls, before), before is None
    else:
        last, is_cold = _full_film(posed, grid, controls, before)
    contact = film_solution(scene, grid, padding, posed, last, controls.tolerance)
    is_cut = contact.status is Status.CONTACT_AT_EDGE
    if is_cut and posed.upstream.cells[0] < grid.cells[0]:
        return solve_on(scene, grid, padding, controls, start, outlet=inf)
    if last.converged(controls.tolerance) and posed.relative_roughness > TUNING.relative_roughness:
        others = _other_films(posed, controls, is_cold=is_cold)
        if any(other.converged(controls.tolerance) and _differs(posed, last, other) for other in others):
            return replace(contact, status=Status.SEVERAL_FILMS)
    return contact


def _full_film(
    posed: PosedFilm, grid: Grid, controls: FilmControls, before: FilmSolution | None
) -> tuple[FilmIteration, bool]:
    """Return the film without asperities from one `before` if that converges, and whether its start is a cold one."""
    if before is not None:
        film, cavitated = start_from(posed, before)
        near = controls if before.grid == grid else _after_coarser_grid(controls)
        warm = _iterated(posed, film, near, cavitated)
        if warm.converged(controls.tolerance):
            return warm, False
    return continued(posed, controls), True


def _mixed_film(posed: PosedFilm, controls: FilmControls, before: FilmSolution | None) -> FilmIteration:
    """Return the film on a boundary film, from one `before`, or from that of the lubricant alone where this is thick."""
    if before is not None:
        return solve_mixed(posed, controls, start_from(posed, before))
    if posed.scales.expected_film <= posed.equation.boundary_film:
        return solve_mixed(posed, controls)
    # on nested grids: on the finest alone it took ten times as long, or did not converge between high places
    alone = _nested(replace(posed, equation=replace(posed.equation, boundary_film=0.0)), controls)
    full = alone.film
    film = with_minimum_film(posed.equation, full.pressure, full.void, full.separation, posed.equation.boundary_film)
    mixed = solve_mixed(posed, controls, (film, alone.cavitated))
    return replace(
        mixed,
        iterations=mixed.iterations + alone.iterations,
        linear_iterations=mixed.linear_iterations + alone.linear_iterations,
    )


def _other_films(posed: PosedFilm, controls: FilmControls, *, is_cold: bool) -> Iterator[FilmIteration]:
    """Iterate over films from other starts: a cold one, lower heights, and of mixed films other speeds."""
    is_mixed = posed.equation.boundary_film > 0
    if not is_cold:
        yield solve_mixed(posed, controls) if is_mixed else _nested(posed, controls)
    if is_mixed:
        yield from other_films(posed, controls)
    elif followed := _from_lower_heights(posed, controls):
        yield followed


def _from_lower_heights(posed: PosedFilm, controls: FilmControls) -> FilmIteration | None:
    """Return the film that is followed from lower heights up to these; None where that fails."""
    smooth = posed.x[:, None] ** 2 / 2
    heights, last = posed.equation.gap - smooth, None
    number = ceil(log(posed.relative_roughness / TUNING.relative_roughness) / log(TUNING.growth))
    for fraction in np.geomspace(TUNING.relative_roughness / posed.relative_roughness, 1, number + 1):
        lower = replace(posed, equation=replace(posed.equation, gap=smooth + fraction * heights))
        if last is None:
            last = _nested(lower, controls)
        else:
            before = last.film
            film = with_minimum_film(
                lower.equation, before.pressure, before.void, before.separation, float(before.thickness.min()) / 2
            )
            last = _iterated(lower, film, controls, last.cavitated)
        if not last.converged(controls.tolerance):
            return None
    return last


def _differs(posed: PosedFilm, last: FilmIteration, other: FilmIteration) -> bool:
    """Return whether two films have distinct mean thicknesses in the Hertzian zone, or asperity loads."""
    inside = np.abs(posed.x) < 1
    films = last.film, other.film
    first, second = (film.thickness[inside].mean() for film in films)
    load, other_load = (film.asperity_pressure.sum() for film in films)
    of_load = abs(load - other_load) / films[0].total_pressure.sum()
    return bool(max(abs(first - second) / first, of_load) > TUNING.distinct)


def continued(posed: PosedFilm, controls: FilmControls) -> FilmIteration:
    """Return the film from a cold start, or where that fails followed from higher speeds down to this one."""
    cold = _nested(posed, controls)
    if cold.converged(controls.tolerance):
        return cold
    from_higher_speed = from_higher_speeds(
        posed,
        TUNING.speeds,
        controls.tolerance,
        lambda faster: _nested(faster, controls),
        lambda slower, last: _iterated(slower, last.film, controls, last.cavitated),
    )
    return from_higher_speed or cold


def _nested(posed: PosedFilm, controls: FilmControls) -> FilmIteration:
    """Return the film from nested grids: a distant start costs little on the coarsest."""
    coarser = posed.coarser()
    if coarser is None:
        return _iterated(posed, hertz_start(posed), controls)
    coarse = _nested(coarser, controls)
    film, cavitated = prolongated(posed.equation, coarse)
    return _iterated(posed, film, _after_coarser_grid(controls), cavitated)


def _after_coarser_grid(controls: FilmControls) -> FilmControls:
    """Return the controls after a coarser grid."""
    return replace(controls, time_step=TUNING.step_after_prolongation)


def _iterated(posed: PosedFilm, film: Film, controls: FilmControls, cavitated: Mask | None = None) -> FilmIteration:
    """Return the film from a given one; where it varies along its length, in steps that change the viscosity less."""
    if posed.upstream.cells[1] > 1:
        controls = replace(controls, viscosity_change=TUNING.rough_change)
    return iterate(posed.equation, film, linear_solver(posed), controls, cavitated=cavitated)


def film_solution(
    scene: Scene,
    grid: Grid,
    padding: Padding | Paddings,
    posed: PosedFilm,
    last: FilmIteration,
    tolerance: float,
    film_rate: Array | None = None,
) -> FilmSolution:
    """Return the contact of an iteration on the whole grid, in SI units; ``film_rate`` (x, y) [m/s] is that upstream."""
    equation, scales, rows = posed.equation, posed.scales, posed.upstream.cells[0]

    def on_whole_grid(values: Array) -> Array:
        return np.pad(values, ((0, grid.cells[0] - rows), (0, 0)))

    pressure = on_whole_grid(last.film.total_pressure * scales.hertz.peak_pressure)
    asperities = None
    if equation.boundary_film:
        asperities = on_whole_grid(last.film.asperity_pressure * scales.hertz.peak_pressure)
    separation = last.film.separation * scales.film
    film = separation + posed.problem.undeformed_gap + posed.displacement(pressure)
    # downstream of the last cell with a balance, streamers carry the content that leaves it
    film_fraction = np.zeros(grid.cells)
    end = rows - OUTLET_CELLS
    film_fraction[:end] = equation.film_fraction(last.film)[:end]
    content = equation.content(last.film)[end - 1] * scales.film
    film_fraction[end:] = np.minimum(content / film[end:], 1) if equation.conserves else 1
    flow = last.linear.flux[INLET_CELLS:-OUTLET_CELLS].mean(axis=1)
    if not equation.conserves:  # beyond the last pressure any flow may appear
        flow = flow[: np.flatnonzero((last.film.pressure > 0).any(axis=1))[-1] - 1]
    mean_speed = equation.speed * scales.lubrication.largest_speed
    sheared = ShearedFilm(posed.instant, mean_speed, grid.cell_size[0], pressure, film, film_fraction, asperities)
    if scales.lubrication.thermal is None:
        shear, temperatures = sheared.elastic()[0], None
    else:
        # imported only for films with temperatures
        from contactstudy.lubrication.film_heat import thermal_reduction, thermal_shear

        reduction = thermal_reduction(scales, scales.lubrication.thermal, starved=_is_starved(equation, last))
        shear, temperatures = thermal_shear(sheared, scene.solids, grid, reduction)
    if film_rate is not None:
        film_rate = on_whole_grid(film_rate)
    creep_loss = 0.0
    if posed.creep is not None:
        slope = np.gradient(posed.creep(pressure), grid.cell_size[0], axis=0)
        creep_loss = float((pressure * slope).mean(axis=1).sum()) * grid.cell_size[0]
    return FilmSolution(
        scene=scene,
        grid=grid,
        padding=padding,
        scales=posed.instant,
        pressure=pressure,
        film=film,
        film_fraction=film_fraction,
        shear=np.sign(scales.lubrication.slide_roll_ratio) * shear,
        temperatures=temperatures,
        mean_speed=mean_speed,
        separation=separation,
        status=_status(posed, last, tolerance, film),
        iterations=last.iterations,
        linear_iterations=last.linear_iterations,
        residual=last.residual,
        flow=float(flow.mean()) * scales.film * scales.lubrication.largest_speed,
        contact_pressure=asperities,
        central_weights=posed.central_weights(float(film.min())),
        film_rate=film_rate,
        creep_loss=creep_loss,
        flux_spread=float(np.ptp(flow) / abs(flow.mean())) if flow.any() else inf,
    )


def _is_starved(equation: FilmEquation, last: FilmIteration) -> bool:
    """Return whether the film is as thick as its supply, which fills the gap inside the grid."""
    return equation.supplied_film < inf and bool((last.film.void[INLET_CELLS] > 0).all())


def _status(posed: PosedFilm, last: FilmIteration, tolerance: float, thickness: Array) -> Status:
    """Return the outcome of an iteration, the gravest first; the `thickness` (x, y) [m] is that on the whole grid."""
    if not last.converged(tolerance):
        return Status.FILM_NOT_CONVERGED
    equation = posed.equation
    if last.film.total_pressure[-OUTLET_CELLS - 1].any() or thickness.min() <= 0:
        return Status.CONTACT_AT_EDGE
    axis = int(np.argmin(np.abs(posed.x - posed.middle / posed.scales.hertz.half_width)))
    # a crowned film matters where it carries load
    load = last.film.total_pressure.sum(axis=0)
    film = float(last.film.thickness[axis] @ load / load.sum())
    steep = not equation.boundary_film and rise_beside_lowest(last.film.thickness) > UNRESOLVED_RISE
    if film < SWEEP * equation.cell[0] ** 1.5 or steep:
        return Status.FILM_BELOW_CELL
    inlet = -posed.x[0] - (posed.upstream_reach - 1)
    # a longer inlet has no effect where the supplied layer fills the gap inside the grid
    if not _is_starved(equation, last) and INLET_ERROR * film > STARVED * inlet**2:
        return Status.STARVED_INLET
    return Status.CONVERGED
