"""Answers under a scene's own boundary conditions on ever finer nested grids, within a budget of seconds."""

from collections.abc import Callable
from dataclasses import dataclass, field
from math import inf, log, prod
from time import perf_counter, process_time

import contactstudy as cs
from studies.advice.compared_scene import (
    Answer,
    ComparedScene,
    Setting,
    bound_by_cells,
    bounds_of,
    failure_of,
    pressure_of,
)
from studies.advice.nested_grids import MULTIPLES, cells_at, is_reference
from studies.reference.line_contact import relative_l1

# Tolerance of the reference, and of what is compared on one grid.
TIGHT_TOLERANCE = 1e-8
# Statuses that finer cells do not change.
FATAL_STATUSES = (
    cs.Status.CONTACT_AT_EDGE,
    cs.Status.YIELD_AT_EDGE,
    cs.Status.NO_ADMISSIBLE_PRESSURE,
)
# Multiple of the unit from which on a solve that fails is no fault of too coarse a grid.
RESOLVED_FROM = 8
# Multiple of the unit up to which every grid is solved that is affordable: less is no reference for any setting.
COARSE_UP_TO = 6
# Fraction of the requested error at which the bound on the reference's own error needs no finer grid, and above which
# it is too large.
FINE_ENOUGH_FRACTION, TOO_COARSE_FRACTION = 0.02, 0.5
# Factor by which the error of the finest setting may be larger than it is expected from those of other grids.
FINEST_MARGIN = 1.5
# Exponent of the time over the cells, at least and at most.
TIME_EXPONENTS = 1.0, 1.3
# Fraction of the time left that the next solve and its bound may take, and that they may take where the reference is too
# coarse for the request.
NEXT_FRACTION, NEXT_REFERENCE_FRACTION = 0.22, 0.85
# Fraction of a budget that the first solve may take and still be repeated, since it compiles.
FIRST_FRACTION = 0.05
# Factor of the expected time above which a solve is repeated, if it took at most a fraction of the time left.
REPEAT_FACTOR, REPEAT_FRACTION = 3.0, 0.3
# Cost of a bound over that of its answer until one was taken: solutions on cells of twice the size, of a film three
# further ones.
BOUND_COST, FILM_BOUND_COST = 0.5, 2.0
# Factor by which a time may be longer than it was, and fraction of a budget that is kept for the last step.
MARGIN, SPARE_FRACTION = 1.2, 0.03


@dataclass
class Budget:
    """Wall time that a comparison may take.

    Attributes
    ----------
    seconds
        The time [s].
    start
        Its beginning, by ``perf_counter``, which may be earlier than the comparison.
    began
        Wall and processor time at which the comparison began, for `slowdown`.
    """

    seconds: float
    start: float = field(default_factory=perf_counter)
    began: tuple[float, float] = field(default_factory=lambda: (perf_counter(), process_time()))

    @property
    def spent(self) -> float:
        """Seconds since the start."""
        return perf_counter() - self.start

    @property
    def left(self) -> float:
        """Seconds left."""
        return self.seconds * (1 - SPARE_FRACTION) - self.spent

    @property
    def slowdown(self) -> float:
        """Wall time over processor time of the work so far, at least 1; more on a busy machine."""
        wall, processor = self.began
        return max(1.0, (perf_counter() - wall) / max(process_time() - processor, 1e-3))

    def allows(self, processor_time: float, kept: float = 0.0) -> bool:
        """Return whether work of a processor time [s] fits, with the fraction `kept` of the budget left for later.

        Its wall time is taken to be `slowdown` times as long.
        """
        return self.left - kept * self.seconds > MARGIN * self.slowdown * processor_time


@dataclass
class NestedAnswers:
    """Answers under the scene's own boundary conditions, with processor times [s], by multiples of the coarsest grid.

    They are for a requested relative L1 `error` within a `budget`; `notes` has a sentence for each thing that is to be
    known.
    """

    subject: ComparedScene
    error: float
    budget: Budget
    notes: list[str] = field(default_factory=list)
    answers: dict[int, Answer] = field(default_factory=dict)
    times: dict[int, float] = field(default_factory=dict)
    _bounds: dict[int, dict[str, float]] = field(default_factory=dict)
    # cost of a bound over that of its answer, as it was last
    _bound_cost: float | None = None

    def cells(self, multiple: int) -> tuple[int, int]:
        """Return the cells (across, along) of a grid."""
        return cells_at(self.subject.unit, multiple)

    def solve(self, multiple: int) -> None:
        """Solve on a grid, and store answer and time; nothing is stored for a grid that is too coarse for the scene.

        Raises :class:`~contactstudy.InvalidInput` for a scene without a solution on any finer grid.
        """
        start = process_time()
        setting = Setting(self.subject.boundary, self.cells(multiple), TIGHT_TOLERANCE)
        try:
            answer = self.subject.solve(setting)
        except cs.InvalidInput:
            if multiple >= RESOLVED_FROM:
                raise
            return
        self.times[multiple] = process_time() - start
        self.answers[multiple] = answer
        if answer.status in FATAL_STATUSES and multiple >= RESOLVED_FROM:
            raise cs.InvalidInput(
                f"{self.subject.name} has no solution to compare: {failure_of(answer)}"
            )

    def bounds(self, multiple: int) -> dict[str, float]:
        """Return the bounds on the errors of an answer by its cells and steps, by quantity."""
        if multiple not in self._bounds:
            start = process_time()
            self._bounds[multiple] = bounds_of(self.answers[multiple])
            self._bound_cost = (process_time() - start) / self.times[multiple]
        return self._bounds[multiple]

    def refine(self, is_needed: Callable[[int], bool], fraction: float = NEXT_FRACTION) -> None:
        """Solve ever finer grids that are needed, until the next one would take a fraction of the time left.

        The two coarsest grids are solved in any case, and further coarse ones unless they take most of that time.
        """
        if not self.answers:
            self.solve(MULTIPLES[0])  # warms up
            took = self.budget.slowdown * self.times.get(MULTIPLES[0], 0.0)
            if took < FIRST_FRACTION * self.budget.seconds:
                self.solve(MULTIPLES[0])
        for multiple in MULTIPLES:
            if multiple in self.answers or not is_needed(multiple):
                continue
            is_coarse = multiple <= COARSE_UP_TO
            if not is_coarse and multiple < max(self.answers, default=0):
                continue
            expected = self.forecast(multiple) if self.answers else 0.0
            fraction_of_budget = NEXT_REFERENCE_FRACTION if is_coarse else fraction
            costs = self.budget.slowdown * expected * (1 + self._cost_of_bound)
            if multiple > MULTIPLES[1] and costs > fraction_of_budget * self.budget.left:
                return
            if not self.subject.fits(self.cells(multiple)):
                self.notes.append("Finer grids do not fit into this machine's memory.")
                return
            self.solve(multiple)
            # a first solve of a size may compile
            took = self.times.get(multiple, 0.0)
            affordable = REPEAT_FRACTION * self.budget.left
            if took > REPEAT_FACTOR * expected > 0 and self.budget.slowdown * took < affordable:
                self.solve(multiple)

    @property
    def _cost_of_bound(self) -> float:
        """Cost of a bound over that of its answer."""
        if self._bound_cost is not None:
            return self._bound_cost
        return FILM_BOUND_COST if self.subject.scene.lubrication is not None else BOUND_COST

    def forecast(self, multiple: int) -> float:
        """Return the expected processor time [s] of a solve, extrapolated from two coarser grids by a power law."""
        sizes = {part: prod(self.cells(part)) for part in (*self.answers, multiple)}
        finest = max(self.answers)
        exponent = TIME_EXPONENTS[1]
        if before := [part for part in self.answers if sizes[part] <= sizes[finest] / 3]:
            coarse = max(before)
            grown = log(self.times[finest] / self.times[coarse])
            exponent = grown / log(sizes[finest] / sizes[coarse])
        exponent = min(max(exponent, TIME_EXPONENTS[0]), TIME_EXPONENTS[1])
        return float(self.times[finest] * (sizes[multiple] / sizes[finest]) ** exponent)

    def reference(self) -> int:
        """Return the multiple of the reference: the finest grid in which the others nest, fine enough if affordable."""
        self.refine(lambda multiple: is_reference(multiple) and not self._is_fine_enough())
        if self._is_too_coarse():
            self.refine(is_reference, NEXT_REFERENCE_FRACTION)
        return self._finest

    @property
    def _finest(self) -> int:
        """The finest grid that may be the reference."""
        return max(filter(is_reference, self.answers), default=max(self.answers))

    def _is_fine_enough(self) -> bool:
        """Return whether the finest possible reference so far has a bound far below the request."""
        if not any(map(is_reference, self.answers)):
            return False
        return self._bound_by_cells(self._finest) <= FINE_ENOUGH_FRACTION * self.error

    def _bound_by_cells(self, multiple: int) -> float:
        """Return the bound on the error of the pressure by the cells, which finer ones make smaller."""
        self.bounds(multiple)  # times what a bound costs
        return bound_by_cells(self.answers[multiple])

    def _is_too_coarse(self) -> bool:
        """Return whether a reference's bound leaves too little of the request to the finest setting judged by it.

        Its error, on cells three times as large, lies between those on cells twice and four times as large.
        """
        reference = self._finest
        bound, true = self._bound_by_cells(reference), pressure_of(self.answers[reference])
        errors = [
            relative_l1(pressure_of(self.answers[reference // part]), true)
            for part in (2, 4)
            if reference % part == 0 and reference // part in self.answers
        ]
        finest = FINEST_MARGIN * prod(errors) ** (1 / len(errors)) if errors else inf
        return bound > TOO_COARSE_FRACTION * self.error or bound + finest > self.error

    def seconds_for_settings(self) -> float:
        """Return the seconds that a reference with settings that nest in it would take, with its bound."""
        multiple = 3 * MULTIPLES[0]
        solve = self.budget.slowdown * self.forecast(multiple)
        return solve * (1 + self._cost_of_bound) / NEXT_REFERENCE_FRACTION


def seconds_left_for(budget: Budget, fraction: float) -> Callable[[], bool]:
    """Return a function that tells whether at most a fraction of the budget was spent since this call."""
    before = budget.spent
    return lambda: budget.spent - before <= fraction * budget.seconds
