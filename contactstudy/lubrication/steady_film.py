"""Steady film on one grid: nested grids, continuation in speed where a cold start fails, and the contact in SI units.

In mixed lubrication the film ``H = H0 + gap + K (P_f + P_c)``, with the separation H0 and the deflection K of the
bodies, is no thinner than the boundary film ``H_b``. Where ``H = H_b`` asperities carry a pressure ``P_c >= 0``.
Lubricant flows in every cell, by its own pressure ``P_f`` and the thickness. Transverse ridges may have two solutions
at one speed: ridges in a thick film, or flattened by contact. The film at a higher speed leads to the first where it
exists, the dry contact to the second. Where cold starts fail, any film is followed from a higher speed down.
"""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from itertools import chain
from math import ceil, inf, log, sqrt

import numpy as np

from contactstudy.domain.grid import Array, ExactPeriodicity, Grid, Padding, Paddings
from contactstudy.lubrication.film_equation import INLET_CELLS, OUTLET_CELLS, FilmEquation
from contactstudy.lubrication.film_friction import ShearedFilm, film_friction
from contactstudy.lubrication.lubricated_contact import FilmSolution, rise_beside_lowest
from contactstudy.lubrication.posed_film import OUTLET, PosedFilm, hertz_start, pose, prolongated, start_from
from contactstudy.lubrication.pseudo_time import FilmControls, FilmIteration, iterate
from contactstudy.scene.scene import Scene
from contactstudy.solvers.solution import Status
from contactstudy.solvers.solve import SolveOptions, solve_contact

# The inlet pressure sweep over the half-width is (H / SWEEP)^(2/3) with the film thickness H in Hertz units. There the
# gap beside Hertz's contact, (2 sqrt(2) / 3) x^(3/2), is the film. An inlet that begins x_a half-widths from the axis
# gives a film that is too thin by the fraction INLET_ERROR H / x_a^2. The factor is 0.97, 0.9 and 0.69 at x_a = 3, 4
# and 8, for Moes's parameters M = 2, of the load, and L = 0, of the material. Heavier loads lose less, a fifth at M =
# 20.
SWEEP, INLET_ERROR = 0.94, 0.9
# An inlet whose length makes the film thinner by more than the fraction STARVED counts as starved. A film is unresolved
# on cells wider than the inlet sweep, or if it rises by more than UNRESOLVED_RISE of itself from its lowest cell to the
# next. Up to that the minimum of smooth films at M = 5 to 200, L = 5 and 10 was within 4 %, at twice it within 12 %.
STARVED, UNRESOLVED_RISE = 0.05, 0.5
# First step in pseudo-time after a coarser grid [a / u_m], with the mean speed u_m. On rough films a hundredth of it
# took 1.3 to 4 times as long, and ten times it needed hundreds of linear iterations in its first steps.
STEP_AFTER_COARSER = 0.3
# In plane strain a second film is sought where the rms height is more than ROUGH times the film, by heights that grow
# from LOWEST times the film by the factor GROWTH. Waves at M = 30 to 100, L = 0 had two from 1.3 times the film on.
# From one or two times the film the cold start found the same film as at the full height. Two films are distinct by
# more than DISTINCT in their mean thickness, relative, or in the part of the load that asperities carry.
ROUGH, LOWEST, GROWTH, DISTINCT = 1.0, 0.5, 1.25, 0.01
# Continuation in speed where no cold start converges, without and with asperities: factor of a step, most increases,
# and least factor of a decrease. Those with asperities, and the constants below, were chosen by what converges on
# ridges at 1 to 1e-6 times a speed, at which Moes's load parameter was 20 and 100.
SPEEDS, MIXED_SPEEDS = (10.0, 4, 1.05), (1.3, 5, 1.02)
# First step in pseudo-time from the dry contact, nearly Newton's: it takes 5 to 9 steps where asperities carry more
# than 0.88 of the load. Residual of that dry contact.
FROM_DRY, DRY_RESIDUAL = 10.0, 1e-10
# Factors on the speed of the films and the dry contacts from which other films are sought. At eight speeds of three
# waves two films were known, and one start or both led to the other.
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
    last = _first_converged(_films(posed, controls, before), controls.tolerance)
    contact = film_solution(scene, grid, padding, posed, last, controls.tolerance)
    is_cut = contact.status is Status.CONTACT_AT_EDGE
    if is_cut and posed.upstream.cells[0] < grid.cells[0]:
        return solve_lubricated(scene, grid, padding, controls, start, outlet=inf)
    if last.converged(controls.tolerance) and posed.relative_roughness > ROUGH:
        others = _other_films(posed, controls)
        if before is not None:
            others = chain([_first_converged(_films(posed, controls), controls.tolerance)], others)
        if any(other.converged(controls.tolerance) and _differs(posed, last, other) for other in others):
            return replace(contact, status=Status.SEVERAL_FILMS)
    return contact


def continued(posed: PosedFilm, controls: FilmControls) -> FilmIteration:
    """Return the film from a cold start, or where that fails followed from higher speeds down to this one."""
    return _first_converged(_films(posed, controls), controls.tolerance)


def _first_converged(films: Iterable[FilmIteration], tolerance: float) -> FilmIteration:
    """Return the first of the films that converged, else that of the least residual."""
    tried = []
    for film in films:
        if film.converged(tolerance):
            return film
        tried.append(film)
    return min(tried, key=lambda film: film.residual)


def _films(posed: PosedFilm, controls: FilmControls, before: FilmSolution | None = None) -> Iterator[FilmIteration]:
    """Iterate over films from several starts, the best first: one `before`, cold starts, and higher speeds.

    A film is solved when it is asked for. On a boundary film the cold starts are the film of the lubricant alone where
    that is thicker, Hertz's pressure on the film of Moes, and the dry contact. The last comes first where the film of
    Moes is thinner than the boundary film. Such a film is followed from higher speeds in plane strain alone.
    """
    equation, is_thick = posed.equation, posed.scales.expected_film > posed.equation.boundary_film
    if before is not None:
        film, cavitated = start_from(posed, before)
        time_step = controls.time_step if before.grid == posed.problem.grid else STEP_AFTER_COARSER
        if 2 * film.asperity_pressure.sum() > film.total_pressure.sum():
            time_step = FROM_DRY
        yield iterate(equation, film, replace(controls, time_step=time_step), cavitated=cavitated)
    if not equation.boundary_film:
        yield _nested(posed, controls)
        yield from _from_higher_speed(posed, SPEEDS, controls, _nested)
        return
    if before is None and is_thick:
        # on nested grids: on the finest alone it took ten times as long, or did not converge between high places
        alone = _nested(replace(posed, equation=replace(equation, boundary_film=0.0)), controls)
        last, least = alone.film, equation.boundary_film
        film = equation.film_of(last.pressure, last.void, last.separation, least=least)
        yield iterate(equation, film, controls, cavitated=alone.cavitated)
    cold = (_from_film, _from_dry) if is_thick else (_from_dry, _from_film)
    yield from (start(posed, controls) for start in cold)
    if posed.upstream.cells[1] == 1:
        yield from _from_higher_speed(posed, MIXED_SPEEDS, controls, _from_film)


def _from_film(posed: PosedFilm, controls: FilmControls) -> FilmIteration:
    """Return the film from Hertz's pressure on the film of Moes, or on the boundary film where that is thicker."""
    return iterate(posed.equation, hertz_start(posed), controls)


def _from_dry(posed: PosedFilm, controls: FilmControls) -> FilmIteration:
    """Return the film from the dry contact on the boundary film, in a gap full of lubricant without pressure."""
    equation = posed.equation
    options = SolveOptions(tolerance=DRY_RESIDUAL)
    dry = solve_contact(posed.problem, options, posed.dry_pressure).pressure[: len(posed.x)]
    asperity_pressure = np.asarray(dry / posed.scales.hertz.peak_pressure)
    zeros = np.zeros_like(asperity_pressure)
    below = (equation.gap + equation.deflection(asperity_pressure)).min()
    start = equation.film_of(zeros, zeros, equation.boundary_film - float(below), asperity_pressure)
    return iterate(equation, start, replace(controls, time_step=FROM_DRY))


def _nested(posed: PosedFilm, controls: FilmControls) -> FilmIteration:
    """Return the film from nested grids: a distant start costs little on the coarsest."""
    coarser = posed.coarser()
    if coarser is None:
        return _from_film(posed, controls)
    coarse = _nested(coarser, controls)
    film, cavitated = prolongated(posed, coarser, coarse)
    return iterate(posed.equation, film, replace(controls, time_step=STEP_AFTER_COARSER), cavitated=cavitated)


def _from_higher_speed(
    posed: PosedFilm,
    steps: tuple[float, int, float],
    controls: FilmControls,
    cold: Callable[[PosedFilm, FilmControls], FilmIteration],
) -> Iterator[FilmIteration]:
    """Yield the film that is followed from the first higher speed where a ``cold`` start converges down to this speed.

    The ``steps`` are `SPEEDS` or `MIXED_SPEEDS`. Each lower speed starts from the last; a step down that fails is tried
    again with the square root of its factor. There is none where no higher speed converges, or the factor falls below
    the least.
    """
    factor, most, least = steps
    wanted = posed.equation.speed_parameter
    for number in range(1, most + 1):
        faster = wanted * factor**number
        last = cold(posed.at(faster), controls)
        if last.converged(controls.tolerance):
            break
    else:
        return
    while faster > wanted:
        slower = faster / factor
        if slower <= wanted * least:  # avoid a tiny last step
            slower = wanted
        trial = iterate(posed.at(slower).equation, last.film, controls, cavitated=last.cavitated)
        if trial.converged(controls.tolerance):
            last, faster = trial, slower
        else:
            factor = sqrt(factor)
            if factor <= least:
                return
    yield last


def _other_films(posed: PosedFilm, controls: FilmControls) -> Iterator[FilmIteration]:
    """Iterate over films in plane strain from other starts.

    Mixed films start from a film at a higher speed, and from the dry contact at a lower one; others are followed from
    lower heights up to these.
    """
    if posed.equation.boundary_film:
        for factor, start in ((FASTER, _from_film), (1 / SLOWER, _from_dry)):
            other = start(posed.at(factor * posed.equation.speed_parameter), controls)
            if other.converged(controls.tolerance):
                yield iterate(posed.equation, other.film, controls)
        return
    smooth = posed.x[:, None] ** 2 / 2
    heights, last = posed.equation.gap - smooth, None
    number = ceil(log(posed.relative_roughness / LOWEST) / log(GROWTH))
    for fraction in np.geomspace(LOWEST / posed.relative_roughness, 1, number + 1):
        lower = replace(posed, equation=replace(posed.equation, gap=smooth + fraction * heights))
        if last is None:
            last = _nested(lower, controls)
        else:
            before, least = last.film, float(last.film.thickness.min()) / 2
            film = lower.equation.film_of(before.pressure, before.void, before.separation, least=least)
            last = iterate(lower.equation, film, controls, cavitated=last.cavitated)
        if not last.converged(controls.tolerance):
            return
    if last is not None:
        yield last


def _differs(posed: PosedFilm, last: FilmIteration, other: FilmIteration) -> bool:
    """Return whether two films have distinct mean thicknesses within Hertz's contact, or loads on asperities."""
    inside = np.abs(posed.x) < 1
    films = last.film, other.film
    first, second = (film.thickness[inside].mean() for film in films)
    load, other_load = (film.asperity_pressure.sum() for film in films)
    of_load = abs(load - other_load) / films[0].total_pressure.sum()
    return bool(max(abs(first - second) / first, of_load) > DISTINCT)


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
    sheared = ShearedFilm(posed.instant, grid.cell_size[0], pressure, film, film_fraction, asperities)
    supply = scales.lubrication.supply
    supply = inf if supply is None or not _is_starved(equation, last) else supply
    shear, temperatures = film_friction(sheared, scene.solids, grid, supply)
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
    """Return whether the film is as thick as its supply, which fills the gap only from a cell inside the grid on."""
    return equation.supplied_film < inf and bool((last.film.void[INLET_CELLS] > 0).all())


def _status(posed: PosedFilm, last: FilmIteration, tolerance: float, thickness: Array) -> Status:
    """Return the outcome of an iteration, the gravest first.

    The `thickness` (x, y) [m] is that on the whole grid, at most zero where bodies touch beyond the outlet.
    """
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
