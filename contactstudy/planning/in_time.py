"""What bodies that yield ask of a grid and of its steps, and what they cost."""

from dataclasses import dataclass, replace
from math import inf, log10, pi, prod, sqrt

import numpy as np

from contactstudy.domain.grid import Grid
from contactstudy.elasticity.eigenstrain.volume import Volume
from contactstudy.evolution.plastic import layers
from contactstudy.planning.grid_requirements import ROOM
from contactstudy.scene.bodies import Body, sudden
from contactstudy.scene.inelastic import ViscoelasticHalfSpace
from contactstudy.scene.load import ChangingLoad, ConstantLoad, LineLoad
from contactstudy.scene.scene import Scene

# Of a rigid cylinder pressed with Hertz's peak pressure r times the yield stress, from 2 to 8, without hardening or
# with little, all over Hertz's half-width: the plastic zone ends at WIDTH + WIDER r^2 across and at DEPTH r - 1.
WIDTH, WIDER, DEPTH = 0.62, 0.07, 1.2
# The error by equal steps is at most STEPS (r / 3)^3 over their number; solves of a march, with its companion and what
# is rejected, are FIRST and SOLVES for each step. An error by cells is r / 3 to the power CELLS times the elastic one.
STEPS, FIRST, SOLVES, CELLS = 0.09, 18, 2.5, 1.5
# A step costs so many elastic solves, or so many for each layer where strain varies along the length; and its fields
# are so many of those of the plastic strain, or more there. Measured on rough cylinders of 48^2 to 128^2 cells.
CONTACTS, CONTACTS_OF_LAYER, FIELDS, FIELDS_ALONG = 120, 9, 24, 36
MARGIN = 1.25


@dataclass(frozen=True)
class Yielding:
    """``ratio`` of Hertz's peak pressure to the lowest yield stress, at Hertz's ``half_width`` [m].

    ``bodies`` is how many yield.
    """

    ratio: float
    half_width: float
    bodies: int

    @property
    def reach(self) -> float:
        """How far the plastic zone reaches across [m]."""
        return self.half_width * MARGIN * (WIDTH + WIDER * self.ratio**2)

    @property
    def cells_error(self) -> float:
        """The error by cells over that of an elastic contact."""
        return float(max(1.0, self.ratio / 3) ** CELLS)

    def contacts(self, grid: Grid) -> int:
        """Elastic solves that a step costs on ``grid``."""
        count, _, along = self.volume(grid).shape
        return CONTACTS if along == 1 else CONTACTS_OF_LAYER * count

    def steps(self, error: float) -> int:
        """Solves of a march with steps for ``error``, with those that estimate it."""
        return round(FIRST + SOLVES * STEPS * (self.ratio / 3) ** 3 / error)

    def volume(self, grid: Grid) -> Volume:
        """Where it yields, on ``grid``."""
        half = min(self.reach, grid.extent[0] / 2)
        across = round(half / grid.cell[0])
        middle = grid.cells[0] // 2
        depth = max(DEPTH * self.ratio - 1, 1.0) * self.half_width
        edges = layers(grid, self.half_width, depth)
        return Volume(grid, max(middle - across, 0), min(middle + across, grid.cells[0]), edges)

    def bytes(self, grid: Grid) -> int:
        """What operators and fields take, beside one solve."""
        volume = self.volume(grid)
        count, across, along = volume.shape
        if along == 1:
            kept = (across + 1) * (3 * count) ** 2 + FIELDS * 3 * prod(volume.shape)
        else:
            kept = FIELDS_ALONG * 5 * prod(volume.shape)
        return 8 * self.bodies * kept

    def reason(self, grid: Grid) -> str:
        """What is chosen for it, in a sentence."""
        volume = self.volume(grid)
        count, across, _ = volume.shape
        return (
            f"yield: Hertz's peak pressure is {self.ratio:.3g} times the lowest yield stress; some {count} layers down "
            f"to {volume.edges[-1]:.3g} m below {across} cells across, as thick as a cell is wide at the surface "
            "and thicker with depth."
        )


def yielding(scene: Scene) -> Yielding | None:
    """Of the largest load of ``scene``; None where nothing yields, or no curvature says how wide the contact is."""
    limits = [
        float(getattr(body, "yield_stress", 0.0))
        for body in scene.solids
        if getattr(body, "yields", False)
    ]
    if not limits or scene.hertz is None:
        return None
    return Yielding(scene.hertz.peak_pressure / min(limits), scene.hertz.half_width, len(limits))


# Solves of a march, with its companion and what is rejected, for an error of 1: of a held load, by the power CREEP_RATE
# and for each decade of relaxation times; of wear, which is of first order, by the number of times the contact
# doubles its width. Measured on a cylinder; within a factor of some three.
CREEP, CREEP_RATE = 7.0, 0.37
WEAR, WEAR_RATE = 1.2, 1.0
# Passes of a steadily rolling contact; as many as these times the ratio of its compliances to 1e-6.
PASSES = 8


# A contact under a smaller share of the largest load than this is not planned for: cells grow with its root.
LEAST_LOAD = 0.1
# Instants at which a load is looked at.
INSTANTS = 2000


@dataclass(frozen=True)
class Extremes:
    """What the narrowest and the widest contact of a scene in time ask of a plan.

    ``narrow`` is the scene of the smallest load that is planned for, before anything has crept or worn, which needs the
    finest cells. ``width`` [m] holds the widest contact. ``steps`` are solves, ``fields`` what is kept between them
    beside one solve, ``reasons`` and ``warnings`` a sentence each. ``plastic`` is what bodies that yield ask.
    """

    narrow: Scene
    width: float
    steps: int
    fields: int
    reasons: tuple[str, ...]
    warnings: tuple[str, ...] = ()
    plastic: Yielding | None = None


def extremes(scene: Scene, error: float, end: float | None = None) -> Extremes:
    """Return those of ``scene`` up to ``end`` [s], or the end of its load, marched with steps for ``error``."""
    load = LineLoad(scene.load.largest)
    still = replace(scene, load=load, solids=sudden(scene.solids), wear=None, rolling=None)
    bodies = [b for b in scene.solids if isinstance(b, ViscoelasticHalfSpace) and b.creeps]
    start = getattr(scene.load, "start", 0.0)
    last = end if end is not None else getattr(scene.load, "end", start)
    duration = max(last - start, 0.0)
    softest = sum(_softest(body, duration) for body in scene.solids)
    hertz = still.hertz
    half_width = 0.0
    if hertz is not None:
        half_width = sqrt(4 * load.per_length * hertz.radius * softest / pi)
    fields = 2 * sum(len(body.creep.terms) + bool(body.creep.fluidity) for body in bodies) + 8
    if scene.rolling is not None:
        ratio = softest * still.contact_modulus
        passes = round(PASSES * (1 + ratio))
        reason = f"rolling: some {passes} passes until the lagged part settles."
        return Extremes(still, 2 * ROOM * half_width * 1.5, passes, 4 * PASSES, (reason,))
    steps = 1.0
    plastic = yielding(scene)
    if plastic is not None:
        steps += plastic.steps(error)
        half_width = max(half_width, plastic.reach / ROOM)
    if bodies:
        times = [time for body in bodies for _, time in body.creep.terms] or [duration or 1.0]
        decades = 1 + log10(max(times) / min(times))
        steps += CREEP * decades * error**-CREEP_RATE
    if scene.wear is not None and hertz is not None and duration:
        worn = 1.5 * hertz.radius * scene.wear.rate * load.per_length * duration
        wider = float(np.cbrt(half_width**3 + worn))
        steps += WEAR * (1 + log10(wider / half_width) / log10(2)) * error**-WEAR_RATE
        half_width = wider
    least, warnings = _smallest_load(scene.load, last)
    if plastic is not None:  # whose errors are over the pressure of the largest load
        least, warnings = load.per_length, ()
    reasons = [
        f"time: some {steps:.2g} solves for an error of {error:.1g} by the steps, with those that "
        "estimate it, if evolve(error=...) chooses them."
    ]
    if least < load.per_length:
        reasons.append(
            f"load: the cells are those that the smallest load asks for, {least:.4g} N/m."
        )
    return Extremes(
        replace(still, load=LineLoad(least)),
        2 * ROOM * half_width,
        round(steps),
        fields,
        tuple(reasons),
        warnings,
        plastic,
    )


def _smallest_load(load: ConstantLoad | ChangingLoad, end: float) -> tuple[float, tuple[str, ...]]:
    """Return the smallest load that is planned for [N/m], and a warning where the load is smaller."""
    if isinstance(load, ConstantLoad):
        return load.per_length, ()
    times = np.linspace(load.start, max(end, load.start), INSTANTS)
    loads = np.array([load.at(float(time)) for time in times])
    least = max(float(loads.min()), LEAST_LOAD * load.largest)
    if loads.min() >= least:
        return least, ()
    after = times[np.argmax(loads >= least)]
    again = bool((loads[times > after] < least).any())
    return least, (
        f"The load is below {least:.3g} N/m {'at times' if again else f'until {after:.3g} s'}, where the contact is "
        "so narrow that the error by the cells is larger than planned: give a finer grid, or a larger first load.",
    )


def _softest(body: Body, end: float) -> float:
    """The largest compliance [1/Pa] of ``body``, of a fluid that at the ``end`` [s]."""
    if not isinstance(body, ViscoelasticHalfSpace):
        return body.compliance
    relaxed = body.creep.equilibrium
    return relaxed if relaxed < inf else float(body.creep(end))
