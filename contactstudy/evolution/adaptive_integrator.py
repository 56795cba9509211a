"""Adaptive integration in time by step doubling, with frames, errors and checkpoints."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import Enum
from functools import cached_property
from math import inf
from typing import Any

import numpy as np

from contactstudy.accuracy.estimate import error_estimate
from contactstudy.accuracy.subcell import SubgridHeights
from contactstudy.domain.checks import NotDefined
from contactstudy.domain.errors import ErrorParts
from contactstudy.domain.fields import Array
from contactstudy.evolution.checkpoint import Checkpoint
from contactstudy.evolution.evolution import Frame
from contactstudy.evolution.state_variables import HasDifference
from contactstudy.evolution.steps import FIRST, Breakpoint, StepControl
from contactstudy.evolution.time_stepper import Instant, TimeStepper
from contactstudy.solvers.solution import Solution, Status, worst

# A pair of steps shorter than this, over the duration of the integration, is never rejected.
SHORTEST = 1e-12
# Parts of a jump of the load where a state depends on its path, in the doubled step: at first and at most.
PARTS, MOST_PARTS = 4, 2**12
# Largest number of halvings of a step in which bodies start to yield.
ONSET = 6
# Errors of first order fall by 0.5 to 0.6 with every halving, so that a difference is up to 1.5 times too small.
FIRST_ORDER = 1.5
# Errors of wear are of order 1/2 where it begins, since the pressure changes at once: they fall by 2^-1/2, and a
# difference is 2^1/2 - 1 of the error.
WORN_FIRST_ORDER = 1 / (2**0.5 - 1)
# Error by the cells of an integration over that of its last contact: with each state variable, which depends on earlier
# pressures, and with plastic strain, whose cells below the surface add to it. Bounds by the cells held in 238 of 238
# frames with creep, wear or both, and were 3 to 4 times too large in the median; with plastic strain the ratios were up
# to 3.6.
REMEMBERED, YIELDED = 1.2, 4.0
# State of an integrator in its checkpoint.
COUNTED = ("breakpoint", "arrived", "step_error", "carried_error", "pair", "rejected", "restarts", "steps", "iterations",
           "convolutions")  # fmt: skip


class _Outcome(Enum):
    """Outcome of the integration to a point."""

    REACHED = "the integration is there"
    AGAIN = "the error grew too large: the integration starts again with shorter steps"
    NO_SOLUTION = "a step has no solution to go on from"


@dataclass(eq=False)
class AdaptiveIntegrator:
    """Integration of a scene in time by pairs of steps, each checked by one step of twice the length.

    The difference of the two estimates the error; a pair that adds too much is rejected, and the next one is as long as
    the estimate allows. Source: Hairer, Norsett & Wanner (1993), sect. II.4, eqs. 4.4 and 4.13.

    Attributes
    ----------
    stepper
        Steps of the scene.
    breakpoints
        Instants at which steps end, in order.
    control
        Control of the step length; None steps from one breakpoint to the next.
    step_doubling
        Whether a second integration with steps twice as long estimates the error of the steps.
    records_all
        Whether every pair of steps is recorded.
    checkpoint
        Folder that frames and states are written to; None writes none.
    progress
        Called with the time reached and the last time [s]; None calls nothing.
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

        # frames whose step error is known once the doubled step reaches their time
        self.waiting: list[Frame] = []
        self.rejected = self.restarts = 0
        self._count()
        self._begin()

    def _begin(self) -> None:
        """Return to the first breakpoint, with a short pair of steps."""
        self.breakpoint, self.arrived = 0, False
        self.main = self.doubled = self.stepper.start(self.breakpoints[0].time)
        self.solution: Solution | None = None
        self.step_error = self.carried_error = 0.0
        self.pair = FIRST * (self.breakpoints[-1].time - self.breakpoints[0].time)

    def _count(self) -> None:
        """Reset the counts of work since the last frame."""
        self.steps, self.iterations, self.convolutions = 0, 0, 0.0
        self.statuses: list[Status] = []

    def integrate(self) -> None:
        """Integrate to the last breakpoint, or to a step that has no solution."""
        while self.breakpoint < len(self.breakpoints):
            point = self.breakpoints[self.breakpoint]
            if self.main.time < point.time:
                outcome = self._integrate_to(point)
                if outcome is _Outcome.NO_SOLUTION:
                    return
                if outcome is _Outcome.AGAIN:
                    continue
            if not self.arrived:
                self.arrived = True
                if point.records == 2:
                    self._record()
            if point.jumps and not self._jump(point.after):
                return
            if point.records or (self.records_all and point.jumps):
                self._record()
            self.breakpoint, self.arrived = self.breakpoint + 1, False
            self._save()

    def _integrate_to(self, point: Breakpoint) -> "_Outcome":
        """Integrate to `point`, which is later than the present time."""
        if self.control is None or not self.stepper.all_state_variables:
            return self._one_step(point)
        return self._pairs_of_steps(point)

    def _one_step(self, point: Breakpoint) -> _Outcome:
        """Integrate to `point` in one step; every second one is checked by one step of twice the length.

        A last step that has no partner is taken in halves, or there would be nothing to compare.
        """
        together = self.doubled.time == self.main.time
        after = self.breakpoints[self.breakpoint + 1] if point is not self.breakpoints[-1] else None
        # both integrations agree where nothing presses, whatever their error before
        last = point.breaks or after is None or point.records == 2 or after.before == 0
        if self.step_doubling and together and last:
            half = (self.main.time + point.time) / 2
            self.main, _ = self._advance(self.main, half, self.stepper.load.at(half), ONSET)
        onset = ONSET if self.step_doubling else 0
        self.main, self.solution = self._advance(self.main, point.time, point.before, onset)
        if not np.isfinite(self.solution.residual):
            self._end(self.solution)
            return _Outcome.NO_SOLUTION
        if self.step_doubling and (last or not together):
            self.doubled, _ = self._advance(self.doubled, point.time, point.before)
            before, self.step_error = self.step_error, self._difference(self.main, self.doubled)
            # the frames that wait lie between two instants of the doubled step
            self._finish_frames(max(before, self.step_error))
        elif not self.step_doubling:
            self.doubled = self.main
        return _Outcome.REACHED

    def _pairs_of_steps(self, point: Breakpoint) -> "_Outcome":
        """Integrate to `point` by pairs of steps, each checked by one step of twice the length."""
        control = self.control
        assert control is not None
        while self.main.time < point.time:
            remaining = point.time - self.main.time
            pair = (
                remaining if self.pair >= remaining * (1 - 1e-9) else min(self.pair, remaining / 2)
            )
            reaches_point = pair == remaining
            end = point.time if reaches_point else self.main.time + pair
            load = point.before if reaches_point else self.stepper.load.at(end)
            half = self.main.time + pair / 2
            first, _ = self._advance(self.main, half, self.stepper.load.at(half), ONSET)
            second, solution = self._advance(first, end, load, ONSET)
            doubled, _ = self._advance(self.doubled, end, load)
            if not np.isfinite(solution.residual):
                self._end(solution)
                return _Outcome.NO_SOLUTION
            added = self._added(second, doubled)
            if not control.accepts(added) and pair > SHORTEST * self.breakpoints[-1].time:
                self.rejected += 1
                self.pair = pair * min(control.factor(added), 0.5)
                continue
            self.main, self.doubled, self.solution = second, doubled, solution
            self.step_error = self._difference(second, doubled)
            if self.step_error > control.error:
                self._start_again(control.stricter(self.step_error))
                return _Outcome.AGAIN
            # a pair cut short by a breakpoint is no measure of the allowed length
            self.pair = max(pair * control.factor(added), self.pair if reaches_point else 0.0)
            if self.records_all:
                self._record()
            elif self.progress is not None:
                self.progress(self.main.time, self.breakpoints[-1].time)
            self._save()
        return _Outcome.REACHED

    def _added(self, main: Instant, doubled: Instant) -> float:
        """Return how much a pair of steps changes the relative L1 difference of the two integrations."""
        before, after = self.main.pressure - self.doubled.pressure, main.pressure - doubled.pressure
        grown = self._shear_difference(main, doubled) - self._shear_difference(
            self.main, self.doubled
        )
        return max(self._relative(after - before, main, self.main), grown)

    def _start_again(self, control: StepControl) -> None:
        """Start the integration again with shorter steps; the work done so far stays counted."""
        self.control, self.frames, self.waiting = control, [], []
        self.restarts += 1
        self._begin()

    def _jump(self, load: float) -> bool:
        """Change the load of both integrations at once; return False if there is no solution to go on from.

        Where a state depends on the path of the load, it changes by parts: twice as many as those of the doubled steps,
        and as many as the allowed error asks for.
        """
        parts = 1 if self.stepper.coupled is None else 2 * PARTS
        onset = ONSET if self.step_doubling else 0
        while True:
            main, solution = self._counted(*self.stepper.jump(self.main, load, parts, onset))
            if not np.isfinite(solution.residual):
                self._end(solution)
                return False
            if not self.step_doubling:
                self.main = self.doubled = main
                break
            doubled, _ = self._counted(
                *self.stepper.jump(self.doubled, load, max(parts // 2, 1), 0)
            )
            added = self._added(main, doubled)
            exact = self.control is None or self.control.accepts(added)
            if self.stepper.coupled is None or exact or parts >= MOST_PARTS:
                self.main, self.doubled = main, doubled
                self.step_error = self._difference(main, doubled)
                break
            self.rejected += 1
            parts *= 2
        self.solution = solution
        return True

    def _advance(
        self, instant: Instant, end: float, load: float, onset: int = 0
    ) -> tuple[Instant, Solution]:
        """Advance one integration to the time `end` [s] and the load `load` [N/m], and count the work."""
        return self._counted(*self.stepper.advance(instant, end, load, onset))

    def _counted(self, after: Instant, solutions: list[Solution]) -> tuple[Instant, Solution]:
        """Count the work of `solutions`, and return the instant after them with the last of them."""
        for solution in solutions:
            self.steps += 1
            self.iterations += solution.iterations
            self.convolutions += solution.convolutions
            self.statuses.append(solution.status)
        return after, solutions[-1]

    def _end(self, solution: Solution) -> None:
        """Record the frame at which the integration has to stop, without a bound of its error."""
        self.solution, self.step_error = solution, inf
        self._record()
        self._finish_frames()

    def _difference(self, main: Instant, doubled: Instant) -> float:
        """Return the L1 difference of two instants' pressures, or of their shears, relative to the first."""
        pressure = self._relative(main.pressure - doubled.pressure, main)
        return max(pressure, self._shear_difference(main, doubled))

    def _shear_difference(self, main: Instant, doubled: Instant) -> float:
        """Return the largest difference of two instants' state variables that have an error of their own."""
        variables = zip(self.stepper.all_state_variables, main.states, doubled.states, strict=True)
        return max(
            (
                variable.difference(fine, coarse)
                for variable, fine, coarse in variables
                if isinstance(variable, HasDifference)
            ),
            default=0.0,
        )

    def _relative(self, difference: Array, *instants: Instant) -> float:
        """Return the L1 norm of a pressure difference, relative to the largest pressure of `instants`.

        With a coupled state variable it is relative to the pressure of the largest load, and scaled up: its steps are
        of first order, so that the difference of two integrations is the error of the finer one, or a little less.
        """
        norm = float(np.abs(difference).sum())
        if self.stepper.coupled is not None:
            return FIRST_ORDER * self._relative_to_largest_load(norm)
        if self.stepper.is_first_order:
            norm *= WORN_FIRST_ORDER
        total = max(float(instant.pressure.sum()) for instant in instants)
        return norm / total if total else 0.0

    @cached_property
    def _heights(self) -> SubgridHeights | None:
        """Heights inside the cells, which all instants share."""
        return SubgridHeights.from_problem(self.stepper.problem)

    def _grid_error(self, solution: Solution) -> tuple[ErrorParts, tuple[str, ...]]:
        """Estimate the error by the grid of this instant's contact, and give the reasons for what has no bound.

        It is relative to the same pressure as the error by the steps.
        """
        pressure = solution.pressure
        if not pressure.any() or not np.isfinite(solution.residual):
            return ErrorParts(0.0, 0.0, 0.0), ()
        try:
            estimate = error_estimate(solution, heights=self._heights)
        except NotDefined as reason:
            return ErrorParts(0.0, inf, 0.0), (f"No bound: {reason}",)
        total = float(pressure.sum())
        # creep and wear keep the errors of earlier pressures, so that they enter later frames
        cells = estimate.l1.by_cause["discretisation"]
        self.carried_error = max(self.carried_error, cells * total)
        if self.stepper.coupled is not None:
            cells *= YIELDED
        elif self.stepper.state_variables:
            cells = REMEMBERED ** len(self.stepper.state_variables) * self.carried_error / total
        factor = 1.0 if self.stepper.coupled is None else self._relative_to_largest_load(total)
        parts = ErrorParts(estimate.l1.truncation, cells, estimate.l1.residual)
        return parts.scaled(factor), estimate.warnings

    def _relative_to_largest_load(self, pressures: float) -> float:
        """Return a sum of cell pressures [Pa] divided by the sum under the largest load."""
        grid = self.stepper.problem.grid
        return pressures * grid.cell_area / grid.period / self.stepper.load.largest

    def _record(self) -> None:
        """Append a frame of the present contact to those that wait for their error."""
        solution = self.solution
        if solution is None:  # before the first load
            solution = self.stepper.at_rest()
        shown = {
            name: field
            for state_variable, state in zip(
                self.stepper.all_state_variables, self.main.states, strict=True
            )
            for name, field in state_variable.fields(state).items()
        }
        parts, warnings = self._grid_error(solution)
        self.waiting.append(
            Frame(
                time=self.main.time,
                load=self.main.load,
                pressure=solution.pressure,
                gap=solution.gap,
                approach=solution.approach,
                fields=shown,
                coupled_state={} if self.stepper.coupled is None else self.main.states[-1],
                status=worst(self.statuses),
                residual=solution.residual,
                step_error=0.0 if not self.stepper.all_state_variables else inf,
                grid_error=parts.total,
                grid_error_parts=parts,
                warnings=warnings,
                adhesion=self.main.adhesion,
                steps=self.steps,
                iterations=self.iterations,
                convolutions=self.convolutions,
            )
        )
        self._count()
        if self.progress is not None:
            self.progress(self.main.time, self.breakpoints[-1].time)
        if not self.step_doubling or self.doubled.time == self.main.time:
            self._finish_frames()

    def _finish_frames(self, step_error: float | None = None) -> None:
        """Set a step error, by default the present one, in the waiting frames, and write them to the checkpoint."""
        error = self.step_error if step_error is None else step_error
        for frame in self.waiting:
            finished = replace(frame, step_error=error) if self.step_doubling else frame
            if self.checkpoint is not None:
                self.checkpoint.write_frame(len(self.frames), finished)
            self.frames.append(finished)
        self.waiting = []

    def _save(self) -> None:
        """Write the state of the integration to the checkpoint, unless a frame waits for its error."""
        if self.checkpoint is None or self.waiting or self.doubled.time != self.main.time:
            return
        progress: dict[str, Any] = {name: getattr(self, name) for name in COUNTED}
        progress["frames"] = len(self.frames)
        progress["statuses"] = [status.name for status in self.statuses]
        if self.control is not None:
            progress["adds"] = self.control.adds
        self.checkpoint.write_state(progress, {"main": self.main, "doubled": self.doubled})

    def restore(self) -> None:
        """Continue from the state in the checkpoint, if there is one."""
        assert self.checkpoint is not None
        saved = self.checkpoint.read_state()
        if saved is None:
            return
        progress, instants = saved
        self.frames = [self.checkpoint.read_frame(number) for number in range(progress["frames"])]
        self.main, self.doubled = instants["main"], instants["doubled"]
        self.statuses = [Status[name] for name in progress["statuses"]]
        if self.control is not None:
            self.control = replace(self.control, adds=progress["adds"])
        for name in COUNTED:
            setattr(self, name, progress[name])
