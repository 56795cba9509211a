"""One step in time of a dry contact: the problem that its state variables make of it, their update, and its frames.

A state variable is what a body or an interface keeps from one instant to the next: retarded pressures of creep, the
depth of wear, the tangential traction of fretting, plastic strain. Each adds to the gap or to the operator of the
contact at the end of a step, which is solved from the pressure before; the state at the end follows from both
pressures. Plastic strain is coupled: it is solved for together with the pressure. Lengths of steps and their errors are
in ``evolve``.

An :class:`Instant` is what a step begins and ends with. A :class:`Frame` is a recorded contact, as a user sees it, with
its errors; a :class:`Trajectory` is the sequence of frames.
"""

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, fields, replace
from functools import cached_property, partial
from math import inf, log2, pi, sqrt
from typing import TYPE_CHECKING, Any

import numpy as np

from contactstudy.domain.device import Cpu, Precision
from contactstudy.domain.errors import ErrorEstimate
from contactstudy.domain.grid import Array, Grid, Padding, Paddings, on_cells
from contactstudy.elasticity.coating import WithWinklerLayer
from contactstudy.elasticity.convolution import (
    BoussinesqCoefficients,
    Coefficients,
    Convolution,
    superposed,
    weighted_sum,
)
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
    least_eigenvalue,
    solved_or_unloaded,
    with_added_gap,
)
from contactstudy.evolution.steady_rolling import SteadyRolling
from contactstudy.problem.constraint import PrescribedLoad
from contactstudy.problem.problem import Field, Problem, Scales
from contactstudy.scene.friction import Fretting, has_proportional_compliances
from contactstudy.scene.loads import ChangingLoad
from contactstudy.scene.scene import PosedScene, Scene
from contactstudy.scene.shapes.shape import ShapesSource, summed_gap
from contactstudy.scene.solids.bodies import creeps, instantaneous, response, yields
from contactstudy.scene.solids.inelastic import creeping, relaxed
from contactstudy.solvers.coulomb import FullSliding
from contactstudy.solvers.solution import (
    AdhesiveTraction,
    Counts,
    Solution,
    Status,
    TangentialTraction,
    net_pressure,
    unloaded,
)
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


@dataclass(frozen=True, eq=False, kw_only=True)
class Frame(Solution):
    """A contact at one recorded instant: its :class:`~contactstudy.Solution`, and what it keeps from earlier instants.

    Solves, iterations and convolutions are counted since the previous frame, and include rejected steps and the
    integration with doubled steps. The status is the worst one of the contacts since the previous frame, without those
    of rejected or halved steps and of replaced iterates; it is DETACHED where the last contact is. The displacement is
    all by which the surfaces have moved: elastically, by creep, wear and yielding. Errors are relative L1 errors of the
    pressure, infinite where there is no estimate; where bodies yield, relative to the pressure under the largest load.

    Attributes
    ----------
    time
        Time [s].
    load
        Load [N/m].
    fields
        Fields (x, y) of the state variables, such as the wear depth, by name.
    solves
        Number of contacts solved, of which a step may take several; contact and plastic strain together count as one.
    errors_by_steps
        Estimated time-discretisation errors by name: ``l1`` of the pressure, or of the tangential traction where that of
        fretting is larger, the peak pressure, and further quantities of a contact that has worn while it rolls. An
        error that is not named is 0.
    coupled_state
        State solved for together with the pressure, such as plastic strain, as arrays by name.
    estimate
        Estimated errors of a contact that keeps a state from earlier instants, with those by the steps; None for others,
        whose errors are those of a contact at rest.
    rolling
        Rolling resistance and centroid of a steadily rolling contact; None for others.
    """

    time: float
    load: float
    fields: Mapping[str, Field] = field(default_factory=dict)
    solves: int = 1
    errors_by_steps: Mapping[str, float] = field(default_factory=dict)
    coupled_state: Mapping[str, Array] = field(default_factory=dict)
    estimate: ErrorEstimate | None = None
    rolling: SteadyRolling | None = None


def frame_of(solution: Solution, **further_fields: Any) -> Frame:
    """Return `solution` as a frame, with `further_fields` of :class:`Frame`, or others in place of its own."""
    values = {member.name: getattr(solution, member.name) for member in fields(Solution)}
    return Frame(**values | further_fields)


# Work of a dry scene in time, with its meaning in words.
MEANING_OF_WORK = {
    "solves": "contact solves",
    "iterations": "solver iterations of all steps",
    "convolutions": "FFT convolutions of the full grid",
    "rejected": "rejected pairs of steps and load jumps",
    "restarts": "restarts with shorter steps",
}


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Frames of a dry scene that was followed through time.

    Attributes
    ----------
    frames
        The recorded instants, in the order of time.
    work
        Work of all steps by the names in `MEANING_OF_WORK`: a load jump that was repeated with more increments counts
        as rejected, and a restart is one because the time-discretisation error grew beyond the allowed one.
    description
        The scene, grid and padding.
    coupled
        State variable that derives fields from the frames' coupled states; None if no body yields.
    """

    frames: tuple[Frame, ...]
    work: Mapping[str, int]
    description: PosedScene
    coupled: "PlasticState | None" = None

    @property
    def times(self) -> Array:
        """Time (time,) [s] of each frame."""
        return np.array([frame.time for frame in self.frames])

    @property
    def counts(self) -> Counts:
        """Number of instants, and of what the integration took."""
        work = {name: (self.work.get(name, 0), meaning) for name, meaning in MEANING_OF_WORK.items()}
        return {"instants": (len(self.frames), "instants recorded")} | work


def error_of_peak(pressure: Array, errors: Array) -> float:
    """Return the error [Pa] of the peak of a `pressure` (x, y) [Pa] whose cells have these `errors` [Pa], at least 0.

    It is how far the peak moves when each cell has its error. (At the edge of a contact that wears errors are large,
    but the pressures are far below the peak.) As the error of a cell may vanish by chance, the error is at least the
    relative mean error times the peak, or the largest error where that is less.
    """
    peak, total = float(pressure.max()), float(pressure.sum())
    moved = max(float((pressure + errors).max()) - peak, peak - float((pressure - errors).max()))
    mean = float(errors.sum()) / total * peak if total else 0.0
    return max(moved, min(mean, float(errors.max())))


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
        """Return whether errors after a `step` [s] may be of order 1/2: by wear, by slip, or by creep over within it."""
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

        Where slip wears, contact and slip are iterated to a fixed point. The state of fretting before the stage holds
        the slip of the last iterate, from which the contact takes its wear. It stays the same object once converged.
        """
        coupled: tuple[State, ...] = ()
        solutions: list[Solution] = []
        has_converged = True
        while True:
            problem = self._problem_at_end(instant, step)
            pressure = solutions[-1].pressure if solutions else instant.pressure
            if self.coupled is None:
                solution = solved_or_unloaded(self.options, problem, pressure)
            else:
                solution, strain = self._coupled_step(self.coupled, instant.states[-1], problem, pressure)
                coupled = (strain,)
            solutions.append(solution)
            net = net_pressure(solution.pressure, solution.adhesion)
            states = tuple(
                state_variable.update(state, instant.net_pressure, net, step)
                for state_variable, state in zip(self.state_variables, instant.states, strict=False)
            )
            if self.fretting is None:
                break
            *others, fretting = instant.states
            iterate = self.fretting.next_iterate(fretting, states[-1], self.options.tolerance)
            has_converged = iterate is fretting
            if has_converged or len(solutions) == MAX_FIXED_POINT_ITERATIONS:
                break
            instant = replace(instant, states=(*others, iterate))
        for variable, before, after in zip(self.state_variables, instant.states, states, strict=False):
            if self.coupled is not None and isinstance(variable, WearState):
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
            step_error=0.0 if np.isfinite(solution.residual) else inf,
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
            """Return contact and energy [J] under a frozen `attraction` (x, y) [Pa], and keep the strain in `after`."""
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
            for coefficients, pressure in contribution.convolved.items():
                convolved[coefficients] = convolved.get(coefficients, 0.0) + pressure
        for coefficients, pressure in convolved.items():
            if pressure.any():
                gap = gap + self._unit_operators[coefficients](pressure)
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
        if scales.length < self.problem.grid.extent[0]:  # a flat contact has the width of the grid as its scale
            length, pressure = sqrt(ratio * compliance_ratio), sqrt(ratio / compliance_ratio)
        else:
            length, pressure = 1.0, ratio
        pressure = 2.0 ** round(log2(scales.pressure * pressure))
        return Scales(scales.length * length, pressure, scales.gap * ratio * compliance_ratio)


def time_stepper(
    scene: Scene,
    grid: Grid,
    padding: Padding | Paddings,
    load: ChangingLoad,
    duration: float,
    scheme: Scheme,
    options: SolveOptions,
) -> TimeStepper:
    """Return the time stepper of a `scene`: its contact under the largest `load` [N/m], and its state variables.

    The other arguments are those of :func:`~contactstudy.evolution.evolve.evolve`, and the `duration` [s] of all steps.
    """
    solids = instantaneous(scene.solids)
    frets = isinstance(scene.friction, Fretting)
    friction = None if frets else scene.friction
    elastic = replace(scene.under(load.largest), solids=solids, wear=None, friction=friction)
    adhesive_solver = None
    if scene.adhesion is not None and any(map(creeps, scene.solids)):
        # bodies that have crept have the shortest cohesive zone, which the grid must resolve
        heights, softest = summed_gap(scene.shapes, grid), relaxed(scene.solids, duration)
        adhesive_solver = scene.adhesion.solver_on(elastic, heights, grid, softest)
    problem = elastic.problem(grid, padding, adhesive_solver)
    datum = elastic.datum(grid)
    variables: list[StateVariable] = [
        # the coefficients lack the factor 1 / pi
        CreepState(body.creep.scaled(1 / pi), BoussinesqCoefficients(datum))
        for body in creeping(scene.solids)
    ]
    if scene.wear is not None and scene.wear.rate_per_pressure > 0:
        variables.append(WearState(scene.wear.rate_per_pressure, scene.wear.body))
    if frets:  # last: the time stepper and the errors take the last state for that of fretting
        variables.append(_fretting_state(scene, problem, options))
    coupled = None
    if any(map(yields, scene.solids)):
        from contactstudy.evolution.states.plastic import PlasticState, YieldingBody, check_paddings

        check_paddings(problem)
        elastic_contact = solved_or_unloaded(options, problem)
        coupled = PlasticState(YieldingBody.in_scene(scene), elastic_contact, Precision(options.precision))
    return TimeStepper(
        problem=problem,
        load=load,
        loaded_length=scene.loaded_length(grid, padding),
        weights=dict(response(solids, datum)),
        state_variables=tuple(variables),
        coupled=coupled,
        scheme=scheme,
        options=options,
    )


def _fretting_state(scene: Scene, problem: Problem, options: SolveOptions) -> FrettingState:
    """Return the tangential traction of a scene that frets, as a state variable."""
    fretting, paddings = scene.friction, problem.paddings
    assert isinstance(fretting, Fretting)
    assert fretting.history is not None
    assert paddings is not None
    gap = problem.undeformed_gap
    return FrettingState(
        coefficient=fretting.coefficient,
        wear=0.0 if scene.wear is None else scene.wear.coefficient,
        response=fretting.response(scene, problem.grid, paddings, scene.datum(problem.grid)),
        history=fretting.history,
        by_force=fretting.forces is not None,
        period=inf if fretting.period is None else fretting.period,
        least_eigenvalue=least_eigenvalue(scene.contact_modulus, min(problem.grid.cell_size)),
        gap_scale=problem.scales.gap,
        compliances_proportional=has_proportional_compliances(scene.solids, gap, paddings),
        creep=_relative_creep(scene, scene.datum(problem.grid)),
        grid=problem.grid,
        loaded_length=scene.loaded_length(problem.grid, paddings),
        tolerance=options.tolerance,
        max_applications=options.max_iterations,
    )


def _relative_creep(scene: Scene, datum: float) -> CreepState | None:
    """Return the creep of both bodies, which are elastically similar, over their instantaneous compliance.

    It is a factor on the elastic response; None if neither creeps. Displacements count from the distance `datum` [m].
    """
    total = sum(body.compliance for body in scene.solids)
    of_bodies = [body.creep.scaled(1 / total) for body in creeping(scene.solids)]
    if not of_bodies:
        return None
    terms = tuple(term for creep in of_bodies for term in creep.terms)
    fluidity = sum(creep.fluidity for creep in of_bodies)
    return CreepState(Creep(1.0, terms, fluidity), BoussinesqCoefficients(datum))
