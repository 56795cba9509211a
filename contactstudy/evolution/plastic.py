"""Which cells below the surface may yield, and how deep their layers reach."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from contactstudy.domain.device import Precision
from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid
from contactstudy.elasticity.eigenstrain.plane_strain import PlaneStrainOperator
from contactstudy.elasticity.eigenstrain.volume import EigenstrainOperator, Moduli, Volume
from contactstudy.elasticity.kernels.stress_cell import COMPONENTS
from contactstudy.evolution.memory import Contact, State
from contactstudy.problem.problem import Field, Problem
from contactstudy.scene.inelastic import ElasticPlasticHalfSpace
from contactstudy.scene.scene import Scene
from contactstudy.solvers.settle import ContactTangent, Settled, settle
from contactstudy.solvers.solution import Solution, Status
from contactstudy.solvers.yielding_bodies import ROOT, Hardening, YieldingBodies

# The first volume holds what the elastic stress makes bear this share of the yield stress, and some room.
SHARE, ROOM = 0.9, 0.15
# It is made so much larger on the side where it yields to its edge.
LARGER = 0.3


def layers(grid: Grid, length: float, depth: float) -> tuple[float, ...]:
    """Depths [m] between layers down to ``depth``, with one more below.

    A layer is as thick as a cell is wide down to the depth ``length``, twice that down to three times this depth, and
    so on, so that errors of layers and of cells fall alike: an operator is made once for each thickness. More
    depth adds layers and leaves the others as they are.
    """
    edges, thickness = [0.0], grid.cell[0]
    while edges[-1] < depth:
        edges.append(edges[-1] + thickness)
        if edges[-1] >= (2 * thickness / grid.cell[0] - 1) * length:
            thickness *= 2
    return (*edges, edges[-1] + thickness)


def first_volume(
    grid: Grid,
    length: float,
    pressure: Array,
    share_of_yield: Callable[[Volume], Array],
) -> Volume:
    """Below the contact of an elastic ``pressure`` (x, y), down to where von Mises' stress has become small.

    ``length`` [m] is that of the contact; ``share_of_yield`` is von Mises' stress over the yield
    stress (layers, x, y) in a volume.
    """
    bears = np.flatnonzero(pressure.any(axis=1))
    first, last = (int(bears[0]), int(bears[-1]) + 1) if bears.size else (0, grid.cells[0])
    depth = min(length, (last - first) * grid.cell[0] / 2)
    while True:
        volume = Volume(grid, 0, grid.cells[0], layers(grid, length, depth))
        share = share_of_yield(volume).max(axis=2)
        if share[-1].max() < min(SHARE, share.max()) or depth > grid.extent[0]:
            break
        depth *= 1 + LARGER
    high = np.flatnonzero((share > SHARE).any(axis=0))
    if high.size:
        first, last = min(first, int(high[0])), max(last, int(high[-1]) + 1)
    room = int(np.ceil(ROOM * (last - first))) + 1
    return replace(volume, first=max(first - room, 0), last=min(last + room, grid.cells[0]))


def larger(volume: Volume, length: float, flows: NDArray[np.bool_]) -> Volume:
    """``volume``, with more room on every side up to which it ``flows`` (layers, x, y), within its grid."""
    room = int(np.ceil(LARGER * (volume.last - volume.first)))
    first = max(volume.first - room, 0) if flows[:, 0].any() else volume.first
    last = min(volume.last + room, volume.grid.cells[0]) if flows[:, -1].any() else volume.last
    edges = volume.edges
    if flows[-1].any():
        edges = layers(volume.grid, length, (1 + LARGER) * edges[-1])
    return Volume(volume.grid, first, last, edges)


def both(one: Volume, other: Volume) -> Volume:
    """The smallest volume that holds both; their layers are the same as far as they reach."""
    edges = max(one.edges, other.edges, key=len)
    return Volume(one.grid, min(one.first, other.first), max(one.last, other.last), edges)


def spread(field: Array, first: int, volume: Volume) -> Array:
    """A field (..., layers, x, y) from cell ``first`` on, with zeros in the rest of a larger ``volume``."""
    layers, across = field.shape[-3:-1]
    whole = np.zeros((*field.shape[:-3], *volume.shape))
    start = first - volume.first
    whole[..., :layers, start : start + across, :] = field
    return whole


@dataclass(frozen=True)
class YieldingBody:
    """Body ``place`` of ``Scene.solids``."""

    place: int
    moduli: Moduli
    hardening: Hardening

    @classmethod
    def all_of(cls, scene: Scene) -> "tuple[YieldingBody, ...]":
        """Those of ``scene``."""
        return tuple(
            cls(
                place,
                Moduli(body.youngs_modulus, body.poisson_ratio),
                Hardening(body.yield_stress, body.hardening_modulus, body.kinematic_modulus),
            )
            for place, body in enumerate(scene.solids)
            if isinstance(body, ElasticPlasticHalfSpace) and body.yields
        )


@dataclass(eq=False)
class PlasticMemory:
    """Plastic strain and equivalent plastic strain of each body, in a volume that grows as it yields.

    ``elastic`` is the contact under the largest load before anything has yielded.
    """

    bodies: tuple[YieldingBody, ...]
    elastic: Solution
    precision: Precision
    has_stages: ClassVar[bool] = False

    operators: list[EigenstrainOperator] = field(init=False)

    def __post_init__(self) -> None:
        problem = self.elastic.problem
        self.operators = []
        for body in self.bodies:

            def share(volume: Volume, body: YieldingBody = body) -> Array:
                stress = operator_on(volume, body.moduli).stress_of_pressure(self.elastic.pressure)
                size = np.sqrt((stress**2).sum(axis=0))
                return np.asarray(size / (ROOT * body.hardening.yield_stress))

            volume = first_volume(problem.grid, self._length, self.elastic.pressure, share)
            self.operators.append(operator_on(volume, body.moduli))

    def start(self, shape: tuple[int, int]) -> State:
        """No plastic strain."""
        state: dict[str, Array] = {"flow": np.zeros(1)}
        for body, one in zip(self.bodies, self.operators, strict=True):
            cells = one.volume.shape
            state |= _named(body, np.zeros((len(one.basis), *cells)), np.zeros(cells), one.volume)
        return state

    def settled(
        self, state: State, problem: Problem, contact: Contact, tolerance: float
    ) -> tuple[Solution, State]:
        """Contact and plastic strain together, in volumes that are as large as what yields."""
        while True:
            # first, since the state of a march that goes on may be in larger volumes than these
            strains, equivalents = self._in_volumes(state)
            bodies = YieldingBodies(
                tuple(self.operators), tuple(body.hardening for body in self.bodies)
            )
            before, equivalent = bodies.joined(strains), bodies.joined(equivalents)
            found = settle(bodies, contact, self._tangent, before, equivalent, tolerance)
            if not self._grown(bodies.parted(found.flow)):
                break
        strains = bodies.parted(found.strain)
        equivalents = bodies.parted(equivalent + found.flow)
        # to rounding, a cell on the yield surface may be beyond it
        flows = found.flow > tolerance * bodies.unit
        flow = float((found.flow * flows * bodies.volumes).sum())
        after: dict[str, Array] = {"flow": state["flow"] + flow if flow else np.zeros(1)}
        parts = zip(self.bodies, self.operators, strains, equivalents, strict=True)
        for body, one, strain, hardened in parts:
            after |= _named(body, strain, hardened, one.volume)
        solution = concluded(found, tolerance)
        yielded = zip(self.operators, equivalents, strict=True)
        if solution.status is Status.CONVERGED and any(
            _meets_edge(one.volume, hardened > 0) for one, hardened in yielded
        ):
            solution = replace(solution, status=Status.YIELD_AT_EDGE)
        return solution, after

    def fields(self, state: State) -> Mapping[str, Field]:
        """``residual_displacement``, of both bodies together."""
        strains, _ = self._in_volumes(state)
        parts = zip(self.operators, strains, strict=True)
        # of the surface, into the bodies
        lift = np.asarray(sum(one.lift(strain) for one, strain in parts))
        about = "residual displacement"
        return {"residual_displacement": Field(("x", "y"), lift, "m", about)}

    def abrupt(self, before: State, after: State) -> bool:
        """Whether plastic strain since it last stopped has become several times as large."""
        return bool(after["flow"][0] > (1 + ABRUPT) * before["flow"][0])

    def over_time(self, states: Sequence[State], pressures: Sequence[Array]) -> Mapping[str, Field]:
        """Strain and stress of each body, over (time, component, z, x, y), across the whole grid."""
        for state in states:
            self._in_volumes(state)  # so that volumes hold all
        found: dict[str, Field] = {
            "component": Field(
                ("component",),
                np.array(list(COMPONENTS)),
                "1",
                "x across, y along, z into the body",
            )
        }
        for number, body in enumerate(self.bodies):
            suffix = f"_{body.place}" if len(self.bodies) > 1 else ""
            narrow = self.operators[number].volume
            volume = replace(narrow, first=0, last=narrow.grid.cells[0])
            wide = operator_on(volume, body.moduli)
            strains, equivalents = zip(
                *(_spread(state, body, volume) for state in states), strict=True
            )
            residual = np.stack([wide.tensor_of_strain(strain) for strain in strains])
            total = residual + np.stack([wide.tensor_of_pressure(p) for p in pressures])
            tensors = np.einsum("ct,ncl...->ntl...", wide.basis, np.stack(strains))
            cells = "time", f"z{suffix}", "x", "y"
            components = "time", "component", *cells[1:]
            down = {"axis": "Z", "positive": "down"}
            said = "tension positive, mean over a cell"
            found |= {
                f"plastic_strain{suffix}": Field(components, tensors, "1", "plastic strain"),
                f"equivalent_plastic_strain{suffix}": Field(
                    cells, np.stack(equivalents), "1", "equivalent plastic strain"
                ),
                f"stress{suffix}": Field(components, total, "Pa", f"stress, {said}", NEAR_EDGE),
                f"residual_stress{suffix}": Field(
                    components, residual, "Pa", f"stress without the pressure, {said}", NEAR_EDGE
                ),
                f"z{suffix}": Field((f"z{suffix}",), volume.depths, "m", "depth of a layer", down),
                f"layer_thickness{suffix}": Field(
                    (f"z{suffix}",), volume.thicknesses, "m", "thickness of a layer"
                ),
            }
        return found

    @property
    def _length(self) -> float:
        return self.elastic.problem.scales.length

    def _tangent(self, solution: Solution) -> ContactTangent:
        return ContactTangent.of(solution, self.precision)

    def _in_volumes(self, state: State) -> tuple[list[Array], list[Array]]:
        """Strains and equivalent strains in the volumes of today, which are made to hold those of ``state``."""
        strains, equivalents = [], []
        for number, body in enumerate(self.bodies):
            strain, first = state[f"strain{body.place}"], int(state[f"first{body.place}"][0])
            now = self.operators[number].volume
            edges = tuple(float(z) for z in state[f"edges{body.place}"])
            held = both(now, Volume(now.grid, first, first + strain.shape[-2], edges))
            if held != now:
                self.operators[number] = operator_on(held, body.moduli)
            one, other = _spread(state, body, held)
            strains.append(one)
            equivalents.append(other)
        return strains, equivalents

    def _grown(self, flows: Sequence[Array]) -> bool:
        """Whether a volume had to be made larger, since it yields up to its edge."""
        changed = False
        for number, (body, one) in enumerate(zip(self.bodies, flows, strict=True)):
            volume = self.operators[number].volume
            grown = larger(volume, self._length, one > 0)
            if grown != volume:
                self.operators[number] = operator_on(grown, body.moduli)
                changed = True
        return changed


# A step that doubles the load beyond that of first yield adds some 3 times the plastic strain that there was.
ABRUPT = 4.0
# A contact that stopped short of what it was asked for.
NEARLY = (Status.PRECISION_LIMIT, Status.STALLED, Status.ITERATION_LIMIT)
# At the edge of the contact the stress has a logarithmic or stronger peak below the size of any cell.
NEAR_EDGE = {
    "comment": "at the surface near the edge of the contact it does not converge with finer cells"
}


def operator_on(volume: Volume, moduli: Moduli) -> EigenstrainOperator:
    """The operator on plastic strain in ``volume``: in plane strain for one cell along the length."""
    if volume.grid.cells[1] == 1:
        return PlaneStrainOperator(volume, moduli)
    # here, for those whose scene varies along the length
    from contactstudy.elasticity.eigenstrain.rows import RowOperator

    return RowOperator(volume, moduli)


def _named(body: YieldingBody, strain: Array, equivalent: Array, volume: Volume) -> State:
    return {
        f"strain{body.place}": strain,
        f"equivalent{body.place}": equivalent,
        f"first{body.place}": np.array([float(volume.first)]),
        f"edges{body.place}": np.array(volume.edges),
    }


def _spread(state: State, body: YieldingBody, volume: Volume) -> tuple[Array, Array]:
    """Strain and equivalent strain of ``body`` in a volume that holds those of ``state``."""
    first = int(state[f"first{body.place}"][0])
    strain, equivalent = state[f"strain{body.place}"], state[f"equivalent{body.place}"]
    return spread(strain, first, volume), spread(equivalent, first, volume)


def _meets_edge(volume: Volume, yielded: NDArray[np.bool_]) -> bool:
    """Whether plastic strain reaches the edges of the grid across."""
    left = volume.first == 0 and yielded[:, 0].any()
    return bool(left or (volume.last == volume.grid.cells[0] and yielded[:, -1].any()))


def concluded(found: Settled, tolerance: float) -> Solution:
    """The last contact of a step, with what all of them took, and what became of the plastic strain."""
    last = found.solution
    status, note = last.status, last.note
    if status in NEARLY and last.residual <= tolerance:
        status = Status.CONVERGED  # the contact had been asked for more
    if not found.residual <= tolerance:
        status = Status.NOT_CONVERGED
        note = (
            f"Plastic strain and pressure settled to {found.residual:.1e} of the yield strain in "
            f"{found.iterations} iterations."
        )
    return replace(
        last,
        status=status,
        note=note,
        residual=max(last.residual, found.residual),
        iterations=sum(one.iterations for one in found.contacts),
        convolutions=sum(one.convolutions for one in found.contacts),
    )
