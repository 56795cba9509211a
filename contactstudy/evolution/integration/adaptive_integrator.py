"""Adaptive integration in time by step doubling, with frames, errors and checkpoints."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import Enum
from functools import cached_property
from math import inf
from typing import Any

import numpy as np

from contactstudy.accuracy.discretisation.subcell import SubgridHeights
from contactstudy.accuracy.estimate import error_estimate
from contactstudy.domain.checks import NotDefined
from contactstudy.domain.errors import ErrorParts
from contactstudy.domain.fields import Array
from contactstudy.evolution.breakpoints import Breakpoint
from contactstudy.evolution.integration.checkpoint import Checkpoint
from contactstudy.evolution.integration.step_control import INITIAL_STEP, StepControl
from contactstudy.evolution.integration.time_stepper import Instant, TimeStepper
from contactstudy.evolution.states.state_variables import HasStepError
from contactstudy.evolution.trajectory import Frame
from contactstudy.evolution.warm_started import unloaded
from contactstudy.solvers.solution import Solution, Status, worst

# A pair of steps shorter than this, over the duration of the integration, is never rejected.
SHORTEST = 1e-12
# Load increments of a jump where a state depends on the path of the load: at first in the doubled step, of which the
# short steps have two each, and at most in the short steps.
INCREMENTS, MAX_INCREMENTS = 4, 2**12
# Largest number of halvings of a step in which bodies start to yield.
MAX_HALVINGS = 6
# Halving the steps leaves 0.5 to 0.6 of errors of first order: the error is up to 1.5 times the difference.
FIRST_ORDER_FACTOR = 1.5
# Errors of wear are of order 1/2 where it begins, since the pressure changes at once: halving the steps leaves 2^-1/2 of
# them, and a difference is 2^1/2 - 1 of the error.
HALF_ORDER_FACTOR = 1 / (2**0.5 - 1)
# Discretisation error at the end of an integration over that of the last contact alone: with each state variable, which
# depends on earlier pressures, and with plastic strain, whose cells below the surface add to it. Bounds by the cells
# held in 238 of 238 frames with creep, wear or both, and were 3 to 4 times too large in the median; with plastic strain
# the ratios were up to 3.6.
GROWTH_PER_STATE_VARIABLE, GROWTH_PLASTIC = 1.2, 4.0
# State of an integrator in its checkpoint.
CHECKPOINTED = ("breakpoint", "step_error", "largest_grid_error", "double_step", "rejected", "restarts", "solves",
                "iterations", "convolutions")  # fmt: skip


class _Outcome(Enum):
    """Outcome of the integration to a point."""

    REACHED = "the integration is there"
    RESTART = "the error grew too large: the integration starts again with shorter steps"
    NO_SOLUTION = "a step has no solution to go on from"


@dataclass(eq=False)
class AdaptiveIntegrator:
    """Integration of a scene in time by pairs of steps, each checked by one step of twice the length (step doubling).

    The two integrations run beside each other: a doubled step goes on from the doubled one before. Their difference
    estimates the error; a pair that adds too much is rejected, and the next one is as long as the estimate allows.
    Source: Hairer, Norsett & Wanner (1993), sect. II.4, eqs. 4.4 and 4.13, there with the error of one pair alone.

    Attributes
    ----------
    stepper
        Steps of the scene.
    breakpoints
        Instants at which steps end, in order.
    control
        Control of the step length; None steps from one breakpoint to the next.
    step_doubling
        Whether a second integration with steps twice as long estimates the time-discretisation error.
    records_all
        Whether every pair of steps is recorded, and the contact after each jump of the load; a scene without a state
        variable takes no pairs of steps.
    checkpoint
        Folder that frames and states are written to; None writes none.
    progress
        Called with the time since the start and that of the whole [s]; None calls nothing.
    """

    stepper: TimeStepper
    breakpoints: tuple[Breakpoint, ...]
    control: StepControl | None
    step_doubling: bool
    records_all: bool
    checkpoint: Checkpoint | None
    progress: Callable[[float, float], None] | None

    def __post_init__(self) -> None:
        self.frames: list[Frame] = []

        # frames whose time-discretisation error is known once the doubled step reaches their time
        self.waiting: list[Frame] = []
        self.rejected = self.restarts = 0
        self._reset_counts()
        self._begin()

    def _begin(self) -> None:
        """Return to the first breakpoint, with a short pair of steps."""
        self.breakpoint = 0
        self.fine = self.coarse = self.stepper.start(self.breakpoints[0].time)
        self.solution: Solution | None = None
        self.step_error = self.largest_grid_error = 0.0
        duration = self.breakpoints[-1].time - self.breakpoints[0].time
        self.double_step, self.shortest = INITIAL_STEP * duration, SHORTEST * duration

    def _reset_counts(self) -> None:
        """Reset the counts of work since the last frame."""
        self.solves, self.iterations, self.convolutions = 0, 0, 0.0
        self.statuses: list[Status] = []

    def integrate(self) -> None:
        """Integrate to the last breakpoint, or to a step that has no solution."""
        while self.breakpoint < len(self.breakpoints):
            point = self.breakpoints[self.breakpoint]
            if self.fine.time < point.time:
                outcome = self._integrate_to(point)
                if outcome is _Outcome.NO_SOLUTION:
                    return
                if outcome is _Outcome.RESTART:
                    continue
            if point.times_recorded == 2:
                self._record()
            if point.jumps and not self._jump(point.after):
                return
            if point.times_recorded or (self.records_all and point.jumps):
                self._record()
            self.breakpoint += 1
            self._save()

    def _integrate_to(self, point: Breakpoint) -> _Outcome:
        """Integrate to `point`, which is later than the present time."""
        if self.control is None or not self.stepper.all_state_variables:
            return self._one_step(point)
        return self._step_adaptively(point)

    def _one_step(self, point: Breakpoint) -> _Outcome:
        """Integrate to `point` in one step; every second one is checked by one step of twice the length.

        A step that ends a doubled step alone is halved, so that the doubled step has two to be compared with.
        """
        synchronised = self.coarse.time == self.fine.time
        after = self.breakpoints[self.breakpoint + 1] if point is not self.breakpoints[-1] else None
        # without load both integrations have the same pressure: end the doubled step there
        ends_double_step = (
            point.is_discontinuity
            or after is None
            or point.times_recorded == 2
            or after.before == 0
        )
        if self.step_doubling and synchronised and ends_double_step:
            half = (self.fine.time + point.time) / 2
            self.fine, _ = self._advance(self.fine, half, self.stepper.load.at(half), MAX_HALVINGS)
        max_halvings = MAX_HALVINGS if self.step_doubling else 0
        self.fine, self.solution = self._advance(self.fine, point.time, point.before, max_halvings)
        if not np.isfinite(self.solution.residual):
            self._record_failure(self.solution)
            return _Outcome.NO_SOLUTION
        if self.step_doubling and (ends_double_step or not synchronised):
            self.coarse, _ = self._advance(self.coarse, point.time, point.before)
            before, self.step_error = self.step_error, self._difference(self.fine, self.coarse)
            # the frames that wait lie between two instants of the doubled step
            self._finish_frames(max(before, self.step_error))
        elif not self.step_doubling:
            self.coarse = self.fine
        return _Outcome.REACHED

    def _step_adaptively(self, point: Breakpoint) -> _Outcome:
        """Integrate to `point` by pairs of steps, each checked by one step of twice the length."""
        control = self.control
        assert control is not None
        while self.fine.time < point.time:
            remaining = point.time - self.fine.time
            double_step = (
                remaining
                if self.double_step >= remaining * (1 - 1e-9)
                else min(self.double_step, remaining / 2)
            )
            reaches_point = double_step == remaining
            end = point.time if reaches_point else self.fine.time + double_step
            load = point.before if reaches_point else self.stepper.load.at(end)
            half = self.fine.time + double_step / 2
            accepted = len(self.statuses)
            first, _ = self._advance(self.fine, half, self.stepper.load.at(half), MAX_HALVINGS)
            second, solution = self._advance(first, end, load, MAX_HALVINGS)
            coarse, _ = self._advance(self.coarse, end, load)
            if not np.isfinite(solution.residual):
                self._record_failure(solution)
                return _Outcome.NO_SOLUTION
            error_increment = self._error_increment(second, coarse)
            if not control.accepts(error_increment) and double_step > self.shortest:
                self._reject(accepted)
                self.double_step = double_step * min(control.factor(error_increment), 0.5)
                continue
            self.fine, self.coarse, self.solution = second, coarse, solution
            self.step_error = self._difference(second, coarse)
            if self.step_error > control.error:
                self._restart(control.stricter(self.step_error))
                return _Outcome.RESTART
            # a pair cut short by a breakpoint is no measure of the allowed length
            self.double_step = max(
                double_step * control.factor(error_increment),
                self.double_step if reaches_point else 0.0,
            )
            if self.records_all:
                self._record()
            else:
                self._report()
            # at the point itself the solution is still to be recorded, and a checkpoint does not hold it
            if not reaches_point:
                self._save()
        return _Outcome.REACHED

    def _reject(self, accepted: int) -> None:
        """Count steps as rejected; of their statuses, none beyond the first `accepted` ones enters a frame."""
        self.rejected += 1
        del self.statuses[accepted:]

    def _error_increment(self, fine: Instant, coarse: Instant) -> float:
        """Return by how much a pair of steps raises the estimated relative L1 error."""
        before, after = self.fine.pressure - self.coarse.pressure, fine.pressure - coarse.pressure
        grown = self._state_error(fine, coarse) - self._state_error(self.fine, self.coarse)
        return max(self._relative(after - before, fine, self.fine), grown)

    def _restart(self, control: StepControl) -> None:
        """Start the integration again with shorter steps; the work done so far counts in the first frame."""
        for frame in (*self.frames, *self.waiting):
            self.solves += frame.solves
            self.iterations += frame.iterations
            self.convolutions += frame.convolutions
        self.control, self.frames, self.waiting, self.statuses = control, [], [], []
        self.restarts += 1
        self._begin()

    def _jump(self, load: float) -> bool:
        """Change the load of both integrations at once; return False if there is no solution to go on from.

        Where a state depends on the path of the load, the jump is applied in as many increments as the allowed error
        requires, twice as many as in the doubled steps.
        """
        increments = 1 if self.stepper.coupled is None else 2 * INCREMENTS
        max_halvings = MAX_HALVINGS if self.step_doubling else 0
        accepted = len(self.statuses)
        while True:
            fine, solution = self._add_work(
                *self.stepper.jump(self.fine, load, increments, max_halvings)
            )
            if not np.isfinite(solution.residual):
                self._record_failure(solution)
                return False
            if not self.step_doubling:
                self.fine = self.coarse = fine
                break
            coarse, _ = self._add_work(
                *self.stepper.jump(self.coarse, load, max(increments // 2, 1), 0)
            )
            error_increment = self._error_increment(fine, coarse)
            exact = self.control is None or self.control.accepts(error_increment)
            if self.stepper.coupled is None or exact or increments >= MAX_INCREMENTS:
                self.fine, self.coarse = fine, coarse
                self.step_error = self._difference(fine, coarse)
                break
            self._reject(accepted)
            increments *= 2
        self.solution = solution
        return True

    def _advance(
        self, instant: Instant, end: float, load: float, max_halvings: int = 0
    ) -> tuple[Instant, Solution]:
        """Advance one integration to the time `end` [s] and the load `load` [N/m], and count the work."""
        return self._add_work(*self.stepper.advance(instant, end, load, max_halvings))

    def _add_work(self, after: Instant, solutions: list[Solution]) -> tuple[Instant, Solution]:
        """Count the work of `solutions`, and return the instant after them with the last of them."""
        for solution in solutions:
            self.solves += 1
            self.iterations += solution.iterations
            self.convolutions += solution.convolutions
            self.statuses.append(solution.status)
        return after, solutions[-1]

    def _record_failure(self, solution: Solution) -> None:
        """Record the frame at which the integration has to stop, with an infinite error."""
        self.solution, self.step_error = solution, inf
        self._record()
        self._finish_frames()

    def _difference(self, fine: Instant, coarse: Instant) -> float:
        """Return the time-discretisation error of `fine`, of the pressure or of the states: the larger one."""
        pressure = self._relative(fine.pressure - coarse.pressure, fine)
        return max(pressure, self._state_error(fine, coarse))

    def _state_error(self, fine: Instant, coarse: Instant) -> float:
        """Return the largest error of the state variables that have an estimate of their own; 0 if none has."""
        variables = zip(self.stepper.all_state_variables, fine.states, coarse.states, strict=True)
        return max(
            (
                variable.step_error(fine, coarse)
                for variable, fine, coarse in variables
                if isinstance(variable, HasStepError)
            ),
            default=0.0,
        )

    def _common_error(self) -> float:
        """Return the time-discretisation error common to both integrations; infinite without a second integration."""
        variables = self.stepper.all_state_variables
        if variables and not self.step_doubling:
            return inf
        states = zip(variables, self.fine.states, strict=True)
        common = (v.common_error(state) for v, state in states if isinstance(v, HasStepError))
        return max(common, default=0.0)

    def _relative(self, difference: Array, *instants: Instant) -> float:
        """Return the L1 norm of a pressure difference over the largest L1 norm of the pressures of `instants`.

        It is multiplied by what the error is of the difference of two integrations, at most: 2.41 where the order may
        be 1/2, 1.5 beside a coupled state variable, whose steps are of first order. There it is relative to the
        pressure under the largest load.
        """
        norm = float(np.abs(difference).sum())
        if self.stepper.coupled is not None:
            return FIRST_ORDER_FACTOR * self._relative_to_largest_load(norm)
        if self.stepper.is_first_order:
            norm *= HALF_ORDER_FACTOR
        total = max(float(instant.pressure.sum()) for instant in instants)
        return norm / total if total else 0.0

    @cached_property
    def _heights(self) -> SubgridHeights | None:
        """Heights inside the cells, which all instants share."""
        return SubgridHeights.from_problem(self.stepper.problem)

    def _grid_errors(self, solution: Solution) -> tuple[ErrorParts, float, tuple[str, ...]]:
        """Return errors of a contact on this grid: in L1 by cause, of the peak by the cells, and why any is infinite.

        The first is relative to the same pressure as the time-discretisation error.
        """
        pressure = solution.pressure
        if not np.isfinite(solution.residual):
            return ErrorParts(0.0, inf, 0.0), inf, (f"No bound: {solution.status}",)
        if not pressure.any():
            return ErrorParts(0.0, 0.0, 0.0), 0.0, ()
        try:
            estimate = error_estimate(solution, heights=self._heights)
        except NotDefined as reason:
            return ErrorParts(0.0, inf, 0.0), inf, (f"No bound: {reason}",)
        total = float(pressure.sum())
        # creep and wear keep the errors of earlier pressures, so that they enter later frames
        cells = estimate.l1.by_cause["discretisation"]
        self.largest_grid_error = max(self.largest_grid_error, cells * total)
        if self.stepper.coupled is not None:
            cells *= GROWTH_PLASTIC
        elif self.stepper.state_variables:
            cells = (
                GROWTH_PER_STATE_VARIABLE ** len(self.stepper.state_variables)
                * self.largest_grid_error
                / total
            )
        factor = 1.0 if self.stepper.coupled is None else self._relative_to_largest_load(total)
        parts = ErrorParts(estimate.l1.images, cells, estimate.l1.residual)
        assert estimate.peak_pressure is not None
        peak = estimate.peak_pressure.by_cause["discretisation"]
        return parts.scaled(factor), peak, estimate.warnings

    def _relative_to_largest_load(self, pressures: float) -> float:
        """Return a sum of cell pressures [Pa] divided by the sum under the largest load."""
        grid = self.stepper.problem.grid
        return pressures * grid.cell_area / grid.length / self.stepper.load.largest

    def _record(self) -> None:
        """Append a frame of the present contact to those that wait for their error."""
        solution = self.solution
        if solution is None:  # before the first load
            solution = unloaded(self.stepper.problem)
        shown = {
            name: field
            for state_variable, state in zip(
                self.stepper.all_state_variables, self.fine.states, strict=True
            )
            for name, field in state_variable.fields(state).items()
        }
        parts, peak_error, warnings = self._grid_errors(solution)
        self.waiting.append(
            Frame(
                time=self.fine.time,
                load=self.fine.load,
                pressure=solution.pressure,
                gap=solution.gap,
                approach=solution.approach,
                fields=shown,
                coupled_state={} if self.stepper.coupled is None else self.fine.states[-1],
                status=worst(self.statuses),
                residual=solution.residual,
                step_error=self._common_error(),
                grid_error_parts=parts,
                peak_grid_error=peak_error,
                warnings=warnings,
                adhesion=self.fine.adhesion,
                solves=self.solves,
                iterations=self.iterations,
                convolutions=self.convolutions,
            )
        )
        self._reset_counts()
        self._report()
        if not self.step_doubling or self.coarse.time == self.fine.time:
            self._finish_frames()

    def _report(self) -> None:
        """Report the time since the start and that of the whole."""
        if self.progress is not None:
            start = self.breakpoints[0].time
            self.progress(self.fine.time - start, self.breakpoints[-1].time - start)

    def _finish_frames(self, step_error: float | None = None) -> None:
        """Add a step error, by default the present one, to the waiting frames, and write them to the checkpoint."""
        error = self.step_error if step_error is None else step_error
        for frame in self.waiting:
            finished = replace(frame, step_error=error + frame.step_error)
            if self.checkpoint is not None:
                self.checkpoint.write_frame(len(self.frames), finished)
            self.frames.append(finished)
        self.waiting = []

    def _save(self) -> None:
        """Write the state of the integration to the checkpoint, unless a frame waits for its error."""
        if self.checkpoint is None or self.waiting or self.coarse.time != self.fine.time:
            return
        progress: dict[str, Any] = {name: getattr(self, name) for name in CHECKPOINTED}
        progress["frames"] = len(self.frames)
        progress["statuses"] = [status.name for status in self.statuses]
        if self.control is not None:
            progress["local_tolerance"] = self.control.local_tolerance
        self.checkpoint.write_state(progress, {"fine": self.fine, "coarse": self.coarse})

    def restore(self) -> None:
        """Continue from the state in the checkpoint, if there is one."""
        assert self.checkpoint is not None
        saved = self.checkpoint.read_state()
        if saved is None:
            return
        progress, instants = saved
        self.frames = [self.checkpoint.read_frame(number) for number in range(progress["frames"])]
        self.fine, self.coarse = instants["fine"], instants["coarse"]
        self.statuses = [Status[name] for name in progress["statuses"]]
        if self.control is not None:
            self.control = replace(self.control, local_tolerance=progress["local_tolerance"])
        for name in CHECKPOINTED:
            setattr(self, name, progress[name])
