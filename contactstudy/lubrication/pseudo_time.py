"""Newton's method in pseudo-time for a film that cavitates, and that may rest on asperities.

Pseudo-transient continuation with switched evolution relaxation (Mulder & van Leer 1985; Kelley & Keyes 1998), the
inequalities by primal-dual active sets (Hintermueller, Ito & Kunisch 2002). One step:

1. Linearise the balance of each cell, and add an implicit step in time to it: from a distant start the film squeezes
   towards its state, and as the residual falls the step grows into Newton's.
2. Solve the linear system for the active sets, and correct the sets until they hold: a cell with a negative pressure
   cavitates, one with a negative void fraction no longer does; on a boundary film, a cell below it touches, one with a
   negative pressure of asperities no longer does.
3. Shorten the step to the fraction that keeps film and viscosity within their limits, or refuse it.
4. Choose the next step in time by how the residual has changed.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import inf
from typing import NamedTuple, Protocol

import numpy as np

from contactstudy.domain.fields import Array
from contactstudy.lubrication.film_equation import Film, FilmEquation, Linearised, Mask, Storage

# Rounding of a pressure and of a film, over the pressure and over the largest height.
ROUNDING = 4 * float(np.finfo(float).eps)


@dataclass(frozen=True)
class PseudoTimeTuning:
    """Tuning constants of the iteration, chosen by counts of steps on 70 smooth points and 75 rough films, cold starts.

    The smooth points are M 1 to 1000 and L 0 to 20 on 100 to 800 cells.

    Attributes
    ----------
    min_film_fraction, content_fall
        Least fractions of a film, and of the content of a cavitated cell, after a step: with these no point
        failed.
    clipped
        Fraction of the cells of a film without asperities in which the change of ln(eta) is cut off at its limit, so
        that single cells do not shorten the step: light rough films of 432 x 64 cells took 44 steps for 61.
    shrink, grow
        Limits of the factor of the step in time, by the ratio of residuals: with these no point failed.
    shortened
        Factor of the step in time after a shortened step, from rough films.
    min_growth, allowed_rise
        Least factor while the residual falls, or rises by no more than the factor ``allowed_rise``. Against a rise of 1,
        steps at 210 points fell from 2883 to 2426.
    refused, least
        Factor of the step in time after a refused step, and the step in time where the iteration ends.
    stall_steps
        Whole steps within which the residual is halved, or the iteration ends. The slowest film that converges took 105
        steps, most of them shortened.
    cycle, longest, damped
        After so many whole steps that do not halve the residual of a mixed film, a step in time is no longer than
        ``longest``, then ``damped`` times as long. Pockets among asperities fill in a time of 10 to 100: beyond it the
        cells at their fronts changed sets in a cycle.
    unsettled
        Largest factor of the residual in a step of a mixed film whose sets have not converged, which is refused above
        it: some of these steps lost all that the iteration had gained.
    contact_tolerance
        Fraction by which a film is below the boundary film where it touches: above the rounding of heights.
    max_rounding
        Largest residual that counts as rounding.
    """

    min_film_fraction: float = 0.3
    content_fall: float = 0.1
    clipped: float = 2e-3
    shrink: float = 0.3
    grow: float = 4.0
    shortened: float = 0.7
    min_growth: float = 2.0
    allowed_rise: float = 1.1
    refused: float = 0.25
    least: float = 1e-9
    stall_steps: int = 30
    cycle: int = 6
    longest: float = 90.0
    damped: float = 0.3
    unsettled: float = 1.5
    contact_tolerance: float = 1e-9
    max_rounding: float = 1e-3

    def next_time_step(
        self, time_step: float, before: float, residual: float, fraction: float
    ) -> float:
        """Return the step in time after one that took a ``fraction`` of Newton's step, ``before`` to ``residual``."""
        factor = (
            float(np.clip(before / residual, self.shrink, self.grow)) if residual else self.grow
        )
        if fraction < 1:
            factor = min(factor, self.shortened)
        elif residual < self.allowed_rise * before:
            factor = max(factor, self.min_growth)
        return factor * time_step


TUNING = PseudoTimeTuning()


class ActiveSets(NamedTuple):
    """Cells (x, y) that are cavitated, and that touch the boundary film; ``touching`` is None without one."""

    cavitated: Mask
    touching: Mask | None = None

    def changes(self, sets: "ActiveSets") -> int:
        """Return how many cells are in other sets."""
        return sum(
            int(np.count_nonzero(mask != other_mask))
            for mask, other_mask in zip(self, sets, strict=True)
            if mask is not None
        )


class FilmCorrection(NamedTuple):
    """Changes of pressure, void fraction and separation, and how the linear system was solved.

    ``solver`` solves the next system: it keeps what this one has found. ``asperity_pressure`` is the change of the
    pressure of asperities, None without a boundary film.
    """

    pressure: Array
    void: Array
    separation: float
    solver: "LinearSolver"
    solved: bool = True
    iterations: int = 0
    asperity_pressure: Array | None = None


class LinearSolver(Protocol):
    """Method that solves the linear system of a step."""

    def step(
        self, linear: Linearised, film: Film, active: ActiveSets, load_residual: float
    ) -> FilmCorrection:
        """Return the step after which cavitated cells have no pressure, touching ones the boundary film."""
        ...


@dataclass(frozen=True)
class FilmControls:
    """When the iteration stops, and how it starts.

    A step that takes the film or the logarithm of the viscosity too far is shortened to the fraction that does not, and
    refused below the fraction ``shortest``. The active sets of a step converge in ``max_active_set_iterations`` at most;
    far from the answer a fraction ``allowed_set_changes`` of the cells may still change. A step whose sets do not
    converge is taken, or refused if ``converged_only``: near a mixed solution in plane strain such a step increases the
    residual by orders of magnitude. From the dry contact it is taken, as no solution is near.
    """

    tolerance: float = 1e-8
    max_iterations: int = 200
    time_step: float = 0.1
    viscosity_change: float = inf
    shortest: float = 0.05
    max_active_set_iterations: int = 6
    converged_only: bool = False
    allowed_set_changes: float = 1e-3


@dataclass(frozen=True, eq=False)
class FilmIteration:
    """The last film of an iteration, its linearisation and residual, and what it took."""

    film: Film
    linear: Linearised
    active: ActiveSets
    residual: float
    iterations: int
    linear_iterations: int

    @property
    def cavitated(self) -> Mask:
        """Cells that are cavitated."""
        return self.active.cavitated

    def converged(self, tolerance: float) -> bool:
        """Return whether the residual is below ``tolerance`` or rounding, and no cell has both a pressure and a void."""
        both = (self.film.pressure > 0) & (self.film.void > 0)
        return self.residual <= max(tolerance, self.rounding) and not bool(both.any())

    @property
    def rounding(self) -> float:
        """Residual that rounding leaves, of pressures and of films, which are small differences of large heights."""
        linear, heights = self.linear, float(np.abs(self.linear.equation.gap).max())
        by_pressure = float((np.abs(linear.pressure[0, 0]) * self.film.pressure).sum())
        by_film = float(np.abs(linear.film[0, 0]).sum()) * heights
        return float(min(ROUNDING * (by_pressure + by_film) / _flow(linear), TUNING.max_rounding))


def iterate(
    equation: FilmEquation,
    start: Film,
    solver: LinearSolver,
    controls: FilmControls,
    *,
    storage: Storage | None = None,
    cavitated: Mask | None = None,
    callback: Callable[[FilmIteration], None] | None = None,
) -> FilmIteration:
    """Iterate from ``start`` until the residual converges or stagnates, at the limit, or when steps vanish."""
    linear = equation.linearise(start, storage)
    active = _initial_active_sets(equation, start, cavitated)
    last = FilmIteration(start, linear, active, _residual(linear, start), 0, 0)
    time_step, best, waited, longest = controls.time_step, last.residual, 0, inf
    while (
        not last.converged(controls.tolerance)
        and waited < TUNING.stall_steps
        and last.iterations < controls.max_iterations
        and time_step > TUNING.least
        and np.isfinite(last.residual)
    ):
        step = _step_of_active_sets(last, solver, time_step, controls)
        solver = step.change.solver
        fraction = _damping_factor(last, step, controls)
        film = _updated_film(last, step, fraction, controls)
        refused = fraction < controls.shortest or not (film.film > 0).all()
        if not refused:
            linear, active = equation.linearise(film, storage), step.next
            residual = _residual(linear, film)
            refused = (
                active.touching is not None
                and not step.converged
                and residual > TUNING.unsettled * last.residual
            )
        if refused:
            time_step *= TUNING.refused
            film, linear, active, residual = last.film, last.linear, last.active, last.residual
        else:
            time_step = TUNING.next_time_step(time_step, last.residual, residual, fraction)
            waited += fraction == 1
            if 2 * residual <= best:
                best, waited, longest = residual, 0, inf
            elif active.touching is not None and fraction == 1 and waited % TUNING.cycle == 0:
                longest = TUNING.longest * TUNING.damped ** (waited // TUNING.cycle - 1)
            time_step = min(time_step, longest)
        last = FilmIteration(
            film, linear, active, residual,
            last.iterations + 1, last.linear_iterations + step.iterations,
        )  # fmt: skip
        if callback is not None and not refused:
            callback(last)
    return last


def _residual(linear: Linearised, film: Film) -> float:
    """Return the largest of the flow that is not balanced, over the flow, the load that is missing, and heights.

    With asperities also the smaller of their pressure and of how far the film is off the boundary film, and how far any
    film is below that, both over it.
    """
    unbalanced = float(np.abs(linear.residual).sum() / _flow(linear))
    residual = max(unbalanced, abs(linear.equation.load_residual(film)))
    if film.asperity_pressure is None:
        return residual
    boundary = linear.equation.boundary_film
    rise = film.film / boundary - 1
    violation = float(np.minimum(np.abs(rise), film.asperity_pressure).max())
    return max(residual, violation, -float(rise.min()))


def _flow(linear: Linearised) -> float:
    """Return the largest flow through a face between cells whose balance counts, along the whole length."""
    return float(np.abs(linear.flux[1:-1]).max() * linear.residual.shape[1])


def _initial_active_sets(equation: FilmEquation, start: Film, cavitated: Mask | None) -> ActiveSets:
    """Return the active sets of a start: all cells filled, if neither cavitated cells nor asperities are given."""
    if start.asperity_pressure is None:
        return ActiveSets(np.zeros_like(equation.fixed) if cavitated is None else cavitated)
    if cavitated is None:
        has_state = (start.asperity_pressure > 0).any() or start.void.any()
        cavitated = (start.pressure == 0) & ~equation.fixed & has_state
    return ActiveSets(cavitated, start.asperity_pressure > 0)


class _ActiveSetStep(NamedTuple):
    """Step with the sets it was solved for, those that hold after it, and the linear iterations it took."""

    change: FilmCorrection
    active: ActiveSets
    next: ActiveSets
    converged: bool
    iterations: int


def _step_of_active_sets(
    last: FilmIteration, solver: LinearSolver, time_step: float, controls: FilmControls
) -> _ActiveSetStep:
    """Solve a step of ``time_step`` for its active sets, and correct the sets until they hold."""
    film, next_active, iterations = last.film, last.active, 0
    linear = last.linear.with_time_step(
        1 / time_step, _height_off_boundary(last.linear.equation, film)
    )
    load_residual = last.linear.equation.load_residual(film)
    # near the answer every cell counts
    allowed = controls.allowed_set_changes * min(1.0, last.residual) * film.film.size
    tried = [next_active]
    for _ in range(controls.max_active_set_iterations):
        active = next_active
        change = solver.step(linear, film, active, load_residual)
        solver, converged = change.solver, False
        iterations += change.iterations
        if not change.solved:
            break
        next_active = _corrected_active_sets(last, active, change)
        converged = active.changes(next_active) <= allowed
        if converged or not all(earlier.changes(next_active) for earlier in tried):  # or a cycle
            break
        tried.append(next_active)
    change = _within_total_pressure(film, active, change)
    return _ActiveSetStep(change, active, next_active, converged, iterations)


def _within_total_pressure(
    film: Film, active: ActiveSets, change: FilmCorrection
) -> FilmCorrection:
    """Return the change with a pressure of the lubricant from zero to the total in cells that touch.

    The boundary film determines their total pressure. Its parts are nearly indeterminate in a viscous lubricant: they
    may be many times as large, of opposite signs, and if each is cut off at zero, the film moves off the boundary film.
    Without this, four films of a narrow transition took 117 steps for 78.
    """
    if active.touching is None or change.asperity_pressure is None:
        return change
    total = film.total_pressure + change.pressure + change.asperity_pressure
    pressure = np.clip(film.pressure + change.pressure, 0, np.maximum(total, 0)) - film.pressure
    pressure = np.where(active.touching, pressure, change.pressure)
    asperity_pressure = change.asperity_pressure + change.pressure - pressure
    return change._replace(pressure=pressure, asperity_pressure=asperity_pressure)


def _height_off_boundary(equation: FilmEquation, film: Film) -> Array | float:
    """Return how far the film (x, y) is off the boundary film where asperities carry load, or where it is below that.

    A step takes these cells onto the boundary film at once. As a motion within a short step in time it would squeeze
    lubricant out at any pressure.
    """
    if film.asperity_pressure is None:
        return 0.0
    height = film.film - equation.boundary_film
    return np.where((film.asperity_pressure > 0) | (height < 0), height, 0.0)


def _corrected_active_sets(
    last: FilmIteration, active: ActiveSets, change: FilmCorrection
) -> ActiveSets:
    """Return the active sets that hold after a whole step."""
    film, equation = last.film, last.linear.equation
    cavitated = np.where(
        active.cavitated, film.void + change.void >= 0, film.pressure + change.pressure < 0
    )
    cavitated &= ~equation.fixed
    if active.touching is None:
        return ActiveSets(cavitated)
    assert film.asperity_pressure is not None
    assert change.asperity_pressure is not None
    low = film.film + _change_of_film(equation, change) < equation.boundary_film * (
        1 - TUNING.contact_tolerance
    )
    return ActiveSets(
        cavitated,
        np.where(active.touching, film.asperity_pressure + change.asperity_pressure > 0, low),
    )


def _change_of_film(equation: FilmEquation, change: FilmCorrection) -> Array:
    """Return the change of the film (x, y) in a step."""
    total = (
        change.pressure
        if change.asperity_pressure is None
        else change.pressure + change.asperity_pressure
    )
    return equation.deflection(total) + change.separation


def _damping_factor(last: FilmIteration, step: _ActiveSetStep, controls: FilmControls) -> float:
    """Return the largest fraction of a step, up to 1, that keeps film and viscosity within their limits.

    Zero for a step that was not solved, and for one whose sets have to converge and do not.
    """
    change, film, equation = step.change, last.film, last.linear.equation
    if not change.solved or (controls.converged_only and not step.converged):
        return 0.0
    rise = _change_of_film(equation, change) / film.film
    log_change = equation.log_viscosity(film.pressure)[1] * np.abs(change.pressure)
    if step.active.touching is None:
        viscous = np.quantile(log_change, 1 - TUNING.clipped)
    else:  # asperities take over the pressure of the lubricant at once
        taken_over = step.active.touching & (change.pressure < 0)
        viscous = log_change[~taken_over].max(initial=0.0)
    # each fraction is its limit over the change
    largest = max(
        float(-rise.min()) / (1 - TUNING.min_film_fraction),
        float(rise[film.pressure > 0].max(initial=0.0)) / (1 / TUNING.min_film_fraction - 1),
        float(viscous) / controls.viscosity_change,
    )
    return 1.0 if largest <= 1 else 1 / largest


def _updated_film(
    last: FilmIteration, step: _ActiveSetStep, fraction: float, controls: FilmControls
) -> Film:
    """Return the film after a ``fraction`` of a step, with pressures and voids in their range."""
    film, equation, change = last.film, last.linear.equation, step.change
    pressure_change = fraction * change.pressure
    if film.asperity_pressure is None:
        largest = np.full_like(pressure_change, inf)
        log_slope = equation.log_viscosity(film.pressure)[1]
        np.divide(controls.viscosity_change, log_slope, out=largest, where=log_slope > 0)
        pressure_change = np.clip(pressure_change, -largest, largest)
    pressure = np.maximum(film.pressure + pressure_change, 0)
    largest_void = 1 - TUNING.content_fall * (1 - film.void) if equation.conserves else inf
    void = np.clip(film.void + fraction * change.void, 0, largest_void)
    asperity_pressure = None
    if film.asperity_pressure is not None and change.asperity_pressure is not None:
        asperity_pressure = np.maximum(
            film.asperity_pressure + fraction * change.asperity_pressure, 0
        )
    if fraction == 1:
        pressure[step.active.cavitated], void[~step.active.cavitated] = 0, 0
        if asperity_pressure is not None and step.active.touching is not None:
            asperity_pressure[~step.active.touching] = 0
    separation = film.separation + fraction * change.separation
    return equation.film_of(pressure, void, separation, asperity_pressure)
