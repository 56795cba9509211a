"""Solve a contact problem: options, checks and status; and a contact whose gap depends on its own pressure.

A solve passes a dimensionless problem to an iteration (:mod:`contactstudy.solvers.conjugate_gradients`), which may run
on another device. A problem that names friction or adhesion is passed on to their solvers, which come back here for
each contact without them. A displacement by the pressure that has no place in a symmetric operator is lagged: a
fixed-point iteration adds it to the undeformed gap of the next contact. Its mixing is that of Anderson (1965), in the
form of Walker & Ni (2011), eq. 2.2.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from math import inf
from typing import Annotated, Any, ClassVar, Literal, NamedTuple, Protocol, runtime_checkable

import numpy as np

from contactstudy.domain.device import Cpu, Device, Precision, checked, using
from contactstudy.domain.device import device as device_in_use
from contactstudy.domain.grid import Array
from contactstudy.domain.validation import ABOVE_ZERO, Example, InvalidInput, Number, at_least, readable, validated
from contactstudy.elasticity.convolution import Convolution
from contactstudy.problem.constraint import Constraint, largest_of, scaled_in_double
from contactstudy.problem.problem import BareProblem, Problem, refuse_too_large
from contactstudy.solvers.conjugate_gradients import Iterate, PreconditionedCG
from contactstudy.solvers.solution import Solution, Status, unloaded


@runtime_checkable
class Solver(Protocol):
    """Iteration that solves a dimensionless problem.

    :class:`~contactstudy.PreconditionedCG` and :class:`~contactstudy.PolonskyKeer` are such solvers.
    """

    def iterate(
        self, problem: BareProblem, *, tolerance: float, max_iterations: int, start: Array | None = None
    ) -> Iterate:
        """Return the last iterate, at the latest after `max_iterations`.

        The iteration ends where ``problem.should_stop`` says so: the residual is at most the `tolerance`, at the
        rounding of the gap, or not finite. It may also end where the residual no longer falls.
        """


@validated
class SolveOptions:
    """Accuracy and method of a solve.

    An answer depends on these, on the problem and, where several states exist, on the start.

    Parameters
    ----------
    tolerance
        Largest dimensionless residual, above 0. The residual is the largest of four: the mean absolute gap in the
        active set, weighted by pressure; the largest penetration without pressure; the largest open gap at the
        hardness; the relative error of the load. The first three are in units of ``Problem.scales.gap``.
    max_iterations
        Iterations after which a solve ends with :attr:`~contactstudy.Status.ITERATION_LIMIT`; of tangential traction,
        applications of its response; with adhesion, inner and outer iterations together, and ten times as many for each
        load of a pull-off but the first. Where a step of bodies that yield, or a displacement that follows from the
        pressure, takes several contacts, each has this limit.
    solver
        The iteration, such as :class:`~contactstudy.PreconditionedCG`.
    precision
        The floating-point numbers of the iteration, ``"double"`` or ``"single"``.

    Raises
    ------
    InvalidInput
        If the tolerance is not above 0, the limit is not a whole number of at least 0, the solver has no method
        ``iterate``, or the precision is unknown.
    """

    called: ClassVar[str] = "solve"

    tolerance: Annotated[Number, ABOVE_ZERO] = 1e-8
    max_iterations: Annotated[int, at_least(0)] = 2000
    solver: Annotated[Solver, Example("PreconditionedCG()")] = field(default_factory=PreconditionedCG)
    precision: Literal["single", "double"] = "double"


def solve_contact(
    problem: Problem,
    options: SolveOptions = SolveOptions(),  # noqa: B008 (a frozen value)
    start: Array | None = None,
    device: Device | None = None,
) -> Solution:
    """Return the solution of a problem.

    Parameters
    ----------
    problem
        The contact in SI units.
    options
        Accuracy and method.
    start
        Pressure (x, y) [Pa] to begin with, at least 0 Pa; None leaves the start to the solver, which may take it
        from coarser grids.
    device
        The device that the fields of the iteration are held on; the one in use if None, by default one CPU thread.

    Returns
    -------
    Solution
        Fields in SI units, and a status, also where the solve did not converge.

    Raises
    ------
    InvalidInput
        If the start is no pressure on the grid or carries no load, or the device cannot hold or solve the problem.
    """
    if device is None:
        device = device_in_use()
    if problem.friction is not None:
        frictionless = replace(problem, friction=None)
        solution: Solution = problem.friction.solve(frictionless, options, start, device)
        return replace(solution, problem=problem)
    if problem.adhesion is not None:
        adhered: Solution = problem.adhesion.solve(problem, options, start, device)
        return adhered
    if not problem.control.is_met_by(problem.constraint, problem.undeformed_gap.size):
        return replace(unloaded(problem), status=Status.NO_ADMISSIBLE_PRESSURE, residual=inf)
    precision = Precision(options.precision)
    if not isinstance(device, Cpu):
        checked(device, "solve.device")
        if type(problem.operator) is not Convolution or type(problem.constraint) is not Constraint:
            raise InvalidInput(
                f"solve.device is {device!r}: solids with free_faces, and an operator or a constraint of your own, "
                "work on numpy arrays, give Cpu()."
            )
    refuse_too_large(problem.grid, problem.operator.transform_size, device, precision)
    if start is not None:
        start = _relative_start(start, problem, precision)
    with using(device), np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        bare = problem.bare(precision)
        last = options.solver.iterate(
            bare,
            tolerance=options.tolerance,
            max_iterations=options.max_iterations,
            start=None if start is None else device.to_device(start),
        )
        scales = problem.scales
        pressure = device.to_numpy(problem.constraint.in_unit(last.pressure, scales.pressure))
        status = _status(bare, replace(last, pressure=pressure), options, problem)
        displacement = scaled_in_double(last.displacement, scales.gap)
        approach = last.approach * scales.gap + problem.reference_height
        gap = device.to_device(problem.undeformed_gap) + displacement
        gap -= approach
    gap = device.to_numpy(gap)
    # yielded cells are in contact: their gap is not negative
    np.maximum(gap, 0.0, out=gap, where=problem.constraint.yielded(pressure))
    return Solution(
        problem=problem,
        pressure=pressure,
        displacement=device.to_numpy(displacement),
        gap=gap,
        approach=approach,
        status=status,
        iterations=last.iterations,
        convolutions=last.convolutions,
        residual=last.residual,
        note=last.note,
    )


def _relative_start(start: Array, problem: Problem, precision: Precision) -> Array:
    """Return a pressure `start` (x, y) [Pa] over ``problem.scales.pressure``, within its limits and scaled to the load.

    Raises InvalidInput for a pressure that is not finite, negative, of another shape, or that carries no load.
    """
    shape, unit = problem.undeformed_gap.shape, problem.scales.pressure
    try:
        pressure = np.asarray(start, dtype=np.float64)
    except (TypeError, ValueError):
        raise InvalidInput("solve.start is no array of numbers: give a pressure in Pa.") from None
    if pressure.shape != shape:
        raise InvalidInput(f"solve.start has the shape {pressure.shape}: give it {shape}.")
    for refused, what in ((~np.isfinite(pressure), "not finite"), (pressure < 0, "below 0 Pa")):
        if refused.any():
            raise InvalidInput(f"solve.start is {what} in {np.count_nonzero(refused)} cells: it must be at least 0 Pa.")
    with np.errstate(over="ignore", under="ignore"):
        relative = np.asarray(pressure / unit)
        carried = relative.sum()
    if problem.control.approach is None and not np.finfo(np.float64).tiny <= carried < inf:
        raise InvalidInput(
            f"solve.start is at most {readable(pressure.max(), 'Pa')}: give a pressure that carries some load, of "
            f"the order of {readable(unit, 'Pa')}."
        )
    # scaled to the load in double precision: single precision may have no number for the factor
    constraint, control = problem.constraint.scaled(1 / unit), problem.control.scaled(1 / unit)
    return constraint.scale_to_load(relative, control.total).astype(precision.real, copy=False)


def _status(bare: BareProblem, last: Iterate, options: SolveOptions, problem: Problem) -> Status:
    """Return the status of an iteration on the `bare` problem that ended in `last`, with its pressure in Pa."""
    if not np.isfinite(last.residual):
        return Status.NOT_FINITE
    if last.residual > options.tolerance:
        if bare.should_stop(last.residual, last.displacement, options.tolerance):
            return Status.PRECISION_LIMIT
        return Status.ITERATION_LIMIT if last.iterations >= options.max_iterations else Status.STALLED
    return Status.CONTACT_AT_EDGE if problem.is_cut_off(last.pressure) else Status.CONVERGED


@dataclass(frozen=True)
class ReportingSolver:
    """Solver that reports the residual of every iteration on the grid itself, not on coarser ones.

    Parameters
    ----------
    report
        Called with the residual and the pressure (x, y) in multiples of ``Problem.scales.pressure``; the array changes
        later.
    solver
        The solver that iterates.
    """

    report: Callable[[float, Array], object] = field(compare=False)
    solver: Solver = field(default_factory=PreconditionedCG)

    def iterate(
        self, problem: BareProblem, *, tolerance: float, max_iterations: int, start: Array | None = None
    ) -> Iterate:
        """Iterate as `solver` does, and report each residual."""
        reporting = replace(problem, report=self.report)
        return self.solver.iterate(reporting, tolerance=tolerance, max_iterations=max_iterations, start=start)


# Constants of lagged displacements, judged by nine contacts that slide, roll or creep, smooth and rough.
# Singular values of the changes below this fraction of the largest are noise of the solves; 1e-12 to 1e-6 take the same
# iterations.
CUT_OFF = 1e-8
# Number of displacements before the last that enter a mixed one: 4 to 16 take the same iterations, 2 up to one in seven
# more.
DEPTH = 8
# Tolerance of a solve over the change of the gap in the outer iteration before. A tenth of it takes up to 13 % more
# convolutions, ten times it 13 % fewer to 6 % more, a hundred times it up to 40 % more.
INNER_REDUCTION = 1e-3
# Largest tolerance of a solve. From 1e-6 to 1e-2 the convolutions change by a fifth either way.
FIRST_TOLERANCE = 1e-4
# Relative change of the pressure, in tolerances, at which outer iterations end. A displacement that varies more with
# the pressure than the gap does, as of rubber near its loss peak, amplifies the error of a solve up to this.
PRESSURE_CHANGE = 10.0


def fixed_point(
    state_at: Callable[[Array, Any], Any],
    first: Array,
    depth: int,
    accepts: Callable[[Any, Any], bool] = lambda last, state: True,
) -> Iterator[Any]:
    """Yield the accepted states of a fixed-point iteration that is accelerated by Anderson's (1965) mixing, without end.

    A state is what a map finds at an iterate: an object with the attributes ``iterate`` and ``image``, arrays of one
    shape. The next iterate is the combination of the last ones whose step, ``image - iterate``, is smallest, moved by
    that step. After a first state, and in place of an iterate that is rejected, it is the plain image of the last
    state, and the mixing begins anew: after one plain image at first, after twice as many with each rejected iterate.

    Parameters
    ----------
    state_at
        Function of an iterate and of the last accepted state, None at first, that returns the state at the iterate.
    first
        First iterate.
    depth
        Number of iterates before the last that enter a mixed one; 0 mixes none.
    accepts
        Function of the last accepted state and of the state at a mixed iterate: whether the iterate is accepted.
    """
    iterate, last, is_mixed = first, None, False
    plain = plain_left = 1
    iterates: list[Array] = []
    steps: list[Array] = []
    while True:
        state = state_at(iterate, last)
        if last is not None and is_mixed and not accepts(last, state):
            iterate, iterates, steps, is_mixed = last.image, [], [], False
            plain *= 2
            plain_left = plain
            continue
        yield state
        last = state
        iterates = [*iterates, state.iterate][-depth - 1 :]
        steps = [*steps, state.image - state.iterate][-depth - 1 :]
        plain_left -= 1
        is_mixed = plain_left < 0 and len(steps) > 1
        iterate = _mixed(iterates, steps) if is_mixed else state.image


def _mixed(iterates: Sequence[Array], steps: Sequence[Array]) -> Array:
    """Return the combination of the `iterates` with the smallest step, moved by that step."""
    changes = np.stack([(b - a).ravel() for a, b in pairwise(steps)], axis=1)
    moves = np.stack([(b - a).ravel() for a, b in pairwise(iterates)], axis=1)
    weights = np.linalg.lstsq(changes, steps[-1].ravel(), rcond=CUT_OFF)[0]
    return iterates[-1] + steps[-1] - ((moves + changes) @ weights).reshape(steps[-1].shape)


@dataclass(frozen=True, eq=False)
class LaggedSolution:
    """Contact with a lagged displacement: one that follows from its pressure and is added to the undeformed gap.

    Parameters
    ----------
    solution
        The last solution, with the iterations and convolutions of all; the undeformed gap of its problem includes the
        displacement.
    added
        The displacement (x, y) [m].
    change
        Change of the pressure in the last outer iteration, relative in L1.
    outer_iterations
        Number of solves.
    """

    solution: Solution
    added: Array | float = 0.0
    change: float = 0.0
    outer_iterations: int = 1

    def solution_of(self, problem: Problem) -> Solution:
        """Return the solution of a `problem` without the displacement, which counts with that of its operator."""
        note = f"{self.outer_iterations} outer iterations over the coupled displacement."
        return replace(
            self.solution,
            problem=problem,
            displacement=self.solution.displacement + self.added,
            note=f"{self.solution.note} {note}".lstrip(),
        )


class _LaggedState(NamedTuple):
    """Contact under a displacement, the `iterate` (x, y) [m], and the `image` (x, y) [m] that its pressure makes.

    `gap_change` is the change from one to the other in the contact, in units of ``problem.scales.gap``, and
    `pressure_change` that of the pressure from the contact before, relative in L1. `converged` is as
    :func:`solve_with_mixing` says.
    """

    solution: Solution
    iterate: Array
    image: Array
    gap_change: float
    pressure_change: float
    converged: bool


def solve_with_mixing(
    problem: Problem,
    displacement_of: Callable[[Array], Array] | None,
    options: SolveOptions,
    start: Array | None = None,
    device: Device | None = None,
    max_outer: int = 100,
    progress: Callable[[float, float], object] | None = None,
) -> LaggedSolution:
    """Return the solution of a problem with a displacement that follows from its own pressure, by fixed-point iteration.

    Outer iterations solve the contact with the mixed displacements under the pressures before. They end where the
    displacement under the last pressure changes the gap in the contact by at most the tolerance, in units of
    ``problem.scales.gap``, or the pressure changes by at most `PRESSURE_CHANGE` tolerances. By mixing they converge
    even where the map from one displacement to the next is no contraction. The status is
    :attr:`~contactstudy.Status.NOT_CONVERGED` where neither is reached.

    Parameters
    ----------
    problem
        The contact in SI units, without the displacement.
    displacement_of
        Map from pressure (x, y) [Pa] to the displacement (x, y) [m], called once in each outer iteration, last with the
        pressure of the solution; None for a single solve.
    options, start, device
        Method and tolerance of each solve, pressure [Pa] to begin with, and device.
    max_outer
        Largest number of outer iterations; rolling took up to 33.
    progress
        Called after each outer iteration with the change of the gap in it, and with the tolerance.
    """
    if displacement_of is None:
        return LaggedSolution(solve_contact(problem, options, start, device))

    def state_at(added: Array, last: _LaggedState | None) -> _LaggedState:
        """Return the contact with a displacement `added` to its gap, from the pressure of the `last` one on."""
        before = start if last is None else last.solution.pressure
        loose = FIRST_TOLERANCE if last is None else min(INNER_REDUCTION * last.gap_change, FIRST_TOLERANCE)
        inner = replace(options, tolerance=max(options.tolerance, loose))
        displaced = replace(problem, undeformed_gap=problem.undeformed_gap + added)
        solution = solve_contact(displaced, inner, before, device)
        pressure = solution.pressure
        if not pressure.any():
            return _LaggedState(solution, added, added, 0.0, 0.0, converged=True)
        pressure_change = inf if before is None else float(np.abs(pressure - before).sum() / pressure.sum())
        image = displacement_of(pressure)
        change = _change_in_contact(image - added, solution) / problem.scales.gap
        is_settled = change <= options.tolerance or pressure_change <= PRESSURE_CHANGE * options.tolerance
        converged = is_settled and inner.tolerance == options.tolerance
        return _LaggedState(solution, added, image, change, pressure_change, converged)

    iterations, convolutions = 0, 0.0
    for outer, state in enumerate(fixed_point(state_at, np.zeros_like(problem.undeformed_gap), DEPTH), 1):
        iterations += state.solution.iterations
        convolutions += state.solution.convolutions
        if progress is not None:
            progress(state.gap_change, options.tolerance)
        is_finite = np.isfinite(state.gap_change)
        if state.converged or outer == max_outer or not is_finite:
            break
    solution = replace(state.solution, iterations=iterations, convolutions=convolutions)
    if not state.converged:
        status = Status.NOT_CONVERGED if is_finite else Status.NOT_FINITE
        solution = replace(solution, status=status, residual=largest_of(solution.residual, state.gap_change))
    return LaggedSolution(solution, state.iterate, state.pressure_change, outer)


def _change_in_contact(change: Array, solution: Solution) -> float:
    """Return the largest `change` of the gap in the contact; under a given load, of what differs from its mean."""
    within = change[solution.pressure > 0]
    if not within.size:
        return 0.0
    if solution.problem.control.approach is None:
        within = within - within.mean()
    return float(np.abs(within).max())
