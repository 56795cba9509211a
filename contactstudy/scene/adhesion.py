"""Adhesion between the bodies of a scene: work, range and law, and the history that selects a state."""

from math import pi, sqrt
from typing import Any, Literal

from contactstudy.analytic import HertzLine
from contactstudy.domain.grid import Array, Grid
from contactstudy.domain.validation import InvalidInput, JoulesPerSquareMetre, Metres, readable, validated
from contactstudy.problem.constraint import CohesiveLaw, Dugdale, Exponential, tabor_length, zone_length
from contactstudy.scene.loads import Approach, ChangingLoad
from contactstudy.scene.shapes.roller import Sphere
from contactstudy.scene.solids.bodies import Body, SceneContext, contact_modulus, modulus_at_own_width
from contactstudy.solvers.adhesion import AdhesiveSolver
from contactstudy.solvers.solution import Branch

# Cells in the cohesive zone: of the range that the grid chooses where none is given, and the fewest that are allowed.
# With 6 cells the pull-off load of a cylinder is within 0.3 %, below 2 cells the contact is trapped between cells.
ZONE_CELLS, MIN_ZONE_CELLS = 6.0, 2.0


@validated
class Adhesion:
    """Adhesion: an attraction between the surfaces that falls with their gap.

    Load and attraction together press the contact; the attraction also acts across the gap beside it. Friction is the
    coefficient times the compressive part of the pressure, which balances both (Derjaguin 1934). A hardness limits the
    net pressure, which is the compressive part less the attraction.
    Several states may be in equilibrium under one load; the branch selects one of them.

    Parameters
    ----------
    work
        Work of adhesion [J/m^2], to separate a unit of area; above zero.
    range
        Range of the attraction [m]: its work over its largest value. None takes the limit of short ranges (Johnson,
        Kendall & Roberts 1971) as far as the grid resolves it, with six cells in the cohesive zone; of bodies that creep
        the shortest zone counts. The pull-off load of a cylinder is then within 0.3 % of that limit on fine grids.
    law
        ``"exponential"``, ``work / range exp(-gap / range)``, or ``"dugdale"`` for a constant attraction that falls
        linearly to zero around the range. It falls between 0.9 and 1.1 times the range on 30 or more cells in the
        cohesive zone. On fewer cells the fall is wider, in inverse proportion, with the same work, since a sharper one
        traps the contact between cells.
    branch
        ``"from afar"`` for bodies that approach, the least adhesive state; ``"from full contact"`` for bodies that
        leave full contact, the most adhesive one. A load history continues from each state to the next.

    Raises
    ------
    InvalidInput
        If a value is outside these limits; in a scene with wear, a lubricant or Fretting in time; where a body that
        creeps rolls, or one that yields in passes; without a range with friction or a body that yields; with a first
        load that is not above zero on bodies from afar; on a grid with less than two cells in the cohesive zone, of
        bodies that creep in the shortest one.
    """

    work: JoulesPerSquareMetre
    range: Metres | None = None
    law: Literal["exponential", "dugdale"] = "exponential"
    branch: Literal["from afar", "from full contact"] = "from afar"

    def check(self, scene: SceneContext) -> None:
        """Raise :class:`~contactstudy.InvalidInput` where bodies from afar begin without a load."""
        load: Any = scene.load
        if self.branch == Branch.FROM_AFAR.value and not isinstance(load, Approach):
            first = load.at(load.start) if isinstance(load, ChangingLoad) else scene.largest_load
            if first <= 0:
                raise InvalidInput(
                    f"Scene.load begins with {readable(first, 'N m-1')} together with Adhesion: bodies from afar do "
                    "not touch without a load, give a first load above 0 N/m, an Approach, or Adhesion.branch = "
                    "'from full contact'."
                )

    def reference_load(self, scene: SceneContext) -> float:
        """Return a load [N/m] for the scales of an adhesive contact at zero load; 0 if flat.

        It is twice the unit ``(pi E* w^2 R)^(1/3)`` of the line contact of Johnson, Kendall & Roberts, w the work. It
        is near the 2.52 units, ``32^(2/3) / 4``, that make a contact without adhesion as wide.
        """
        if scene.radius is None:
            return 0.0
        modulus = contact_modulus(scene.solids)
        load = 2 * (pi * modulus * self.work**2 * scene.radius) ** (1 / 3)
        width = HertzLine(load, scene.radius, modulus).half_width
        ratio = contact_modulus(scene.solids, width) / modulus
        return float(load * ratio ** (1 / 3))

    def reference_pressure(self, scene: SceneContext, width: float) -> float:
        """Return Griffith's tensile stress [Pa] of a crack of half-length `width` [m], ``sqrt(2 E* w / (pi width))``."""
        return sqrt(2 * contact_modulus(scene.solids) * self.work / (pi * width))

    def cohesive(self, modulus: float, cell: float) -> CohesiveLaw:
        """Return the traction as a function of the gap, by a contact `modulus` [Pa] and on cells of this size [m]."""
        attraction_range, cells = self.range, ZONE_CELLS
        if attraction_range is None:
            # the largest attraction work / range is that whose zone_length is so many cells
            attraction_range = self.work / sqrt(pi * modulus * self.work / (4 * cells * cell))
        else:
            cells = zone_length(modulus, self.work, self.work / attraction_range) / cell
        if self.law == "dugdale":
            return Dugdale.on_cells(self.work, attraction_range, cells)
        return Exponential(self.work, attraction_range)

    def zone_modulus(self, solids: tuple[Body, Body], width: float) -> float:
        """Return E* [Pa] at the length of the cohesive zone, which is `width` [m] where no range is given.

        A coating that is thinner than the zone has little part in it.
        """
        if self.range is None:
            return contact_modulus(solids, width)
        strength = self.work / self.range
        return modulus_at_own_width(lambda modulus: zone_length(modulus, self.work, strength), solids)

    def solver_on(
        self, scene: SceneContext, gap: Array, grid: Grid, relaxed: tuple[Body, Body] | None = None
    ) -> AdhesiveSolver:
        """Return the solver of the attraction in a `scene` on a grid with an undeformed `gap` (x, y) [m].

        Where bodies creep, `relaxed` are both bodies in the end: then their cohesive zone is the shortest, which the
        grid must resolve, and by which the Tabor parameter is found.

        Raises
        ------
        InvalidInput
            If the cohesive zone has fewer than `MIN_ZONE_CELLS` cells.
        """
        solids = relaxed or scene.solids
        varies = bool((gap != gap[:, :1]).any())
        cell = max(grid.cell_size) if varies else grid.cell_size[0]
        modulus = self.zone_modulus(solids, ZONE_CELLS * cell)
        law = self.cohesive(modulus, cell)
        zone = zone_length(modulus, self.work, law.strength)
        cells = zone / cell
        if cells < MIN_ZONE_CELLS:
            least = MIN_ZONE_CELLS * cell
            shortest = sqrt(4 * least * self.work / (pi * contact_modulus(solids, least)))
            when = "" if relaxed is None else ", once the bodies have crept"
            raise InvalidInput(
                f"Adhesion.range is {self.range!r}: its cohesive zone of {readable(zone)} is {cells:.2g} cells of this "
                f"grid wide{when}; give a range of at least {readable(shortest)}, cells of at most "
                f"{readable(zone / MIN_ZONE_CELLS)}, or leave the range out for the limit of short ranges on this grid."
            )
        tabor, radius = None, scene.radius
        if radius is None:  # a sphere in a point contact, whose shapes have no radius of a line contact
            radius = min((shape.radius for shape in scene.shapes if isinstance(shape, Sphere)), default=None)
        if radius is not None:
            tabor = tabor_length(radius, self.work, modulus) * law.strength / self.work
        return AdhesiveSolver(law, Branch(self.branch), float(cells), tabor, regularised=self.range is None)
