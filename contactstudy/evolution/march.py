"""One step in time: a bare problem made from a scene's memories, solved from the pressure before."""

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from math import log2, sqrt

import numpy as np

from contactstudy.domain.checks import InvalidInput
from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid
from contactstudy.elasticity.coefficients import Coefficients
from contactstudy.elasticity.convolution import Convolution, combined, superposed
from contactstudy.evolution.memory import (
    Contribution,
    JointMemory,
    Kept,
    Memory,
    State,
    Step,
)
from contactstudy.evolution.steps import Scheme
from contactstudy.problem.constraint import PrescribedLoad
from contactstudy.problem.problem import Problem, Scales, Source
from contactstudy.scene.load import ChangingLoad
from contactstudy.solvers.solution import Solution, Status
from contactstudy.solvers.solve import SolveOptions

# A contact is solved to this share of the tolerance where something is found together with it, which sees its error.
CLOSER = 0.01
# A step without stages.
WHOLE = ((1.0, 0.0),)


@dataclass(frozen=True, eq=False)
class Instant:
    """A contact at ``time`` [s] under ``load`` [N/m]: its ``pressure`` (x, y) [Pa] and what is kept, by memory."""

    time: float
    load: float
    pressure: Array
    states: tuple[State, ...]


def solved_or_unloaded(
    options: SolveOptions, problem: Problem, start: Array | None = None, share: float = 1.0
) -> Solution:
    """Return the solution from a pressure (x, y) [Pa], to a `share` of the tolerance; without load, as it is."""
    if problem.resultant.uniform(1) == 0:
        return unloaded(problem)
    begin = start if start is not None and start.any() else None
    return replace(options, tolerance=share * options.tolerance).solved(problem, begin)


@dataclass(eq=False)
class LoweredContact:
    """The contact of ``problem`` over a surface that is lowered, solved from the pressure found ``last``."""

    problem: Problem
    options: SolveOptions
    last: Array

    def __call__(self, lift: Array) -> Solution:
        """Over a surface that is lowered by ``lift`` (x, y) [m]."""
        solution = solved_or_unloaded(self.options, lowered(self.problem, lift), self.last, CLOSER)
        self.last = solution.pressure
        return solution


@dataclass(frozen=True, eq=False)
class March:
    """The steps of one scene on one grid under a changing ``load``.

    ``problem`` is that of the largest load, applied suddenly before anything has changed; ``weights`` [1/Pa] are
    those of the coefficients in its operator. ``joint`` is found together with the pressure.
    """

    problem: Problem
    load: ChangingLoad
    weights: Mapping[Coefficients, float]
    memories: tuple[Memory, ...]
    joint: JointMemory | None
    scheme: Scheme
    options: SolveOptions

    @property
    def kept(self) -> tuple[Kept, ...]:
        """All that is kept, in the order of an instant's states."""
        return self.memories if self.joint is None else (*self.memories, self.joint)

    @property
    def is_first_order(self) -> bool:
        """Whether the error of a step falls only like its duration."""
        return len(self.scheme.stages) == 1 and any(one.has_stages for one in self.memories)

    def start(self, time: float) -> Instant:
        """Before the first load."""
        shape = self.problem.grid.cells
        states = tuple(memory.start(shape) for memory in self.kept)
        return Instant(time, 0.0, np.zeros(shape), states)

    def at_rest(self) -> Solution:
        """The bodies as they just touch, before the first load."""
        return unloaded(self.problem)

    def jump(
        self, instant: Instant, load: float, parts: int, onset: int
    ) -> tuple[Instant, list[Solution]]:
        """To another ``load`` [N/m] at once, by so many equal ``parts``."""
        solutions: list[Solution] = []
        first = instant.load
        for part in range(1, parts + 1):
            target = load if part == parts else first + (load - first) * part / parts
            instant, found = self.advance(instant, instant.time, target, onset)
            solutions += found
        return instant, solutions

    def advance(
        self, instant: Instant, end: float, load: float, onset: int = 0
    ) -> tuple[Instant, list[Solution]]:
        """To the time ``end`` [s], where the ``load`` is known, with all solutions on the way.

        A step in which bodies start to yield has an error that no step twice as long shows, if they do not yield in its
        first half, or hardly do. So an abrupt step is halved, and its halves again, up to ``onset`` times.
        """
        after, solutions = self._step(instant, end, load)
        joint = self.joint
        if not onset or joint is None or not joint.abrupt(instant.states[-1], after.states[-1]):
            return after, solutions
        time = (instant.time + end) / 2
        half = self.load.at(time) if instant.time < end else (instant.load + load) / 2
        middle, first = self.advance(instant, time, half, onset - 1)
        after, second = self.advance(middle, end, load, onset - 1)
        return after, solutions + first + second

    def _step(self, instant: Instant, end: float, load: float) -> tuple[Instant, list[Solution]]:
        start, duration = instant.time, end - instant.time
        if duration == 0:
            return self._stage(instant, Step(end, end, (instant.load, load), load))
        solutions: list[Solution] = []
        stages = self.scheme.stages if any(m.has_stages for m in self.kept) else WHOLE
        share = 0.0
        for part, explicit in stages:
            share += part
            last = len(solutions) == len(stages) - 1
            time = end if last else start + share * duration
            loads = instant.load, load if last else self.load.at(time)
            step = Step(instant.time, time, loads, self.load.mean(instant.time, time), explicit)
            instant, found = self._stage(instant, step)
            solutions += found
        return instant, solutions

    def _stage(self, instant: Instant, step: Step) -> tuple[Instant, list[Solution]]:
        problem = self._problem_at_end(instant, step)
        joint: tuple[State, ...] = ()
        if self.joint is not None:
            contact = LoweredContact(problem, self.options, instant.pressure)
            solution, state = self.joint.settled(
                instant.states[-1], problem, contact, self.options.tolerance
            )
            joint = (state,)
        else:
            solution = solved_or_unloaded(self.options, problem, instant.pressure)
        after = solution.pressure
        states = tuple(
            memory.advance(state, instant.pressure, after, step)
            for memory, state in zip(self.memories, instant.states, strict=False)
        )
        return Instant(step.end, step.loads[1], after, states + joint), [solution]

    def _problem_at_end(self, instant: Instant, step: Step) -> Problem:
        contributions = [
            memory.contribution(state, instant.pressure, step)
            for memory, state in zip(self.memories, instant.states, strict=False)
        ]
        weights = Counter(self.weights)
        for one in contributions:
            weights.update(one.compliance)
        own = sum(one.own for one in contributions)
        problem = self._with(weights, own, step.loads[1], self.problem)
        source = self.problem.source
        if source is not None:
            source = StepSource(source, partial(self._with, weights, own, step.loads[1]))
        return replace(problem, undeformed_gap=self._gap(contributions), source=source)

    def _with(
        self, weights: Mapping[Coefficients, float], own: float, load: float, problem: Problem
    ) -> Problem:
        """Return a ``problem`` of the largest load, on any grid, with a step's operator and ``load`` [N/m]."""
        grid = problem.grid
        softer = sum(weights.values()) / sum(self.weights.values())
        return replace(
            problem,
            operator=self._operator(problem, weights, own),
            resultant=PrescribedLoad(load * grid.period / grid.cell_area),
            scales=self._scales(load, softer) if load else problem.scales,
        )

    def _gap(self, contributions: Iterable[Contribution]) -> Array:
        gap = self.problem.undeformed_gap
        strains: dict[Coefficients, Array] = {}
        for one in contributions:
            if one.gap is not None:
                gap = gap + one.gap
            for coefficients, field in one.strained.items():
                strains[coefficients] = strains.get(coefficients, 0.0) + field
        for coefficients, strain in strains.items():
            if strain.any():
                gap = gap + self._units[coefficients](strain)
        return gap

    def _operator(
        self, problem: Problem, weights: Mapping[Coefficients, float], own: float
    ) -> Convolution:
        operator = problem.operator
        assert isinstance(operator, Convolution)
        if weights == self.weights:
            return combined([(1.0, operator)], own) if own else operator
        units = self._units if problem is self.problem else self._units_of(problem)
        return combined(((weight, units[one]) for one, weight in weights.items()), own)

    @cached_property
    def _units(self) -> Mapping[Coefficients, Convolution]:
        return self._units_of(self.problem)

    def _units_of(self, problem: Problem) -> Mapping[Coefficients, Convolution]:
        """Return an operator on the grid of ``problem`` for each kind of coefficients [m]."""
        if len(self.weights) == 1:
            ((coefficients, weight),) = self.weights.items()
            assert isinstance(problem.operator, Convolution)
            return {coefficients: combined([(1 / weight, problem.operator)])}
        if problem.paddings is None:
            raise InvalidInput("Problem.paddings is None: give those of the two axes.")
        return {
            coefficients: superposed({coefficients: 1.0}, problem.grid, problem.paddings)
            for coefficients in self.weights
        }

    def _scales(self, load: float, softer: float) -> Scales:
        """Those of a contact under ``load`` that is ``softer`` by a factor.

        A curved contact grows like the root of both, a flat one stays as wide as it is.
        """
        scales = self.problem.scales
        ratio = load / self.load.largest
        if scales.length < self.problem.grid.extent[0]:
            length, pressure = sqrt(ratio * softer), sqrt(ratio / softer)
        else:
            length, pressure = 1.0, ratio
        pressure = 2.0 ** round(log2(scales.pressure * pressure))
        return Scales(scales.length * length, pressure, scales.gap * ratio * softer)


@dataclass(frozen=True)
class StepSource:
    """The heights of a scene, and its problem on another grid as a step has it, but for what memories add to the gap."""

    source: Source
    step: Callable[[Problem], Problem]

    @property
    def finest(self) -> tuple[float, float]:
        """The shortest lengths (across, along) over which the heights change [m]."""
        return self.source.finest

    @property
    def names_scales(self) -> bool:
        """Whether ``finest`` is known of every shape."""
        return self.source.names_scales

    @property
    def ends_along(self) -> bool:
        """Whether a body ends along the length."""
        return self.source.ends_along

    def gap(self, grid: Grid) -> Array:
        """Return the undeformed gap [m] on ``grid``."""
        return self.source.gap(grid)

    def gap_without_scales(self, grid: Grid) -> Array:
        """Return the gap [m] on ``grid`` of the shapes that name no scales."""
        known: Callable[[Grid], Array] = getattr(self.source, "gap_without_scales", self.source.gap)
        return known(grid)

    def problem(self, grid: Grid) -> Problem:
        """Return the problem of the step on ``grid``."""
        return self.step(self.source.problem(grid))


def lowered(problem: Problem, lift: Array) -> Problem:
    """``problem`` with its surface lowered by ``lift`` (x, y) [m]."""
    return replace(problem, undeformed_gap=problem.undeformed_gap + lift)


def unloaded(problem: Problem) -> Solution:
    """Bodies that just touch."""
    gap = problem.undeformed_gap
    nothing = np.zeros_like(gap)
    approach = float(gap.min())
    return Solution(
        problem=problem,
        pressure=nothing,
        displacement=nothing.copy(),
        gap=gap - approach,
        approach=approach,
        status=Status.CONVERGED,
        iterations=0,
        convolutions=0.0,
        residual=0.0,
    )


def worst(statuses: Sequence[Status]) -> Status:
    """The first in the order in which they matter, most serious first."""
    order = (Status.NOT_FINITE, Status.NO_ADMISSIBLE_PRESSURE, Status.NOT_CONVERGED, Status.STALLED,
             Status.ITERATION_LIMIT, Status.PRECISION_LIMIT, Status.CONTACT_AT_EDGE, Status.YIELD_AT_EDGE,
             Status.CONVERGED)  # fmt: skip
    return min(statuses, key=order.index, default=Status.CONVERGED)
