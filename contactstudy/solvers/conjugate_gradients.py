"""Conjugate gradients: for linear equations, for a contact by Polonsky & Keer (1999), and preconditioned for a contact.

A contact is a quadratic programme: the pressure p within its limits has the least complementary energy,
``1/2 p K p + p h``. Here K maps pressure to displacement, and h is the undeformed gap. The gradient is the gap. The
active set is the cells at no limit of their pressure, in which the gap should be zero; an array of it is 1 there and 0
elsewhere. Fields are dimensionless, and of a :class:`~contactstudy.problem.problem.BareProblem`. Its operations on them
are loops fused for the CPU or the GPU. One convolution is one application of K.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import prod
from typing import NamedTuple

import numpy as np

from contactstudy.domain.device import Precision, arrays
from contactstudy.domain.grid import Array, device_loops, equal, first_cells, inner, mean_over, total
from contactstudy.problem.constraint import Gap
from contactstudy.problem.field_operations import Direction
from contactstudy.problem.problem import BareProblem, Extension
from contactstudy.solvers.solution import Solution


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
    """Detector of a stalled residual, which is not halved within `patience` iterations.

    `best` is the last residual that was less than half of the best before, and `since` the iterations since then.
    """

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
    product `inner`. The iteration begins with zero. It ends where the norm of the residual, ``sqrt(inner(r, M r))``
    with the preconditioner M, is `rtol` times the first one, after `maxiter` applications of the operator, or at a
    direction without curvature. Source: Hestenes & Stiefel (1952), eq. 3:1.
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


# Relative residual of a tangent operator, with which Newton's method of a plastic step takes as many iterations as with
# an exact one. Most operator applications in it: up to 3 were seen on smooth and rough contacts.
TANGENT_RTOL, TANGENT_MAXITER = 1e-2, 200


def contact_tangent(solution: Solution, precision: Precision = Precision.DOUBLE) -> Callable[[Array], Array]:
    """Return the tangent operator ``-dp/dgap`` of a contact under a fixed load, with its active set as it is.

    The operator maps a change of the gap (x, y) [m] to minus the change of the pressure (x, y) [Pa]. It is
    ``K^-1 - K^-1 1 1^T K^-1 / (1^T K^-1 1)``, with the map K from pressure to displacement of the active set, the cells
    in contact below their hardness, and the vector 1 of ones there. It is applied by conjugate gradients among
    pressures without a load, in this `precision` and preconditioned as the contact is.
    """
    problem, bare = solution.problem, solution.problem.bare(precision)
    active = np.asarray(problem.constraint.active(solution.pressure), dtype=precision.real)
    count = total(active)
    if count < 2:  # a single cell keeps the load
        return np.zeros_like
    extension = bare.operator.approximate_inverse().extension(active)

    def deviation(field: Array) -> Array:
        """Return a field less its mean over the active set, and zero elsewhere."""
        field = field * active
        return np.asarray((field - total(field) / count) * active)

    def tangent(gap: Array) -> Array:
        pressure = conjugate_gradients(
            lambda pressure: deviation(bare.operator(pressure)),
            lambda residual: deviation(extension.pressure(extension(residual))),
            inner,
            deviation((gap / problem.scales.gap).astype(active.dtype)),
            TANGENT_RTOL,
            TANGENT_MAXITER,
        )
        return np.asarray(pressure * problem.scales.pressure, dtype=np.float64)

    return tangent


@dataclass(frozen=True)
class PolonskyKeer:
    """Conjugate gradients on the active set, the cells in contact below an upper limit, restarted when the contact
    gains a cell.

    An iteration takes two convolutions. Source: Polonsky & Keer (1999), Wear 231, sect. 3. Additions: an upper limit of
    the pressure, a prescribed approach, and the step of a Winkler foundation for a single cell. Where the direction is
    no descent direction the iteration restarts; where scaling to the load leaves none it takes a projected gradient
    step.

    Parameters
    ----------
    patience
        Iterations without a halving of the residual after which the solver stops. On rough contacts that converge there
        were up to 20; it allows far more, since no other scheme goes on from there.
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


# Constants of the preconditioned iteration, chosen for few iterations on rough contacts with 9 % to 100 % of the area
# of Hertz. A step that a limit cut off is taken in whole where the complementary energy is least beyond this fraction
# of it. Since the energy is quadratic along the step, the whole one then lowers it too.
LEAST_FRACTION = 0.5
# Limits of the trial step length. The preconditioner is stiffer than the contact, not softer, so that steps beyond 1
# overshoot; the lower limit keeps rounding from shortening all further steps.
SHORTEST, LONGEST = 0.1, 1.0
# Fraction of its first residual at which a coarse grid ends. A smaller fraction gains nothing, as interpolation to a
# rough surface leaves about a third of the first residual; 0.1 costs an iteration on rough contacts of 96 x 96 and 512
# x 512 cells.
COARSE_REDUCTION = 0.02
# Number of cells up to which no coarser grids are used: iterations there cost nearly as much. With 1024 a line of 4096
# cells takes 20 convolutions in place of 33, and contacts that vary along both axes take no fewer.
MAX_DIRECT_CELLS = 4096
# The same on a GPU, where small grids cost as much as one of 512 x 512 cells.
MAX_DIRECT_GPU_CELLS = 2**18


class ContactPreconditioner:
    """Prediction of the active set, and preconditioner on it.

    The approximate inverse of the operator takes a displacement of all cells. The extension of an active set continues
    a displacement of that set smoothly to the other cells; it is kept until the set changes.
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
        """Return the active set (x, y) predicted for a step, whether a cell entered it, and the preconditioned residual.

        The preconditioned residual is the pressure (x, y) that would close the gap of the set by the approximate
        inverse. The set is the cells with pressure, and those that would penetrate after a step of this length. The
        step closes the gap of the former and displaces the cells beside them. By the gap before the step, every cell
        with a small overlap would enter where the pressure of a wide region is slightly too small.
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


class LastStep(NamedTuple):
    """Pressures and displacements (x, y) after and before a step, and the inner product `curvature` of their changes.

    `cut` says whether a limit of the pressure cut the step off, so that the next one cannot be conjugate to it.
    """

    after: Array
    before: Array
    displacement_after: Array
    displacement_before: Array
    curvature: float
    cut: bool


class Descent:
    """Pressure, displacement and gap (x, y) of a `problem`, and the steps that lower its complementary energy.

    The `step_length` is the factor on the preconditioned residual with which the next trial pressure is taken.
    """

    def __init__(self, problem: BareProblem, pressure: Array, convolutions: float) -> None:
        self.problem, self.pressure, self.step_length = problem, pressure, 1.0
        self.displacement, self._convolutions = problem.operator(pressure), convolutions + 1
        self.gap = problem.gap(pressure, self.displacement)
        self._preconditioner = ContactPreconditioner(problem)
        self._last: LastStep | None = None

    @property
    def convolutions(self) -> float:
        """Number of convolutions of the full grid so far, those of the preconditioner in proportion to its cells."""
        return self._convolutions + self._preconditioner.convolutions

    def step(self) -> None:
        """Take a step towards a trial pressure, to the least energy along it or up to limits of the pressure.

        The energy is quadratic along the step: the convolution of the trial gives its minimum.
        """
        problem, operations, last = self.problem, self.problem.operations, self._last
        # the pressure before the last step is the buffer of the trial
        trial = arrays().empty_like(self.pressure) if last is None else last.before
        slope, is_cut = 0.0, True
        if problem.control.approach is None or bool(arrays().any(self.pressure > 0)):  # else nothing to precondition
            slope, is_cut = self._conjugate_trial(trial, last)
            if slope >= 0:
                self.step_length = max(self.step_length / 4, SHORTEST)
        if slope >= 0:
            # the projected gradient step, always a descent direction: Nocedal & Wright (2006), sect. 16.7
            trial[...] = self.pressure - self.gap.height / problem.operator.self_compliance
            problem.project(trial)
            slope, is_cut = operations.slope(trial, self.pressure, self.gap.height), True
        self._last = last = None  # free its fields before the next convolution
        displacement = problem.operator(trial)
        self._convolutions += 1
        ends = trial, self.pressure, displacement, self.displacement
        curvature = operations.curvature(*ends)
        best = -slope / curvature if curvature > 0 else 0.0
        if is_cut:  # cells at a limit of their pressure would be beyond it after more than the whole step
            is_whole = best > LEAST_FRACTION
        else:  # not a longer step to the first limit: rounding would decide which of many cells reaches it
            is_whole = best > 1 and operations.crosses_a_limit(trial, self.pressure, best)
        fraction = 1.0 if is_whole else best
        if fraction != 1:
            operations.take_fraction(*ends, fraction)
        self._last = LastStep(*ends, curvature * fraction**2, is_cut)
        self.pressure, self.displacement = trial, displacement
        self.gap = problem.gap(trial, displacement, self.gap)
        self.step_length = min(max(self.step_length * best, SHORTEST), LONGEST)

    def _conjugate_trial(self, trial: Array, last: LastStep | None) -> tuple[float, bool]:
        """Write a trial pressure (x, y) into `trial`, one step length along the conjugate direction.

        Return the slope of the energy along the step, and whether limits of the pressure cut it off.

        The direction is against the preconditioned residual, plus beta times the `last` step, at whose start the
        pressure was what `trial` holds first. The direction is zero outside the active set, and keeps the load. Under a
        prescribed approach the load follows: the direction has a uniform part, which closes the mean gap. Beta is that
        of Hestenes & Stiefel (1952), eq. 3:1; it is 0 where a cell entered the active set, a limit cut the last step
        off, or the direction would not be a descent direction.
        """
        pressure, height, control = self.pressure, self.gap.height, self.problem.control
        operations, preconditioner = self.problem.operations, self._preconditioner
        active, has_entered, preconditioned = preconditioner.predict(pressure, self.gap, self.step_length)
        uniform = None if control.approach is None else preconditioner.uniform_correction(active, height)
        shift, beta = 0.0 if uniform is None else -uniform, 0.0
        if last is not None and not (last.cut or has_entered) and last.curvature > 0:
            fields = last.before, last.after, last.displacement_before, last.displacement_after
            with_last = operations.conjugacy_sums(height, preconditioned, active, *fields)
            descent = with_last.gap_preconditioned
            if uniform is None:
                shift = with_last.preconditioned / with_last.cells
            else:
                descent += uniform * inner(active, height)
            beta = (with_last.preconditioned_response - shift * with_last.active_response) / last.curvature
            if not beta * with_last.gap_step < descent:
                beta = 0.0
            elif uniform is None:  # the direction keeps the load
                shift -= beta * with_last.step / with_last.cells
        elif uniform is None:
            count, summed = operations.direction_sums(active, preconditioned)
            shift = summed / count
        sums = operations.trial(
            pressure, height, Direction(preconditioned, active, shift, beta), self.step_length, trial
        )
        rounding = 16 * float(arrays().finfo(pressure.dtype).eps)  # of a sum
        if sums.cut or control.error(sums.load) > rounding:
            return operations.project_to_load(trial, sums, active, control, pressure, height), sums.cut
        return sums.slope, sums.cut


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
        Iterations without a halving of the residual after which Polonsky & Keer's scheme goes on, as the solution's
        note says. On rough contacts that converge there were up to 12.
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
        descent = Descent(problem, *self._first_pressure(problem, start, tolerance))
        stall, iteration = Stall(self.patience), 0
        residual = problem.residual(descent.pressure, descent.gap)
        tolerance = max(tolerance, reduction * residual)
        while not (
            problem.should_stop(residual, descent.displacement, tolerance, descent.gap.largest_displacement)
            or iteration == max_iterations
            or stall.stalled(residual)
        ):
            iteration += 1
            descent.step()
            residual = problem.residual(descent.pressure, descent.gap)
        end = descent.pressure, descent.displacement, descent.gap.approach
        return Iterate(*end, residual, iteration, descent.convolutions)
