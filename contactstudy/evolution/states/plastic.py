"""Plastic strain as a state variable: the cells that may yield, and how a load step changes it with the pressure.

Plastic strain is kept in a volume of layers and cells below the contact for each body that yields. A volume grows as
the body yields: before a step to where the contact would make it yield, after a step to where it did. What a state holds
is said in :class:`PlasticState`. Equations and solver of a step are in the module `plasticity`, and the stress by
plastic strain is in `eigenstrain`.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from math import inf
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contactstudy.domain.device import Precision
from contactstudy.domain.grid import Array, Grid
from contactstudy.domain.validation import InvalidInput
from contactstudy.elasticity.eigenstrain.plane_strain_operator import (
    EigenstrainOperator,
    Moduli,
    PlaneStrainOperator,
    Volume,
)
from contactstudy.elasticity.kernels.stress import COMPONENTS
from contactstudy.evolution.states.state_variables import State
from contactstudy.problem.constraint import largest_of
from contactstudy.problem.problem import Field, Problem, ResidualStress
from contactstudy.scene.scene import Scene
from contactstudy.scene.solids.inelastic import ElasticPlasticHalfSpace
from contactstudy.solvers.conjugate_gradients import contact_tangent
from contactstudy.solvers.plasticity import ElastoplasticStep, Hardening, YieldingBodies, solve_elastoplastic_step
from contactstudy.solvers.solution import Solution, Status, net_pressure

# Before each step a volume grows until the stress of the contact, without further plastic flow, is below this fraction
# of the yield stress at its edge. Since a step is repeated in a larger volume where yield reaches its edge, this changes
# the time and not the accuracy: four contacts of 1 to 8 steps took up to 1.2 times as long with 0.8, 1.8 times with 1.
NEAR_YIELD = 0.9
# Fraction of its width or depth by which a volume grows. These contacts took up to 1.2 times as long with half of it and
# 1.4 times with twice.
GROWTH = 0.3


def layers(grid: Grid, length: float, depth: float) -> tuple[float, ...]:
    """Return the depths [m] of the edges of layers from 0 to at least `depth`, and of one more with its middle below it.

    A layer is as thick as a cell is wide down to the depth `length`, twice that down to ``3 length``, four times that
    down to ``7 length``, and so on, so that errors of layers and of cells fall alike and what an operator keeps of a
    layer is made once for each of few thicknesses. A larger depth adds layers and leaves the others unchanged.

    Parameters
    ----------
    grid
        Grid of the surface.
    length
        Length scale of the contact [m], such as its half-width.
    depth
        Depth that the layers cover [m].
    """
    edges, thickness = [0.0], grid.cell_size[0]
    while edges[-1] < depth:
        edges.append(edges[-1] + thickness)
        if edges[-1] >= (2 * thickness / grid.cell_size[0] - 1) * length:
            thickness *= 2
    return (*edges, edges[-1] + thickness)


def enlarged(volume: Volume, length: float, yielded: NDArray[np.bool_]) -> Volume:
    """Return `volume` with more margin on every side where plastic flow reaches its edge, within its grid.

    Parameters
    ----------
    volume
        Cells that could yield.
    length
        Length scale of the contact [m], for which layers are made.
    yielded
        Whether a cell yielded (layers, x, y).
    """
    margin = int(np.ceil(GROWTH * (volume.last - volume.first)))
    first = max(volume.first - margin, 0) if yielded[:, 0].any() else volume.first
    last = min(volume.last + margin, volume.grid.cells[0]) if yielded[:, -1].any() else volume.last
    edges = volume.edges
    if yielded[-1].any():
        edges = layers(volume.grid, length, (1 + GROWTH) * edges[-1])
    return Volume(volume.grid, first, last, edges)


def embedded(field: Array, first: int, volume: Volume) -> Array:
    """Return a field in a larger volume, with zeros in the added cells.

    Parameters
    ----------
    field
        Values (..., layers, x, y) in a smaller volume.
    first
        First cell across of the smaller volume.
    volume
        The larger volume.
    """
    depth, across = field.shape[-3:-1]
    values = np.zeros((*field.shape[:-3], *volume.shape))
    start = first - volume.first
    values[..., :depth, start : start + across, :] = field
    return values


# Function that returns the contact with a field (x, y) [m] added to its gap.
Contact = Callable[[Array], Solution]
# A step that adds more than this multiple of the plastic strain before it is taken as the onset of yield, which the
# control of steps in time resolves. A step that doubles the load adds about 3 times the plastic strain.
ABRUPT = 4.0
# Largest number of iterations of the lagged stress of friction in a step. To four times the load of first yield in one
# step, a coefficient of friction of 0.1 takes 6, one of 0.3 takes 9 and one of 0.6 does not converge.
MAX_OUTER_ITERATIONS = 50
# Statuses of a contact that stopped before its tolerance, which a step may have reached all the same.
STOPPED_EARLY = (Status.PRECISION_LIMIT, Status.STALLED, Status.ITERATION_LIMIT)
# Attribute of stress in a data set. At the edge of a contact it has a logarithmic or stronger peak, finer than any cell.
NEAR_EDGE = {"comment": "at the surface near the edge of the contact it does not converge with finer cells"}


@dataclass(frozen=True)
class YieldingBody:
    """A body that yields: its `index` in ``Scene.solids``, elastic moduli and hardening [Pa]."""

    index: int
    moduli: Moduli
    hardening: Hardening

    @classmethod
    def in_scene(cls, scene: Scene) -> "tuple[YieldingBody, ...]":
        """Return the yielding bodies of `scene`, in the order of its solids."""
        return tuple(
            cls(
                index,
                Moduli(body.youngs_modulus, body.poisson_ratio),
                Hardening(body.yield_stress, body.hardening_modulus, body.kinematic_modulus),
            )
            for index, body in enumerate(scene.solids)
            if isinstance(body, ElasticPlasticHalfSpace) and body.yields
        )


class CoupledSolution(NamedTuple):
    """Contact that was solved together with a state of the bodies, and the `energy` [J] that the state adds.

    The `state`, the plastic strain of each body, is that of :class:`PlasticState`.
    """

    solution: Solution
    state: State
    energy: float


@dataclass(eq=False)
class PlasticState:
    """State variable of plastic strain and equivalent plastic strain of each yielding body.

    They are kept in volumes of cells that grow as bodies yield, and depend on the path of the load, not on how fast the
    load follows it. A state has, for the body with the index i in ``Scene.solids``, ``plastic<i>``: the C
    components of plastic strain in the basis of its operator, then the equivalent one, (C + 1, layers, x, y);
    ``first<i>``, the first cell across of its volume; and ``edges<i>`` [m], the depths between its layers. ``flow`` (1,)
    [m^3] is the increase of the equivalent plastic strain since the last step without plastic flow, integrated over the
    volumes of all bodies.

    Attributes
    ----------
    bodies
        The bodies that yield.
    elastic
        Contact of the elastic bodies under the largest load of the history.
    precision
        Precision of the contact's solver.
    operators
        Operator on the plastic strain of each body, in its present volume.
    """

    bodies: tuple[YieldingBody, ...]
    elastic: Solution
    precision: Precision

    operators: list[EigenstrainOperator] = field(init=False)
    # operators across the whole grid, by place in `bodies`
    _wide_operators: dict[int, EigenstrainOperator] = field(init=False, default_factory=dict)

    def __post_init__(self) -> None:
        # as wide as the contact, and half as deep, but no deeper than the length: the highest stress lies there
        grid = self.elastic.problem.grid
        loaded = np.flatnonzero(net_pressure(self.elastic.pressure, self.elastic.adhesion).any(axis=1))
        first, last = (int(loaded[0]), int(loaded[-1]) + 1) if loaded.size else (0, grid.cells[0])
        depth = min(self._length, (last - first) * grid.cell_size[0] / 2)
        volume = Volume(grid, first, last, layers(grid, self._length, depth))
        self.operators = [operator_on(volume, body.moduli) for body in self.bodies]

    def start(self, shape: tuple[int, int]) -> State:
        """Return a state without plastic strain; the `shape` of the grid follows from the elastic contact instead."""
        state: dict[str, Array] = {"flow": np.zeros(1)}
        for body, operator in zip(self.bodies, self.operators, strict=True):
            plastic = np.zeros((len(operator.basis) + 1, *operator.volume.shape))
            state |= _body_state(body, plastic, operator.volume)
        return state

    def solve_step(
        self,
        state: State,
        contact: Contact,
        tolerance: float,
        attraction: Array | None = None,
        guess: State | None = None,
    ) -> CoupledSolution:
        """Return contact and plastic strain at the end of a step, in volumes that hold everything that yields.

        Parameters
        ----------
        state
            State at the start of the step.
        contact
            Solves the contact at the end of the step with a field (x, y) [m] added to its gap.
        tolerance
            Largest relative residual of contact and state.
        attraction
            Traction (x, y) [Pa] by which the surfaces attract each other beside the pressure.
        guess
            State at the end of the step to begin with; None begins with that at its start.
        """
        begin = state if guess is None else guess
        first = contact(np.asarray(sum(self._residual_displacements(begin))))
        while self._grown(self._nearly_yields(first, attraction)):
            pass
        while True:
            # the volumes of either state may be larger than those of the other: first they grow to hold both
            self._in_volumes(state)
            guessed, initial = self._in_volumes(begin), self._in_volumes(state)
            bodies = YieldingBodies(tuple(self.operators), tuple(body.hardening for body in self.bodies))
            before = bodies.concatenated(initial)
            solve_under = partial(
                solve_elastoplastic_step, bodies, contact,
                partial(contact_tangent, precision=self.precision),
                before[:-1], before[-1], tolerance, guess=bodies.concatenated(guessed)[:-1],
            )  # fmt: skip
            adhesive_stress = 0.0 if attraction is None else bodies.stress_of_pressure(-attraction)
            step = self._solve_with_friction(bodies, first, adhesive_stress, solve_under, tolerance)
            if not self._grown([flow > 0 for flow in bodies.split(step.equivalent_increment)]):
                break
        plastics = bodies.split(np.concatenate((step.strain, before[-1:] + step.equivalent_increment)))

        # rounding may put a cell that is on the yield surface beyond it
        yielded_cells = step.equivalent_increment > tolerance * bodies.yield_strain
        integral = float((step.equivalent_increment * yielded_cells * bodies.volumes).sum())
        after: dict[str, Array] = {"flow": state["flow"] + integral if integral else np.zeros(1)}
        volumes = [operator.volume for operator in self.operators]
        for body, volume, plastic in zip(self.bodies, volumes, plastics, strict=True):
            after |= _body_state(body, plastic, volume)
        solution = step_solution(step, tolerance)
        if solution.traction is not None and np.abs(solution.traction.shear[0]).max() > self._traction_limit:
            solution = replace(solution, status=Status.SHEAR_BEYOND_YIELD)
        at_edge = any(_meets_edge(volume, plastic[-1] > 0) for volume, plastic in zip(volumes, plastics, strict=True))
        if solution.status is Status.CONVERGED and at_edge:
            solution = replace(solution, status=Status.YIELD_AT_EDGE)
        return CoupledSolution(solution, after, step.energy)  # residual stress, loss, hardening; adhesion lowers it

    def _nearly_yields(self, solution: Solution, attraction: Array | None) -> list[NDArray[np.bool_]]:
        """Return by body in which cells (layers, x, y) the stress of a contact exceeds `NEAR_YIELD` of the yield stress.

        It is von Mises' stress without the residual one; its square is 3/2 of that of the deviator, whose components are
        in an orthonormal basis.
        """
        pressure = solution.pressure if attraction is None else solution.pressure - attraction
        nearly_yields = []
        parts = zip(self.bodies, self.operators, self._stress_of_friction(solution), strict=True)
        for body, operator, friction in parts:
            stress = operator.stress_of_pressure(pressure) + friction
            exceeds = 1.5 * (stress**2).sum(axis=0) > (NEAR_YIELD * body.hardening.yield_stress) ** 2
            # far beyond yield this elastic stress reaches deeper than flow does, which spreads the pressure: what lies
            # deeper than the grid is wide does not count
            nearly_yields.append(exceeds & (operator.volume.depths[:, None, None] < operator.volume.grid.extent[0]))
        return nearly_yields

    def _solve_with_friction(
        self,
        bodies: YieldingBodies,
        first: Solution,
        adhesive_stress: Array | float,
        solve_under: Callable[[Array], ElastoplasticStep],
        tolerance: float,
    ) -> ElastoplasticStep:
        """Return pressure and plastic strain at the end of a step.

        Friction makes the problem unsymmetric. Its stress is lagged: it follows from the pressure of the previous
        iteration, from that of the `first` contact on, until it changes by less than the tolerance. `adhesive_stress`
        (C, cells) [Pa] is that of an attraction, and `solve_under` returns the step under a further stress (C, cells).
        """
        contacts, stress = [first], bodies.concatenated(self._stress_of_friction(first))
        for _ in range(MAX_OUTER_ITERATIONS):
            step = solve_under(adhesive_stress + stress)
            contacts += step.contacts
            last, stress = stress, bodies.concatenated(self._stress_of_friction(step.solution))
            change = float((np.abs(stress - last) / bodies.law.yield_stress).max(initial=0.0))
            if change <= tolerance or not np.isfinite(change):
                break
        return replace(step, contacts=tuple(contacts), residual=largest_of(step.residual, change))

    def _stress_of_friction(self, solution: Solution) -> list[Array]:
        """Return the stress (C, layers, x, y) [Pa] in each body by the tangential traction along x of a contact.

        The traction of the `solution` is that on the first body; on the second it is reversed.
        """
        if solution.traction is None:
            return [np.zeros((len(operator.basis), *operator.volume.shape)) for operator in self.operators]
        shear, bodies = solution.traction.shear[0], zip(self.bodies, self.operators, strict=True)
        return [operator.stress_of_shear((1 - 2 * body.index) * shear) for body, operator in bodies]

    def fields(self, state: State) -> Mapping[str, Field]:
        """Return the residual displacement (x, y) [m] of each body's surface, positive into the body."""
        fields: dict[str, Field] = {}
        for body, displacement in zip(self.bodies, self._residual_displacements(state), strict=True):
            label = "residual displacement" + f" of solids[{body.index}]" * (len(self.bodies) > 1)
            fields[f"residual_displacement{self._suffix(body)}"] = Field(("x", "y"), displacement, "m", label)
        return fields

    def _residual_displacements(self, state: State) -> list[Array]:
        """Return the surface displacement (x, y) [m] of each body by plastic strain alone, positive into the body."""
        plastics = self._in_volumes(state)
        return [
            operator.residual_displacement(plastic[:-1])
            for operator, plastic in zip(self.operators, plastics, strict=True)
        ]

    def _suffix(self, body: YieldingBody) -> str:
        """Return what ends the names of a body's fields: nothing where it alone yields."""
        return f"_{body.index}" if len(self.bodies) > 1 else ""

    def worn(self, state: State, index: int, depth: Array) -> State:
        """Return the state after ``Scene.solids[index]`` has lost a further `depth` (x, y) [m]: its strain moves up."""
        if f"first{index}" not in state:
            return state
        first, plastic = int(state[f"first{index}"][0]), state[f"plastic{index}"]
        depth = depth[first : first + plastic.shape[-2]]
        return {**state, f"plastic{index}": _moved_up(plastic, state[f"edges{index}"], depth)}

    def has_onset_of_yield(self, before: State, after: State) -> bool:
        """Return whether a step added more than `ABRUPT` times the plastic strain since the last step without flow.

        It did, too, where there was none before and some after.
        """
        return bool(after["flow"][0] > (1 + ABRUPT) * before["flow"][0])

    def residual_stress(self, state: State, index: int, deepest: float) -> ResidualStress | None:
        """Return the residual stress of ``Scene.solids[index]`` as a function of depths [m]; None if it does not yield.

        It is for depths down to `deepest` [m].
        """
        self._in_volumes(state)  # the volume grows to hold the state
        for number, body in enumerate(self.bodies):
            if body.index == index:
                wide = self._across_grid(number, deepest)
                plastic = _embedded_state(state, body, wide.volume)
                return partial(_at_depths, wide.volume.depths, wide.residual_stress_tensor(plastic[:-1]))
        return None

    def _across_grid(self, number: int, deepest: float = 0.0) -> EigenstrainOperator:
        """Return the operator of ``bodies[number]`` across the whole grid.

        It reaches down to the lowest layer of the body's volume, and to the depth `deepest` [m] at least.
        """
        yielding = self.operators[number].volume
        grid = yielding.grid
        edges = max(yielding.edges, layers(grid, self._length, deepest), key=len)
        volume = Volume(grid, 0, grid.cells[0], edges)
        operator = self._wide_operators.get(number)
        if operator is None or operator.volume != volume:
            operator = operator_on(volume, self.bodies[number].moduli)
            self._wide_operators[number] = operator
        return operator

    def over_time(self, states: Sequence[State]) -> Mapping[str, Field]:
        """Return strain and residual stress of each body over (time, component, z, x, y), across the whole grid.

        The depths are called ``z``; with two yielding bodies, ``z_0`` and ``z_1`` after their places in
        ``Scene.solids``. So they are with outputs of the scene, as stress below the surface: these have depths ``z``.
        """
        for state in states:
            self._in_volumes(state)  # volumes grow to hold every state
        names = np.array(list(COMPONENTS))
        axes = "x across the contact line, y along it, z into the body"
        fields = {"component": Field(("component",), names, "1", axes)}
        for number, body in enumerate(self.bodies):
            suffix = self._suffix(body)
            depth_suffix = suffix or f"_{body.index}" * bool(self.elastic.problem.outputs)
            wide = self._across_grid(number)
            volume = wide.volume
            plastics = np.stack([_embedded_state(state, body, volume) for state in states])
            residual = np.stack([wide.residual_stress_tensor(plastic[:-1]) for plastic in plastics])
            tensors = np.einsum("ct,ncl...->ntl...", wide.basis, plastics[:, :-1])
            layer = (f"z{depth_suffix}",)
            cells = "time", *layer, "x", "y"
            components = "time", "component", *cells[1:]
            down = {"axis": "Z", "positive": "down"}
            sign = "tension positive, mean over a cell"
            of = f" of solids[{body.index}]" if suffix else ""
            unloaded = f"residual stress{of}, {sign}"
            depth, thickness = "depth of a layer", "thickness of a layer"
            fields |= {
                f"plastic_strain{suffix}": Field(components, tensors, "1", f"plastic strain{of}"),
                f"equivalent_plastic_strain{suffix}": Field(
                    cells, plastics[:, -1], "1", f"equivalent plastic strain{of}"
                ),
                f"residual_stress{suffix}": Field(components, residual, "Pa", unloaded, NEAR_EDGE),
                f"z{depth_suffix}": Field(layer, volume.depths, "m", depth, down),
                f"layer_thickness{depth_suffix}": Field(layer, volume.thicknesses, "m", thickness),
            }
        return fields

    @property
    def _traction_limit(self) -> float:
        """Largest tangential traction [Pa] that the surfaces sustain; infinite if every body hardens.

        It is the smallest yield stress in shear of the bodies that do not harden.
        """
        laws = (body.hardening for body in self.bodies)
        limits = (law.yield_stress for law in laws if law.isotropic == law.kinematic == 0)
        return min(limits, default=inf) / 3**0.5

    @property
    def _length(self) -> float:
        """Length scale of the contact [m], for which layers are made."""
        return self.elastic.problem.scales.length

    def _in_volumes(self, state: State) -> list[Array]:
        """Enlarge the volumes to hold `state`, and return its fields ``plastic<i>`` in them, by body."""
        plastics = []
        for number, body in enumerate(self.bodies):
            plastic, first = state[f"plastic{body.index}"], int(state[f"first{body.index}"][0])
            present = self.operators[number].volume
            # the layers of both are equal as far as both reach
            edges = max(present.edges, tuple(state[f"edges{body.index}"].tolist()), key=len)
            last = max(present.last, first + plastic.shape[-2])
            volume = Volume(present.grid, min(present.first, first), last, edges)
            if volume != present:
                self.operators[number] = operator_on(volume, body.moduli)
            plastics.append(embedded(plastic, first, volume))
        return plastics

    def _grown(self, yielded: Sequence[NDArray[np.bool_]]) -> bool:
        """Enlarge the volume of each body that yields (layers, x, y) at its edge, and return whether there was one."""
        volumes = [operator.volume for operator in self.operators]
        for number, (body, volume) in enumerate(zip(self.bodies, volumes, strict=True)):
            new_volume = enlarged(volume, self._length, yielded[number])
            if new_volume != volume:
                self.operators[number] = operator_on(new_volume, body.moduli)
        return volumes != [operator.volume for operator in self.operators]


def check_paddings(problem: Problem) -> None:
    """Raise InvalidInput for a padding of `problem` on which plastic strain has no operator."""
    assert problem.paddings is not None
    across, along = problem.paddings
    if not problem.open_edges or along.window is not None:
        raise InvalidInput(
            f"solve.padding is {across!r} across and {along!r} along: plastic strain is supported below a "
            "surface that is infinite across and periodic along, give padding=ExactPeriodicity(), which leaves the "
            "width open and repeats the length."
        )


def operator_on(volume: Volume, moduli: Moduli) -> EigenstrainOperator:
    """Return the operator on plastic strain in `volume`, in plane strain if the grid has one cell along the length."""
    if volume.grid.cells[1] == 1:
        return PlaneStrainOperator(volume, moduli)
    # imported only for scenes that vary along the length
    from contactstudy.elasticity.eigenstrain.periodic_operator import PeriodicOperator

    return PeriodicOperator(volume, moduli)


def _body_state(body: YieldingBody, plastic: Array, volume: Volume) -> State:
    """Return the arrays of one body's state, named after its index in the scene."""
    return {
        f"plastic{body.index}": plastic,
        f"first{body.index}": np.array([float(volume.first)]),
        f"edges{body.index}": np.array(volume.edges),
    }


def _embedded_state(state: State, body: YieldingBody, volume: Volume) -> Array:
    """Return plastic strain and its equivalent (C + 1, layers, x, y) of `body`, in a `volume` that contains them."""
    return embedded(state[f"plastic{body.index}"], int(state[f"first{body.index}"][0]), volume)


def _moved_up(means: Array, edges: Array, depth: Array) -> Array:
    """Return the means (..., layers, x, y) over layers of a field after a `depth` (x, y) [m] is removed at the surface.

    `means` (..., layers, x, y) are those before, in layers between `edges` [m]. Below the last one the field is zero.
    """
    thickness = np.diff(edges)[:, None, None]
    above = np.cumsum(means * thickness, axis=-3)
    above = np.concatenate((np.zeros_like(above[..., :1, :, :]), above), axis=-3)
    deeper = np.minimum(edges[:, None, None] + depth, edges[-1])
    layer = np.minimum(np.searchsorted(edges, deeper, "right"), len(edges) - 1) - 1
    x, y = np.indices(depth.shape)
    integral = above[..., layer, x, y] + means[..., layer, x, y] * (deeper - edges[layer])
    return np.asarray(np.diff(integral, axis=-3) / thickness)


def _at_depths(middles: Array, values: Array, depths: Array) -> Array:
    """Return the residual stress (6, z, x, y) [Pa] at some `depths` (z,) [m], linear between the middles of layers.

    `values` (6, layers, x, y) [Pa] are the stresses xx, yy, zz, yz, xz, xy at the depths `middles` [m]. At the surface
    xx, yy and xy are extrapolated, and zz, yz and xz are zero; below the last middle all stay.
    """
    slope = (values[:, 1] - values[:, 0]) / (middles[1] - middles[0])
    surface = values[:, 0] - slope * middles[0]
    surface[2:5] = 0.0
    values = np.concatenate((surface[:, None], values), axis=1)
    middles = np.array((0.0, *middles))
    upper = np.clip(np.searchsorted(middles, depths) - 1, 0, len(middles) - 2)
    fraction = (depths - middles[upper]) / (middles[upper + 1] - middles[upper])
    fraction = np.minimum(fraction, 1.0)[:, None, None]
    return np.asarray((1 - fraction) * values[:, upper] + fraction * values[:, upper + 1])


def _meets_edge(volume: Volume, yielded: NDArray[np.bool_]) -> bool:
    """Return whether plastic strain (layers, x, y) reaches the edges of the grid across."""
    at_start = volume.first == 0 and yielded[:, 0].any()
    return bool(at_start or (volume.last == volume.grid.cells[0] and yielded[:, -1].any()))


def step_solution(step: ElastoplasticStep, tolerance: float) -> Solution:
    """Return the contact at the end of a step, with the work of all its contacts and the status of the plastic strain.

    Parameters
    ----------
    step
        Contact and plastic strain, solved together.
    tolerance
        Largest residual with which they count as converged.
    """
    last = step.solution
    status, note = last.status, last.note
    if status in STOPPED_EARLY and last.residual <= tolerance:
        # the contact has a smaller tolerance than the step
        is_cut_off = last.problem.is_cut_off(last.pressure)
        status = Status.CONTACT_AT_EDGE if is_cut_off else Status.CONVERGED
    if not (status.is_failure or step.residual <= tolerance):
        status = Status.NOT_CONVERGED
        note = (
            f"Plastic strain and pressure stopped at a residual of {step.residual:.1e} yield strains, above the "
            f"tolerance, after {step.iterations} iterations."
        )
    return replace(
        last,
        status=status,
        note=note,
        residual=largest_of(last.residual, step.residual),
        iterations=sum(contact.iterations for contact in step.contacts),
        convolutions=sum(contact.convolutions for contact in step.contacts),
    )
