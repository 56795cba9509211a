"""Steps of a dry scene in time, with their errors and those by the grid, and the frames recorded of them."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import exp, inf
from typing import Any

import numpy as np

from contactstudy.accuracy.error_terms import residual_errors
from contactstudy.accuracy.estimate import error_estimate
from contactstudy.accuracy.hidden_heights import HiddenHeights
from contactstudy.domain.checks import NotDefined
from contactstudy.domain.errors import ErrorParts
from contactstudy.evolution.integration.time_stepper import Instant, TimeStepper
from contactstudy.evolution.march import Method, Record
from contactstudy.evolution.time_steps import ErrorEstimator
from contactstudy.evolution.trajectory import UNKNOWN, Frame, error_of_peak, frame_of
from contactstudy.solvers.solution import Solution, Status, unloaded, worst_until

# Halving the steps leaves 0.5 to 0.6 of errors of first order: the error is up to 1.5 times the difference.
FIRST_ORDER_FACTOR = 1.5
# Errors of wear are of order 1/2 where it begins, since the pressure changes at once: halving the steps leaves 2^-1/2 of
# them, and a difference is 2^1/2 - 1 of the error. Of creep within a step, errors were up to 2.34 differences.
HALF_ORDER_FACTOR = 1 / (2**0.5 - 1)
# Largest factor by which the error of a traction falls in a doubled step: at most 3.4 in fretting of creeping bodies.
LARGEST_FALL = 4.0
# Errors inside a doubled step over those at its end where creep is over within a step: they fall with its length.
INSIDE_STIFF_STEP = 2.0
# Load increments of a jump in doubled steps at first, where bodies yield.
INCREMENTS = 4
# Largest number of halvings of a step in which bodies start to yield, where doubled steps tell the error.
MAX_HALVINGS = 6
# Time-discretisation errors: in L1 of the pressure and of the states, and of the peak pressure.
NAMES_OF_ERRORS = "pressure", "states", "peak_pressure"
# Discretisation error at the end of an integration over that of the last contact alone: with each state variable, which
# depends on earlier pressures, and with plastic strain, whose cells below the surface add to it. Bounds by the cells
# held in 238 of 238 frames with creep, wear or both, and were 3 to 4 times too large in the median; with plastic strain
# the ratios were up to 3.6.
GROWTH_PER_STATE_VARIABLE, GROWTH_PLASTIC = 1.2, 4.0


@dataclass(eq=False)
class Errors:
    """Errors of a march until now.

    Attributes
    ----------
    by_steps, inside
        Relative time-discretisation errors by the names of `NAMES_OF_ERRORS`, after the last doubled step and in its
        middle.
    step
        Duration [s] of its two short steps.
    largest_by_cells
        Largest error by the cells of a recorded contact, summed over the cells [Pa].
    largest_by_residual
        The same by the residual, of contacts that stopped before the tolerance; at the rounding of the precision only of
        those recorded, as it is the same in all.
    after_stiff_step
        Time [s] after the last step longer than a retardation time, and errors of the pressure then: summed over the
        cells, and the largest of any [Pa]. They decay at least as fast as creep in the longest retardation time; the
        difference of two integrations may vanish on the way.
    after_step
        Error of the states after the last doubled step, in the unit of their size.
    """

    by_steps: Mapping[str, float] = field(default_factory=lambda: dict.fromkeys(NAMES_OF_ERRORS, 0.0))
    inside: Mapping[str, float] = field(default_factory=lambda: dict.fromkeys(NAMES_OF_ERRORS, 0.0))
    step: float = 0.0
    largest_by_cells: float = 0.0
    largest_by_residual: float = 0.0
    after_stiff_step: tuple[float, float, float] = (0.0, 0.0, 0.0)
    after_step: float = 0.0


@dataclass(eq=False)
class DrySteps(Method[Instant]):
    """Steps of a dry scene; errors are relative to the pressure, or where bodies yield to that under the largest load.

    Attributes
    ----------
    stepper
        Takes one step.
    estimator
        How the time-discretisation error is estimated.
    """

    stepper: TimeStepper
    estimator: ErrorEstimator
    errors: "Errors" = field(init=False)

    def __post_init__(self) -> None:
        self.increments = 0 if self.stepper.coupled is None else INCREMENTS

    def begin(self, start: Instant) -> tuple[Instant, Instant | None]:
        """Return the instant before the first load for short steps, which are halved, and for doubled ones, if any."""
        self.errors = Errors()
        if self.estimator == "none":
            return start, None
        return replace(start, max_halvings=MAX_HALVINGS), start

    def step(self, state: Instant, end: float) -> Instant:
        """Return the contact after a step to the time `end` [s], before any jump of the load there."""
        return self.stepper.step(state, end)

    def jump(self, state: Instant, increments: int) -> Instant:
        """Return the contact after the jump of the load at its time in so many increments."""
        return self.stepper.jump(state, increments)

    def error(self, before: tuple[Instant, Instant], middle: Instant, after: tuple[Instant, Instant]) -> float:
        """Return by how much a pair of steps raises the time-discretisation error."""
        if after[0].change == inf:
            return inf
        change = (after[0].pressure - after[1].pressure) - (before[0].pressure - before[1].pressure)
        of_states = self._of_states(*after) - self._of_states(*before)
        step = (after[0].time - before[0].time) / 2
        total = self._error_over_difference(step) * float(np.abs(change).sum())
        return max(self._relative(total, after[0], before[0]), of_states)

    def accept(self, before: Instant, middle: Instant, after: tuple[Instant, Instant | None]) -> float:
        """Keep the errors of a pair of steps or a jump, and return the largest error in L1."""
        (fine, coarse), errors = after, self.errors
        for instant in {id(each): each for each in (middle, fine, coarse) if each}.values():
            self._keep(instant.kept)
        if coarse is None:
            return 0.0
        if fine.time > before.time:
            errors.step = (fine.time - before.time) / 2
        earlier, errors.by_steps = errors.by_steps, self._by_steps(fine, coarse, errors.step)
        # what is recorded in the middle lies between two instants of the doubled step
        factor = INSIDE_STIFF_STEP if self.stepper.creep_ends_within(errors.step) else 1.0
        inside = {name: max(earlier[name], factor * of) for name, of in errors.by_steps.items()}
        size, at_begin, at_end = map(self._size_of_states, (middle, before, fine))
        of_states = max(earlier["states"] * at_begin, factor * errors.by_steps["states"] * at_end)
        errors.inside = inside | {"states": of_states / size if size else 0.0}
        return max(errors.by_steps["pressure"], errors.by_steps["states"])

    def frame(self, record: Record[Instant], *, has_failed: bool) -> Frame:
        """Return what is recorded as a frame; its errors are infinite if the march ends without a solution."""
        instant, stepper = record.state, self.stepper
        solution = instant.kept[-1] if instant.kept else unloaded(stepper.problem)
        by_steps = self.errors.by_steps if record.coarse is not None else self.errors.inside
        if has_failed or (self.estimator == "none" and stepper.all_state_variables):
            by_steps = dict.fromkeys(NAMES_OF_ERRORS, inf)
        # what two integrations have in common: errors of the traction of fretting, and of a pressure that its slip wears
        fretting = stepper.fretting
        common = 0.0 if fretting is None else fretting.common_error(instant.states[-1])
        of_pressure = common if fretting is not None and fretting.wear else 0.0
        l1 = max(by_steps["pressure"] + of_pressure, by_steps["states"] + common)
        total = {"peak_pressure": by_steps["peak_pressure"] + of_pressure, "l1": l1}
        shown = {
            name: of
            for variable, state in zip(stepper.all_state_variables, instant.states, strict=True)
            for name, of in variable.fields(state).items()
        }
        problem, displacement = solution.problem, solution.displacement
        grid_errors: tuple[Any, ...] = (None, UNKNOWN, ())
        if stepper.all_state_variables or has_failed or not solution.pressure.any():
            problem = stepper.problem
            displacement = solution.gap + solution.approach - problem.undeformed_gap
            grid_errors = self._of_grid(solution)
        parts, peak_parts, warnings = grid_errors
        work: Any = {name: record.work[name] for name in ("solves", "iterations", "convolutions")}
        return frame_of(
            solution,
            time=instant.time,
            load=instant.load,
            problem=problem,
            displacement=displacement,
            traction=stepper.traction(instant),
            fields=shown,
            coupled_state={} if stepper.coupled is None else instant.states[-1],
            status=worst_until(solution.status, record.statuses),
            errors_by_steps=total,
            grid_error_parts=parts,
            peak_grid_error_parts=peak_parts,
            warnings=warnings,
            adhesion=instant.adhesion,
            **work,
        )

    def _by_steps(self, fine: Instant, coarse: Instant, step: float) -> dict[str, float]:
        """Return errors of `fine` by steps, in L1 of the pressure and of the states, and of the peak pressure.

        Those of bodies which are apart in `fine` alone are relative to the
        pressure of `coarse`. The last `step` of `fine` has that duration [s].
        """
        instant = fine if fine.pressure.any() else coarse
        time, *earlier = self.errors.after_stiff_step
        decay = exp(min(time - fine.time, 0.0) / self.stepper.longest_retardation_time)
        sizes = np.abs(fine.pressure - coarse.pressure) * self._error_over_difference(step)
        of_both = float(sizes.sum()), error_of_peak(fine.pressure, sizes)
        total, largest = (max(size, decay * error) for size, error in zip(of_both, earlier, strict=True))
        if self.stepper.creep_ends_within(step):
            self.errors.after_stiff_step = fine.time, total, largest
        peak, size = float(instant.pressure.max()), self._size_of_states(fine)
        # the difference of two integrations may vanish where the force turns, and their error does not
        of_states = max(self._of_states(fine, coarse), self.errors.after_step / LARGEST_FALL / size if size else 0.0)
        self.errors.after_step = of_states * size
        return {
            "pressure": self._relative(total, instant),
            "states": of_states,
            "peak_pressure": largest / peak if peak else 0.0,
        }

    def _size_of_states(self, instant: Instant) -> float:
        """Return the L1 norm that errors of states are relative to; 0 if none has an estimate of its own."""
        fretting = self.stepper.fretting
        return 0.0 if fretting is None else fretting.size(instant.states[-1])

    def _of_states(self, fine: Instant, coarse: Instant) -> float:
        """Return the largest error of the state variables that have an estimate of their own; 0 if none has."""
        fretting = self.stepper.fretting
        return 0.0 if fretting is None else fretting.time_discretisation_error(fine.states[-1], coarse.states[-1])

    def _relative(self, norm: float, *instants: Instant) -> float:
        """Return an error summed over the cells [Pa], relative to the largest L1 norm of the pressures of `instants`.

        Beside a coupled state variable it is relative to the pressure under the largest load.
        """
        if self.stepper.coupled is not None:
            return self._relative_to_largest_load(norm)
        total = max(float(instant.pressure.sum()) for instant in instants)
        return norm / total if total else 0.0

    def _error_over_difference(self, step: float) -> float:
        """Return the largest error over the difference of two integrations, after a `step` [s].

        It is 1.5 where bodies yield, 2.41 where they wear, fret, or creep within a step, else 1.
        """
        if self.stepper.coupled is not None:
            return FIRST_ORDER_FACTOR
        return HALF_ORDER_FACTOR if self.stepper.is_half_order(step) else 1.0

    def _keep(self, contacts: Iterable[Solution]) -> None:
        """Keep the errors of contacts that stopped before the tolerance, on whose pressure later states depend."""
        for contact in contacts if self.stepper.all_state_variables else ():
            stopped = contact.status is not Status.PRECISION_LIMIT
            if stopped and not contact.status.has_converged and contact.pressure.any():
                total = residual_errors(contact).l1 * float(contact.pressure.sum())
                self.errors.largest_by_residual = max(self.errors.largest_by_residual, total)

    @cached_property
    def _heights(self) -> HiddenHeights | None:
        """Heights inside the cells, which all instants share."""
        return HiddenHeights.from_problem(self.stepper.problem)

    def _of_grid(self, solution: Solution) -> tuple[ErrorParts, ErrorParts, tuple[str, ...]]:
        """Return errors of a contact on this grid by cause: in L1, of its peak pressure, and why any is infinite."""
        pressure = solution.pressure
        if not np.isfinite(solution.residual):
            return UNKNOWN, UNKNOWN, (f"No bound: {solution.status}",)
        if not pressure.any():
            return ErrorParts(0.0, 0.0, 0.0), ErrorParts(0.0, 0.0, 0.0), ()
        try:
            estimate = error_estimate(solution, heights=self._heights)
        except NotDefined as reason:
            return UNKNOWN, UNKNOWN, (f"No bound: {reason}",)
        total = float(pressure.sum())
        # creep and wear keep the errors of earlier pressures, so that they enter later frames
        cells, residual = (estimate.l1.by_cause[cause] for cause in ("discretisation", "residual"))
        self.errors.largest_by_cells = max(self.errors.largest_by_cells, cells * total)
        if not solution.status.has_converged:
            self.errors.largest_by_residual = max(self.errors.largest_by_residual, residual * total)
        if self.stepper.all_state_variables:
            residual = max(residual, self.errors.largest_by_residual / total)
        if self.stepper.coupled is not None:
            cells *= GROWTH_PLASTIC
        elif self.stepper.state_variables:
            growth = GROWTH_PER_STATE_VARIABLE ** len(self.stepper.state_variables)
            cells = growth * self.errors.largest_by_cells / total
        factor = 1.0 if self.stepper.coupled is None else self._relative_to_largest_load(total)
        parts = ErrorParts(estimate.l1.images, cells, residual, range=estimate.l1.range)
        assert estimate.peak_pressure is not None
        return parts.scaled(factor), estimate.peak_pressure, estimate.warnings

    def _relative_to_largest_load(self, pressures: float) -> float:
        """Return a sum of cell pressures [Pa] divided by the sum under the largest load."""
        largest = self.stepper.load.largest * self.stepper.loaded_length
        return pressures * self.stepper.problem.grid.cell_area / largest
