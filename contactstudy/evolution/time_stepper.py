"""One step in time of a dry contact: the problem that its state variables make of it, and their update.

A state variable is what a body or an interface keeps from one instant to the next: retarded pressures of creep, the
depth of wear, the tangential traction of fretting, plastic strain. Each adds to the gap or to the operator of the
contact at the end of a step, which is solved from the pressure before; the state at the end follows from both
pressures. Plastic strain is coupled: it is solved for together with the pressure. Lengths of steps and their errors are
in ``evolve``.
"""

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial
from math import inf, log2, sqrt
from typing import TYPE_CHECKING, Any

import numpy as np

from contactstudy.domain.device import Cpu
from contactstudy.domain.grid import Array, on_cells
from contactstudy.elasticity.coating import WithWinklerLayer
from contactstudy.elasticity.convolution import Coefficients, Convolution, superposed, weighted_sum
from contactstudy.elasticity.viscoelastic import Creep
from contactstudy.evolution.march import STAGES, MarchState, Scheme
from contactstudy.evolution.states.state_variables import (
    Contribution,
    CreepState,
    FrettingState,
    State,
    Step,
    WarmStartedContact,
    WearState,
    solved_or_unloaded,
    with_added_gap,
)
from contactstudy.problem.constraint import PrescribedLoad
from contactstudy.problem.problem import Problem, Scales
from contactstudy.scene.loads import ChangingLoad
from contactstudy.scene.shapes.shape import ShapesSource
from contactstudy.solvers.coulomb import FullSliding
from contactstudy.solvers.solution import AdhesiveTraction, Solution, Status, TangentialTraction, net_pressure, unloaded
from contactstudy.solvers.solve import SolveOptions

if TYPE_CHECKING:  # imported only for scenes with a body that yields
    from contactstudy.evolution.states.plastic import PlasticState

StateVariable = CreepState | WearState | FrettingState
# Most contacts that a step with plastic strain beside an attraction solves, each with the limit of iterations: 3 to 13
# were solved in 36 steps.
CONTACTS_PER_COUPLED_STEP = 30
# Most iterations of a step between the contact and the slip that wears it: 3 to 8 were taken in 69 steps.
MAX_FIXED_POINT_ITERATIONS = 30
# The stage of a step without sliding wear, in the form of `STAGES`: all of the step, implicit.
SINGLE_STAGE = ((1.0, 0.0),)


@dataclass(frozen=True, eq=False, kw_only=True)
class Instant(MarchState):
    """A dry contact at one time, with the state of every state variable.

    Attributes
    ----------
    load
        Load [N/m].
    pressure
        Pressure (x, y) [Pa].
    states
        State of each state variable, in the order of :attr:`TimeStepper.all_state_variables`.
    adhesion
        Adhesive traction, from which the next contact continues; None without adhesion, and before the first contact.
    max_halvings
        How often a step from here may be halved, see :meth:`TimeStepper.advance`.
    """

    load: float
    pressure: Array
    states: tuple[State, ...]
    adhesion: AdhesiveTraction | None = None
    max_halvings: int = 0

    @property
    def net_pressure(self) -> Array:
        """Pressure (x, y) [Pa] less the attraction, which drives the state variables."""
        return net_pressure(self.pressure, self.adhesion)

    def without_solutions(self) -> "Instant":
        """Return this instant without the contacts of the step that led to it."""
        return replace(self, contacts=(), replaced=())

    def after(self, before: "Instant", *replaced: Solution) -> "Instant":
        """Return this instant with the contacts that led to the instant `before` too, and with those `replaced`."""
        contacts, replaced = before.contacts + self.contacts, replaced + before.replaced + self.replaced
        return replace(self, contacts=contacts, replaced=replaced)


@dataclass(frozen=True, eq=False)
class TimeStepper:
    """Steps in time of one scene on one grid.

    Attributes
    ----------
    problem
        The contact under the largest load, applied suddenly before any state variable has changed.
    load
        Load [N/m] over time.
    loaded_length
        Length [m] on which the load acts.
    weights
        Weights [1/Pa] of the influence coefficients in the operator of the problem.
    state_variables
        State variables whose update follows from the pressures at both ends of a step. The traction of fretting is the
        last; no body yields beside it.
    coupled
        Plastic strain, which is solved for together with the pressure; None if no body yields.
    scheme
        Scheme of a step with sliding wear, whose stages are in `STAGES`; other steps have a single implicit stage.
    options
        How each contact is solved.
    """

    problem: Problem
    load: ChangingLoad
    loaded_length: float
    weights: Mapping[Coefficients, float]
    state_variables: tuple[StateVariable, ...]
    coupled: "PlasticState | None"
    scheme: Scheme
    options: SolveOptions

    @property
    def all_state_variables(self) -> "tuple[StateVariable | PlasticState, ...]":
        """Every state variable of the scene, in the order of an instant's states."""
        coupled = () if self.coupled is None else (self.coupled,)
        return (*self.state_variables, *coupled)

    def is_half_order(self, step: float) -> bool:
        """Return whether the order after a `step` [s] may be 1/2, as where wear begins, by wear, slip or stiff creep."""
        return self._wears or self.fretting is not None or self.creep_ends_within(step)

    @property
    def _wears(self) -> bool:
        """True if a body wears by sliding, whose steps the stages of a scheme make more accurate."""
        return any(isinstance(variable, WearState) for variable in self.state_variables)

    def creep_ends_within(self, step: float) -> bool:
        """Return whether a retardation time of a body is shorter than a `step` [s]."""
        return any(time < step for creep in self._creeps for _, time in creep.terms)

    @property
    def longest_retardation_time(self) -> float:
        """Longest retardation time of the bodies [s]; infinite if one flows, or none creeps."""
        times = [time for creep in self._creeps for _, time in creep.terms]
        flows = any(creep.fluidity for creep in self._creeps)
        return inf if flows else max(times, default=inf)

    @property
    def _creeps(self) -> list[Creep]:
        """Creep functions of the bodies."""
        return [variable.creep for variable in self.state_variables if isinstance(variable, CreepState)]

    @property
    def depends_on_path(self) -> bool:
        """True if a state depends on every turn of the load, as plastic strain and the traction of fretting do."""
        return self.coupled is not None or self.fretting is not None

    @property
    def fretting(self) -> FrettingState | None:
        """State variable of the tangential traction of a contact that frets; None of others."""
        last = self.state_variables[-1] if self.state_variables else None
        return last if isinstance(last, FrettingState) else None

    def traction(self, instant: Instant) -> TangentialTraction | None:
        """Return the tangential traction of a contact that frets, or of full sliding; None without friction."""
        if self.fretting is not None:
            return self.fretting.traction(instant.states[-1])
        friction = self.problem.friction
        return friction.traction(instant.pressure) if isinstance(friction, FullSliding) else None

    def start(self, time: float) -> Instant:
        """Return the instant before the first load, at `time` [s]."""
        shape = self.problem.grid.cells
        states = tuple(state_variable.start(shape) for state_variable in self.all_state_variables)
        return Instant(time=time, load=0.0, pressure=np.zeros(shape), states=states)

    def jump(self, instant: Instant, increments: int) -> Instant:
        """Return the contact after the jump of the load at an `instant`, in so many equal load increments."""
        load = self.load.at(instant.time)
        last = instant.without_solutions()
        for increment in range(1, increments + 1):
            between = instant.load + (load - instant.load) * increment / increments
            target = load if increment == increments else between
            last = self.advance(last, instant.time, target, instant.max_halvings).after(last)
        return last

    def step(self, instant: Instant, end: float) -> Instant:
        """Return the contact at the time `end` [s], before any jump of the load there."""
        return self.advance(instant, end, self.load.before(end), instant.max_halvings)

    def advance(self, instant: Instant, end: float, load: float, max_halvings: int) -> Instant:
        """Return the contact at the time `end` [s], where the load is `load` [N/m]; without duration it is a jump.

        A step in which bodies start to yield may have an error that a step twice as long does not show, because they
        hardly yield in its first half. So such a step is halved, and its halves again, up to `max_halvings` times.
        """
        after = self._stages(instant, end, load)
        coupled = self.coupled
        if not max_halvings or coupled is None or not coupled.has_onset_of_yield(instant.states[-1], after.states[-1]):
            return after
        time = (instant.time + end) / 2
        half = self.load.at(time) if instant.time < end else (instant.load + load) / 2
        middle = self.advance(instant, time, half, max_halvings - 1)
        last = self.advance(middle, end, load, max_halvings - 1)
        return last.after(middle, *after.contacts, *after.replaced)

    def _stages(self, instant: Instant, end: float, load: float) -> Instant:
        """Return the contact after the stages of one step to `end` [s], where the load is `load` [N/m]."""
        start, duration = instant.time, end - instant.time
        if duration == 0:
            return self._stage(instant, Step(end, end, (instant.load, load), load))
        stages = STAGES[self.scheme] if self._wears else SINGLE_STAGE
        fraction, last = 0.0, instant.without_solutions()
        for number, (part, explicit) in enumerate(stages, start=1):
            fraction += part
            is_end = number == len(stages)
            time = end if is_end else start + fraction * duration
            loads = last.load, load if is_end else self.load.at(time)
            step = Step(last.time, time, loads, self.load.mean(last.time, time), explicit)
            last = self._stage(last, step).after(last)
        return last

    def _stage(self, instant: Instant, step: Step) -> Instant:
        """Solve the contact at the end of one stage, and advance every state variable.

        Where slip wears, contact and slip are iterated to a fixed point: the state of fretting before the stage holds
        the slip of the last iterate, from which the contact takes its wear.
        """
        coupled: tuple[State, ...] = ()
        solutions: list[Solution] = []
        has_converged = True
        while True:
            problem = self._problem_at_end(instant, step)
            last = solutions[-1].pressure if solutions else instant.pressure
            if self.coupled is not None:
                before = instant.states[-1]
                solution, state = self._coupled_step(self.coupled, before, problem, last)
                coupled = (state,)
            else:
                solution = solved_or_unloaded(self.options, problem, last)
            solutions.append(solution)
            net = net_pressure(solution.pressure, solution.adhesion)
            states = tuple(
                state_variable.update(state, instant.net_pressure, net, step)
                for state_variable, state in zip(self.state_variables, instant.states, strict=False)
            )
            if self.fretting is None:
                break
            *others, guess = instant.states
            better = self.fretting.next_iterate(guess, states[-1], self.options.tolerance)
            has_converged = better is guess
            if has_converged or len(solutions) == MAX_FIXED_POINT_ITERATIONS:
                break
            instant = replace(instant, states=(*others, better))
        if self.coupled is not None:
            parts = zip(self.state_variables, instant.states, states, strict=False)
            for variable, before, after in parts:
                if isinstance(variable, WearState):
                    depth = after["wear_depth"] - before["wear_depth"]
                    coupled = (self.coupled.worn(coupled[0], variable.body, depth),)
        if not has_converged and solution.status.has_converged:
            solution = replace(solution, status=Status.NOT_CONVERGED)
        if self.fretting is not None and solution.status.has_converged:
            status, residual = self.fretting.outcome(states[-1])
            if status is not Status.CONVERGED:
                solution = replace(solution, status=status, residual=residual)
        return Instant(
            time=step.end,
            load=step.loads[1],
            pressure=solution.pressure,
            states=states + coupled,
            adhesion=solution.adhesion,
            contacts=(solution,),
            replaced=tuple(solutions[:-1]),
            change=0.0 if np.isfinite(solution.residual) else inf,
            max_halvings=instant.max_halvings,
        )

    def _coupled_step(
        self, coupled: "PlasticState", state: State, problem: Problem, pressure: Array
    ) -> tuple[Solution, State]:
        """Return the contact and the plastic strain at the end of a step; an attraction is iterated around both.

        Parameters
        ----------
        coupled
            The state variable.
        state
            Plastic strain before the step, as arrays by name.
        problem
            The contact at the end of the step, without the residual displacement of the plastic strain.
        pressure
            Pressure (x, y) [Pa] to begin with.
        """
        tolerance = self.options.tolerance
        if problem.adhesion is None:
            contact = WarmStartedContact(problem, self.options, pressure)
            solution, after, _ = coupled.solve_step(state, contact, tolerance)
            return solution, after
        after = state

        def solve_under(
            frozen: Problem, attraction: Array, options: SolveOptions, start: Array | None
        ) -> tuple[Solution, float]:
            nonlocal after
            contact = WarmStartedContact(frozen, options, pressure if start is None else start)
            solution, after, energy = coupled.solve_step(state, contact, options.tolerance, attraction, after)
            return solution, energy

        start = pressure if pressure.any() else None
        solver: Any = problem.adhesion
        limit = CONTACTS_PER_COUPLED_STEP * self.options.max_iterations
        options = replace(self.options, max_iterations=limit)
        solution = solver.solve(problem, options, start, Cpu(), solve_under)
        if not solution.pressure.any():  # the bodies came apart

            def separated(added_gap: Array) -> Solution:
                return unloaded(with_added_gap(problem, added_gap))

            after = coupled.solve_step(state, separated, tolerance).state
        return solution, after

    def _problem_at_end(self, instant: Instant, step: Step) -> Problem:
        """Return the problem at the end of a step, with the contributions of all state variables."""
        contributions = [
            state_variable.contribution(state, instant.net_pressure, step)
            for state_variable, state in zip(self.state_variables, instant.states, strict=False)
        ]
        weights = Counter(self.weights)
        for contribution in contributions:
            weights.update(contribution.compliance)
        local = sum(contribution.local_compliance for contribution in contributions)
        posed = partial(self._problem_under, weights, local, step.loads[1])
        problem, source = posed(self.problem), self.problem.source
        if isinstance(source, ShapesSource):
            source = source.with_problem_step(posed)
        adhesion = self.problem.adhesion
        if adhesion is not None and instant.adhesion is not None:
            adhesion = adhesion.continued(instant.adhesion.attraction)
        gap = self._gap(contributions)
        return replace(problem, undeformed_gap=gap, source=source, adhesion=adhesion)

    def _problem_under(
        self, weights: Mapping[Coefficients, float], local: float | Array, load: float, problem: Problem
    ) -> Problem:
        """Return `problem`, which has the largest load, with the operator and the `load` [N/m] of a step.

        Parameters
        ----------
        weights
            Weights [1/Pa] of the influence coefficients in the step.
        local
            Displacement of a cell over its own pressure [m/Pa], one number or (x, y), added to the operator.
        load
            Load [N/m] at the end of the step.
        problem
            The scene's problem, on any grid.
        """
        grid = problem.grid
        compliance_ratio = sum(weights.values()) / sum(self.weights.values())
        return replace(
            problem,
            operator=self._operator(problem, weights, local),
            control=PrescribedLoad(load * self.loaded_length / grid.cell_area),
            scales=self._scales(load, compliance_ratio),
        )

    def _gap(self, contributions: Iterable[Contribution]) -> Array:
        """Return the undeformed gap (x, y) [m] plus the contributions of all state variables.

        Pressures that act on after a step are convolved once for each kind of influence coefficients.
        """
        gap = self.problem.undeformed_gap
        convolved: dict[Coefficients, Array] = {}
        for contribution in contributions:
            if contribution.gap is not None:
                gap = gap + contribution.gap
            for coefficients, field in contribution.convolved.items():
                convolved[coefficients] = convolved.get(coefficients, 0.0) + field
        for coefficients, field in convolved.items():
            if field.any():
                gap = gap + self._unit_operators[coefficients](field)
        return gap

    def _operator(
        self, problem: Problem, weights: Mapping[Coefficients, float], local: float | Array
    ) -> Convolution | WithWinklerLayer:
        """Return the operator of a step on `problem`; the arguments are those of :meth:`_problem_under`.

        It is made of operators that exist already, whose transforms take as long as several steps.
        """
        operator = problem.operator
        assert isinstance(operator, Convolution)
        layer, uniform = (local, 0.0) if isinstance(local, np.ndarray) else (None, local)
        if weights != self.weights:
            units = self._unit_operators if problem is self.problem else self._units_of(problem)
            operator = weighted_sum(((weight, units[kind]) for kind, weight in weights.items()), uniform)
        elif uniform:
            operator = weighted_sum([(1.0, operator)], uniform)
        return operator if layer is None else WithWinklerLayer(operator, on_cells(layer, problem.grid.cells))

    @cached_property
    def _unit_operators(self) -> Mapping[Coefficients, Convolution]:
        """Operator of each kind of coefficients [m], of weight 1, on the grid of the integration."""
        return self._units_of(self.problem)

    def _units_of(self, problem: Problem) -> Mapping[Coefficients, Convolution]:
        """Return the operator of each kind of coefficients [m], of weight 1, on the grid of `problem`."""
        if len(self.weights) == 1:
            ((coefficients, weight),) = self.weights.items()
            assert isinstance(problem.operator, Convolution)
            return {coefficients: weighted_sum([(1 / weight, problem.operator)])}
        assert problem.paddings is not None
        return {
            coefficients: superposed({coefficients: 1.0}, problem.grid, problem.paddings)
            for coefficients in self.weights
        }

    def _scales(self, load: float, compliance_ratio: float) -> Scales:
        """Return the scales under `load` [N/m] and a ratio of the step's compliance to the instantaneous one.

        The width of a curved contact grows with the square root of load and compliance; a flat contact keeps its width.
        Bodies that adhere, which no load leaves undeformed, have the scales of the largest load. The scale of the
        pressure is a power of two, so that scaling by it rounds nothing.
        """
        scales = self.problem.scales
        ratio = load / self.load.largest if load > 0 and self.problem.adhesion is None else 1.0
        if scales.length < self.problem.grid.extent[0]:
            length, pressure = sqrt(ratio * compliance_ratio), sqrt(ratio / compliance_ratio)
        else:
            length, pressure = 1.0, ratio
        pressure = 2.0 ** round(log2(scales.pressure * pressure))
        return Scales(scales.length * length, pressure, scales.gap * ratio * compliance_ratio)
