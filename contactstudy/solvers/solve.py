"""Solve a contact problem: options, checks and status; and displacements that follow from the pressure, by fixed point.

The mixing is that of Anderson (1965), in the form of Walker & Ni (2011), eq. 2.2.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from itertools import pairwise
from math import inf
from typing import Annotated, ClassVar, Literal, Protocol, runtime_checkable

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
        Largest dimensionless residual, above 0. The residual is the largest of these: the mean absolute gap in the
        active set, weighted by pressure; the largest penetration without pressure, and the largest open gap at the
        hardness, all three in units of ``Problem.scales.gap``; and the relative error of the load.
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
        Fields in SI units, and a status; a solve that did not converge returns too.

    Raises
    ------
    InvalidInput
        If the start is no pressure on the grid or carries no load, or the device cannot hold or solve the problem.
    """
    if device is None:
        device = device_in_use()
    if start is not None:
        start = _finite_pressure(start, problem)
    if problem.friction is not None:
        frictionless = replace(problem, friction=None)
        solution: Solution = problem.friction.solve(frictionless, options, start, device)
        return replace(solution, problem=problem)
    if problem.adhesion is not None:
        adhered: Solution = problem.adhesion.solve(problem, options, start, device)
        return adhered
    if not problem.control.is_met_by(problem.constraint, problem.undeformed_gap.size):
        return _without_pressure(problem)
    precision = Precision(options.precision)
    if not isinstance(device, Cpu):
        _check_arrays(checked(device, "solve.device"), problem)
    refuse_too_large(problem.grid, problem.operator.transform_size, device, precision)
    if start is not None:
        start = _admissible_start(start, problem, precision)
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


def _check_arrays(device: Device, problem: Problem) -> None:
    """Raise InvalidInput for a problem that a device other than the CPU cannot solve."""
    operator, constraint = problem.operator, problem.constraint
    if not isinstance(operator, Convolution) or type(constraint) is not Constraint:
        raise InvalidInput(
            f"solve.device is {device!r}: an operator or a constraint of your own works on numpy arrays, give Cpu()."
        )


def _finite_pressure(start: Array, problem: Problem) -> Array:
    """Return `start` as an array of pressures [Pa] on the grid of `problem`, or raise InvalidInput."""
    shape = problem.undeformed_gap.shape
    try:
        pressure = np.asarray(start, dtype=np.float64)
    except (TypeError, ValueError):
        raise InvalidInput("solve.start is no array of numbers: give a pressure in Pa.") from None
    if pressure.shape != shape:
        raise InvalidInput(f"solve.start has the shape {pressure.shape}: give it {shape}.")
    for refused, what in ((~np.isfinite(pressure), "not finite"), (pressure < 0, "below 0 Pa")):
        if refused.any():
            raise InvalidInput(f"solve.start is {what} in {np.count_nonzero(refused)} cells: it must be at least 0 Pa.")
    return pressure


def _admissible_start(pressure: Array, problem: Problem, precision: Precision) -> Array:
    """Return a `pressure` [Pa] over ``problem.scales.pressure``, clipped to its limits and scaled to the load."""
    with np.errstate(over="ignore", under="ignore"):
        relative = np.asarray(pressure / problem.scales.pressure)
        carried = relative.sum()
    if problem.control.approach is None and not np.finfo(np.float64).tiny <= carried < inf:
        raise InvalidInput(
            f"solve.start is at most {readable(pressure.max(), 'Pa')}: give a pressure that carries some load, of "
            f"the order of {readable(problem.scales.pressure, 'Pa')}."
        )
    # scaled to the load in double precision: single precision may have no number for the factor
    unit = 1 / problem.scales.pressure
    admissible = problem.constraint.scaled(unit).scale_to_load(relative, problem.control.scaled(unit).total)
    return admissible.astype(precision.real, copy=False)


def _without_pressure(problem: Problem) -> Solution:
    """Return the solution of a load that no admissible pressure carries: the bodies undeformed."""
    return replace(
        unloaded(problem),
        gap=problem.undeformed_gap.copy(),
        approach=0.0,
        status=Status.NO_ADMISSIBLE_PRESSURE,
        residual=inf,
    )


def _status(bare: BareProblem, last: Iterate, options: SolveOptions, problem: Problem) -> Status:
    """Return the status of an iteration that ended in `last`."""
    if not np.isfinite(last.residual):
        return Status.NOT_FINITE
    if last.residual > options.tolerance:
        if bare.should_stop(last.residual, last.displacement, options.tolerance):
            return Status.PRECISION_LIMIT
        return Status.ITERATION_LIMIT if last.iterations >= options.max_iterations else Status.STALLED
    return Status.CONTACT_AT_EDGE if problem.is_cut_off(last.pressure) else Status.CONVERGED


# Takes the residual and the pressure (x, y), both dimensionless.
Report = Callable[[float, Array], object]


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

    report: Report = field(compare=False)
    solver: Solver = field(default_factory=PreconditionedCG)

    def iterate(
        self, problem: BareProblem, *, tolerance: float, max_iterations: int, start: Array | None = None
    ) -> Iterate:
        """Iterate as `solver` does, and report each residual."""

        def report(residual: float, pressure: Array) -> None:
            self.report(residual, device_in_use().to_numpy(pressure))

        reporting = replace(problem, report=report)
        return self.solver.iterate(reporting, tolerance=tolerance, max_iterations=max_iterations, start=start)


# Singular values of the changes below this fraction of the largest are noise of the solves.
CUT_OFF = 1e-8
# Number of displacements before the last that enter a mixed one.
DEPTH = 8
# Tolerance of a solve over the change in the outer iteration before; a tenth of it saves no outer iteration.
INNER_REDUCTION = 1e-3
# Largest tolerance of a solve.
FIRST_TOLERANCE = 1e-4
# Relative change of the pressure in tolerances at which outer iterations end: a displacement that varies more with the
# pressure than the gap does, as of rubber near its loss peak, turns the tolerance of a solve into so much.
PRESSURE_CHANGE = 10.0


class AndersonMixing:
    """Mixing of the last iterates of a fixed-point iteration, by Anderson (1965).

    Parameters
    ----------
    depth
        Number of iterates before the last that enter a mixed iterate.
    """

    def __init__(self, depth: int) -> None:
        self._depth = depth
        self.restart()

    def restart(self) -> None:
        """Forget all iterates."""
        self._iterates: list[Array] = []
        self._steps: list[Array] = []

    def record(self, iterate: Array, step: Array) -> None:
        """Record an `iterate` and the `step` that the fixed-point map adds to it."""
        self._iterates = [*self._iterates, iterate][-self._depth - 1 :]
        self._steps = [*self._steps, step][-self._depth - 1 :]

    @property
    def mixes(self) -> bool:
        """True if there are several iterates, so that the mixed iterate differs from the plain next one."""
        return len(self._steps) > 1

    def mixed_iterate(self) -> Array:
        """Return the combination of the iterates with the smallest step, moved by that step."""
        iterate, step = self._iterates[-1], self._steps[-1]
        if not self.mixes:
            return iterate + step
        changes = np.stack([(b - a).ravel() for a, b in pairwise(self._steps)], axis=1)
        moves = np.stack([(b - a).ravel() for a, b in pairwise(self._iterates)], axis=1)
        weights = np.linalg.lstsq(changes, step.ravel(), rcond=CUT_OFF)[0]
        return iterate + step - ((moves + changes) @ weights).reshape(step.shape)


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

    def of(self, problem: Problem) -> Solution:
        """Return the solution of a `problem` without the displacement, which counts with that of its operator."""
        note = f"{self.outer_iterations} outer iterations over the coupled displacement."
        return replace(
            self.solution,
            problem=problem,
            displacement=self.solution.displacement + self.added,
            note=f"{self.solution.note} {note}".lstrip(),
        )


def solve_with_mixing(
    problem: Problem,
    displacement_of: Callable[[Array], Array] | None,
    options: SolveOptions,
    start: Array | None = None,
    device: Device | None = None,
    max_outer: int = 100,
    progress: Callable[[float, float], object] | None = None,
) -> LaggedSolution:
    """Return the solution of a problem with a displacement that follows from its own pressure, by Anderson's mixing.

    Each outer iteration solves the contact with the mixed displacements under the pressures before, until the one under
    the last pressure changes the gap in the contact by at most the tolerance, in units of ``problem.scales.gap``, or the
    pressure changes by at most `PRESSURE_CHANGE` tolerances. It also converges where the map from one displacement to
    the next is no contraction. The status is :attr:`~contactstudy.Status.NOT_CONVERGED` where neither is reached.

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
        Largest number of outer iterations.
    progress
        Called after each outer iteration with the change of the gap in it, and with the tolerance.
    """
    mixing, added = AndersonMixing(DEPTH), np.zeros_like(problem.undeformed_gap)
    change, change_of_pressure, outer, iterations, convolutions = inf, inf, 0, 0, 0.0
    while True:
        loose = 0.0 if displacement_of is None else min(INNER_REDUCTION * change, FIRST_TOLERANCE)
        inner = replace(options, tolerance=max(options.tolerance, loose))
        displaced = replace(problem, undeformed_gap=problem.undeformed_gap + added) if outer else problem
        solution = solve_contact(displaced, inner, start, device)
        outer += 1
        iterations += solution.iterations
        convolutions += solution.convolutions
        solution = replace(solution, iterations=iterations, convolutions=convolutions)
        if displacement_of is None or not solution.pressure.any():
            return LaggedSolution(solution)
        if start is not None:
            change_of_pressure = float(np.abs(solution.pressure - start).sum() / solution.pressure.sum())
        start = solution.pressure
        following = displacement_of(start)
        change = _change_in_contact(following - added, solution) / problem.scales.gap
        if progress is not None:
            progress(change, options.tolerance)
        is_settled = change <= options.tolerance or change_of_pressure <= PRESSURE_CHANGE * options.tolerance
        converged = is_settled and inner.tolerance == options.tolerance
        if converged or outer == max_outer or not np.isfinite(change):
            break
        mixing.record(added, following - added)
        added = mixing.mixed_iterate()
    if not converged:
        status = Status.NOT_CONVERGED if np.isfinite(change) else Status.NOT_FINITE
        solution = replace(solution, status=status, residual=largest_of(solution.residual, change))
    return LaggedSolution(solution, added, change_of_pressure, outer)


def _change_in_contact(change: Array, solution: Solution) -> float:
    """Return the largest `change` of the gap in the contact; under a given load, of what differs from its mean."""
    within = change[solution.pressure > 0]
    if not within.size:
        return 0.0
    if solution.problem.control.approach is None:
        within = within - within.mean()
    return float(np.abs(within).max())
