"""The way through time: main march and companion, from mark to mark."""

from collections.abc import Callable
from dataclasses import astuple, dataclass, replace
from enum import Enum
from math import inf
from typing import Any

import numpy as np

from contactstudy.accuracy.estimate import error_estimate
from contactstudy.accuracy.expected_error import ErrorParts
from contactstudy.domain.checks import NotDefined
from contactstudy.domain.fields import Array
from contactstudy.evolution.checkpoint import Checkpoint
from contactstudy.evolution.evolution import Frame
from contactstudy.evolution.march import Instant, March, worst
from contactstudy.evolution.steps import FIRST, Mark, StepControl
from contactstudy.solvers.solution import Solution, Status

# Pairs of steps this short over the whole time are taken as they are.
SHORTEST = 1e-12
# Parts of a jump of the load on whose path something depends: first and at the most, of the companion.
PARTS, MOST_PARTS = 4, 2**12
# A step in which bodies start to yield is halved so often at the most.
ONSET = 6
# Errors of first order fall by 0.5 to 0.6 with every halving, so that a difference is up to 1.5 times too small.
FIRST_ORDER = 1.5
# Those of wear, whose pressure changes at once where it begins, are of order 1/2 there: they fall by 2^-1/2, and a
# difference is 2^1/2 - 1 of the error.
WORN_FIRST_ORDER = 1 / (2**0.5 - 1)
# Error of a march by the cells over that of its contact alone: of a memory, which has seen other pressures, and of
# plastic strain, whose cells below the surface add to it. On 40 marches they were up to 1.1 and 3.6.
REMEMBERED, YIELDED = 1.25, 4.0
COUNTED = ("mark", "arrived", "found", "carried", "pair", "rejected", "restarts", "steps", "iterations",
           "convolutions")  # fmt: skip


class _Outcome(Enum):
    """How the way to a mark ended."""

    REACHED = "the march is there"
    AGAIN = "the error grew too large: the march starts again with shorter steps"
    NO_SOLUTION = "a step has no solution to go on from"


@dataclass(eq=False)
class Walk:
    """Where a march is: the only thing here that changes."""

    march: March
    marks: tuple[Mark, ...]
    control: StepControl | None
    companion: bool
    wraps: tuple[bool, bool]
    records_all: bool
    checkpoint: Checkpoint | None
    progress: Callable[[float, float], None] | None

    def __post_init__(self) -> None:
        self.frames: list[Frame] = []
        # frames whose error is known when the companion comes up to them
        self.waiting: list[Frame] = []
        self.rejected = self.restarts = 0
        self._count()
        self._begin()

    def _begin(self) -> None:
        self.mark, self.arrived = 0, False
        self.main = self.behind = self.march.start(self.marks[0].time)
        self.solution: Solution | None = None
        self.found = self.carried = 0.0
        self.pair = FIRST * (self.marks[-1].time - self.marks[0].time)

    def _count(self) -> None:
        self.steps, self.iterations, self.convolutions = 0, 0, 0.0
        self.statuses: list[Status] = []

    def go(self) -> None:
        """To the last mark, or to a step that has no solution."""
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
        if self.control is None or not self.march.all_memories:
            return self._one_step(mark)
        return self._pairs_of_steps(mark)

    def _one_step(self, mark: Mark) -> _Outcome:
        """To ``mark`` at once; the companion takes every other step.

        A single step that has no other beside it is taken in halves, or the companion would be no different.
        """
        together = self.behind.time == self.main.time
        last = mark.breaks or mark is self.marks[-1] or mark.records == 2
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
            self.found = self._difference(self.main, self.behind)
            self._settle()
        elif not self.companion:
            self.behind = self.main
        return _Outcome.REACHED

    def _pairs_of_steps(self, mark: Mark) -> "_Outcome":
        """To ``mark`` by pairs of steps, the companion by one step for each pair."""
        control = self.control
        assert control is not None
        while self.main.time < mark.time:
            rest = mark.time - self.main.time
            pair = rest if self.pair >= rest * (1 - 1e-9) else min(self.pair, rest / 2)
            whole = pair == rest
            end = mark.time if whole else self.main.time + pair
            load = mark.before if whole else self.march.load.at(end)
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
            self.found = self._difference(second, behind)
            if self.found > control.error:
                self._start_again(control.stricter(self.found))
                return _Outcome.AGAIN
            # a mark that cuts a pair short says nothing of its length
            self.pair = max(pair * control.factor(added), self.pair if whole else 0.0)
            if self.records_all:
                self._record()
            elif self.progress is not None:
                self.progress(self.main.time, self.marks[-1].time)
            self._save()
        return _Outcome.REACHED

    def _added(self, main: Instant, behind: Instant) -> float:
        """How far the difference of the two marches changes in a pair of steps, in L1 over the pressure."""
        before, after = self.main.pressure - self.behind.pressure, main.pressure - behind.pressure
        return self._relative(after - before, main, self.main)

    def _start_again(self, control: StepControl) -> None:
        """With shorter steps; what the march has cost is counted on."""
        self.control, self.frames, self.waiting = control, [], []
        self.restarts += 1
        self._begin()

    def _jump(self, load: float) -> bool:
        """Both marches to another load at once; False if there is no solution to go on from.

        By parts where something depends on the path of the load: twice as many of them as the companion takes, and
        as many as the error asks for.
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
                self.found = self._difference(main, behind)
                break
            self.rejected += 1
            parts *= 2
        self.solution = solution
        return True

    def _advance(
        self, instant: Instant, end: float, load: float, onset: int = 0
    ) -> tuple[Instant, Solution]:
        return self._counted(*self.march.advance(instant, end, load, onset))

    def _counted(self, after: Instant, solutions: list[Solution]) -> tuple[Instant, Solution]:
        for solution in solutions:
            self.steps += 1
            self.iterations += solution.iterations
            self.convolutions += solution.convolutions
            self.statuses.append(solution.status)
        return after, solutions[-1]

    def _end(self, solution: Solution) -> None:
        """The frame at which the march has to stop."""
        self.solution, self.found = solution, inf
        self._record()
        self._settle()

    def _difference(self, one: Instant, other: Instant) -> float:
        """Of two pressures, in L1, over the first."""
        return self._relative(one.pressure - other.pressure, one)

    def _relative(self, difference: Array, *instants: Instant) -> float:
        """In L1 over the largest pressure of ``instants``, with joint memories over that of the largest load.

        These are of first order, so that a difference of two marches is the error of the finer one, or a little less.
        """
        size = float(np.abs(difference).sum())
        if self.march.joint is not None:
            return FIRST_ORDER * self._share(size)
        if self.march.is_first_order:
            size *= WORN_FIRST_ORDER
        whole = max(float(instant.pressure.sum()) for instant in instants)
        return size / whole if whole else 0.0

    def _grid_error(self, solution: Solution) -> tuple[ErrorParts, tuple[str, ...]]:
        """Estimate the error of the contact of this instant, and give the reasons for what has no bound.

        It is relative to the same as the error by the steps.
        """
        pressure = solution.pressure
        if not pressure.any() or not np.isfinite(solution.residual):
            return ErrorParts(0.0, 0.0, 0.0), ()
        try:
            found = error_estimate(solution)
        except NotDefined as reason:
            return ErrorParts(0.0, inf, 0.0), (f"No bound: {reason}",)
        total = float(pressure.sum())
        # what has crept or worn in error stays, so that an error of an earlier frame enters the later ones
        self.carried = max(self.carried, found.l1.discretisation * total)
        cells = found.l1.discretisation
        if self.march.joint is not None:
            cells *= YIELDED
        elif self.march.memories:
            cells = REMEMBERED * self.carried / total
        share = 1.0 if self.march.joint is None else self._share(total)
        parts = ErrorParts(found.l1.truncation, cells, found.l1.residual)
        return ErrorParts(*(share * part for part in astuple(parts))), found.warnings

    def _share(self, pressures: float) -> float:
        """A sum of pressures over that of the largest load."""
        grid = self.march.problem.grid
        return pressures * grid.cell_area / grid.period / self.march.load.largest

    def _record(self) -> None:
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
                kept={} if self.march.joint is None else self.main.states[-1],
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

    def _settle(self) -> None:
        """Give the frames that wait for it the error found."""
        for frame in self.waiting:
            known = replace(frame, step_error=self.found) if self.companion else frame
            if self.checkpoint is not None:
                self.checkpoint.write_frame(len(self.frames), known)
            self.frames.append(known)
        self.waiting = []

    def _save(self) -> None:
        """Where to go on from, as long as no frame waits for its error."""
        if self.checkpoint is None or self.waiting or self.behind.time != self.main.time:
            return
        progress: dict[str, Any] = {name: getattr(self, name) for name in COUNTED}
        progress["frames"] = len(self.frames)
        progress["statuses"] = [status.name for status in self.statuses]
        if self.control is not None:
            progress["adds"] = self.control.adds
        self.checkpoint.write_state(progress, {"main": self.main, "behind": self.behind})

    def restore(self) -> None:
        """Go on from what was saved, if anything was."""
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
