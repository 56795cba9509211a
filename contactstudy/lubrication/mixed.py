"""Mixed lubrication in plane strain: lubricant and asperities bear the load together.

The film ``H = H0 + gap + K (P_f + P_c)`` is no thinner than the boundary film ``H_b``, and where it is as thin
asperities bear a pressure ``P_c >= 0``. Lubricant flows in every cell, by its own pressure ``P_f`` and the film. A step
in pseudo-time solves for both and for the separation; which cells cavitate and which touch is settled together within
it. A step whose sets do not settle is refused: taken, it would throw the residual back.

Transverse ridges may have two answers at one speed: one on a thick film, and one held flat by contact. A start from the
film of a higher speed leads to the first where there is one; the dry contact leads to the second.
"""

from dataclasses import dataclass, replace

import numpy as np

from contactstudy.domain.fields import Array
from contactstudy.lubrication.film_equation import Film, Linearised, Mask
from contactstudy.lubrication.plane_strain import DenseCoefficients, DirectStep
from contactstudy.lubrication.posed_film import PosedFilm, hertz_start
from contactstudy.lubrication.pseudo_time import (
    LONGER,
    PATIENCE,
    SHORTER,
    FilmControls,
    FilmIteration,
    FilmStep,
    residual_of,
    share_of,
)
from contactstudy.solvers.solve import SolveOptions

# A film this much below the boundary film touches it. The residual of the dry contact to start from.
TOUCHES, DRY = 1e-9, 1e-10
# First steps in pseudo-time, from a film and from the dry contact, rounds that settle the sets of a step, and by what it
# is shortened where they do not. The change of ln(eta) in a step from a film.
FILM_STEP, DRY_STEP, ROUNDS, UNSETTLED, CHANGE = 0.1, 10.0, 12, 0.3, 6.0
# Where neither converges: factors in speed to go up by, how often at most, and the least one to come down by.
SPEED_STEP, FASTEST, LEAST_SPEED_STEP = 1.3, 5, 1.02
# Steps from the dry contact, and the least step.
DRY_STEPS, LEAST = 30, 1e-9


def solve_mixed(
    posed: PosedFilm, controls: FilmControls, warm: Film | None = None
) -> FilmIteration:
    """Iterate from ``warm``, else from the film, from the dry contact, or from higher speeds.

    The dry contact comes before the film where that of Moes is thinner than the boundary film.
    """
    film_controls = replace(controls, time_step=FILM_STEP, viscosity_change=CHANGE)
    dry_controls = replace(controls, time_step=DRY_STEP, max_iterations=DRY_STEPS)
    found: list[FilmIteration] = []
    if warm is not None:
        found.append(iterate_mixed(posed, warm, film_controls))
    starts = [(_film_start, film_controls), (_dry_start, dry_controls)]
    if posed.scales.expected_film < posed.equation.boundary:
        starts.reverse()
    for start, how in starts:
        if found and found[-1].converged(controls.tolerance):
            return found[-1]
        found.append(iterate_mixed(posed, start(posed), how))
    if found[-1].converged(controls.tolerance):
        return found[-1]
    slowed = _from_higher_speeds(posed, film_controls)
    return min((*found, *([slowed] if slowed else [])), key=lambda one: one.residual)


def _from_higher_speeds(posed: PosedFilm, controls: FilmControls) -> FilmIteration | None:
    """Iterate from the mixed film at a higher speed down to this one; None where that fails."""
    resistance = faster = posed.equation.resistance
    for _ in range(FASTEST):
        faster *= SPEED_STEP
        last = iterate_mixed(posed.at(faster), _film_start(posed), controls)
        if last.converged(controls.tolerance):
            break
    else:
        return None
    step = SPEED_STEP
    while faster > resistance and step > LEAST_SPEED_STEP:
        slower = faster / step if faster / step > resistance * LEAST_SPEED_STEP else resistance
        trial = iterate_mixed(posed.at(slower), last.film, controls)
        if trial.converged(controls.tolerance):
            last, faster = trial, slower
        else:
            step = step**0.5
    return last if faster == resistance else None


def _film_start(posed: PosedFilm) -> Film:
    """Return the start of a film without asperities, raised to the boundary film."""
    start, equation = hertz_start(posed), posed.equation
    rise = max(0.0, equation.boundary - float(start.film.min()))
    none = np.zeros_like(start.pressure)
    return equation.film_of(start.pressure, start.void, start.separation + rise, none)


def _dry_start(posed: PosedFilm) -> Film:
    """Return the dry contact on the boundary film, with streamers of lubricant that fill the gaps."""
    equation = posed.equation
    dry = SolveOptions(tolerance=DRY).solved(posed.problem).pressure[: len(posed.x)]
    contact = np.asarray(dry / posed.scales.hertz.peak_pressure)
    none = np.zeros_like(contact)
    below = (equation.gap + equation.deflection(contact)).min()
    return equation.film_of(none, none, equation.boundary - float(below), contact)


@dataclass(frozen=True, eq=False)
class _MixedStep:
    """Step of a mixed film, with the change of the pressure of asperities."""

    lubricant: FilmStep
    contact: Array
    cavitated: Mask
    touching: Mask
    settled: bool


def iterate_mixed(posed: PosedFilm, start: Film, controls: FilmControls) -> FilmIteration:
    """Iterate from ``start`` until the residual is below the tolerance or rests, the limit, or steps without length."""
    equation = posed.equation
    solver = DirectStep.for_equation(equation)
    linear = equation.linearise(start)
    assert start.contact is not None
    cavitated = (start.pressure == 0) & ~equation.fixed
    if not (start.contact > 0).any() and not start.void.any():
        cavitated = np.zeros_like(equation.fixed)
    touching = start.contact > 0
    last = FilmIteration(start, linear, cavitated, _residual(linear, start), 0, 0)
    time_step, best, waited = controls.time_step, last.residual, 0
    while (
        not last.converged(controls.tolerance)
        and not last.rests
        and last.iterations < controls.max_iterations
        and time_step > LEAST
        and np.isfinite(last.residual)
    ):
        step = _settled(solver, last, touching, time_step)
        share = share_of(last, step.lubricant, controls.viscosity_change, step.contact)
        count = last.iterations + 1
        film = _moved(last.film, step, share, linear)
        # the dry start has no distant film to lose
        refused = not step.settled and controls.time_step < DRY_STEP
        if refused or share < controls.shortest or not (film.film > 0).all():
            time_step *= UNSETTLED
            last = replace(last, iterations=count)
            continue
        linear = equation.linearise(film)
        residual = _residual(linear, film)
        factor = float(np.clip(last.residual / residual, SHORTER, LONGER)) if residual else LONGER
        if share < 1:
            factor = min(factor, 0.7)
        elif residual < last.residual:
            factor = max(factor, 2.0)
        time_step *= factor
        touching = step.touching
        last = FilmIteration(film, linear, step.cavitated, residual, count, 0)
        waited += share == 1
        if 2 * residual <= best:
            best, waited = residual, 0
        if waited >= PATIENCE:
            last = replace(last, rests=True)
    return last


def _residual(linear: Linearised, film: Film) -> float:
    """Return the largest of flow and load that are missing, and of what a touching film is off the boundary film."""
    assert film.contact is not None
    thickness = linear.equation.boundary
    off = np.abs(film.film - thickness)[film.contact > 0].max(initial=0.0) / thickness
    below = max(0.0, thickness - float(film.film.min())) / thickness
    return max(residual_of(linear, film), float(off), below)


def _settled(
    solver: DirectStep, last: FilmIteration, touching: Mask, time_step: float
) -> _MixedStep:
    """Return a step of ``time_step``, with the cells that cavitate and those that touch after it."""
    film, equation, cavitated = last.film, last.linear.equation, last.cavitated
    assert film.contact is not None
    coefficients = DenseCoefficients(last.linear.delayed(1 / time_step), solver.influence)
    thickness, settled = equation.boundary, False
    for _ in range(ROUNDS):
        lubricant, contact = _solved(coefficients, solver, film, cavitated, touching)
        if not lubricant.solved:
            break
        change = equation.deflection(lubricant.pressure + contact) + lubricant.separation
        empty = np.where(
            cavitated, film.void + lubricant.void >= 0, film.pressure + lubricant.pressure < 0
        )
        empty &= ~equation.fixed
        low = film.film + change < thickness * (1 - TOUCHES)
        touch = np.where(touching, film.contact + contact > 0, low)
        settled = bool((empty == cavitated).all() and (touch == touching).all())
        if settled:
            break
        cavitated, touching = empty, touch
    return _MixedStep(lubricant, contact, cavitated, touching, settled)


def _solved(
    coefficients: DenseCoefficients,
    solver: DirectStep,
    film: Film,
    cavitated: Mask,
    touching: Mask,
) -> tuple[FilmStep, Array]:
    """Return the step for given sets, and the change of the pressure of asperities."""
    assert film.contact is not None
    linear, influence = coefficients.linear, coefficients.influence
    equation = linear.equation
    n, fixed, empty, touch = len(influence), equation.fixed[:, 0], cavitated[:, 0], touching[:, 0]
    places = np.flatnonzero(touch)
    pressure = np.where(empty, -film.pressure[:, 0], 0.0)
    void = np.where(empty, 0.0, -film.void[:, 0])
    lifted = np.where(touch, 0.0, -film.contact[:, 0])
    # what is known: pressures that vanish, of both kinds
    known = influence @ (pressure + lifted)
    right = -linear.residual[:, 0]
    right -= coefficients.by_pressure @ pressure + coefficients.by_void @ void
    right -= coefficients.by_film @ lifted
    size = n + len(places) + 1
    system = np.zeros((size, size))
    system[:n, :n] = coefficients.by_pressure
    system[:n, :n][:, empty] = coefficients.by_void[:, empty]
    system[:n, n:-1] = coefficients.by_film[:, places]
    system[:n, -1] = coefficients.by_separation
    system[:n][fixed] = np.eye(n, size)[fixed]
    right[fixed] = 0
    bears = ~(empty | fixed)
    system[n:-1, :n] = influence[places] * bears
    system[n:-1, n:-1] = influence[np.ix_(places, places)]
    system[n:-1, -1] = 1
    width = equation.cell[0]
    system[-1, :n] = width * bears
    system[-1, n:-1] = width
    missing = equation.load_missing(film) - width * float((pressure + lifted).sum())
    distance = equation.boundary - film.film[places, 0] - known[places]
    right = np.concatenate((right, distance, [missing]))
    scale = np.abs(system).max(axis=1)
    try:
        solution = np.linalg.solve(system / scale[:, None], right / scale)
    except np.linalg.LinAlgError:
        return FilmStep(film.pressure, film.void, 0.0, solver, solved=False), np.zeros_like(
            film.film
        )
    contact = lifted
    contact[places] = solution[n:-1]
    unknown = solution[:n]
    step = FilmStep(
        np.where(empty, pressure, unknown)[:, None],
        np.where(empty, unknown, void)[:, None],
        float(solution[-1]),
        solver,
    )
    return step, contact[:, None]


def _moved(film: Film, step: _MixedStep, share: float, linear: Linearised) -> Film:
    """Return the film after a ``share`` of a step, with pressures and voids in their range."""
    assert film.contact is not None
    lubricant = step.lubricant
    pressure = np.maximum(film.pressure + share * lubricant.pressure, 0)
    contact = np.maximum(film.contact + share * step.contact, 0)
    void = np.clip(film.void + share * lubricant.void, 0, 1 - 0.1 * (1 - film.void))
    if share == 1 and step.settled:
        pressure[step.cavitated], void[~step.cavitated] = 0, 0
        contact[~step.touching] = 0
    separation = film.separation + share * lubricant.separation
    return linear.equation.film_of(pressure, void, separation, contact)
