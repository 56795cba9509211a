"""What bodies that yield ask of a grid and of its steps, and what they cost."""

from dataclasses import dataclass
from math import prod

from contactstudy.domain.grid import Grid
from contactstudy.elasticity.eigenstrain.volume import Volume
from contactstudy.evolution.memories.yielding_volume import layers
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
