"""The comparison of a scene's settings within a budget: which padding, n, grid and tolerance.

A ladder of grids at the scene's own boundary leads to a reference. Paddings and tolerances are judged on one grid of
it, where the error by the cells is the same and cancels, so that solves add and do not multiply. Whole settings, on
grids that nest in the reference, are then timed in turns.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from math import inf, isfinite, log, prod
from time import perf_counter

import numpy as np
from threadpoolctl import threadpool_limits

import contactstudy as cs
from contactstudy.domain.checks import positive
from studies.advice.comparison import (
    LINE,
    Comparison,
    Measured,
    PaddingError,
    label_of,
    with_envelope,
)
from studies.advice.ladder import MULTIPLES, cells_at, is_reference
from studies.advice.rounds import ROUNDS, in_rounds, seconds_of
from studies.advice.subject import (
    Answer,
    Setting,
    Subject,
    bounds_of,
    failure_of,
    last_of,
    numbers_of,
    pressure_of,
)
from studies.reference.line_contact import hertz_means, relative_l1

# Tolerance of the reference, and of what is compared on one grid.
TIGHT_TOLERANCE = 1e-8
TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
# Statuses that finer cells do not change.
FATAL_STATUSES = (
    cs.Status.CONTACT_AT_EDGE,
    cs.Status.YIELD_AT_EDGE,
    cs.Status.NO_ADMISSIBLE_PRESSURE,
)
# Multiple of the unit from which on a solve that fails is no fault of too coarse a grid.
RESOLVED_FROM = 8
# Multiple of the unit up to which every rung is solved that is affordable.
COARSE_UP_TO = 6
# Fraction of the requested error that the tolerance may take.
TOLERANCE_FRACTION = 0.1
# Cells on which paddings and tolerances are compared, and those of one row.
MIDDLE_CELLS, MIDDLE_CELLS_1D = 2**14, 2**9
# Fraction of the requested error at which the bound on the reference's own error needs no finer grid.
FINE_ENOUGH_FRACTION = 0.02
# Exponent of the time over the cells, at least and at most.
TIME_EXPONENTS = 1.0, 1.3
# Fraction of the time left that the next solve of the ladder may take, and that it may take where the reference is too
# coarse for the request; the fraction of a budget for the paddings on one grid.
NEXT_FRACTION, NEXT_REFERENCE_FRACTION, PADDINGS_FRACTION = 0.15, 0.45, 0.15
# Fraction of a budget after which no further padding is compared: some take far longer than the own boundary.
MAX_PADDINGS_FRACTION = 0.3
# Factor of the expected time above which a solve is repeated.
REPEAT_FACTOR = 3.0
# Cost of a bound over that of its answer: solutions on cells of twice the size, of a film three further ones.
BOUND_COST, FILM_BOUND_COST = 0.5, 2.0
# Fraction of the requested error above which the bound on the reference's own error is too large.
TOO_COARSE_FRACTION = 0.5
# Factor of the least error by the cells up to which a padding's own error is worth timing.
MAX_PADDING_ERROR_FACTOR = 20.0
# Turns in which every setting is timed before the rounds of the best: one time alone may be interrupted.
REPEATS = 3
# Settings of the last rounds, and how much slower than the quickest they may be.
MAX_SETTINGS, MAX_TIME_FACTOR = 7, 2.0
# Fraction of the budget that is kept for the rounds, and for what follows them.
ROUNDS_FRACTION, SPARE_FRACTION = 0.3, 0.03
# Fraction of the budget that the finest grid may take where the reference is a closed form.
FINEST_FRACTION = 0.005
# Numbers of images that are compared on one grid, and those that are timed.
CIRCULAR_IMAGES, SUPERPOSED_IMAGES, TIMED_IMAGES = (1, 2, 4, 6, 10, 20), (1, 6, 20), (1, 6)

Log = Callable[[str], object]


@dataclass
class Budget:
    """Wall time [s] that a comparison may take."""

    seconds: float
    start: float = field(default_factory=perf_counter)

    @property
    def spent(self) -> float:
        """Seconds since the start."""
        return perf_counter() - self.start

    @property
    def left(self) -> float:
        """Seconds left."""
        return self.seconds * (1 - SPARE_FRACTION) - self.spent


def compared(
    subject: Subject, error: float, budget: Budget, log: Log = lambda text: None
) -> Comparison:
    """Return what was measured of a scene's settings within a budget.

    Parameters
    ----------
    subject
        The scene.
    error
        Requested relative L1 error of the pressure.
    budget
        Its seconds; a solve that has begun is not stopped.
    log
        Takes a sentence on each step.

    Raises
    ------
    InvalidInput
        If the error or the seconds are not above 0, or the scene has no solution on the coarsest grids.
    """
    positive("error", error, "must be a relative error above 0, such as 1e-2")
    positive("seconds", budget.seconds, "must be a time above 0 s, such as 60")
    with threadpool_limits(1):
        return _Comparing(subject, error, budget, log).result()


@dataclass(frozen=True)
class _Rung:
    """A multiple of the unit, with the tolerance that suffices on it, and whether its answer has a bound."""

    multiple: int
    tolerance: float
    is_bounded: bool


@dataclass
class _Comparing:
    """A comparison while it is made."""

    subject: Subject
    error: float
    budget: Budget
    log: Log
    notes: list[str] = field(default_factory=list)
    # answers at the own boundary, by the multiple of the unit, with their wall times [s]
    solved: dict[int, Answer] = field(default_factory=dict)
    walls: dict[int, float] = field(default_factory=dict)
    # bounds on their own errors in L1
    bounds: dict[int, float] = field(default_factory=dict)

    def result(self) -> Comparison:
        """Run all steps."""
        subject = self.subject
        self.notes += subject.notes
        max_cells = MIDDLE_CELLS if subject.unit[1] > 1 else MIDDLE_CELLS_1D
        self._climb(lambda multiple: prod(self._cells(multiple)) <= max_cells, NEXT_FRACTION)
        middle = self._middle()
        paddings = self._paddings(middle)
        tolerances = self._tolerances(middle)
        hertz = subject.exact
        reference, bounds = None, {"pressure_l1": 0.0}
        if hertz is None:
            reference, bounds = self._reference()
        floor = bounds["pressure_l1"]
        settings = self._settings(reference, paddings)
        measured = Comparison(
            name=subject.name,
            text=subject.text,
            extent=subject.extent,
            own=subject.own,
            error=self.error,
            floor=floor,
            reference=None if reference is None else self._cells(reference),
            bounds=bounds,
            paddings=tuple(paddings),
            paddings_on=self._cells(middle),
            tolerances=tolerances,
            settings=tuple(settings),
        )
        measured = self._in_turns(measured)
        return replace(measured, notes=tuple(self.notes), spent=self.budget.spent)

    def _cells(self, multiple: int) -> tuple[int, int]:
        return cells_at(self.subject.unit, multiple)

    def _solve(self, multiple: int) -> None:
        """Solve at the own boundary, on a rung; a rung that is too coarse for the scene is passed over."""
        start = perf_counter()
        setting = Setting(self.subject.own, self._cells(multiple), TIGHT_TOLERANCE)
        try:
            answer = self.subject.solve(setting)
        except cs.InvalidInput:
            if multiple >= RESOLVED_FROM:
                raise
            return
        self.walls[multiple] = perf_counter() - start
        self.solved[multiple] = answer
        if answer.status in FATAL_STATUSES and multiple >= RESOLVED_FROM:
            raise cs.InvalidInput(
                f"{self.subject.name} has no solution to compare: {failure_of(answer)}"
            )

    def _climb(self, is_needed: Callable[[int], bool], fraction: float) -> None:
        """Solve ever finer rungs that are needed, until the next one would take a fraction of the time left.

        The two coarsest rungs are solved in any case, and further coarse ones unless they take about half of that time.
        """
        if not self.solved:
            self._solve(MULTIPLES[0])  # warms up
        for multiple in MULTIPLES:
            is_coarse = multiple <= MULTIPLES[1] or (
                multiple <= COARSE_UP_TO
                and self.forecast(multiple) < NEXT_REFERENCE_FRACTION * self.budget.left
            )
            if not is_needed(multiple) or (not is_coarse and multiple <= max(self.solved)):
                continue
            expected = inf if is_coarse else self.forecast(multiple)
            costs = expected * (1 + self._bound_cost)
            if not is_coarse and costs > (1 + BOUND_COST) * fraction * self.budget.left:
                return
            if not self.subject.fits(self._cells(multiple)):
                self.notes.append("Finer grids do not fit into this machine's memory.")
                return
            if multiple not in self.solved or len(self.solved) == 1:
                self._solve(multiple)
                # a first solve of a size may compile, or was interrupted
                if self.walls.get(multiple, 0.0) > REPEAT_FACTOR * expected:
                    self._solve(multiple)

    @property
    def _bound_cost(self) -> float:
        """Cost of a bound over that of its answer."""
        return FILM_BOUND_COST if self.subject.scene.lubrication is not None else BOUND_COST

    def forecast(self, multiple: int) -> float:
        """Return the seconds to expect of a solve at the own boundary."""
        finest = max(self.solved)
        size = self._size(multiple) / self._size(finest)
        exponent = TIME_EXPONENTS[1]
        before = [m for m in self.solved if self._size(m) <= self._size(finest) / 3]
        if before:
            coarse = max(before)
            grown = log(self.walls[finest] / self.walls[coarse])
            exponent = grown / log(self._size(finest) / self._size(coarse))
        return float(
            self.walls[finest] * size ** min(max(exponent, TIME_EXPONENTS[0]), TIME_EXPONENTS[1])
        )

    def _size(self, multiple: int) -> int:
        return prod(self._cells(multiple))

    def _middle(self) -> int:
        """Return the finest rung on which all paddings can be solved in their fraction of the budget."""
        count = 2.0 * (len(self._candidates()) + len(TOLERANCES))
        affordable = [
            multiple
            for multiple in self.solved
            if not failure_of(self.solved[multiple])
            and count * self.walls[multiple] <= PADDINGS_FRACTION * self.budget.seconds
        ]
        if not affordable:
            return min(self.solved)
        return max(affordable)

    def _candidates(self) -> Sequence[cs.Padding | cs.Paddings]:
        """Return the paddings other than the own boundary."""
        scene_padding, is_line = self.subject.own, self.subject.unit[1] == 1
        if self.subject.is_free and label_of(scene_padding) != "free":
            return ()
        circular = [cs.CircularSuperposition(n) for n in CIRCULAR_IMAGES]
        if is_line:
            return (cs.ZeroPadding(), *circular)
        paddings: list[cs.Padding | cs.Paddings] = [
            cs.DuplicatedPadding(),
            *circular,
            *(cs.Superposition(n) for n in SUPERPOSED_IMAGES),
        ]
        if self.subject.is_free:
            return (cs.ExactPeriodicity(), *paddings)
        return (*paddings, cs.ZeroPadding())

    def _paddings(self, middle: int) -> list[PaddingError]:
        """Return what each padding alone does on the middle grid."""
        cells, reference = self._cells(middle), self.solved[middle]
        errors, omitted, refused, spent_before = [], [], dict[str, str](), self.budget.spent
        for padding in self._candidates():
            if self.budget.spent - spent_before > MAX_PADDINGS_FRACTION * self.budget.seconds:
                omitted.append(label_of(padding))
                continue
            try:
                answer = self.subject.solve(Setting(padding, cells, TIGHT_TOLERANCE))
            except cs.InvalidInput as error:  # an effect may not take this padding
                refused[label_of(padding)] = str(error)
                continue
            if not pressure_of(answer).any() or not np.isfinite(pressure_of(answer)).all():
                refused[label_of(padding)] = failure_of(answer)
                continue
            numbers = numbers_of(answer)
            changes = {
                name: numbers[name] / value - 1
                for name, value in numbers_of(reference).items()
                if value and name in numbers
            }
            errors.append(
                PaddingError(
                    padding, relative_l1(pressure_of(answer), pressure_of(reference)), changes
                )
            )
        if refused:
            reason = next(iter(refused.values()))
            self.notes.append(f"Left out: {'; '.join(refused)}. For the first: {reason}")
        if omitted:
            self.notes.append(
                f"Not compared, since the seconds did not suffice: {'; '.join(omitted)}."
            )
        self.log(f"paddings on {cells[0]} x {cells[1]} cells: {self.budget.spent:.0f} s")
        return errors

    def _tolerances(self, middle: int) -> dict[float, float]:
        """Return the error by each tolerance, on the middle grid."""
        cells, reference = self._cells(middle), self.solved[middle]
        answers = {
            tolerance: self._solved_to(Setting(self.subject.own, cells, tolerance))
            for tolerance in TOLERANCES
        }
        return {
            tolerance: relative_l1(pressure_of(answer), pressure_of(reference))
            for tolerance, answer in answers.items()
            if answer is not None
        }

    def _solved_to(self, setting: Setting) -> Answer | None:
        """Return the answer to a tolerance; None where the steps of the scene refuse a tolerance as loose."""
        try:
            return self.subject.solve(setting)
        except cs.InvalidInput:
            return None

    def _reference(self) -> tuple[int, dict[str, float]]:
        """Return the finest rung in which the others nest, and the bounds on its errors."""
        self._climb(
            lambda multiple: is_reference(multiple) and not self._is_fine_enough(), NEXT_FRACTION
        )
        reference = max(filter(is_reference, self.solved))
        bounds = bounds_of(self.solved[reference])
        if self._is_too_coarse(reference, bounds["pressure_l1"]):
            self._climb(is_reference, NEXT_REFERENCE_FRACTION)
            finer = max(filter(is_reference, self.solved))
            if finer > reference:
                reference, bounds = finer, bounds_of(self.solved[finer])
        cells = self._cells(reference)
        self.log(
            f"reference on {cells[0]} x {cells[1]} cells, bound {bounds['pressure_l1']:.2g}: {self.budget.spent:.0f} s"
        )
        if bounds["pressure_l1"] == inf:
            self.notes += last_of(self.solved[reference]).error.warnings[:1]
        if failure_of(self.solved[reference]):
            self.notes.append(f"The reference: {failure_of(self.solved[reference])}")
        return reference, bounds

    def _is_too_coarse(self, reference: int, bound: float) -> bool:
        """Return whether a reference's bound leaves too little of the request to the finest setting judged by it.

        Its error, on cells three times as large, lies between those on cells twice and four times as large.
        """
        true = pressure_of(self.solved[reference])
        errors = [
            relative_l1(pressure_of(self.solved[reference // part]), true)
            for part in (2, 4)
            if reference % part == 0 and reference // part in self.solved
        ]
        finest = prod(errors) ** (1 / len(errors)) if errors else 0.0
        return bound > TOO_COARSE_FRACTION * self.error or bound + finest > self.error

    def _is_fine_enough(self) -> bool:
        """Return whether the finest possible reference so far has a bound far below the request."""
        finest = max(filter(is_reference, self.solved), default=0)
        if finest not in self.bounds and finest:
            self.bounds[finest] = bounds_of(self.solved[finest])["pressure_l1"]
        return self.bounds.get(finest, inf) <= FINE_ENOUGH_FRACTION * self.error

    def _multiples(self, reference: int | None) -> Iterator[int]:
        """Yield the rungs that nest in the reference and are at most a third as fine; all for a closed form."""
        for multiple in MULTIPLES:
            if reference is not None:
                if multiple <= reference // 3 and reference % multiple == 0:
                    yield multiple
            elif (
                multiple in self.solved
                or self.forecast(multiple) < FINEST_FRACTION * self.budget.seconds
            ):
                yield multiple

    def _settings(self, reference: int | None, paddings: Sequence[PaddingError]) -> list[Measured]:
        """Return the whole settings with their errors and first times, which are taken in turns."""
        rungs: list[_Rung] = []
        for multiple in self._multiples(reference):
            # where a coarser answer has a bound, a finer one has
            rung = self._rung(multiple, is_bounded=any(measured.is_bounded for measured in rungs))
            rungs += [] if rung is None else [rung]
        scene_settings = self._solved(self.subject, self.subject.own, rungs, reference)
        least = min(
            (measured.error for measured in scene_settings if measured.is_bounded), default=inf
        )
        settings = scene_settings
        if self.subject.exact is not None and self.subject.unit[1] > 1:
            line = replace(self.subject, unit=(self.subject.unit[0], 1))
            settings = settings + self._solved(line, cs.ExactPeriodicity(), rungs, None, LINE)
        # first those of which one may be chosen
        untimed = []
        max_images = max(TIMED_IMAGES)
        short = any(
            measured.l1 > TOLERANCE_FRACTION * self.error
            for measured in paddings
            if getattr(measured.padding, "images", 0) == max_images
        )
        for measured in sorted(
            paddings,
            key=lambda measured: measured.l1 > max(MAX_PADDING_ERROR_FACTOR * least, self.error),
        ):
            images = getattr(measured.padding, "images", max_images)
            if images not in TIMED_IMAGES and not (short and images == max(CIRCULAR_IMAGES)):
                continue
            mean_time = (
                sum(measured.time for measured in settings)
                / max(1, len(scene_settings))
                * len(rungs)
            )
            if (1 + REPEATS) * mean_time > self.budget.left - ROUNDS_FRACTION * self.budget.seconds:
                untimed.append(label_of(measured.padding))
                continue
            settings = settings + self._solved(self.subject, measured.padding, rungs, reference)
        if untimed:
            self.notes.append(
                f"Not timed, since the seconds did not suffice: {'; '.join(untimed)}."
            )
        self.log(f"{len(settings)} settings solved: {self.budget.spent:.0f} s")
        turn_time = 1.2 * sum(measured.time for measured in settings)
        turns = in_rounds(
            [partial(self.subject.solve, measured.setting) for measured in settings],
            REPEATS,
            lambda: self.budget.left - ROUNDS_FRACTION / 2 * self.budget.seconds > turn_time,
        )
        return [
            replace(measured, seconds=tuple(turn[k] for turn in turns) or measured.seconds)
            for k, measured in enumerate(settings)
        ]

    def _rung(self, multiple: int, *, is_bounded: bool) -> "_Rung | None":
        """Return a rung with the loosest tolerance that suffices on it; None where it is too coarse to be solved."""
        if multiple not in self.solved:
            self._solve(multiple)
        if multiple not in self.solved:
            return None
        tight = self.solved[multiple]
        is_bounded = not failure_of(tight) and (
            is_bounded
            or self.subject.exact is not None
            or isfinite(bounds_of(tight)["pressure_l1"])
        )
        for tolerance in TOLERANCES:
            setting = Setting(self.subject.own, self._cells(multiple), tolerance)
            answer = self._solved_to(setting)
            if answer is None:
                continue
            error = relative_l1(pressure_of(answer), pressure_of(tight))
            if error <= TOLERANCE_FRACTION * self.error:
                return _Rung(multiple, tolerance, is_bounded)
        return _Rung(multiple, TIGHT_TOLERANCE, is_bounded)

    def _solved(
        self,
        subject: Subject,
        padding: cs.Padding | cs.Paddings,
        rungs: Sequence["_Rung"],
        reference: int | None,
        label: str = "",
    ) -> list[Measured]:
        """Return the settings of a padding on all rungs, with their errors."""
        rows, errors = list[Measured](), []
        for rung in rungs:
            setting = Setting(padding, cells_at(subject.unit, rung.multiple), rung.tolerance)
            seconds, answer = seconds_of(partial(subject.solve, setting))
            if rows:
                # a first solve of a size may compile, or was interrupted
                before = rows[-1]
                grown = prod(setting.cells) / prod(before.setting.cells)
                if seconds > REPEAT_FACTOR * grown * before.time:
                    seconds = min(seconds, seconds_of(partial(subject.solve, setting))[0])
            errors.append(self._error(answer, reference))
            is_bounded = rung.is_bounded and not failure_of(answer)
            rows.append(Measured(setting, label or label_of(padding), 0.0, is_bounded, (seconds,)))
        enveloped = with_envelope(errors)
        return [replace(row, error=error) for row, error in zip(rows, enveloped, strict=True)]

    def _error(self, answer: Answer, reference: int | None) -> float:
        """Return the relative L1 error of an answer against the reference."""
        if reference is not None:
            return relative_l1(pressure_of(answer), pressure_of(self.solved[reference]))
        hertz, shape = self.subject.exact, pressure_of(answer).shape
        assert hertz is not None
        grid = self.subject.grid((shape[0], shape[1]))
        return relative_l1(pressure_of(answer), hertz_means(hertz, grid))

    def _in_turns(self, measured: Comparison) -> Comparison:
        """Return the comparison with the times of its best settings, taken in turns."""
        meeting = measured.meeting(self.error)
        quickest = measured.quickest(self.error).values()
        close = [
            setting for setting in meeting if setting.time <= MAX_TIME_FACTOR * meeting[0].time
        ]
        front = (*measured.front(measured.own_label), *measured.front(LINE))
        ordered = {id(setting): setting for setting in (*quickest, *close)}
        chosen = list(
            {
                id(setting): setting for setting in (*list(ordered.values())[:MAX_SETTINGS], *front)
            }.values()
        )
        if not chosen:
            return measured
        round_time = sum(setting.time for setting in chosen)
        rounds = in_rounds(
            [partial(self.subject.solve, setting.setting) for setting in chosen],
            ROUNDS,
            lambda: self.budget.left > 1.2 * round_time,
        )
        if len(rounds) < ROUNDS:
            self.notes.append(
                f"The seconds sufficed for {len(rounds)} of {ROUNDS} rounds of times."
            )
        times = {id(setting): tuple(turn[k] for turn in rounds) for k, setting in enumerate(chosen)}
        settings = tuple(
            replace(setting, rounds=times.get(id(setting), ())) for setting in measured.settings
        )
        self.log(f"{len(rounds)} rounds of {len(chosen)} settings: {self.budget.spent:.0f} s")
        return replace(measured, settings=settings)
