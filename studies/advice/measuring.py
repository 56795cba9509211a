"""The comparison of a scene's settings within a budget: which padding, n, grid and tolerance.

Nested grids under the scene's own boundary conditions lead to a reference. Paddings and tolerances are compared on one
of them, where the discretisation error is the same and cancels, so that the numbers of solves add and do not multiply.
Whole settings, on grids that nest in the reference, are then timed in rounds.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from math import inf, isfinite, prod

from threadpoolctl import threadpool_limits

import contactstudy as cs
from contactstudy.domain.checks import positive
from studies.advice.compared_scene import (
    Answer,
    ComparedScene,
    Setting,
    failure_of,
    last_of,
    numbers_of,
    pressure_of,
    time_discretisation_error_of,
)
from studies.advice.comparison import (
    LINE,
    Comparison,
    MeasuredPadding,
    MeasuredSetting,
    label_of,
    with_envelope,
)
from studies.advice.nested_answers import (
    REPEAT_FACTOR,
    TIGHT_TOLERANCE,
    Budget,
    NestedAnswers,
    seconds_left_for,
)
from studies.advice.nested_grids import MULTIPLES, cells_at
from studies.advice.rounds import ROUNDS, timed_call, times_in_rounds
from studies.model.plain_text import Log
from studies.reference.line_contact import hertz_means, relative_l1

TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
# Fraction of the requested error that the tolerance may take.
TOLERANCE_FRACTION = 0.1
# Cells on which paddings and tolerances are compared, and those of one row.
COMPARISON_CELLS, COMPARISON_CELLS_1D = 2**14, 2**9
# Fractions of a budget: that the paddings on one grid are to take, after which no further one is compared since some
# take far longer than the scene's own padding, and the same for tolerances.
PADDINGS_FRACTION, MAX_PADDINGS_FRACTION, MAX_TOLERANCES_FRACTION = 0.12, 0.2, 0.08
# Fraction of the requested error that a bound by the steps in time may take without a word.
STEPS_FRACTION = 0.5
# Factor of the least error by the cells up to which a padding's own error is worth timing.
MAX_PADDING_ERROR_FACTOR = 20.0
# Turns in which every setting is timed before the rounds of the best: one time alone may be interrupted.
REPEATS = 3
# Settings of the last rounds, and how much slower than the quickest they may be; and those of the front.
MAX_SETTINGS, MAX_TIME_FACTOR, MAX_FRONT_FACTOR = 7, 2.0, 4.0
# Fraction of the budget that is kept for the rounds, and for the second half of them.
ROUNDS_FRACTION, HALF_ROUNDS_FRACTION = 0.3, 0.15
# Fraction of the budget that the finest grid may take where the reference is a closed form.
FINEST_FRACTION = 0.005
# Numbers of images that are compared on one grid, and those that are timed.
CIRCULAR_IMAGES, SUPERPOSED_IMAGES, TIMED_IMAGES = (1, 2, 4, 6, 10, 20), (1, 6, 20), (1, 6)


def compare_settings(
    subject: ComparedScene, error: float, budget: Budget, log: Log = lambda text: None
) -> Comparison:
    """Return the errors and times of a scene's settings, measured within a budget.

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
        return _Measurement(NestedAnswers(subject, error, budget), log).result()


@dataclass(frozen=True)
class _GridLevel:
    """A multiple of the unit, with the tolerance that suffices on it, and whether its answer has a bound."""

    multiple: int
    tolerance: float
    is_bounded: bool


@dataclass
class _Measurement:
    """Measurement of a scene's settings, step by step."""

    nested: NestedAnswers
    log: Log
    reference: int | None = None
    settings: list[MeasuredSetting] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.subject, self.error, self.budget = (
            self.nested.subject, self.nested.error, self.nested.budget
        )  # fmt: skip
        self.notes = self.nested.notes

    def result(self) -> Comparison:
        """Run all steps."""
        subject, nested = self.subject, self.nested
        self.notes += subject.notes
        max_cells = COMPARISON_CELLS if subject.unit[1] > 1 else COMPARISON_CELLS_1D
        nested.refine(lambda multiple: prod(nested.cells(multiple)) <= max_cells)
        multiple = self._comparison_multiple()
        paddings = self._paddings(multiple)
        tolerances = self._tolerances(multiple)
        bounds = self._bounds_of_reference() if subject.exact is None else {"pressure_l1": 0.0}
        reference_bound = bounds["pressure_l1"]
        self._settings(paddings, reference_bound)
        if not self.settings:
            self.notes.append(
                f"The budget is too short for grids that can be judged: give --seconds "
                f"{max(2 * self.budget.seconds, 2 * nested.seconds_for_settings()):.0f}."
            )
        comparison = Comparison(
            name=subject.name,
            text=subject.text,
            extent=subject.extent,
            boundary=subject.boundary,
            error=self.error,
            reference_bound=reference_bound,
            reference=None if self.reference is None else nested.cells(self.reference),
            bounds=bounds,
            paddings=tuple(paddings),
            paddings_on=nested.cells(multiple),
            tolerances=tolerances,
            settings=tuple(self.settings),
        )
        comparison = self._timed_in_rounds(comparison)
        spent, given = self.budget.spent, self.budget.seconds
        return replace(comparison, notes=tuple(self.notes), seconds=spent, budget=given)

    def _comparison_multiple(self) -> int:
        """Return the finest level on which all paddings can be solved in their fraction of the budget."""
        count = 2.0 * (len(self._candidates()) + len(TOLERANCES))
        affordable = [
            multiple
            for multiple, answer in self.nested.answers.items()
            if not failure_of(answer)
            and self.budget.slowdown * count * self.nested.times[multiple]
            <= PADDINGS_FRACTION * self.budget.seconds
        ]
        return max(affordable, default=min(self.nested.answers))

    def _candidates(self) -> Sequence[cs.Padding | cs.Paddings]:
        """Return the paddings other than the scene's own."""
        if self.subject.is_free and label_of(self.subject.boundary) != "free":
            return ()
        circular = [cs.CircularSuperposition(n) for n in CIRCULAR_IMAGES]
        if self.subject.unit[1] == 1:
            return (cs.ZeroPadding(), *circular)
        return (
            cs.ExactPeriodicity() if self.subject.is_free else cs.ZeroPadding(),
            cs.DuplicatedPadding(),
            *circular,
            *(cs.Superposition(n) for n in SUPERPOSED_IMAGES),
        )

    def _paddings(self, multiple: int) -> list[MeasuredPadding]:
        """Return the error of each padding alone, on the comparison grid."""
        cells, reference = self.nested.cells(multiple), self.nested.answers[multiple]
        errors, omitted, refused = [], [], dict[str, str]()
        has_time = seconds_left_for(self.budget, MAX_PADDINGS_FRACTION)
        for padding in self._candidates():
            if not has_time():
                omitted.append(label_of(padding))
                continue
            try:
                answer = self.subject.solve(Setting(padding, cells, TIGHT_TOLERANCE))
            except cs.InvalidInput as error:  # an effect may not take this padding
                refused[label_of(padding)] = str(error)
                continue
            is_zero = not pressure_of(answer).any()
            if why := failure_of(answer) or "its pressure is zero." * is_zero:
                refused[label_of(padding)] = why
                continue
            numbers = numbers_of(answer)
            changes = {
                name: numbers[name] / value - 1
                for name, value in numbers_of(reference).items()
                if value and name in numbers
            }
            l1 = relative_l1(pressure_of(answer), pressure_of(reference))
            errors.append(MeasuredPadding(padding, l1, changes))
        if refused:
            reason = next(iter(refused.values()))
            self.notes.append(f"Left out: {'; '.join(refused)}. For the first: {reason}")
        self._note("compared", omitted)
        self.log(f"paddings on {cells[0]} x {cells[1]} cells: {self.budget.spent:.0f} s")
        return errors

    def _note(self, what: str, omitted: Sequence[str]) -> None:
        """Note what was not done for lack of time."""
        if omitted:
            self.notes.append(
                f"Not {what}, because the budget of seconds was used up: {'; '.join(omitted)}."
            )

    def _tolerances(self, multiple: int) -> dict[float, float]:
        """Return the error by each tolerance, on the comparison grid, from the loosest."""
        has_time = seconds_left_for(self.budget, MAX_TOLERANCES_FRACTION)
        errors = {part: self._error_by(part, multiple) for part in TOLERANCES if has_time()}
        return {tolerance: error for tolerance, error in errors.items() if error is not None}

    def _error_by(self, tolerance: float, multiple: int) -> float | None:
        """Return the error by a tolerance on a level; None where the steps of the scene refuse a tolerance as loose."""
        setting = Setting(self.subject.boundary, self.nested.cells(multiple), tolerance)
        try:
            answer = self.subject.solve(setting)
        except cs.InvalidInput:
            return None
        return relative_l1(pressure_of(answer), pressure_of(self.nested.answers[multiple]))

    def _bounds_of_reference(self) -> dict[str, float]:
        """Find the reference, and return the bounds on its errors."""
        self.reference = self.nested.reference()
        answer, bounds = self.nested.answers[self.reference], self.nested.bounds(self.reference)
        cells = self.nested.cells(self.reference)
        bound = bounds["pressure_l1"]
        self.log(
            f"reference on {cells[0]} x {cells[1]} cells, bound {bound:.2g}: {self.budget.spent:.0f} s"
        )
        if bound == inf:
            self.notes += last_of(answer).error.warnings[:1]
        elif (steps := time_discretisation_error_of(answer)) > STEPS_FRACTION * self.error:
            self.notes.append(
                f"Of that bound {steps:.2g} is by the steps in time, which no grid makes smaller: give [time_steps] an "
                f"error of {STEPS_FRACTION * self.error:.1g}."
            )
        if failure_of(answer):
            self.notes.append(f"The reference: {failure_of(answer)}")
        return bounds

    def _multiples(self) -> Iterator[int]:
        """Yield the levels that nest in the reference, at most a third as fine; for a closed form those affordable."""
        for multiple in MULTIPLES:
            if self.reference is not None:
                if multiple <= self.reference // 3 and self.reference % multiple == 0:
                    yield multiple
            elif (
                multiple in self.nested.answers
                or self.nested.forecast(multiple) < FINEST_FRACTION * self.budget.seconds
            ):
                yield multiple

    def _settings(self, paddings: Sequence[MeasuredPadding], reference_bound: float) -> None:
        """Measure whole settings: the scene's own padding on all grids, others on the grid that suffices first."""
        levels: list[_GridLevel] = []
        for multiple in self._multiples():
            # where a coarser answer has a bound, a finer one has
            level = self._grid_level(multiple, is_bounded=any(level.is_bounded for level in levels))
            levels += [] if level is None else [level]
        if not levels:
            return
        own_settings = self._measure_padding(self.subject, self.subject.boundary, levels)
        bounded = [k for k, measured in enumerate(own_settings) if measured.is_bounded]
        enough = [
            k for k in bounded if own_settings[k].error + reference_bound <= self.error
        ] or bounded[-1:]
        near = slice(max(0, enough[0] - 1), enough[0] + 2) if enough else slice(None)
        least = min((own_settings[k].error for k in bounded), default=inf)
        worth_timing = max(MAX_PADDING_ERROR_FACTOR * least, self.error)
        candidates = [
            (self.subject, item.padding, label_of(item.padding))
            for item in sorted(paddings, key=lambda item: item.l1 > worth_timing)
            if self._is_timed(item, paddings)
        ]
        if self.subject.exact is not None and self.subject.unit[1] > 1:
            line = replace(self.subject, unit=(self.subject.unit[0], 1))
            candidates.insert(0, (line, cs.ExactPeriodicity(), LINE))
        times = {
            level.multiple: item.time for level, item in zip(levels, own_settings, strict=True)
        }
        outside = [level for level in levels if level not in levels[near]]
        untimed: list[str] = []
        for part in (levels[near], outside):
            for subject, padding, label in candidates:
                # with the turns that follow, and one half slower than the scene's own padding
                cost = 1.5 * (1 + REPEATS) * sum(times[level.multiple] for level in part)
                if label in untimed or not self.budget.allows(cost, ROUNDS_FRACTION):
                    untimed += [label] * (part is not outside)
                    continue
                self._measure_padding(subject, padding, part, label)
        self._note("timed", untimed)
        self.log(f"{len(self.settings)} settings solved: {self.budget.spent:.0f} s")
        self.settings = self._enveloped()
        turn_time = sum(measured.time for measured in self.settings)
        turns = times_in_rounds(
            [partial(self.subject.solve, measured.setting) for measured in self.settings],
            REPEATS,
            lambda: self.budget.allows(turn_time, HALF_ROUNDS_FRACTION),
        )
        self.settings = [
            replace(measured, seconds=tuple(turn[k] for turn in turns) or measured.seconds)
            for k, measured in enumerate(self.settings)
        ]

    def _is_timed(self, item: MeasuredPadding, paddings: Sequence[MeasuredPadding]) -> bool:
        """Return whether a padding is timed: without an n, with a small one, or with the largest if that is needed."""
        images = getattr(item.padding, "images", 0)
        longest = [
            part for part in paddings if getattr(part.padding, "images", 0) == max(TIMED_IMAGES)
        ]
        is_short = any(part.l1 > TOLERANCE_FRACTION * self.error for part in longest)
        return images in (0, *TIMED_IMAGES) or (is_short and images == max(CIRCULAR_IMAGES))

    def _grid_level(self, multiple: int, *, is_bounded: bool) -> _GridLevel | None:
        """Return a level with the loosest tolerance that suffices on it; None where it is too coarse to be solved."""
        nested = self.nested
        if multiple not in nested.answers:
            nested.solve(multiple)
        if multiple not in nested.answers:
            return None
        is_bounded = not failure_of(nested.answers[multiple]) and (
            is_bounded
            or self.subject.exact is not None
            or isfinite(nested.bounds(multiple)["pressure_l1"])
        )
        for tolerance in TOLERANCES:
            if not self.budget.allows(nested.times[multiple]):
                break
            error = self._error_by(tolerance, multiple)
            if error is not None and error <= TOLERANCE_FRACTION * self.error:
                return _GridLevel(multiple, tolerance, is_bounded)
        return _GridLevel(multiple, TIGHT_TOLERANCE, is_bounded)

    def _measure_padding(
        self,
        subject: ComparedScene,
        padding: cs.Padding | cs.Paddings,
        levels: Sequence[_GridLevel],
        label: str = "",
    ) -> list[MeasuredSetting]:
        """Measure a padding on some levels, and return its settings, each with its own error."""
        rows = list[MeasuredSetting]()
        for level in levels:
            setting = Setting(padding, cells_at(subject.unit, level.multiple), level.tolerance)
            seconds, answer = timed_call(partial(subject.solve, setting))
            if rows:
                # a first solve of a size may compile, or was interrupted
                before = rows[-1]
                grown = prod(setting.cells) / prod(before.setting.cells)
                if seconds > REPEAT_FACTOR * grown * before.time:
                    seconds = min(seconds, timed_call(partial(subject.solve, setting))[0])
            name, is_bounded = (
                label or label_of(padding),
                level.is_bounded and not failure_of(answer),
            )
            rows.append(MeasuredSetting(setting, name, self._error(answer), is_bounded, (seconds,)))
        self.settings += rows
        return rows

    def _enveloped(self) -> list[MeasuredSetting]:
        """Return the settings by padding and cells, with the largest error of each and any finer grid of its padding."""
        enveloped: list[MeasuredSetting] = []
        for label in dict.fromkeys(measured.label for measured in self.settings):
            line = [measured for measured in self.settings if measured.label == label]
            line.sort(key=lambda measured: prod(measured.setting.cells))
            errors = with_envelope([measured.error for measured in line])
            enveloped += [
                replace(measured, error=error) for measured, error in zip(line, errors, strict=True)
            ]
        return enveloped

    def _error(self, answer: Answer) -> float:
        """Return the relative L1 error of an answer against the reference."""
        pressure, hertz = pressure_of(answer), self.subject.exact
        if self.reference is not None:
            return relative_l1(pressure, pressure_of(self.nested.answers[self.reference]))
        assert hertz is not None
        grid = self.subject.grid((pressure.shape[0], pressure.shape[1]))
        return relative_l1(pressure, hertz_means(hertz, grid))

    def _timed_in_rounds(self, comparison: Comparison) -> Comparison:
        """Return the comparison with the times of its best settings, taken in turns."""
        meeting = comparison.settings_meeting(self.error)
        quickest = comparison.quickest_by_padding(self.error).values()
        front = [*comparison.front(comparison.boundary_label), *comparison.front(LINE)]
        close = [item for item in meeting if item.time <= MAX_TIME_FACTOR * meeting[0].time]
        longest = MAX_FRONT_FACTOR * meeting[0].time if meeting else inf
        best = list({id(item): item for item in (*quickest, *close)}.values())[:MAX_SETTINGS]
        chosen = list({id(item): item for item in (*best, *front) if item.time <= longest}.values())
        if not chosen:
            return comparison
        round_time = sum(setting.time for setting in chosen)
        rounds = times_in_rounds(
            [partial(self.subject.solve, setting.setting) for setting in chosen],
            ROUNDS,
            lambda: self.budget.allows(round_time),
        )
        if len(rounds) < ROUNDS:
            self.notes.append(
                f"The budget of seconds allowed {len(rounds)} of {ROUNDS} rounds of times."
            )
        times = {id(setting): tuple(turn[k] for turn in rounds) for k, setting in enumerate(chosen)}
        settings = tuple(
            replace(setting, rounds=times.get(id(setting), ())) for setting in comparison.settings
        )
        self.log(f"{len(rounds)} rounds of {len(chosen)} settings: {self.budget.spent:.0f} s")
        return replace(comparison, settings=settings)
