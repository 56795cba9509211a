"""The march through time: main march and companion, from mark to mark, with frames, errors and checkpoints."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import Enum
from functools import cached_property
from math import inf
from typing import Any

import numpy as np

from contactstudy.accuracy.estimate import error_estimate
from contactstudy.accuracy.subcell import HeightsInside
from contactstudy.domain.checks import NotDefined
from contactstudy.domain.errors import ErrorParts
from contactstudy.domain.fields import Array
from contactstudy.evolution.checkpoint import Checkpoint
from contactstudy.evolution.evolution import Frame
from contactstudy.evolution.march import Instant, March
from contactstudy.evolution.steps import FIRST, Mark, StepControl
from contactstudy.solvers.solution import Solution, Status, worst

# A pair of steps shorter than this, over the duration of the march, is never rejected.
SHORTEST = 1e-12
# Parts of a jump of the load where a state depends on its path, in the companion: at first and at most.
PARTS, MOST_PARTS = 4, 2**12
# Largest number of halvings of a step in which bodies start to yield.
ONSET = 6
# Errors of first order fall by 0.5 to 0.6 with every halving, so that a difference is up to 1.5 times too small.
FIRST_ORDER = 1.5
# Errors of wear are of order 1/2 where it begins, since the pressure changes at once: they fall by 2^-1/2, and a
# difference is 2^1/2 - 1 of the error.
WORN_FIRST_ORDER = 1 / (2**0.5 - 1)
# Error by the cells of a march over that of its last contact: with each memory, which depends on earlier pressures, and
# with plastic strain, whose cells below the surface add to it. Bounds by the cells held in 238 of 238 frames with creep,
# wear or both, and were 3 to 4 times too large in the median; with plastic strain the ratios were up to 3.6.
REMEMBERED, YIELDED = 1.2, 4.0
# State of a walk in its checkpoint.
COUNTED = ("mark", "arrived", "step_error", "carried_error", "pair", "rejected", "restarts", "steps", "iterations",
           "convolutions")  # fmt: skip


class _Outcome(Enum):
    """Outcome of the march to a mark."""

    REACHED = "the march is there"
    AGAIN = "the error grew too large: the march starts again with shorter steps"
    NO_SOLUTION = "a step has no solution to go on from"


@dataclass(eq=False)
class Walk:
    """State of a march through time, and the methods that advance it.

    Attributes
    ----------
    march
        Steps of the scene.
    marks
        Instants at which steps end, in order.
    control
        Control of the step length; None steps from mark to mark.
    companion
        Whether a second march with steps twice as long estimates the error of the steps.
    records_all
        Whether every pair of steps is recorded.
    checkpoint
        Folder that frames and states are written to; None writes none.
    progress
        Called with the time reached and the last time [s]; None calls nothing.
    """

    march: March
    marks: tuple[Mark, ...]
    control: StepControl | None
    companion: bool
    records_all: bool
    checkpoint: Checkpoint | None
    progress: Callable[[float, float], None] | None

    def __post_init__(self) -> None:
        self.frames: list[Frame] = []

        # frames whose step error is known once the companion reaches their time
        self.waiting: list[Frame] = []
        self.rejected = self.restarts = 0
        self._count()
        self._begin()

    def _begin(self) -> None:
        """Return to the first mark, with a short pair of steps."""
        self.mark, self.arrived = 0, False
        self.main = self.behind = self.march.start(self.marks[0].time)
        self.solution: Solution | None = None
        self.step_error = self.carried_error = 0.0
        self.pair = FIRST * (self.marks[-1].time - self.marks[0].time)

    def _count(self) -> None:
        """Reset the counts of work since the last frame."""
        self.steps, self.iterations, self.convolutions = 0, 0, 0.0
        self.statuses: list[Status] = []

    def go(self) -> None:
        """March to the last mark, or to a step that has no solution."""
        while self.mark < len(self.marks):
            mark = self.marks[self.mark]
            if self.main.time < mark.time:
                outcome = self._approach(mark)
                if outcome is _Outcome.NO_SOLUTION:
                    return
                if outcome is _Outcome.AGAIN:
                    continue
            if not self.arrived:
                self.arrived = True
                if mark.records == 2:
                    self._record()
            if mark.jumps and not self._jump(mark.after):
                return
            if mark.records or (self.records_all and mark.jumps):
                self._record()
            self.mark, self.arrived = self.mark + 1, False
            self._save()

    def _approach(self, mark: Mark) -> "_Outcome":
        """March to `mark`, which is later than the present time."""
        if self.control is None or not self.march.all_memories:
            return self._one_step(mark)
        return self._pairs_of_steps(mark)

    def _one_step(self, mark: Mark) -> _Outcome:
        """March to `mark` in one step; the companion takes every other step.

        A last step without a partner for the companion is taken in halves, or both marches would be equal.
        """
        together = self.behind.time == self.main.time
        after = self.marks[self.mark + 1] if mark is not self.marks[-1] else None
        # both marches agree where nothing presses, whatever their error before
        last = mark.breaks or after is None or mark.records == 2 or after.before == 0
        if self.companion and together and last:
            half = (self.main.time + mark.time) / 2
            self.main, _ = self._advance(self.main, half, self.march.load.at(half), ONSET)
        onset = ONSET if self.companion else 0
        self.main, self.solution = self._advance(self.main, mark.time, mark.before, onset)
        if not np.isfinite(self.solution.residual):
            self._end(self.solution)
            return _Outcome.NO_SOLUTION
        if self.companion and (last or not together):
            self.behind, _ = self._advance(self.behind, mark.time, mark.before)
            before, self.step_error = self.step_error, self._difference(self.main, self.behind)
            # the frames that wait lie between two instants of the companion
            self._settle(max(before, self.step_error))
        elif not self.companion:
            self.behind = self.main
        return _Outcome.REACHED

    def _pairs_of_steps(self, mark: Mark) -> "_Outcome":
        """March to `mark` by pairs of steps; the companion takes one step for each pair."""
        control = self.control
        assert control is not None
        while self.main.time < mark.time:
            remaining = mark.time - self.main.time
            pair = (
                remaining if self.pair >= remaining * (1 - 1e-9) else min(self.pair, remaining / 2)
            )
            reaches_mark = pair == remaining
            end = mark.time if reaches_mark else self.main.time + pair
            load = mark.before if reaches_mark else self.march.load.at(end)
            half = self.main.time + pair / 2
            first, _ = self._advance(self.main, half, self.march.load.at(half), ONSET)
            second, solution = self._advance(first, end, load, ONSET)
            behind, _ = self._advance(self.behind, end, load)
            if not np.isfinite(solution.residual):
                self._end(solution)
                return _Outcome.NO_SOLUTION
            added = self._added(second, behind)
            if not control.accepts(added) and pair > SHORTEST * self.marks[-1].time:
                self.rejected += 1
                self.pair = pair * min(control.factor(added), 0.5)
                continue
            self.main, self.behind, self.solution = second, behind, solution
            self.step_error = self._difference(second, behind)
            if self.step_error > control.error:
                self._start_again(control.stricter(self.step_error))
                return _Outcome.AGAIN
            # a pair cut short by a mark is no measure of the allowed length
            self.pair = max(pair * control.factor(added), self.pair if reaches_mark else 0.0)
            if self.records_all:
                self._record()
            elif self.progress is not None:
                self.progress(self.main.time, self.marks[-1].time)
            self._save()
        return _Outcome.REACHED

    def _added(self, main: Instant, behind: Instant) -> float:
        """Return how much a pair of steps changes the relative L1 difference of the two marches."""
        before, after = self.main.pressure - self.behind.pressure, main.pressure - behind.pressure
        return self._relative(after - before, main, self.main)

    def _start_again(self, control: StepControl) -> None:
        """Start the march again with shorter steps; the work done so far stays counted."""
        self.control, self.frames, self.waiting = control, [], []
        self.restarts += 1
        self._begin()

    def _jump(self, load: float) -> bool:
        """Change the load of both marches at once; return False if there is no solution to go on from.

        Where a state depends on the path of the load, it changes by parts: twice as many as the companion's, and as many
        as the allowed error asks for.
        """
        parts = 1 if self.march.joint is None else 2 * PARTS
        onset = ONSET if self.companion else 0
        while True:
            main, solution = self._counted(*self.march.jump(self.main, load, parts, onset))
            if not np.isfinite(solution.residual):
                self._end(solution)
                return False
            if not self.companion:
                self.main = self.behind = main
                break
            behind, _ = self._counted(*self.march.jump(self.behind, load, max(parts // 2, 1), 0))
            added = self._added(main, behind)
            exact = self.control is None or self.control.accepts(added)
            if self.march.joint is None or exact or parts >= MOST_PARTS:
                self.main, self.behind = main, behind
                self.step_error = self._difference(main, behind)
                break
            self.rejected += 1
            parts *= 2
        self.solution = solution
        return True

    def _advance(
        self, instant: Instant, end: float, load: float, onset: int = 0
    ) -> tuple[Instant, Solution]:
        """Advance one march to the time `end` [s] and the load `load` [N/m], and count the work."""
        return self._counted(*self.march.advance(instant, end, load, onset))

    def _counted(self, after: Instant, solutions: list[Solution]) -> tuple[Instant, Solution]:
        """Count the work of `solutions`, and return the instant after them with the last of them."""
        for solution in solutions:
            self.steps += 1
            self.iterations += solution.iterations
            self.convolutions += solution.convolutions
            self.statuses.append(solution.status)
        return after, solutions[-1]

    def _end(self, solution: Solution) -> None:
        """Record the frame at which the march has to stop, without a bound of its error."""
        self.solution, self.step_error = solution, inf
        self._record()
        self._settle()

    def _difference(self, main: Instant, companion: Instant) -> float:
        """Return the L1 difference of two instants' pressures, relative to the first."""
        return self._relative(main.pressure - companion.pressure, main)

    def _relative(self, difference: Array, *instants: Instant) -> float:
        """Return the L1 norm of a pressure difference, relative to the largest pressure of `instants`.

        With a joint memory it is relative to the pressure of the largest load, and scaled up: its steps are of first
        order, so that the difference of two marches is the error of the finer one, or a little less.
        """
        norm = float(np.abs(difference).sum())
        if self.march.joint is not None:
            return FIRST_ORDER * self._share(norm)
        if self.march.is_first_order:
            norm *= WORN_FIRST_ORDER
        total = max(float(instant.pressure.sum()) for instant in instants)
        return norm / total if total else 0.0

    @cached_property
    def _heights(self) -> HeightsInside | None:
        """Heights inside the cells, which all instants share."""
        return HeightsInside.from_problem(self.march.problem)

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
        if self.march.joint is not None:
            cells *= YIELDED
        elif self.march.memories:
            cells = REMEMBERED ** len(self.march.memories) * self.carried_error / total
        share = 1.0 if self.march.joint is None else self._share(total)
        parts = ErrorParts(estimate.l1.truncation, cells, estimate.l1.residual)
        return parts.scaled(share), estimate.warnings

    def _share(self, pressures: float) -> float:
        """Return a sum of cell pressures [Pa] divided by the sum under the largest load."""
        grid = self.march.problem.grid
        return pressures * grid.cell_area / grid.period / self.march.load.largest

    def _record(self) -> None:
        """Append a frame of the present contact to those that wait for their error."""
        solution = self.solution
        if solution is None:  # before the first load
            solution = self.march.at_rest()
        shown = {
            name: field
            for memory, state in zip(self.march.all_memories, self.main.states, strict=True)
            for name, field in memory.fields(state).items()
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
                joint_state={} if self.march.joint is None else self.main.states[-1],
                status=worst(self.statuses),
                residual=solution.residual,
                step_error=0.0 if not self.march.all_memories else inf,
                grid_error=parts.total,
                grid_error_parts=parts,
                warnings=warnings,
                steps=self.steps,
                iterations=self.iterations,
                convolutions=self.convolutions,
            )
        )
        self._count()
        if self.progress is not None:
            self.progress(self.main.time, self.marks[-1].time)
        if not self.companion or self.behind.time == self.main.time:
            self._settle()

    def _settle(self, step_error: float | None = None) -> None:
        """Set a step error, by default the present one, in the waiting frames, and write them to the checkpoint."""
        error = self.step_error if step_error is None else step_error
        for frame in self.waiting:
            finished = replace(frame, step_error=error) if self.companion else frame
            if self.checkpoint is not None:
                self.checkpoint.write_frame(len(self.frames), finished)
            self.frames.append(finished)
        self.waiting = []

    def _save(self) -> None:
        """Write the state of the march to the checkpoint, unless a frame waits for its error."""
        if self.checkpoint is None or self.waiting or self.behind.time != self.main.time:
            return
        progress: dict[str, Any] = {name: getattr(self, name) for name in COUNTED}
        progress["frames"] = len(self.frames)
        progress["statuses"] = [status.name for status in self.statuses]
        if self.control is not None:
            progress["adds"] = self.control.adds
        self.checkpoint.write_state(progress, {"main": self.main, "behind": self.behind})

    def restore(self) -> None:
        """Continue from the state in the checkpoint, if there is one."""
        assert self.checkpoint is not None
        saved = self.checkpoint.read_state()
        if saved is None:
            return
        progress, instants = saved
        self.frames = [self.checkpoint.read_frame(number) for number in range(progress["frames"])]
        self.main, self.behind = instants["main"], instants["behind"]
        self.statuses = [Status[name] for name in progress["statuses"]]
        if self.control is not None:
            self.control = replace(self.control, adds=progress["adds"])
        for name in COUNTED:
            setattr(self, name, progress[name])
