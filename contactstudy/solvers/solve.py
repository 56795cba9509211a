"""Solve a contact problem: its options, its checks, and the solution with its status."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from math import inf
from typing import Annotated, ClassVar, Literal, Protocol, runtime_checkable

import numpy as np

from contactstudy.domain.checks import InvalidInput
from contactstudy.domain.device import Cpu, Device, Precision, checked, using
from contactstudy.domain.device import device as device_in_use
from contactstudy.domain.fields import Array
from contactstudy.domain.units import Number, readable
from contactstudy.domain.validation import ABOVE_ZERO, Example, at_least, validated
from contactstudy.elasticity.convolution import Convolution
from contactstudy.problem.bare_problem import BareProblem
from contactstudy.problem.constraint import Compressive, HardnessLimited, scaled_in_double, yielded
from contactstudy.problem.memory import refuse_on, refuse_solve
from contactstudy.problem.problem import Problem
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
    if isinstance(device, Cpu):
        refuse_solve(problem, precision)
    else:
        _refuse_other_device(checked(device, "solve.device"), problem, precision)
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
    if not isinstance(problem.constraint, Compressive):  # yielded cells are in contact: their gap is not negative
        np.maximum(gap, 0.0, out=gap, where=yielded(problem.constraint, pressure))
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


def _refuse_other_device(device: Device, problem: Problem, precision: Precision) -> None:
    """Raise InvalidInput for a problem that a device other than the CPU cannot solve."""
    operator, constraint = problem.operator, problem.constraint
    if not isinstance(operator, Convolution) or not isinstance(constraint, Compressive | HardnessLimited):
        raise InvalidInput(
            f"solve.device is {device!r}: an operator or a constraint of your own works on numpy arrays, give Cpu()."
        )
    refuse_on(device, operator, precision)


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
    admissible = problem.control.scaled(unit).clip_and_scale(relative, problem.constraint.scaled(unit))
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
