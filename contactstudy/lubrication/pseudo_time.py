"""Newton's method in pseudo-time for a film that cavitates, and on which asperities may touch.

Pseudo-transient continuation with switched evolution relaxation (Mulder & van Leer 1985; Kelley & Keyes 1998), the
inequalities by primal-dual active sets (Hintermueller, Ito & Kunisch 2002). One step:

1. Linearise the flow balance of each cell, and add the squeeze term of an implicit step in pseudo-time. From a distant
   start the film moves as in time; as the residual falls the step becomes Newton's.
2. Solve the linear system for the active sets, and correct the sets until they hold. A cell with a negative pressure
   cavitates, one with a negative void fraction no longer does. On a boundary film, a cell whose film would be thinner
   touches, one with a negative asperity pressure no longer does.
3. Damp the step so that film and viscosity change within their limits, or reject it.
4. Choose the next step in pseudo-time by the ratio of the residuals.

Units are those of :mod:`~contactstudy.lubrication.film_equation`: time over a / u_m, with the mean speed u_m. H_b is
the boundary film, M and L are the parameters of Moes (1992).
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import inf
from typing import NamedTuple

import numpy as np

from contactstudy.domain.grid import Array
from contactstudy.lubrication.film_equation import Film, FilmEquation, Linearised, Mask, SqueezeTerm
from contactstudy.lubrication.linear_solvers import ActiveSets, FilmCorrection, StepSolver

# Rounding of a pressure over the pressure, and of a film thickness over the largest height: four units in the last
# place, as a thickness is a sum.
ROUNDING = 4 * float(np.finfo(float).eps)
# The constants below were chosen by counts of steps from cold starts, on 75 rough and 70 smooth films, the latter with
# M 1 to 1000 and L 0 to 20 on 100 to 800 cells.
# Least film thickness, and least content of a cavitated cell, after a step over that before it. Limits of the factor of
# the step in pseudo-time, by the ratio of residuals. With these no film failed.
MIN_FILM_FRACTION, MIN_CONTENT_FRACTION, SHRINK, GROW = 0.3, 0.1, 0.3, 4.0
# Fraction of the cells in which the change of ln(eta) is clipped to its limit where no cell touches, so that single
# cells do not damp the step. Light rough films of 432 x 64 cells took 44 steps with it, 61 without.
CLIPPED = 2e-3
# Largest factor of the step in pseudo-time after a damped step, from rough films. Least factor while the residual
# falls, or rises by no more than the factor ALLOWED_RISE: 210 films took 2426 steps, and 2883 without a rise.
AFTER_DAMPING, MIN_GROWTH, ALLOWED_RISE = 0.7, 2.0, 1.1
# Damping factor below which a step is rejected, since a shorter step in pseudo-time costs less than twenty damped ones.
# The factor of the step in pseudo-time then; and the step where the iteration ends, far below any that led to a film.
MIN_DAMPING, REJECTED, LEAST_TIME_STEP = 0.05, 0.25, 1e-9
# Largest change of ln(eta) in a step, to which it is damped, of a film that varies along its length or on which
# asperities may touch. Smooth films in plane strain need no limit: with it they took 2.3 times the steps.
ROUGH_CHANGE = 6.0
# Most iterations for the active sets of a step, in plane strain and along the length. Along the length a set need not
# converge in each step. Films in a narrow transition, from full to boundary lubrication within a small change of speed,
# took three times the linear iterations with 12, as a set moves by a few cells in each. SET_CHANGES is the fraction of
# the cells that may still change sets in the last iteration, far from the solution.
ACTIVE_SETS, ACTIVE_SETS_ALONG, SET_CHANGES = 12, 3, 1e-3
# Undamped steps within which the residual is halved, or the iteration ends. The slowest film that converges took 105
# steps, most of them damped.
STALL_STEPS = 30
# Largest factor of the residual in a step of a mixed film whose active sets have not converged. Beyond it the step is
# rejected: some of these steps lost all that the iteration had gained.
UNCONVERGED_RISE = 1.5
# Compressibility of the lubricant in a step in pseudo-time, over 1 / p_H, in cells that touch or whose film is thinner
# than NEAR_CONTACT boundary films (Chorin 1967). With it alone a film in a narrow transition converges on 256 x 64
# cells. On 64 x 16 cells one took 12 steps in place of 27, and with 0.1 and 3 three times as many.
ARTIFICIAL_COMPRESSIBILITY, NEAR_CONTACT = 0.3, 2.0
# A cell enters the contact where its film is thinner than the boundary film by CONTACT_TOLERANCE, a fraction above the
# rounding of heights. Largest residual that counts as rounding, which is up to 2e-8 in smooth films of M = 20 to 3000.
CONTACT_TOLERANCE, MAX_ROUNDING = 1e-9, 1e-3


@dataclass(frozen=True)
class FilmControls:
    """Stopping rule and first step of the iteration.

    Attributes
    ----------
    tolerance
        Residual, as in :class:`FilmIteration`, up to which a film counts as converged.
    max_iterations
        The most steps.
    time_step
        First step in pseudo-time [a / u_m]; with half and twice, cold starts took about as many steps.
    progress
        Called with the iteration so far after each step.
    """

    tolerance: float = 1e-8
    max_iterations: int = 200
    time_step: float = 0.1
    progress: "Callable[[FilmIteration], object] | None" = None


@dataclass(frozen=True, eq=False)
class FilmIteration:
    """Last film of an iteration, converged or not.

    ``linear`` is the flow balance with its derivatives at the ``film``, ``active`` are its active sets. ``residual`` is
    the largest of the unbalanced flow over the flow, the missing load over ``p_H a``, and the violation of the
    conditions of contact. ``iterations`` are the steps, rejected ones too, ``linear_iterations`` those of GMRES in all
    of them.
    """

    film: Film
    linear: Linearised
    active: ActiveSets
    residual: float
    iterations: int
    linear_iterations: int

    @property
    def cavitated(self) -> Mask:
        """Cavitated cells (x, y)."""
        return self.active.cavitated

    def converged(self, tolerance: float) -> bool:
        """Return whether the residual is below ``tolerance`` or rounding, and no cell has both a pressure and a void."""
        both = (self.film.pressure > 0) & (self.film.void > 0)
        return self.residual <= max(tolerance, self.rounding) and not bool(both.any())

    @property
    def rounding(self) -> float:
        """Residual by rounding: of pressures, and of film thicknesses, which are small differences of large heights."""
        linear, heights = self.linear, float(np.abs(self.linear.equation.gap).max())
        # the diagonals of the derivatives by pressure and by thickness
        by_pressure = float((np.abs(linear.pressure[0, 0]) * self.film.pressure).sum())
        by_film = float(np.abs(linear.thickness[0, 0]).sum()) * heights
        return float(min(ROUNDING * (by_pressure + by_film) / _flow(linear), MAX_ROUNDING))


def iterate(
    equation: FilmEquation,
    start: Film,
    controls: FilmControls,
    *,
    squeeze: SqueezeTerm | None = None,
    cavitated: Mask | None = None,
) -> FilmIteration:
    """Return the film after the iteration from ``start``: converged, stagnated, at the limit, or with vanishing steps.

    Parameters
    ----------
    equation, start, controls
        What is solved, the film to start from, and when to stop.
    squeeze
        Squeeze term of a film in time; None for a steady film.
    cavitated
        Cells (x, y) that are cavitated at first. By default none, unless the start has voids or asperities that carry
        load: then the cells without pressure.
    """
    linear = equation.linearise(start, squeeze)
    active, solver = _initial_active_sets(equation, start, cavitated), StepSolver()
    last = FilmIteration(start, linear, active, _residual(linear, start), 0, 0)
    time_step, best, waited = controls.time_step, last.residual, 0
    while (
        not last.converged(controls.tolerance)
        and waited < STALL_STEPS
        and last.iterations < controls.max_iterations
        and time_step > LEAST_TIME_STEP
        and np.isfinite(last.residual)
    ):
        step = _step_of_active_sets(last, solver, time_step)
        damping = _damping_factor(last, step)
        film = _updated_film(last, step, damping)
        rejected = damping < MIN_DAMPING or not (film.thickness > 0).all()
        if not rejected:
            linear, active = equation.linearise(film, squeeze), step.next
            residual = _residual(linear, film)
            rejected = equation.boundary_film > 0 and not step.converged and residual > UNCONVERGED_RISE * last.residual
        if rejected:
            time_step *= REJECTED
            film, linear, active, residual = last.film, last.linear, last.active, last.residual
        else:
            time_step = _next_time_step(time_step, last.residual, residual, damping)
            waited += damping == 1
            if 2 * residual <= best:
                best, waited = residual, 0
        last = FilmIteration(
            film, linear, active, residual,
            last.iterations + 1, last.linear_iterations + step.iterations,
        )  # fmt: skip
        if controls.progress is not None:
            controls.progress(last)
    return last


def _next_time_step(time_step: float, before: float, residual: float, damping: float) -> float:
    """Return the next step in pseudo-time, after one that led from the residual ``before`` to the ``residual``."""
    factor = float(np.clip(before / residual, SHRINK, GROW)) if residual else GROW
    if damping < 1:
        factor = min(factor, AFTER_DAMPING)
    elif residual < ALLOWED_RISE * before:
        factor = max(factor, MIN_GROWTH)
    return factor * time_step


def _residual(linear: Linearised, film: Film) -> float:
    """Return the largest of the unbalanced flow over the flow, the missing load over ``p_H a``, and errors of contact.

    With the film thickness H and the pressure P_c of asperities over p_H, the errors of contact on a boundary film are
    the largest ``min(|H / H_b - 1|, P_c)`` and ``1 - H / H_b`` of all cells.
    """
    unbalanced = float(np.abs(linear.residual).sum() / _flow(linear))
    residual = max(unbalanced, abs(linear.equation.load_residual(film)))
    boundary = linear.equation.boundary_film
    if not boundary:
        return residual
    rise = film.thickness / boundary - 1
    violation = float(np.minimum(np.abs(rise), film.asperity_pressure).max())
    return max(residual, violation, -float(rise.min()))


def _flow(linear: Linearised) -> float:
    """Return the largest flow through a face across, between cells with a balance, times the number of cells along."""
    return float(np.abs(linear.flux[1:-1]).max() * linear.residual.shape[1])


def _initial_active_sets(equation: FilmEquation, start: Film, cavitated: Mask | None) -> ActiveSets:
    """Return the active sets of a start: full film in all cells, unless ``cavitated``, asperities or voids are given."""
    if cavitated is None:
        has_state = (start.asperity_pressure > 0).any() or start.void.any()
        cavitated = (start.pressure == 0) & ~equation.fixed & has_state
    return ActiveSets(cavitated, start.asperity_pressure > 0)


class _ActiveSetStep(NamedTuple):
    """Step with the sets that it was solved for, the sets after it, whether both agree, and the linear iterations."""

    change: FilmCorrection
    active: ActiveSets
    next: ActiveSets
    converged: bool
    iterations: int


def _step_of_active_sets(last: FilmIteration, solver: StepSolver, time_step: float) -> _ActiveSetStep:
    """Return a step in pseudo-time whose active sets are corrected until they hold, recur, or at the most iterations."""
    film, next_active, iterations = last.film, last.active, 0
    linear = last.linear.with_time_step(
        1 / time_step, _height_off_boundary(last.linear.equation, film), _artificial_storage(last)
    )
    load_residual = last.linear.equation.load_residual(film)
    # near the solution every cell counts
    allowed = SET_CHANGES * min(1.0, last.residual) * film.thickness.size
    tried = [next_active]
    for _ in range(ACTIVE_SETS if film.thickness.shape[1] == 1 else ACTIVE_SETS_ALONG):
        active = next_active
        change = solver.step(linear, film, active, load_residual)
        converged = False
        iterations += change.iterations
        if not change.solved:
            break
        next_active = _corrected_active_sets(last, active, change)
        converged = active.changes(next_active) <= allowed
        recurs = not all(earlier.changes(next_active) for earlier in tried)
        if converged or recurs:
            break
        tried.append(next_active)
    change = _within_total_pressure(film, active, change)
    return _ActiveSetStep(change, active, next_active, converged, iterations)


def _within_total_pressure(film: Film, active: ActiveSets, change: FilmCorrection) -> FilmCorrection:
    """Return the change with a lubricant pressure between zero and the total pressure in touching cells.

    The boundary film determines their total pressure. Its split between lubricant and asperities is nearly
    indeterminate where the lubricant is viscous: the parts may be many times as large and of opposite signs. If each
    were cut off at zero, the film would leave the boundary film. Without this, four films in a narrow transition took
    117 steps in place of 78.
    """
    total = film.total_pressure + change.pressure + change.asperity_pressure
    pressure = np.clip(film.pressure + change.pressure, 0, np.maximum(total, 0)) - film.pressure
    pressure = np.where(active.touching, pressure, change.pressure)
    asperity_pressure = change.asperity_pressure + change.pressure - pressure
    return change._replace(pressure=pressure, asperity_pressure=asperity_pressure)


def _height_off_boundary(equation: FilmEquation, film: Film) -> Array:
    """Return the height (x, y) above the boundary film where asperities carry load, or the film is thinner than it.

    A step sets the film of these cells to the boundary film. As a motion within a short step in pseudo-time, that would
    squeeze lubricant out under any pressure.
    """
    height = film.thickness - equation.boundary_film
    return np.where((film.asperity_pressure > 0) | (height < 0), height, 0.0)


def _artificial_storage(last: FilmIteration) -> Array | float:
    """Return the content (x, y) that a unit pressure adds to cells in contact or near it, by artificial compressibility.

    The film of touching cells is given, and hardly any lubricant flows in them: without this their pressure would
    change without limit in a short step in pseudo-time. It has no effect on a steady film.
    """
    touching, boundary = last.active.touching, last.linear.equation.boundary_film
    if not touching.any():
        return 0.0
    near = touching | (last.film.thickness < NEAR_CONTACT * boundary)
    return ARTIFICIAL_COMPRESSIBILITY * boundary * near


def _corrected_active_sets(last: FilmIteration, active: ActiveSets, change: FilmCorrection) -> ActiveSets:
    """Return the active sets that the film would have after an undamped step."""
    film, equation = last.film, last.linear.equation
    cavitated = np.where(active.cavitated, film.void + change.void >= 0, film.pressure + change.pressure < 0)
    cavitated &= ~equation.fixed
    if not equation.boundary_film:
        return ActiveSets(cavitated, active.touching)
    low = film.thickness + _change_of_thickness(equation, change) < equation.boundary_film * (1 - CONTACT_TOLERANCE)
    return ActiveSets(cavitated, np.where(active.touching, film.asperity_pressure + change.asperity_pressure > 0, low))


def _change_of_thickness(equation: FilmEquation, change: FilmCorrection) -> Array:
    """Return the change of the film thickness (x, y) in a step."""
    return equation.deflection(change.pressure + change.asperity_pressure) + change.separation


def _damping_factor(last: FilmIteration, step: _ActiveSetStep) -> float:
    """Return the largest damping factor, at most 1, with which film and viscosity change within their limits.

    Zero for a step that was not solved.
    """
    change, film, equation = step.change, last.film, last.linear.equation
    if not change.solved:
        return 0.0
    rise = _change_of_thickness(equation, change) / film.thickness
    log_change = equation.log_viscosity(film.pressure)[1] * np.abs(change.pressure)
    if not step.active.touching.any():
        viscous = np.quantile(log_change, 1 - CLIPPED)
    else:  # where asperities take over pressure, its fall has no limit
        taken_over = step.active.touching & (change.pressure < 0)
        viscous = log_change[~taken_over].max(initial=0.0)
    # each change over its limit
    largest = max(
        float(-rise.min()) / (1 - MIN_FILM_FRACTION),
        float(rise[film.pressure > 0].max(initial=0.0)) / (1 / MIN_FILM_FRACTION - 1),
        float(viscous) / _viscosity_change(equation),
    )
    return 1.0 if largest <= 1 else 1 / largest


def _viscosity_change(equation: FilmEquation) -> float:
    """Return the largest change of ln(eta) in a step."""
    return ROUGH_CHANGE if equation.boundary_film or equation.gap.shape[1] > 1 else inf


def _updated_film(last: FilmIteration, step: _ActiveSetStep, damping: float) -> Film:
    """Return the film after a damped step, with pressures and void fractions clipped to their ranges."""
    film, equation, change = last.film, last.linear.equation, step.change
    pressure_change = damping * change.pressure
    if not step.active.touching.any():  # the few cells beyond the quantile that limits the damping
        largest = np.full_like(pressure_change, inf)
        log_slope = equation.log_viscosity(film.pressure)[1]
        np.divide(_viscosity_change(equation), log_slope, out=largest, where=log_slope > 0)
        pressure_change = np.clip(pressure_change, -largest, largest)
    pressure = np.maximum(film.pressure + pressure_change, 0)
    # under Reynolds' cavitation void is a source, without an upper limit
    largest_void = 1 - MIN_CONTENT_FRACTION * (1 - film.void) if equation.conserves else inf
    void = np.clip(film.void + damping * change.void, 0, largest_void)
    asperity_pressure = np.maximum(film.asperity_pressure + damping * change.asperity_pressure, 0)
    if damping == 1:
        pressure[step.active.cavitated], void[~step.active.cavitated] = 0, 0
        asperity_pressure[~step.active.touching] = 0
    separation = film.separation + damping * change.separation
    return equation.film_of(pressure, void, separation, asperity_pressure)
