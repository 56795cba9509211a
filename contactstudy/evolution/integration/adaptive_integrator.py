"""Adaptive integration in time by step doubling, with frames, errors and checkpoints."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from enum import Enum
from math import inf
from typing import Any

import numpy as np

from contactstudy.domain.checks import InvalidInput
from contactstudy.domain.validation import RelativeError, valid
from contactstudy.evolution.integration.checkpoint import Checkpoint
from contactstudy.evolution.integration.integration_errors import IntegrationErrors
from contactstudy.evolution.integration.time_stepper import Instant, SolvedContacts, TimeStepper
from contactstudy.evolution.time_steps import Breakpoint
from contactstudy.evolution.trajectory import Frame, frame_of
from contactstudy.solvers.solution import Solution, Status, unloaded, worst_until

# A pair of steps shorter than this, over the duration of the integration, is never rejected.
SHORTEST = 1e-12
# Load increments of a jump where bodies yield: at first in the doubled step, of which the short steps have two each, and
# at most in the short steps.
INCREMENTS, MAX_INCREMENTS = 4, 2**12
# Largest number of halvings of a step in which bodies start to yield.
MAX_HALVINGS = 6
# Files of a checkpoint: a recorded frame by its index, and the state to continue from.
FRAME_FILE, STATE_FILE = "frame_{:05d}.npz", "state.npz"
# Time-discretisation errors: in L1 of the pressure and of the states, and of the peak pressure.
NAMES_OF_ERRORS = "pressure", "states", "peak_pressure"
# State of an integrator in its checkpoint.
CHECKPOINTED = ("breakpoint", "time_discretisation_errors", "double_step", "rejected", "restarts", "solves",
                "iterations", "convolutions")  # fmt: skip
# The same of its errors.
CHECKPOINTED_ERRORS = "largest_by_cells", "largest_by_residual", "after_stiff_step", "after_step"
# Steps make no pair where their lengths differ by a larger factor: an error of first order is 1.08 times the difference
# to one step of both lengths at this factor, once that at equal lengths, and 5 times at 10.
MAX_RATIO_OF_PAIR = 1.5
# Errors inside a doubled step over those at its end where creep is over within a step: they fall with its length.
INSIDE_STIFF_STEP = 2.0
# In the first integration, a pair of steps may add this fraction of the allowed error to the difference of two
# integrations.
INITIAL_TOLERANCE_FRACTION = 0.5
# Smallest and largest factor on the length of a step, and the fraction of the allowed length that is aimed at.
MIN_FACTOR, MAX_FACTOR, SAFETY = 0.2, 2.0, 0.9
# The error increment of a pair grows with its length to this power; that of all pairs, to this power minus 1.
ORDER = 2
# Duration of the first pair of steps over that of the integration: if it is too long, it is rejected.
INITIAL_STEP = 1e-2
# Steps of an integration that starts again, over those before, at most.
MAX_RESTART_FACTOR = 0.7
# The least ratio of the error to the solver's tolerance, so that the solver's error does not count.
MIN_ERROR_OVER_TOLERANCE = 100


@dataclass(frozen=True)
class StepControl:
    """Control of the step length by the error increment: by how much a pair of steps raises the error estimate.

    How far later steps damp that error is not known in advance: if the accumulated error exceeds the allowed one, the
    integration restarts with a :meth:`stricter` control.

    Attributes
    ----------
    error
        Allowed relative L1 time-discretisation error.
    local_tolerance
        Allowed error increment of a pair of steps.
    """

    error: float
    local_tolerance: float

    @classmethod
    def for_error(cls, error: float, tolerance: float) -> "StepControl":
        """Return the control of a first integration.

        Parameters
        ----------
        error
            Allowed relative L1 time-discretisation error.
        tolerance
            Tolerance of the solver.

        Raises
        ------
        InvalidInput
            If the error is not between 0 and 1, or too close to the tolerance for steps to meet it.
        """
        error = valid("TimeSteps.error", error, RelativeError)
        if error < MIN_ERROR_OVER_TOLERANCE * tolerance:
            raise InvalidInput(
                f"solve.error or TimeSteps.error leaves {error!r} to the steps in time: give at least "
                f"{MIN_ERROR_OVER_TOLERANCE} times the tolerance of the contacts, or a smaller tolerance."
            )
        return cls(error, INITIAL_TOLERANCE_FRACTION * error)

    def accepts(self, error_increment: float) -> bool:
        """Return whether a pair of steps with this `error_increment` is short enough."""
        return error_increment <= self.local_tolerance

    def factor(self, error_increment: float) -> float:
        """Return the factor on the length of the next pair, after one with this `error_increment`."""
        if error_increment <= 0:
            return MAX_FACTOR
        longer: float = (self.local_tolerance / error_increment) ** (1 / ORDER)
        return min(max(SAFETY * longer, MIN_FACTOR), MAX_FACTOR)

    def stricter(self, excessive_error: float) -> "StepControl":
        """Return the control of the next integration, after one whose error is above the allowed one."""
        shorter = min(SAFETY * self.error / excessive_error, MAX_RESTART_FACTOR) ** (
            ORDER / (ORDER - 1)
        )
        return StepControl(self.error, self.local_tolerance * shorter)


class _Outcome(Enum):
    """Outcome of the integration to a point."""

    REACHED = "the integration is there"
    RESTART = "the error grew too large: the integration starts again with shorter steps"
    NO_SOLUTION = "a step has no solution to go on from"


@dataclass(frozen=True)
class _SavedState:
    """State of an integration: its `progress` as JSON holds it, and the last instants of short and doubled steps."""

    progress: Mapping[str, Any]
    fine: Instant
    coarse: Instant


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
        self.double_step_begin = self.fine
        self.solution: Solution | None = None
        self.errors = IntegrationErrors(self.stepper)
        self.time_discretisation_errors = dict.fromkeys(NAMES_OF_ERRORS, 0.0)
        duration = self.breakpoints[-1].time - self.breakpoints[0].time
        self.double_step, self.shortest = INITIAL_STEP * duration, SHORTEST * duration
        self.step = 0.0  # duration of the last step

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
        if synchronised := self.coarse.time == self.fine.time:
            self.double_step_begin = self.fine
        ends_double_step = self._ends_double_step(point)
        if self.step_doubling and synchronised and ends_double_step:
            half = (self.fine.time + point.time) / 2
            self.fine, solved = self._advance(
                self.fine, half, self.stepper.load.at(half), MAX_HALVINGS
            )
            self._accept(solved)
        middle, max_halvings = self.fine, MAX_HALVINGS if self.step_doubling else 0
        self.fine, solved = self._advance(self.fine, point.time, point.before, max_halvings)
        if not np.isfinite(solved.last.residual):
            self._record_failure(self.fine, solved)
            return _Outcome.NO_SOLUTION
        self.solution = solved.last
        self._accept(solved)
        if self.step_doubling and (ends_double_step or not synchronised):
            self.step = (point.time - self.coarse.time) / 2
            self.coarse, solved = self._advance(self.coarse, point.time, point.before)
            self._accept(solved)
            before = self.time_discretisation_errors
            errors = self.errors.by_steps(self.fine, self.coarse, self.step)
            # the frames that wait lie between two instants of the doubled step
            factor = INSIDE_STIFF_STEP if self.stepper.creep_ends_within(self.step) else 1.0
            inside = {name: max(before[name], factor * errors[name]) for name in errors}
            size, at_begin, at_end = map(
                self.errors.size_of_states, (middle, self.double_step_begin, self.fine)
            )
            of_states = max(before["states"] * at_begin, factor * errors["states"] * at_end)
            inside["states"] = of_states / size if size else 0.0
            self._finish_frames(inside)
            self.time_discretisation_errors = errors
        elif not self.step_doubling:
            self.coarse = self.fine
        return _Outcome.REACHED

    def _ends_double_step(self, point: Breakpoint) -> bool:
        """Return whether the step to `point` makes no pair with the one after it."""
        if point is self.breakpoints[-1] or point.is_discontinuity or point.times_recorded == 2:
            return True
        after = self.breakpoints[self.breakpoint + 1]
        ratio = (after.time - point.time) / (point.time - self.fine.time)
        # without load both integrations have the same pressure
        return after.before == 0 or max(ratio, 1 / ratio) > MAX_RATIO_OF_PAIR

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
            load_at_half = self.stepper.load.at(half)
            first, to_half = self._advance(self.fine, half, load_at_half, MAX_HALVINGS)
            second, to_end = self._advance(first, end, load, MAX_HALVINGS)
            coarse, in_one = self._advance(self.coarse, end, load)
            if not np.isfinite(to_end.last.residual):
                self._record_failure(second, to_end)
                return _Outcome.NO_SOLUTION
            error_increment = self.errors.increment((self.fine, self.coarse), (second, coarse))
            if not control.accepts(error_increment) and double_step > self.shortest:
                self.rejected += 1
                self.double_step = double_step * min(control.factor(error_increment), 0.5)
                continue
            self._accept(to_half + to_end + in_one)
            self.fine, self.coarse, self.solution = second, coarse, to_end.last
            self.step = double_step / 2
            self.time_discretisation_errors = self.errors.by_steps(second, coarse, self.step)
            errors = self.time_discretisation_errors
            if (error := max(errors["pressure"], errors["states"])) > control.error:
                self._restart(control.stricter(error))
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
        while True:
            fine, solved = self._add_work(
                *self.stepper.jump(self.fine, load, increments, max_halvings)
            )
            if not np.isfinite(solved.last.residual):
                self._record_failure(fine, solved)
                return False
            if not self.step_doubling:
                coarse, in_fewer = fine, SolvedContacts()
                break
            coarse, in_fewer = self._add_work(
                *self.stepper.jump(self.coarse, load, max(increments // 2, 1), 0)
            )
            error_increment = self.errors.increment((self.fine, self.coarse), (fine, coarse))
            exact = self.control is None or self.control.accepts(error_increment)
            if self.stepper.coupled is None or exact or increments >= MAX_INCREMENTS:
                self.time_discretisation_errors = self.errors.by_steps(fine, coarse, self.step)
                break
            self.rejected += 1
            increments *= 2
        self._accept(solved + in_fewer)
        self.fine, self.coarse, self.solution = fine, coarse, solved.last
        return True

    def _advance(
        self, instant: Instant, end: float, load: float, max_halvings: int = 0
    ) -> tuple[Instant, SolvedContacts]:
        """Advance one integration to the time `end` [s] and the load `load` [N/m], and count the work."""
        return self._add_work(*self.stepper.advance(instant, end, load, max_halvings))

    def _add_work(self, after: Instant, solved: SolvedContacts) -> tuple[Instant, SolvedContacts]:
        """Count the work of a step, whether it is accepted or not, and return what is given."""
        contacts = solved.kept + solved.replaced
        self.solves += len(contacts)
        self.iterations += sum(contact.iterations for contact in contacts)
        self.convolutions += sum(contact.convolutions for contact in contacts)
        return after, solved

    def _accept(self, solved: SolvedContacts) -> None:
        """Take the statuses and the residuals of accepted steps into the next frame."""
        self.statuses += [contact.status for contact in solved.kept]
        self.errors.keep(solved.kept)

    def _record_failure(self, instant: Instant, solved: SolvedContacts) -> None:
        """Record the `instant` at which the integration has to stop, with an infinite error."""
        self.fine, self.solution = instant, solved.last
        self.time_discretisation_errors = dict.fromkeys(self.time_discretisation_errors, inf)
        self._accept(solved)
        self._record()
        self._finish_frames()

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
        parts, peak_parts, warnings = self.errors.of_grid(solution)
        is_estimated = self.step_doubling or not self.stepper.all_state_variables
        frame = frame_of(
            solution,
            time=self.fine.time,
            load=self.fine.load,
            problem=self.stepper.problem,
            displacement=solution.gap + solution.approach - self.stepper.problem.undeformed_gap,
            traction=self.stepper.traction(self.fine),
            fields=shown,
            coupled_state={} if self.stepper.coupled is None else self.fine.states[-1],
            status=worst_until(solution.status, self.statuses),
            errors_by_steps=(
                self.errors.common(self.fine)
                if is_estimated
                else dict.fromkeys(NAMES_OF_ERRORS, inf)
            ),
            grid_error_parts=parts,
            peak_grid_error_parts=peak_parts,
            warnings=warnings,
            adhesion=self.fine.adhesion,
            solves=self.solves,
            iterations=self.iterations,
            convolutions=self.convolutions,
        )
        self.waiting.append(frame)
        self._reset_counts()
        self._report()
        if not self.step_doubling or self.coarse.time == self.fine.time:
            self._finish_frames()

    def _report(self) -> None:
        """Report the time since the start and that of the whole."""
        if self.progress is not None:
            start = self.breakpoints[0].time
            self.progress(self.fine.time - start, self.breakpoints[-1].time - start)

    def _finish_frames(self, errors: Mapping[str, float] | None = None) -> None:
        """Add the present time-discretisation errors, or these, to the waiting frames, and write them."""
        for frame in self.waiting:
            total = {
                name: error + frame.errors_by_steps[name]
                for name, error in (errors or self.time_discretisation_errors).items()
            }
            total["l1"] = max(total.pop("pressure"), total.pop("states"))
            finished = replace(frame, errors_by_steps=total)
            if self.checkpoint is not None:
                self.checkpoint.write(FRAME_FILE.format(len(self.frames)), finished)
            self.frames.append(finished)
        self.waiting = []

    def _save(self) -> None:
        """Write the state of the integration to the checkpoint, unless a frame waits for its error."""
        if self.checkpoint is None or self.waiting or self.coarse.time != self.fine.time:
            return
        progress: dict[str, Any] = {name: getattr(self, name) for name in CHECKPOINTED}
        progress["errors"] = {name: getattr(self.errors, name) for name in CHECKPOINTED_ERRORS}
        progress["frames"] = len(self.frames)
        progress["statuses"] = [status.name for status in self.statuses]
        if self.control is not None:
            progress["local_tolerance"] = self.control.local_tolerance
        self.checkpoint.write(STATE_FILE, _SavedState(progress, self.fine, self.coarse))

    def restore(self) -> None:
        """Continue from the state in the checkpoint, if there is one."""
        checkpoint = self.checkpoint
        assert checkpoint is not None
        if not (checkpoint.folder / STATE_FILE).exists():
            return
        saved = checkpoint.read(STATE_FILE, _SavedState)
        progress, self.fine, self.coarse = saved.progress, saved.fine, saved.coarse
        numbers = range(progress["frames"])
        frames = (checkpoint.read(FRAME_FILE.format(number), Frame) for number in numbers)
        self.frames = [replace(frame, problem=self.stepper.problem) for frame in frames]
        self.statuses = [Status[name] for name in progress["statuses"]]
        if self.control is not None:
            self.control = replace(self.control, local_tolerance=progress["local_tolerance"])
        self.errors = IntegrationErrors(self.stepper, **progress["errors"])
        for name in CHECKPOINTED:
            setattr(self, name, progress[name])
