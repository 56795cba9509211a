"""Creep, wear and fretting: state variables of bodies and interfaces that change with time, and the contact in a step.

A class has the state before the first load (``start``), what it contributes to the problem of the contact at the end of
a step (``contribution``), the state there (``update``), and the fields of a state that a user is shown (``fields``). A
step is taken in this order: the contribution follows from the state and the pressure (x, y) [Pa] at the start of the
step, less the attraction. The contact is solved with it, and the update follows from both pressures. States are never
changed in place: a step may be tried and rejected. Plastic strain, which is solved together with the pressure, is in
the module `plastic`.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import exp, expm1

import numpy as np

from contactstudy.domain.grid import Array, Grid
from contactstudy.elasticity.convolution import Coefficients
from contactstudy.elasticity.tangential import ShearResponse
from contactstudy.elasticity.viscoelastic import Creep
from contactstudy.problem.problem import Field, Problem
from contactstudy.scene.loads import PiecewiseLinear
from contactstudy.solvers.coulomb import SlipStep, shear_status
from contactstudy.solvers.fretting import locked_shear, slip_step, transmission_status
from contactstudy.solvers.solution import Solution, Status, TangentialTraction, unloaded
from contactstudy.solvers.solve import SolveOptions, solve_contact

# The arrays that a state variable keeps, by name, as its method `start` lists them: all that a checkpoint needs of it.
State = Mapping[str, Array]
# Factor on the tolerance of a contact that is solved again and again together with plastic strain. The residual of the
# strain holds the error of the contact, which is to be a small part of it. Half or twice of the factor changed the
# convolutions of three contacts by at most 5 %; with 1, one of them did not converge.
COUPLED_TOLERANCE_FACTOR = 0.01


@dataclass(frozen=True)
class Step:
    """A step in time, or a jump of the load where it starts and ends at one instant.

    Attributes
    ----------
    start, end
        Time [s].
    loads
        Load [N/m] at the start and at the end.
    mean_load
        Mean load [N/m] over the step.
    explicit
        Fraction of the step in which an interface changes under the pressure at its start; in the remaining fraction it
        changes under the pressure at its end.
    """

    start: float
    end: float
    loads: tuple[float, float]
    mean_load: float
    explicit: float = 0.0

    @property
    def duration(self) -> float:
        """Duration of the step [s]; 0 for a jump."""
        return self.end - self.start


@dataclass(frozen=True)
class Contribution:
    """Contribution of a state variable to the problem of the contact at the end of a step.

    Attributes
    ----------
    gap
        Field (x, y) [m] that is added to the undeformed gap; None adds nothing.
    convolved
        Past pressures times their creep compliance (x, y) [-] by influence coefficients [m]: their convolution is added
        to the gap.
    compliance
        Compliance [1/Pa] by influence coefficients [m], by which displacement under the pressure at the end grows.
    local_compliance
        Displacement of a cell over its own pressure at the end [m/Pa], one number or (x, y), that is added.
    """

    gap: Array | None = None
    convolved: Mapping[Coefficients, Array] = field(default_factory=dict)
    compliance: Mapping[Coefficients, float] = field(default_factory=dict)
    local_compliance: float | Array = 0.0


@dataclass(frozen=True)
class CreepState:
    """Internal variables of a viscoelastic body: retarded pressures, and the impulse of a body that flows (Maxwell).

    Retarded pressures follow ``c_i' = (p - c_i) / lambda_i``; the impulse is the time integral ``b' = p``. The surface
    moves as under ``J_0 p + sum(J_i c_i) + fluidity b``, where the operator of the contact has the instantaneous
    compliance J_0. Steps are exact for a pressure that is linear in time.

    Attributes
    ----------
    creep
        Creep function of the body, with weights [1/Pa].
    coefficients
        Influence coefficients [m] of its surface.
    """

    creep: Creep
    coefficients: Coefficients

    def start(self, shape: tuple[int, ...]) -> State:
        """Return retarded pressures and impulse of zero on `shape` cells (x, y), or of several fields."""
        names = [f"retarded{number}" for number in range(len(self.creep.terms))]
        names += ["impulse"] * bool(self.creep.fluidity)
        return {name: np.zeros(shape) for name in names}

    def contribution(self, state: State, pressure: Array, step: Step) -> Contribution:
        """Return the hereditary term of past pressures, and the compliance for the pressure at the end of the step."""
        weighted, compliance = self.hereditary_terms(state, pressure, step.duration)
        return Contribution(convolved={self.coefficients: weighted}, compliance={self.coefficients: compliance})

    def hereditary_terms(self, state: State, pressure: Array, duration: float) -> tuple[Array, float]:
        """Return the past pressures times their creep compliance after a `duration` [s], and the compliance of the next.

        Parameters
        ----------
        state
            State before.
        pressure
            Pressure before [Pa], of the shape of the state's fields.
        duration
            Time in which the pressure changes linearly to the next [s].
        """
        weighted = np.zeros_like(pressure)
        compliance = 0.0
        for number, (size, time) in enumerate(self.creep.terms):
            from_state, from_start, from_end = retardation_weights(duration / time)
            weighted += (size * from_state) * state[f"retarded{number}"]
            weighted += (size * from_start) * pressure
            compliance += size * from_end
        if self.creep.fluidity:
            half = self.creep.fluidity * duration / 2
            weighted += self.creep.fluidity * state["impulse"] + half * pressure
            compliance += half
        return weighted, compliance

    def update(self, state: State, before: Array, after: Array, step: Step) -> State:
        """Return the retarded pressures [Pa] and the impulse [Pa s] at the end of the step."""
        retarded: dict[str, Array] = {}
        for number, (_, time) in enumerate(self.creep.terms):
            from_state, from_start, from_end = retardation_weights(step.duration / time)
            retarded[f"retarded{number}"] = (
                from_state * state[f"retarded{number}"] + from_start * before + from_end * after
            )
        if self.creep.fluidity:
            retarded["impulse"] = state["impulse"] + step.duration / 2 * (before + after)
        return retarded

    def fields(self, state: State) -> Mapping[str, Field]:
        """Return no fields: retarded pressures are not shown to users."""
        return {}


def retardation_weights(ratio: float) -> tuple[float, float, float]:
    """Return the weights of the retarded pressure, the pressure before and the pressure after, in a step of creep.

    They are ``e``, ``f - e`` and ``1 - f`` with ``e = exp(-ratio)`` and ``f = (1 - e) / ratio``. They add up to 1 and
    none is negative.

    Parameters
    ----------
    ratio
        Duration of the step over the retardation time lambda.
    """
    from_state = exp(-ratio)
    if ratio < 1e-3:  # where the quotient would cancel
        from_end = ratio / 2 - ratio**2 / 6 + ratio**3 / 24
        return from_state, -expm1(-ratio) - from_end, from_end
    from_end = 1 + expm1(-ratio) / ratio
    return from_state, -expm1(-ratio) - from_end, from_end


@dataclass(frozen=True)
class WearState:
    """State variable of wear: the wear depth w, with ``dw/dt = k v p`` (Archard 1953).

    The pressure at the start of a step acts in its explicit fraction, the pressure at its end in the remaining one,
    which adds a constant to the diagonal of the operator. The wear volume is exact also where the load changes within
    the step. Where the weighted load is above the mean one, both pressures are scaled down to the mean load. Where it is
    below, the weight of the pressure at the start is raised, and then that of the pressure at the end.

    Attributes
    ----------
    rate_per_pressure
        Depth over pressure and time [m/(Pa s)]: the specific wear rate times the sliding speed.
    body
        Index in ``Scene.solids`` of the body that wears.
    """

    rate_per_pressure: float
    body: int = 0

    def start(self, shape: tuple[int, int]) -> State:
        """Return a wear depth of zero on `shape` cells (x, y)."""
        return {"wear_depth": np.zeros(shape)}

    def contribution(self, state: State, pressure: Array, step: Step) -> Contribution:
        """Return the depth worn so far as a gap, and the wear by the pressure at the end as a local compliance."""
        explicit, implicit = self._depths_per_pressure(step)
        worn = state["wear_depth"]
        if explicit:
            worn = worn + explicit * pressure
        return Contribution(gap=worn, local_compliance=implicit)

    def update(self, state: State, before: Array, after: Array, step: Step) -> State:
        """Return the wear depth at the end of the step."""
        explicit, implicit = self._depths_per_pressure(step)
        worn = state["wear_depth"] + implicit * after
        return {"wear_depth": worn + explicit * before if explicit else worn}

    def fields(self, state: State) -> Mapping[str, Field]:
        """Return the wear depth (x, y) [m]."""
        return {"wear_depth": Field(("x", "y"), state["wear_depth"], "m", "wear depth")}

    def _depths_per_pressure(self, step: Step) -> tuple[float, float]:
        """Return depth over pressure [m/Pa] worn in the step by the pressure at its start and by that at its end."""
        (first, last), mean, explicit = step.loads, step.mean_load, step.explicit
        depth = self.rate_per_pressure * step.duration
        weighted_load = explicit * first + (1 - explicit) * last
        if weighted_load >= mean:
            scale = mean / weighted_load if weighted_load else 0.0
            return depth * explicit * scale, depth * (1 - explicit) * scale
        if last == 0:
            return depth * (mean / first if first else 0.0), 0.0

        # at most half of the implicit fraction becomes explicit, so that the step stays stable
        additional = min((mean - weighted_load) / first, (1 - explicit) / 2) if first else 0.0
        explicit += additional
        return depth * explicit, depth * (mean - explicit * first) / last


def least_eigenvalue(contact_modulus: float, cell: float) -> float:
    """Return the smallest eigenvalue [m/Pa] of the influence matrix of touching cells, ``0.742 cell / contact_modulus``.

    It is that of plane strain, for a pressure that alternates from `cell` to cell, whose width is in [m]: 0.742 is
    ``8 G / pi^2`` with Catalan's constant G. Cells that are also short along the length have a smaller one.
    """
    return 0.742 * cell / contact_modulus


def solved_or_unloaded(options: SolveOptions, problem: Problem, start: Array | None = None) -> Solution:
    """Return the solution of `problem`; without load, the undeformed bodies that just touch.

    Parameters
    ----------
    options
        How the problem is solved.
    problem
        The contact.
    start
        Pressure (x, y) [Pa] to begin with; None or zero begins on coarser grids.
    """
    if problem.adhesion is None and problem.control.uniform(cells=1) == 0:  # a load of 0
        return unloaded(problem)
    begin = start if start is not None and start.any() else None
    return solve_contact(problem, options, begin)


@dataclass(eq=False)
class WarmStartedContact:
    """The contact of `problem` with a field added to its gap, each time solved from the `last` pressure (x, y) [Pa].

    Its tolerance is that of `options` times `COUPLED_TOLERANCE_FACTOR`.
    """

    problem: Problem
    options: SolveOptions
    last: Array

    def __call__(self, added_gap: Array) -> Solution:
        """Return the contact with `added_gap` (x, y) [m] added to its gap."""
        tolerance = COUPLED_TOLERANCE_FACTOR * self.options.tolerance
        options = replace(self.options, tolerance=tolerance)
        solution = solved_or_unloaded(options, with_added_gap(self.problem, added_gap), self.last)
        self.last = solution.pressure
        return solution


def with_added_gap(problem: Problem, added_gap: Array) -> Problem:
    """Return `problem` with `added_gap` (x, y) [m] added to its undeformed gap."""
    return replace(problem, undeformed_gap=problem.undeformed_gap + added_gap)


# Error of the tangential traction over the difference of two integrations where slip wears or bodies creep, of first
# order in the step or of less. It was at most 2.4 in twelve contacts that wear, and 1.5 in three that creep.
ERROR_OVER_DIFFERENCE = 4.0
# Error of the traction locked in by cells that enter contact, relative to it, over the relative deviation of the
# locked-in traction from `slope` times the pressure increment in neighbouring cells. It was at most 2.4 in 30 contacts,
# smooth, rough and finite, in 1 to 16 steps.
ERROR_OVER_DEVIATION = 3.0
# Limit of the traction of cells that stick, over the largest traction that a step locks in where it is proportional to
# the pressure: far above what they take.
UNLIMITED = 1e3
# A number below this is zero: dividing by more does not overflow.
TINY = 1e-300


@dataclass(frozen=True)
class FrettingState:
    """Tangential traction between bodies that stick in part, the distance slipped, and the depth worn by it.

    Each step is one of :func:`~contactstudy.solvers.fretting.slip_step`, from the traction before it and
    what a rising pressure locks in. The step loses ``mu p |slip|`` per area and wears ``k p |slip|`` (Archard 1953),
    with a mean p of the pressures at its start and its end (a theta method), so that the wear volume is ``k / mu``
    times the energy. With the depth per pressure w worn in a step and the weight e of the pressure at its start, an
    eigenmode of the pressure with the eigenvalue lambda of the influence matrix is multiplied by
    ``(lambda - e w) / (lambda + (1 - e) w)``. The weight is a half, the second-order scheme, where w is at most twice
    the smallest eigenvalue; above, it is that eigenvalue over w, so that in plane strain no mode changes its
    sign from step to step. The implicit part enters the contact as a local compliance; slip and contact are iterated to
    a fixed point. A step within a segment of the tangential history that lasts n half periods counts its slip n times
    (cycle jump).

    A state has ``shear`` (2, x, y) [Pa], the traction along x and y on the first body; ``stick`` (x, y), 1 where bodies
    stick; ``slip_distance`` (x, y) [m]; ``energy`` (x, y) [J/m^2], lost to friction; ``shear_error`` (x, y) [Pa], see
    :meth:`common_error`; and of the last solution ``residual``, ``applications`` and ``limit`` [Pa], the friction of all
    cells, each (1,). With wear it also has ``wear_depth`` (x, y) [m], ``slip_iterate`` (x, y) [m], the slip of a half
    cycle that the contact was solved with, and ``slip_change`` (1,), the error by it over the scale of the gap.

    Attributes
    ----------
    coefficient
        Coefficient of friction mu.
    wear
        Specific wear rate k [1/Pa], the wear coefficient over the hardness; 0 wears nothing.
    response
        Tangential displacement under a tangential traction.
    history
        Tangential force [N/m] on the first body, or rigid-body displacement [m] of the second against the first, over
        time and along x.
    by_force
        Whether the history is one of forces.
    period
        Duration of a cycle [s]; infinite if each force is followed once.
    least_eigenvalue
        Smallest eigenvalue of the influence matrix in plane strain [m/Pa].
    gap_scale
        Scale of the gap [m], to which its errors are relative.
    creep
        Creep of the surfaces over their instantaneous compliance; None of elastic bodies. Its state also keeps the
        retarded pressure: traction is locked in where the pressure rises above it.
    compliances_proportional
        Whether the tangential compliance is proportional to the normal one.
    grid
        Grid of the contact.
    loaded_length
        Length [m] on which forces per length act.
    tolerance, max_applications
        Largest residual of a step, and its number of applications of the response at most.
    """

    coefficient: float
    wear: float
    response: ShearResponse
    history: PiecewiseLinear
    by_force: bool
    period: float
    least_eigenvalue: float
    gap_scale: float
    compliances_proportional: bool
    creep: CreepState | None
    grid: Grid
    loaded_length: float
    tolerance: float
    max_applications: int

    def start(self, shape: tuple[int, int]) -> State:
        """Return a state without traction, slip or wear on `shape` cells (x, y)."""
        names = ["stick", "slip_distance", "energy", "shear_error"]
        numbers = ["residual", "applications", "limit"]
        if self.wear:
            names += ["wear_depth", "slip_iterate"]
            numbers += ["slip_change"]
        state: dict[str, Array] = {"shear": np.zeros((2, *shape))}
        state |= {name: np.zeros(shape) for name in names} | {name: np.zeros(1) for name in numbers}
        return state if self.creep is None else {**state, **self.creep.start((3, *shape))}

    def contribution(self, state: State, pressure: Array, step: Step) -> Contribution:
        """Return the depth worn so far as a gap, and the wear of the step by the slip of the last iterate."""
        if not self.wear:
            return Contribution()
        worn = self.wear * self._half_cycles(step) * state["slip_iterate"]
        explicit = self._fraction_at_start(worn)
        return Contribution(
            gap=state["wear_depth"] + explicit * worn * pressure, local_compliance=(1 - explicit) * worn
        )

    def next_iterate(self, state: State, end: State, tolerance: float) -> State:
        """Return `state` with the slip up to the `end` of a step as the next iterate.

        It is `state` itself where nothing wears, or the gap by the last iterate is right to the `tolerance`.
        """
        if not self.wear or end["slip_change"][0] <= tolerance:
            return state
        return dict(state) | {"slip_iterate": end["slip_iterate"]}

    def outcome(self, state: State) -> tuple[Status, float]:
        """Return how the solution for the traction of the last step ended, and its relative residual."""
        residual, applications = float(state["residual"][0]), int(state["applications"][0])
        status = shear_status(residual, applications, self.tolerance, self.max_applications)
        return status, residual

    def traction(self, state: State) -> TangentialTraction:
        """Return the tangential traction of a state."""
        return TangentialTraction(state["shear"], state["stick"] > 0, "fretting", int(state["applications"][0]))

    def update(self, state: State, before: Array, after: Array, step: Step) -> State:
        """Return traction, slip, energy and wear depth at the end of the step.

        1. Take the force at the end of the step, or the rigid-body displacement in it.
        2. Let the surfaces creep under the traction and the pressure before.
        3. Add the traction that a rising pressure locks in.
        4. Solve for traction and slip under the pressure at the end.
        5. Add the slip of all half cycles that the step stands for, its energy and its wear.
        """
        slope, total, rigid = self._driving(before, step)
        if total is not None:
            force = float(total[0]) * self.grid.cell_area / self.grid.length
            # raises InvalidInput for a force above friction
            transmission_status(force, self.coefficient * after, self.grid)
        shear = state["shear"]
        carried, response = self._crept(state, np.stack([*shear, before]), step)
        reference, locking_error = self._locked(carried[:2], carried[2], after, slope)
        solved = slip_step(
            response,
            self.coefficient * after,
            reference,
            self.tolerance,
            self.max_applications,
            total=total,
            rigid=rigid,
        )
        half_cycles = self._half_cycles(step)
        distance = half_cycles * _slip_distance(solved, response, reference, before, after)
        explicit = self._fraction_at_start(self.wear * distance)
        pressure_times_slip = (explicit * before + (1 - explicit) * after) * distance
        may_begin_to_slip = (state["stick"] > 0) | (before == 0)
        end = dict(state) | {
            "shear": solved.shear,
            "stick": solved.stick.astype(np.float64),
            "slip_distance": state["slip_distance"] + distance,
            "energy": state["energy"] + self.coefficient * pressure_times_slip,
            "shear_error": np.where(
                solved.stick, state["shear_error"] + locking_error, may_begin_to_slip * np.abs(solved.shear[1])
            ),
            "residual": np.array([solved.residual]),
            "applications": np.array([float(solved.applications)]),
            "limit": np.array([self.coefficient * float(after.sum())]),
        }
        if self.creep is not None:
            tractions = np.stack([*shear, before]), np.stack([*solved.shear, after])
            end |= self.creep.update(state, *tractions, step)
        if self.wear:
            iterate = half_cycles * state["slip_iterate"]
            error = self.wear * float((after * np.abs(distance - iterate)).max())
            end["wear_depth"] = state["wear_depth"] + self.wear * pressure_times_slip
            end["slip_iterate"] = distance / half_cycles
            end["slip_change"] = np.array([error / self.gap_scale])
        return end

    def _driving(self, before: Array, step: Step) -> tuple[float, Array | None, Array | None]:
        """Return what drives a step: the rise of force over that of load, and the total traction or the displacement.

        The ratio is 0 where the load does not rise, or jumps. The total (2,) [Pa] is the sum of the traction of all
        cells at the end of the step, the displacement (2,) [m] that of the second body in the step; one of them is
        None. Force and displacement jump, as the load does, in a step without duration. A first load that jumps is
        applied before the traction; one that ramps up locks traction in.
        """
        history = self.history
        first = 0.0
        if before.any():
            first = (history.at if step.duration else history.before)(step.start)
        last = (history.before if step.duration else history.at)(step.end)
        if not self.by_force:
            return 0.0, None, np.array([last - first, 0.0])
        slope, rise = 0.0, step.loads[1] - step.loads[0]
        if rise > 0 and step.duration > 0:
            slope = float(np.clip((last - first) / rise, -self.coefficient, self.coefficient))
        return slope, np.array([last * self.loaded_length / self.grid.cell_area, 0.0]), None

    def _crept(self, state: State, carried: Array, step: Step) -> tuple[Array, ShearResponse]:
        """Return traction and pressure (3, x, y) [Pa] that give the displacement after creep, and the response then.

        Over the instantaneous response, the displacement under `carried` is ``carried + delayed`` before the step. A
        traction q after creep gives ``q (1 + compliance_change) + still_delayed`` at its end.
        """
        if self.creep is None:
            return carried, self.response
        delayed, _ = self.creep.hereditary_terms(state, carried, 0.0)
        still_delayed, compliance_change = self.creep.hereditary_terms(state, carried, step.duration)
        carried = (carried + delayed - still_delayed) / (1 + compliance_change)
        return carried, self.response.scaled(1 + compliance_change)

    def _locked(self, shear: Array, before: Array, after: Array, slope: float) -> tuple[Array, Array]:
        """Return the traction (2, x, y) [Pa] that slip is counted from, with what is locked in, and its error (x, y).

        Unless tangential and normal compliances are proportional, the locked-in traction is not proportional to the
        increment of the pressure. Cells in contact throughout the step have one rigid-body displacement; cells that
        enter contact take `slope` times their pressure. The error of the latter is estimated from the deviation in
        neighbouring cells, and spread over all cells as the increment of the pressure.
        """
        reference, in_contact = locked_shear(shear, before, after, slope), before > 0
        gained = slope * (after - before)
        if self.compliances_proportional or not in_contact.any() or not gained.any():
            return reference, np.zeros_like(after)
        # cells in contact stick and take the rest of the sum; those that enter have their traction already
        entering = np.stack([np.where(in_contact, 0.0, gained), np.zeros_like(gained)])
        locked = slip_step(
            self.response,
            np.where(in_contact, UNLIMITED * np.abs(gained).max(), 0.0),
            -entering,
            self.tolerance,
            self.max_applications,
            total=np.array([gained[in_contact].sum(), 0.0]),
        )
        total_shear = np.asarray(shear + entering + locked.shear)
        deviation = np.hypot(*(total_shear - reference))
        enters = entering[0] != 0
        neighbours = [np.roll(enters, step, axis) for axis in (0, 1) for step in (1, -1)]
        beside, sizes = in_contact & np.any(neighbours, axis=0), np.abs(gained)
        gained_beside, entered, all_gained = (sizes[of].sum() for of in (beside, enters, ...))
        relative = 0.0
        if gained_beside:
            relative = ERROR_OVER_DEVIATION * deviation[beside].sum() / gained_beside
        return total_shear, relative * entered / all_gained * sizes

    def _half_cycles(self, step: Step) -> float:
        """Return the number of half cycles that a step stands for: those in its segment of the history, at least 1.

        A jump, and a step before or after the history, stand for themselves.
        """
        times = self.history.times
        if not (step.duration and times[0] <= step.start and step.end <= times[-1]):
            return 1.0
        later = next(time for time in times if time >= step.end)
        earlier = max(time for time in times if time <= step.start)
        return max(1.0, 2 * (later - earlier) / self.period)

    def _fraction_at_start(self, worn: Array) -> Array:
        """Return the weight of the pressure at the start in its mean over a step that wears `worn` [m/Pa] per pressure.

        It is a half, and less where an eigenmode of the pressure would change its sign from step to step with a half.
        """
        return np.asarray(np.minimum(0.5, self.least_eigenvalue / np.maximum(worn, TINY)))

    def fields(self, state: State) -> Mapping[str, Field]:
        """Return slip, energy and wear depth (x, y)."""
        plane = ("x", "y")
        fields = {
            "slip_distance": Field(plane, state["slip_distance"], "m", "distance slipped so far"),
            "friction_energy": Field(plane, state["energy"], "J m-2", "energy lost to friction so far per area"),
        }
        if self.wear:
            fields["wear_depth"] = Field(plane, state["wear_depth"], "m", "wear depth")
        return fields

    def time_discretisation_error(self, state: State, other: State) -> float:
        """Return the L1 error of the traction that the difference of two states estimates, relative to the first."""
        size = self.size(state)
        changed = float(np.abs(state["shear"] - other["shear"]).sum())
        factor = ERROR_OVER_DIFFERENCE if self.wear or self.creep is not None else 1.0
        return factor * changed / size if size > TINY else 0.0

    def common_error(self, state: State) -> float:
        """Return the L1 error of the traction, relative to it, that longer steps have in common with shorter ones.

        It is that of the traction locked in by a rising pressure, and of the traction along y in cells that begin to
        slip in a step, whose direction follows the slip of the whole step.
        """
        size = self.size(state)
        return float(state["shear_error"].sum()) / size if size > TINY else 0.0

    def size(self, state: State) -> float:
        """Return the sum of the absolute components of the traction [Pa] over all cells.

        It is at least the limit of the traction times the tolerance, below which the traction is rounding.
        """
        return max(float(np.abs(state["shear"]).sum()), self.tolerance * float(state["limit"][0]))


def _slip_distance(solved: SlipStep, response: ShearResponse, reference: Array, before: Array, after: Array) -> Array:
    """Return the distance (x, y) [m] slipped in a step; where contact is lost, that up to the loss."""
    slip = np.where(solved.stick, 0.0, np.hypot(*solved.slip))
    released = (before > 0) & (after == 0)
    if released.any() and after.any():
        slip_at_release = response(solved.shear - reference) - solved.rigid[:, None, None]
        slip = np.where(released, np.hypot(*slip_at_release), slip)
    return slip
