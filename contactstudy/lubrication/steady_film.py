"""Steady film on one grid: nested grids, continuation in speed where a cold start fails, and the contact in SI units.

In mixed lubrication the film ``H = H0 + gap + K (P_f + P_c)`` is no thinner than the boundary film ``H_b``, and where
``H = H_b`` asperities carry a pressure ``P_c >= 0``. Lubricant flows in every cell, by its own pressure ``P_f`` and the
thickness. Transverse ridges may have two solutions at one speed: ridges in a thick film, or flattened by contact. The
film at a higher speed leads to the first where it exists, the dry contact to the second. Where cold starts fail, any
film is followed from a higher speed down.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace
from math import ceil, inf, log, sqrt

import numpy as np

from contactstudy.domain.grid import Array, ExactPeriodicity, Grid, Padding, Paddings
from contactstudy.lubrication.film_equation import INLET_CELLS, OUTLET_CELLS, Film, FilmEquation, Mask
from contactstudy.lubrication.lubricated_contact import FilmSolution, ShearedFilm, rise_beside_lowest
from contactstudy.lubrication.posed_film import (
    OUTLET,
    PosedFilm,
    hertz_start,
    pose,
    prolongated,
    start_from,
    with_minimum_film,
)
from contactstudy.lubrication.pseudo_time import FilmControls, FilmIteration, iterate
from contactstudy.scene.scene import Scene
from contactstudy.solvers.solution import Status
from contactstudy.solvers.solve import SolveOptions, solve_contact

# The inlet pressure sweep over the half-width is (H / SWEEP)^(2/3) with the film thickness H in Hertz units: there the
# gap beside Hertz's contact, (2 sqrt(2) / 3) x^(3/2), is the film. An inlet of x_a half-widths gives a film that is too
# thin by the fraction INLET_ERROR H / x_a^2, as at Moes's load parameter M = 2 and material parameter L = 0; heavier
# loads lose less.
SWEEP, INLET_ERROR = 0.94, 0.9
# An inlet whose length makes the film thinner by more than the fraction STARVED counts as starved. A film is unresolved
# on cells wider than the inlet sweep, or if it rises by more than UNRESOLVED_RISE of itself from its lowest cell to the
# next.
STARVED, UNRESOLVED_RISE = 0.05, 0.5
# First step in pseudo-time after a coarser grid, and the largest change of ln(eta) in a step of a film that varies
# along its length or begins far from its contact. On rough films a hundredth of the former took 1.3 to 4 times as long,
# and ten times it needed hundreds of linear iterations in its first steps; smooth films in plane strain need no limit.
STEP_AFTER_COARSER, ROUGH_CHANGE = 0.3, 6.0
# In plane strain a second film is sought where the rms height is more than ROUGH times the film, by heights that grow
# from that by the factor GROWTH. Two films are distinct by more than DISTINCT in their mean thickness, relative, or in
# the part of the load that asperities carry.
ROUGH, GROWTH, DISTINCT = 2.0, 1.25, 0.01
# Continuation in speed where no cold start converges, without and with asperities: factor of a step, most increases,
# and least factor of a decrease. Those with asperities, and the constants below, were chosen by what converges on
# ridges at 1 to 1e-6 times a speed, at which Moes's load parameter was 20 and 100.
SPEEDS, MIXED_SPEEDS = (10.0, 4, 1.05), (1.3, 5, 1.02)
# First steps in pseudo-time on a boundary film, from a film and from the dry contact. From the latter it is nearly
# Newton's: 5 to 9 steps at load fractions above 0.88.
FROM_FILM, FROM_DRY = 0.1, 10.0
# Most iterations for the active sets of a step, in plane strain and along the length. There a set moves downstream by a
# few cells in an iteration, and need not converge in each step: with 12, films of a narrow transition took three times
# the linear iterations.
ACTIVE_SETS, ACTIVE_SETS_ALONG = 12, 3
# Most steps from the dry contact in plane strain, as more are spent where there is a film; and its residual.
DRY_STEPS, DRY_RESIDUAL = 30, 1e-10
# Factors on the speed of the films and the dry contacts from which other films are sought: of eight speeds of three
# waves, where two films were known, one or both led to the other.
FASTER, SLOWER = 4.0, 3.0


def solve_lubricated(
    scene: Scene,
    grid: Grid,
    padding: Padding | Paddings = ExactPeriodicity(),  # noqa: B008 (a frozen value)
    controls: FilmControls = FilmControls(),  # noqa: B008 (a frozen value)
    start: FilmSolution | None = None,
    outlet: float = OUTLET,
) -> FilmSolution:
    """Return the steady film of ``scene``, flooded or starved, isothermal or heated, with a status.

    Where its pressure reaches the outlet, the outlet is moved to the end of the grid. In plane strain, where the rms
    height is more than `ROUGH` times the film, a second film is sought, and the status says if it exists.

    Parameters
    ----------
    scene
        A scene with ``lubrication``.
    grid
        Cells (x, y); one cell along the length is plane strain. Lubricant enters at smaller x.
    padding
        Along the length, one that wraps.
    controls
        When the iteration stops.
    start
        A contact to start from, such as that at a somewhat higher speed; on another grid it is interpolated.
    outlet
        Half-widths from the end of the dry contact to where the film has no pressure any more.

    Raises
    ------
    InvalidInput
        For a scene without a curvature, and for a grid or a padding on which it has no film.
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
        return solve_lubricated(scene, grid, padding, controls, start, outlet=inf)
    if last.converged(controls.tolerance) and posed.relative_roughness > ROUGH:
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
        return _solve_mixed(posed, controls, start_from(posed, before))
    if posed.scales.expected_film <= posed.equation.boundary_film:
        return _solve_mixed(posed, controls)
    # on nested grids: on the finest alone it took ten times as long, or did not converge between high places
    alone = _nested(replace(posed, equation=replace(posed.equation, boundary_film=0.0)), controls)
    full = alone.film
    film = with_minimum_film(posed.equation, full.pressure, full.void, full.separation, posed.equation.boundary_film)
    mixed = _solve_mixed(posed, controls, (film, alone.cavitated))
    return replace(
        mixed,
        iterations=mixed.iterations + alone.iterations,
        linear_iterations=mixed.linear_iterations + alone.linear_iterations,
    )


def _other_films(posed: PosedFilm, controls: FilmControls, *, is_cold: bool) -> Iterator[FilmIteration]:
    """Iterate over films from other starts: a cold one, lower heights, and of mixed films other speeds."""
    is_mixed = posed.equation.boundary_film > 0
    if not is_cold:
        yield _solve_mixed(posed, controls) if is_mixed else _nested(posed, controls)
    if is_mixed:
        yield from _other_mixed_films(posed, controls)
    elif followed := _from_lower_heights(posed, controls):
        yield followed


def _from_lower_heights(posed: PosedFilm, controls: FilmControls) -> FilmIteration | None:
    """Return the film that is followed from lower heights up to these; None where that fails."""
    smooth = posed.x[:, None] ** 2 / 2
    heights, last = posed.equation.gap - smooth, None
    number = ceil(log(posed.relative_roughness / ROUGH) / log(GROWTH))
    for fraction in np.geomspace(ROUGH / posed.relative_roughness, 1, number + 1):
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
    return bool(max(abs(first - second) / first, of_load) > DISTINCT)


def continued(posed: PosedFilm, controls: FilmControls) -> FilmIteration:
    """Return the film from a cold start, or where that fails followed from higher speeds down to this one."""
    cold = _nested(posed, controls)
    if cold.converged(controls.tolerance):
        return cold
    from_higher_speed = _from_higher_speeds(
        posed,
        SPEEDS,
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
    film, cavitated = prolongated(posed, coarser, coarse)
    return _iterated(posed, film, _after_coarser_grid(controls), cavitated)


def _after_coarser_grid(controls: FilmControls) -> FilmControls:
    """Return the controls after a coarser grid."""
    return replace(controls, time_step=STEP_AFTER_COARSER)


def _iterated(posed: PosedFilm, film: Film, controls: FilmControls, cavitated: Mask | None = None) -> FilmIteration:
    """Return the film from a given one; where it varies along its length, in steps that change the viscosity less."""
    if posed.upstream.cells[1] > 1:
        controls = replace(controls, viscosity_change=ROUGH_CHANGE)
    return iterate(posed.equation, film, controls, cavitated=cavitated)


def _from_higher_speeds(
    posed: PosedFilm,
    steps: tuple[float, int, float],
    tolerance: float,
    cold: Callable[[PosedFilm], FilmIteration],
    warm: Callable[[PosedFilm, FilmIteration], FilmIteration],
) -> FilmIteration | None:
    """Return the film that is followed from the first higher speed where a ``cold`` start converges.

    The ``steps`` are those of `SPEEDS`. Each lower speed has a ``warm`` start from the last; a step down that fails is
    tried again with the square root of its factor. None where no higher speed converges, or the factor falls below the
    least.
    """
    factor, most, least = steps
    wanted = faster = posed.equation.speed_parameter
    for _ in range(most):
        faster *= factor
        last = cold(posed.at(faster))
        if last.converged(tolerance):
            break
    else:
        return None
    while faster > wanted:
        slower = faster / factor
        if slower <= wanted * least:  # avoid a tiny last step
            slower = wanted
        trial = warm(posed.at(slower), last)
        if trial.converged(tolerance):
            last, faster = trial, slower
        else:
            factor = sqrt(factor)
            if factor <= least:
                return None
    return last


def _solve_mixed(posed: PosedFilm, controls: FilmControls, warm: tuple[Film, Mask] | None = None) -> FilmIteration:
    """Return the film from the first start that converges, else that of the least residual.

    The starts are ``warm`` (a film and its cavitated cells), Hertz's pressure on the film of Moes, the dry contact, and
    in plane strain higher speeds. The dry contact comes before Hertz's pressure where the film of Moes is thinner than
    the boundary film.
    """
    controls, film_controls, dry_controls = _mixed_controls(posed, controls)
    in_plane_strain = posed.upstream.cells[1] == 1
    starts: list[tuple[Callable[[PosedFilm], Film], FilmControls, Mask | None]]
    starts = [(_film_start, film_controls, None), (_dry_start, dry_controls, None)]
    if posed.scales.expected_film < posed.equation.boundary_film:
        starts.reverse()
    if warm is not None:
        film, cavitated = warm
        starts.insert(0, (lambda _: film, film_controls, cavitated))
        if not in_plane_strain and 2 * film.asperity_pressure.sum() > film.total_pressure.sum():
            starts.insert(0, (lambda _: film, dry_controls, cavitated))
    iterations: list[FilmIteration] = []
    for start, start_controls, cavitated_cells in starts:
        iterations.append(_mixed_iterated(posed, start(posed), start_controls, cavitated_cells))
        if iterations[-1].converged(controls.tolerance):
            return iterations[-1]
    if in_plane_strain:
        from_higher_speed = _from_higher_speeds(
            posed,
            MIXED_SPEEDS,
            controls.tolerance,
            lambda faster: _mixed_iterated(faster, _film_start(faster), film_controls),
            lambda slower, last: _mixed_iterated(slower, last.film, film_controls),
        )
        iterations += [from_higher_speed] if from_higher_speed else []
    return min(iterations, key=lambda iteration: iteration.residual)


def _other_mixed_films(posed: PosedFilm, controls: FilmControls) -> Iterator[FilmIteration]:
    """Iterate over films in plane strain from a faster one, and from the dry contact at a lower speed."""
    controls, film_controls, dry_controls = _mixed_controls(posed, controls)
    speed = posed.equation.speed_parameter
    for factor, start, start_controls in (
        (FASTER, _film_start, film_controls),
        (1 / SLOWER, _dry_start, dry_controls),
    ):
        other = posed.at(factor * speed)
        at_other_speed = _mixed_iterated(other, start(other), start_controls)
        if at_other_speed.converged(controls.tolerance):
            yield _mixed_iterated(posed, at_other_speed.film, film_controls)


def _mixed_controls(posed: PosedFilm, controls: FilmControls) -> tuple[FilmControls, FilmControls, FilmControls]:
    """Return the controls of a mixed film, those from a film, and those from the dry contact."""
    in_plane_strain = posed.upstream.cells[1] == 1
    controls = replace(
        controls,
        max_active_set_iterations=ACTIVE_SETS if in_plane_strain else ACTIVE_SETS_ALONG,
    )
    film_controls = replace(
        controls, time_step=FROM_FILM, viscosity_change=ROUGH_CHANGE, converged_only=in_plane_strain
    )
    dry_controls = replace(controls, time_step=FROM_DRY)
    if in_plane_strain:
        dry_controls = replace(dry_controls, max_iterations=DRY_STEPS)
    return controls, film_controls, dry_controls


def _film_start(posed: PosedFilm) -> Film:
    """Return Hertz's pressure on the film of Moes, raised to the boundary film, without contact."""
    start, equation = hertz_start(posed), posed.equation
    rise = max(0.0, equation.boundary_film - float(start.thickness.min()))
    return equation.film_of(start.pressure, start.void, start.separation + rise)


def _dry_start(posed: PosedFilm) -> Film:
    """Return the dry contact on the boundary film, in a gap full of lubricant without pressure."""
    equation = posed.equation
    options = SolveOptions(tolerance=DRY_RESIDUAL)
    dry = solve_contact(posed.problem, options, posed.dry_pressure).pressure[: len(posed.x)]
    asperity_pressure = np.asarray(dry / posed.scales.hertz.peak_pressure)
    zeros = np.zeros_like(asperity_pressure)
    below = (equation.gap + equation.deflection(asperity_pressure)).min()
    return equation.film_of(zeros, zeros, equation.boundary_film - float(below), asperity_pressure)


def _mixed_iterated(
    posed: PosedFilm, start: Film, controls: FilmControls, cavitated: Mask | None = None
) -> FilmIteration:
    return iterate(posed.equation, start, controls, cavitated=cavitated)


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
        shear, temperatures = sheared.stress_and_slip()[0], None
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
