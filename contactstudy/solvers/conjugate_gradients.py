"""Conjugate gradients: for a semidefinite operator, by Polonsky & Keer (1999), and preconditioned for a contact."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import prod

import numpy as np

from contactstudy.domain.device import arrays
from contactstudy.domain.grid import Array, device_loops, equal, first_cells, inner, mean_over, total
from contactstudy.problem.constraint import Gap
from contactstudy.problem.field_operations import Direction
from contactstudy.problem.problem import BareProblem, Extension


@dataclass(frozen=True, eq=False)
class Iterate:
    """State in which an iteration stopped, dimensionless.

    Parameters
    ----------
    pressure, displacement
        Fields (x, y).
    approach
        Approach of the bodies, counted from the reference height of the problem.
    residual
        Violation of the complementarity conditions, or error of the load, see :class:`~contactstudy.SolveOptions`.
    iterations
        Number of iterations.
    convolutions
        Number of FFT convolutions of the full grid; those of smaller grids count in proportion.
    note
        Sentence about an unusual course of the iteration, or empty.
    """

    pressure: Array
    displacement: Array
    approach: float
    residual: float
    iterations: int
    convolutions: float
    note: str = ""


class Stall:
    """Detector of a stalled residual: one that is not halved within `patience` iterations."""

    def __init__(self, patience: int) -> None:
        self.patience, self.best, self.since = patience, float("inf"), 0

    def stalled(self, residual: float) -> bool:
        """Record the next `residual` and return whether the iteration has stalled."""
        if residual < self.best / 2:
            self.best, self.since = residual, 0
        else:
            self.since += 1
        return self.since >= self.patience


def conjugate_gradients(
    product: Callable[[Array], Array],
    precondition: Callable[[Array], Array],
    inner: Callable[[Array, Array], float],
    rhs: Array,
    rtol: float,
    maxiter: int,
) -> Array:
    """Return an approximate solution x of ``product(x) = rhs``.

    The operator `product` and the preconditioner `precondition` are self-adjoint and positive semidefinite in the inner
    product `inner`. The iteration begins with zero, and ends where the norm of the residual, ``sqrt(inner(r, M r))``
    with the preconditioner M, has fallen to `rtol` times the first one, after `maxiter` applications of the operator, or
    at a direction without curvature. Source: Hestenes & Stiefel (1952), eq. 3:1.
    """
    solution, residual = np.zeros_like(rhs), rhs
    preconditioned = precondition(residual)
    direction, size = preconditioned, inner(residual, preconditioned)
    target = rtol**2 * size
    for _ in range(maxiter):
        if not size > target:
            break
        response = product(direction)
        curvature = inner(direction, response)
        if not curvature > 0:
            break
        length = size / curvature
        solution = solution + length * direction
        residual = residual - length * response
        preconditioned = precondition(residual)
        last, size = size, inner(residual, preconditioned)
        direction = preconditioned + (size / last) * direction
    return solution


@dataclass(frozen=True)
class PolonskyKeer:
    """Conjugate gradients on the active set, the cells in contact below an upper limit, restarted when the contact
    gains a cell.

    An iteration takes two convolutions. Source: Polonsky & Keer (1999), Wear 231, sect. 3. Additions: an upper limit of
    the pressure, a prescribed approach, a restart where the direction is not a descent direction, the step of a Winkler
    foundation for a single cell, and a projected gradient step where scaling to the load leaves no descent direction.

    Parameters
    ----------
    patience
        Iterations without a halving of the residual after which the solver stops.
    """

    patience: int = 400

    def iterate(
        self, problem: BareProblem, *, tolerance: float, max_iterations: int, start: Array | None = None
    ) -> Iterate:
        """Return the state where ``problem.should_stop`` at this `tolerance`, at `max_iterations` or at a stall."""
        xp, constraint = arrays(), problem.constraint
        initial = problem.uniform() if start is None else xp.asarray(start, copy=True)
        pressure = problem.clip_and_scale(initial)
        direction = xp.zeros_like(pressure)
        # delta is 0 after the contact has gained cells, else 1
        previous_squared_norm, delta = 1.0, 0.0
        stall = Stall(self.patience)
        compliance = problem.operator.self_compliance
        iteration = 0
        while True:
            # 1. the gap, whose mean over the active set is zero under a prescribed load
            displacement = problem.operator(pressure)
            gap = problem.gap(pressure, displacement)
            residual = problem.residual(pressure, gap)
            ended = problem.should_stop(residual, displacement, tolerance, gap.largest_displacement)
            if ended or iteration == max_iterations or stall.stalled(residual):
                convolutions = 2.0 * iteration + 1
                return Iterate(pressure, displacement, gap.approach, residual, iteration, convolutions)
            iteration += 1
            # 2. the conjugate direction on the active set
            active = constraint.active(pressure)
            contact_gap = gap.height * active
            squared_norm = inner(contact_gap, contact_gap)
            beta = delta * squared_norm / previous_squared_norm if previous_squared_norm > 0 else 0.0
            direction = contact_gap + beta * direction * active
            previous_squared_norm = squared_norm
            if inner(contact_gap, direction) <= 0:  # addition: restart
                direction = contact_gap
            # 3. the step length, by the second convolution
            response = problem.operator(direction)
            if problem.control.approach is None and squared_norm > 0:
                response -= mean_over(active, response)
            curvature = inner(response, direction)
            # addition: a single active cell has no curvature, nor has none
            step = inner(contact_gap, direction) / curvature if curvature > 0 else 1 / compliance
            # 4. the step, without tension
            before, pressure = pressure, constraint.clip(pressure - step * direction)
            # 5. cells that overlap enter the contact
            at_limit = 1 - constraint.active(pressure)
            trial = constraint.clip(pressure - step * gap.height * at_limit)
            delta = 1.0 if xp.all(trial == pressure) else 0.0
            # 6. the load
            pressure = problem.clip_and_scale(trial)
            # addition: the projected gradient step where that one is no descent direction
            if inner(gap.height, pressure - before) >= 0:
                delta, pressure = 0.0, problem.project(before - step * gap.height)


# Constants of the preconditioned iteration, chosen for few iterations on rough contacts with 9 % to 100 % of the area of
# Hertz.
# A step that a limit cut off is taken in whole where the complementary energy is least beyond this fraction of it: the
# whole step then lowers that energy too, which is quadratic along it.
LEAST_FRACTION = 0.5
# Limits of the trial step length. The preconditioner is stiffer than the contact, not softer, so that steps beyond 1
# overshoot; the lower limit keeps rounding from shortening all further steps.
SHORTEST, LONGEST = 0.1, 1.0
# Fraction of its first residual at which a coarse grid ends. Interpolation to a rough surface has about a third of that
# residual, so that a smaller fraction gains nothing; 0.1 costs an iteration on rough contacts of 96 x 96 and 512 x 512
# cells.
COARSE_REDUCTION = 0.02
# Number of cells up to which no coarser grids are used: iterations there cost nearly as much. With 1024 a line of 4096
# cells takes 20 convolutions in place of 33, and contacts that vary along both axes take no fewer.
MAX_DIRECT_CELLS = 4096
# The same on a GPU, where small grids cost as much as one of 512 x 512 cells.
MAX_DIRECT_GPU_CELLS = 2**18


@dataclass(frozen=True)
class PressureStep:
    """Pressure and displacement before and after a step, and the inner product `curvature` of their changes.

    `cut` says whether a limit cut the step off, so that the next one cannot be conjugate to it.
    """

    after: Array
    before: Array
    displacement_after: Array
    displacement_before: Array
    curvature: float
    cut: bool = False


@dataclass(frozen=True)
class Trial:
    """Trial pressure (x, y), `slope` of the complementary energy along the step to it, and whether limits `cut` it."""

    pressure: Array
    slope: float
    cut: bool


class ContactState:
    """Pressure, displacement and gap of an iteration, and its last step.

    The pressure before the last step is the buffer of the next trial.
    """

    def __init__(self, problem: BareProblem, pressure: Array, convolutions: float) -> None:
        self.problem, self.pressure = problem, pressure
        self.displacement, self.convolutions = problem.operator(pressure), convolutions + 1
        self.gap = problem.gap(pressure, self.displacement)
        self._last: PressureStep | None = None

    @property
    def residual(self) -> float:
        """Residual of the pressure."""
        return self.problem.residual(self.pressure, self.gap)

    @property
    def has_contact(self) -> bool:
        """True if any cell has pressure, which under a given load is always so."""
        return self.problem.control.approach is None or bool(arrays().any(self.pressure > 0))

    def take_last_step(self) -> PressureStep | None:
        """Return the last step and forget it, so that its fields are free for the next convolution."""
        last, self._last = self._last, None
        return last

    def advance(self, trial: Trial) -> float:
        """Step towards the `trial` and return the fraction of the step at which the complementary energy is least.

        The energy is quadratic along the step: one convolution gives its minimum. The step ends there, or at the
        `trial` where limits of the pressure are in the way.
        """
        operations = self.problem.operations
        displacement = self.problem.operator(trial.pressure)
        self.convolutions += 1
        ends = trial.pressure, self.pressure, displacement, self.displacement
        curvature = operations.curvature(*ends)
        best = -trial.slope / curvature if curvature > 0 else 0.0
        fraction = self._fraction(trial, best)
        if fraction != 1:
            operations.take_fraction(*ends, fraction)
        self._last = PressureStep(*ends, curvature * fraction**2, trial.cut)
        self.pressure, self.displacement = trial.pressure, displacement
        self.gap = self.problem.gap(self.pressure, displacement, self.gap)
        return best

    def _fraction(self, trial: Trial, best: float) -> float:
        """Return the fraction of a step to take: `best`, of least complementary energy, unless limits are in the way."""
        if trial.cut:
            # cut cells are at a limit of their pressure, and would be beyond it after more than the whole step
            return 1.0 if best > LEAST_FRACTION else best
        # not up to the first limit beyond it: rounding would decide which of many cells reaches it
        operations = self.problem.operations
        crosses = best > 1 and operations.crosses_a_limit(trial.pressure, self.pressure, best)
        return 1.0 if crosses else best


class ContactPreconditioner:
    """Prediction of the active set, and preconditioner on it, whose extension is kept until the set changes.

    The active set is the cells in which the constraint ``gap >= 0`` is active: the gap should be zero there.
    """

    def __init__(self, problem: BareProblem) -> None:
        self._problem = problem
        precision = problem.operations.preconditioner_precision(problem.undeformed_gap)
        self._inverse = problem.operator.approximate_inverse(precision)
        self._extension: Extension | None = None
        self._uniform = 0.0, 0.0
        self._convolutions = 0.0

    @property
    def convolutions(self) -> float:
        """Number of convolutions that cost as much as all preconditioning so far."""
        return self._inverse.cells_transformed / self._problem.operator.transform_size + self._convolutions

    def uniform_correction(self, active: Array, height: Array) -> float:
        """Return the uniform pressure on `active` cells that closes the mean of their gap, of this `height`.

        The compliance under a uniform pressure is found again where the number of cells has changed by a tenth.
        """
        count, compliance = self._uniform
        cells = total(active)
        if abs(cells - count) > count / 10:
            pressure = arrays().astype(active, height.dtype)
            compliance = inner(pressure, self._problem.operator(pressure)) / cells
            self._uniform, self._convolutions = (cells, compliance), self._convolutions + 1
        return inner(active, height) / cells / compliance

    def predict(self, pressure: Array, gap: Gap, step_length: float) -> tuple[Array, bool, Array]:
        """Return the active set (x, y) predicted for a step of this length, and whether any cell entered it.

        The third is the preconditioned residual, the pressure (x, y) that would close the gap of the set by the
        approximate inverse.

        The set, 1 in its cells and 0 elsewhere, is the cells with pressure, and those that would penetrate after a step
        that closes the gap of these and displaces the cells beside them. The gap before the step would add every cell
        with a small gap where a contact is slightly too high over a wide region.
        """
        operations = self._problem.operations
        active, gap_of_set = operations.active_set(pressure, gap.height, self._inverse.real)
        if self._extension is None or not equal(self._extension.active, active):
            self._extension = None  # free it before the next one is made
            self._extension = self._inverse.extension(active)
        active = self._extension.active
        extended = self._extension(gap_of_set)
        of_cells = first_cells(extended, active.shape)
        entered = operations.add_entering(pressure, gap.height, of_cells, step_length, active, gap_of_set)
        if entered:
            self._extension = None  # free the extension of the smaller set before the next one is made
            del extended, of_cells
            self._extension = self._inverse.extension(active)
            extended = self._extension(gap_of_set)
        return active, entered, self._extension.pressure(extended)


def trial_step(state: ContactState, preconditioner: ContactPreconditioner, step_length: float) -> Trial:
    """Return the trial pressure a `step_length` along the conjugate direction, projected to the load.

    The direction is against the preconditioned residual. It is zero outside the active set, and such that the load
    stays as it is; under a prescribed approach it has a uniform part too, which closes the mean gap, and the load
    follows. It is conjugate to the last step where the active set is the same, no limit cut that step off and the
    direction is still a descent direction.
    """
    problem, pressure, height = state.problem, state.pressure, state.gap.height
    operations, control = problem.operations, problem.control
    active, entered, preconditioned = preconditioner.predict(pressure, state.gap, step_length)
    uniform = None if control.approach is None else preconditioner.uniform_correction(active, height)
    last = state.take_last_step()
    trial = arrays().empty_like(pressure) if last is None else last.before
    usable = None if last is None or last.cut or entered or last.curvature <= 0 else last
    shift, beta = _shift_and_beta(problem, height, preconditioned, active, usable, uniform)
    direction = Direction(preconditioned, active, shift, beta)
    sums = operations.trial(pressure, height, direction, step_length, trial)
    slope, rounding = sums.slope, 16 * float(arrays().finfo(pressure.dtype).eps)  # rounding of a sum
    if sums.cut or control.error(sums.load) > rounding:
        slope = operations.project_to_load(trial, sums, active, control, pressure, height)
    return Trial(trial, slope, sums.cut)


def _shift_and_beta(
    problem: BareProblem,
    height: Array,
    preconditioned: Array,
    active: Array,
    last: PressureStep | None,
    uniform: float | None,
) -> tuple[float, float]:
    """Return what to add to the direction against the residual: a uniform pressure, and beta times the last step.

    Beta is that of Hestenes & Stiefel (1952), eq. 3:1, for directions that keep the load; 0 where the direction would
    not be a descent direction.
    """
    operations = problem.operations
    if last is None:
        if uniform is not None:
            return -uniform, 0.0
        count, summed = operations.direction_sums(active, preconditioned)
        return summed / count, 0.0
    fields = last.before, last.after, last.displacement_before, last.displacement_after
    sums = operations.conjugacy_sums(height, preconditioned, active, *fields)
    shift = sums.preconditioned / sums.cells if uniform is None else -uniform
    beta = (sums.preconditioned_response - shift * sums.active_response) / last.curvature
    descent = sums.gap_preconditioned
    if uniform is not None:
        descent += uniform * inner(active, height)
    if not beta * sums.gap_step < descent:
        return shift, 0.0
    if uniform is None:  # the direction keeps the load
        shift -= beta * sums.step / sums.cells
    return shift, beta


def projected_gradient_step(state: ContactState, trial: Array) -> Trial:
    """Return the projected gradient step, against the gap; `trial` is overwritten.

    Its direction is always a descent direction. Source: Nocedal & Wright (2006), sect. 16.7.
    """
    problem, pressure, height = state.problem, state.pressure, state.gap.height
    trial[...] = pressure - height / problem.operator.self_compliance
    problem.project(trial)
    return Trial(trial, problem.operations.slope(trial, pressure, height), cut=True)


@dataclass(frozen=True)
class PreconditionedCG:
    """Preconditioned conjugate gradients with a trial step and a start from coarser grids.

    An iteration takes one convolution and one preconditioning:

    1. predict the active set, where the gap should be zero: the cells with pressure, and those expected to penetrate
       after a step of the trial length;
    2. precondition the residual, the gap, on that set;
    3. take a direction against it, conjugate to the last step where the active set is the same;
    4. take a trial pressure one trial length along it, projected to the load; a projected gradient step where that is
       not a descent direction after projection, which also quarters the trial length;
    5. exact line search: the convolution of the trial gives the complementary energy along it. The trial length is
       multiplied by the fraction of the step at which that is least, within 0.1 and 1; at first it is 1.

    Source: active sets Hintermueller, Ito & Kunisch (2002), here with one step of the inner iteration to each set;
    preconditioner Vollebregt (2014); conjugacy Hestenes & Stiefel (1952), eq. 3:1.

    Parameters
    ----------
    coarse_tolerance
        Residual at which iterations on coarser grids end, which give the start. They also end at `COARSE_REDUCTION`
        times their first residual, and after `patience` iterations.
    patience
        Iterations without a halving of the residual after which Polonsky & Keer's scheme goes on from there, and the
        solution's note says so.
    """

    coarse_tolerance: float = 1e-3
    patience: int = 40

    def iterate(
        self, problem: BareProblem, *, tolerance: float, max_iterations: int, start: Array | None = None
    ) -> Iterate:
        """Return the state where ``problem.should_stop`` at this `tolerance`, at `max_iterations` or at a stall."""
        last = self._descend(problem, start, tolerance, max_iterations)
        ended = problem.should_stop(last.residual, last.displacement, tolerance)
        if ended or last.iterations == max_iterations:
            return last
        following = PolonskyKeer().iterate(
            problem, tolerance=tolerance, max_iterations=max_iterations - last.iterations, start=last.pressure
        )
        better = min(last, following, key=lambda iterate: iterate.residual)
        return replace(
            better,
            iterations=last.iterations + following.iterations,
            convolutions=last.convolutions + following.convolutions,
            note=f"Preconditioned conjugate gradients stalled at a residual of {last.residual:.1e} after "
            f"{last.iterations} iterations; Polonsky & Keer's scheme went on from there.",
        )

    def _first_pressure(self, problem: BareProblem, start: Array | None, tolerance: float) -> tuple[Array, float]:
        """Return the admissible pressure to start from, in a new array, and at most how many convolutions it takes."""
        if start is not None:
            admissible = problem.clip_and_scale(arrays().asarray(start, copy=True))
            if problem.control.approach is None or arrays().any(admissible > 0):
                return admissible, 0.0
            return problem.winkler_start(), 1.0
        shape = problem.undeformed_gap.shape
        on_gpu = device_loops() is not None
        direct = MAX_DIRECT_GPU_CELLS if on_gpu else MAX_DIRECT_CELLS
        coarse = problem.coarsened() if prod(shape) > direct else None
        if coarse is None:
            return problem.winkler_start(), 1.0
        enough = max(tolerance, self.coarse_tolerance)
        last = self._descend(coarse, None, enough, self.patience, COARSE_REDUCTION)
        blocks = [n // m for n, m in zip(shape, last.pressure.shape, strict=True)]
        xp = arrays()
        fine = xp.repeat(xp.repeat(last.pressure, blocks[1], axis=1), blocks[0], axis=0)
        return fine, last.convolutions * coarse.operator.transform_size / problem.operator.transform_size

    def _descend(
        self, problem: BareProblem, start: Array | None, tolerance: float, max_iterations: int, reduction: float = 0.0
    ) -> Iterate:
        """Return the state in which the iteration from `start`, or from coarser grids, ends or stalls.

        It also ends at a residual of this `reduction` times the first one.
        """
        preconditioner = ContactPreconditioner(problem)
        state = ContactState(problem, *self._first_pressure(problem, start, tolerance))
        stall, iteration, step_length = Stall(self.patience), 0, 1.0
        residual = state.residual
        tolerance = max(tolerance, reduction * residual)
        while not (
            problem.should_stop(residual, state.displacement, tolerance, state.gap.largest_displacement)
            or iteration == max_iterations
            or stall.stalled(residual)
        ):
            iteration += 1
            if state.has_contact:
                trial = trial_step(state, preconditioner, step_length)
            else:  # no contact to precondition: it begins in the cells that penetrate
                trial = projected_gradient_step(state, arrays().empty_like(state.pressure))
            if trial.slope >= 0:  # not a descent direction after projection
                step_length = max(step_length / 4, SHORTEST)
                trial = projected_gradient_step(state, trial.pressure)
            step_length *= state.advance(trial)
            step_length = min(max(step_length, SHORTEST), LONGEST)
            residual = state.residual
        return Iterate(
            state.pressure,
            state.displacement,
            state.gap.approach,
            residual,
            iteration,
            state.convolutions + preconditioner.convolutions,
        )
