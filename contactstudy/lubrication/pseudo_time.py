"""Newton's method in pseudo-time for a film in which lubricant cavitates.

Each cell has one unknown: its pressure, or the void fraction where it is cavitated. A step solves the linearised balance
with an implicit step in time, of a length that grows as the residual falls: from a distant start the film squeezes
towards its state, near the end the step is Newton's. Which cells are cavitated is settled within the step: one with a
negative pressure becomes so, one with a negative void fraction no longer is.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import inf
from typing import NamedTuple, Protocol

import numpy as np

from contactstudy.domain.fields import Array
from contactstudy.lubrication.film_equation import Film, FilmEquation, Linearised, Mask, Storage

# The film may fall to this share in a step, the content of a cavitated cell to that.
FILM_FALL, CONTENT_FALL = 0.3, 0.1
# A step in time changes by these factors at most, and one below this is given up.
SHORTER, LONGER, REFUSED, LEAST = 0.3, 4.0, 0.25, 1e-9
# A step in time grows while the residual falls, or rises by no more than this factor.
RISES = 1.1
# Rounding of a pressure and of a film, over the pressure and over the largest height. A residual by rounding that is
# larger than COARSE is no balance.
ROUNDING, COARSE = 4 * float(np.finfo(float).eps), 1e-3
# Rounds that settle which cells are cavitated, and the share of cells that need not be.
ROUNDS, UNSETTLED = 6, 1e-3
# Whole steps within which the residual is halved, or the iteration ends; shortened ones do not count.
PATIENCE = 30


class FilmStep(NamedTuple):
    """Changes of pressure, void fraction and separation, and how the linear system was solved.

    ``solver`` solves the next system: it keeps what this one has found.
    """

    pressure: Array
    void: Array
    separation: float
    solver: "StepSolver"
    solved: bool = True
    iterations: int = 0


class StepSolver(Protocol):
    """Method that solves the linear system of a step."""

    def step(
        self, linear: Linearised, film: Film, cavitated: Mask, load_missing: float
    ) -> FilmStep:
        """Return the step after which ``cavitated`` cells have no pressure, and the others no void."""
        ...


@dataclass(frozen=True)
class FilmControls:
    """When the iteration stops, and how it starts.

    A step that takes the film or the logarithm of the viscosity too far is shortened to the share that does not, and
    refused below the share ``shortest``.
    """

    tolerance: float = 1e-8
    max_iterations: int = 200
    time_step: float = 0.1
    viscosity_change: float = inf
    shortest: float = 0.05


@dataclass(frozen=True, eq=False)
class FilmIteration:
    """The last film of an iteration, its linearisation and residual, and what it took."""

    film: Film
    linear: Linearised
    cavitated: Mask
    residual: float
    iterations: int
    linear_iterations: int
    rests: bool = False

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
        return float(min(ROUNDING * (by_pressure + by_film) / _flow(linear), COARSE))


def residual_of(linear: Linearised, film: Film) -> float:
    """Return the larger of the flow that is not balanced, over the flow, and the load that is missing."""
    unbalanced = np.abs(linear.residual).sum() / _flow(linear)
    return float(max(unbalanced, abs(linear.equation.load_missing(film))))


def _flow(linear: Linearised) -> float:
    """Return the largest flow through a face between cells whose balance counts, along the whole length."""
    return float(np.abs(linear.flux[1:-1]).max() * linear.residual.shape[1])


def iterate(
    equation: FilmEquation,
    start: Film,
    solver: StepSolver,
    controls: FilmControls,
    *,
    storage: Storage | None = None,
    cavitated: Mask | None = None,
    watch: Callable[[FilmIteration], None] | None = None,
) -> FilmIteration:
    """Iterate from ``start`` until the residual is below the tolerance or rests, the limit, or steps without length."""
    linear = equation.linearise(start, storage)
    if cavitated is None:
        cavitated = np.zeros_like(equation.fixed)
    last = FilmIteration(start, linear, cavitated, residual_of(linear, start), 0, 0)
    time_step, best, waited = controls.time_step, last.residual, 0
    while (
        not last.converged(controls.tolerance)
        and not last.rests
        and last.iterations < controls.max_iterations
        and time_step > LEAST
        and np.isfinite(last.residual)
    ):
        settled, next_cavitated, change, linear_iterations = _settled(last, solver, time_step)
        solver = change.solver
        share = share_of(last, change, controls.viscosity_change) if change.solved else 0.0
        counts = last.iterations + 1, last.linear_iterations + linear_iterations
        film = _moved(last, change, settled, share)
        if share < controls.shortest or not (film.film > 0).all():
            time_step *= REFUSED
            last = FilmIteration(last.film, last.linear, last.cavitated, last.residual, *counts)
            continue
        linear = equation.linearise(film, storage)
        residual = residual_of(linear, film)
        factor = float(np.clip(last.residual / residual, SHORTER, LONGER)) if residual else LONGER
        if share < 1:
            factor = min(factor, 0.7)
        elif residual < RISES * last.residual:
            factor = max(factor, 2.0)
        time_step *= factor
        last = FilmIteration(film, linear, next_cavitated, residual, *counts)
        waited += share == 1
        if 2 * residual <= best:
            best, waited = residual, 0
        if waited >= PATIENCE:
            last = replace(last, rests=True)
        if watch is not None:
            watch(last)
    return last


def _settled(
    last: FilmIteration, solver: StepSolver, time_step: float
) -> tuple[Mask, Mask, FilmStep, int]:
    """Return a step of ``time_step``.

    Returns the cells that cavitate in it, those that should after it, the step, and the linear iterations it took.
    """
    equation, film, cavitated = last.linear.equation, last.film, last.cavitated
    delayed = last.linear.delayed(1 / time_step)
    missing, iterations = equation.load_missing(film), 0
    # near the answer every cell counts
    unsettled = UNSETTLED * min(1.0, last.residual) * film.film.size
    for round_number in range(ROUNDS):
        change = solver.step(delayed, film, cavitated, missing)
        solver = change.solver
        iterations += change.iterations
        if not change.solved:
            next_cavitated = cavitated
            break
        next_cavitated = np.where(
            cavitated, film.void + change.void >= 0, film.pressure + change.pressure < 0
        )
        next_cavitated &= ~equation.fixed
        flips = np.count_nonzero(next_cavitated != cavitated)
        if flips <= unsettled or round_number == ROUNDS - 1:
            break
        cavitated = next_cavitated
    return cavitated, next_cavitated, change, iterations


def share_of(
    last: FilmIteration, change: FilmStep, viscosity_change: float, contact: Array | float = 0.0
) -> float:
    """Return the largest share of a step, up to 1, that keeps film and viscosity within their limits."""
    film, equation = last.film, last.linear.equation
    change_of_film = equation.deflection(change.pressure + contact) + change.separation
    loaded = film.pressure > 0
    log_slope = equation.log_viscosity(film.pressure)[1]
    # each share is its limit over the change
    largest = max(
        float((-change_of_film / film.film).max()) / (1 - FILM_FALL),
        float((change_of_film / film.film)[loaded].max(initial=0.0)) / (1 / FILM_FALL - 1),
        float((log_slope * np.abs(change.pressure)).max()) / viscosity_change,
    )
    return 1.0 if largest <= 1 else 1 / largest


def _moved(last: FilmIteration, change: FilmStep, cavitated: Mask, share: float) -> Film:
    """Return the film after a ``share`` of a step, with pressures and voids in their range."""
    film, equation = last.film, last.linear.equation
    pressure = np.maximum(film.pressure + share * change.pressure, 0)
    most = 1 - CONTENT_FALL * (1 - film.void) if equation.conserves else inf
    void = np.clip(film.void + share * change.void, 0, most)
    if share == 1:
        pressure[cavitated], void[~cavitated] = 0, 0
    return equation.film_of(pressure, void, film.separation + share * change.separation)
