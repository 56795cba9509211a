"""Requirements of scenes that change in time, roll, yield or adhere: the width, the load and the cells of their grid.

Contacts grow as bodies creep, wear and yield, and so the width of the grid is that of the widest contact to expect, and
its cells are those of the narrowest one. The width of the contact is that of Hertz's line contact of the same load and
radius, with the modulus that applies; widths of grids are `WIDTH_FACTOR` times those of contacts.
"""

from dataclasses import dataclass, replace
from math import inf, log, pi, prod, sqrt

import numpy as np

from contactstudy.analytic import HertzLine
from contactstudy.domain.grid import Grid, Padding, Paddings
from contactstudy.domain.validation import readable
from contactstudy.elasticity.eigenstrain.plane_strain_operator import Volume
from contactstudy.evolution.states.plastic import layers
from contactstudy.planning.grid_requirements import WIDTH_FACTOR, GridRequirements, grid_requirements, halvable_count
from contactstudy.planning.planned import Plan, plan_on
from contactstudy.planning.refinement import first_grids, with_width
from contactstudy.problem.constraint import tabor_length, zone_length
from contactstudy.scene.adhesion import ZONE_CELLS
from contactstudy.scene.friction import Fretting
from contactstudy.scene.loads import DATUM_OVER_RADIUS, ChangingLoad, LineLoad
from contactstudy.scene.scene import AnyLoad, Scene
from contactstudy.scene.solids.bodies import Body, contact_modulus, instantaneous, yields
from contactstudy.scene.solids.inelastic import creeping, relaxed

# Plastic zone below a rigid cylinder pressed with Hertz's peak pressure r times the yield stress, r from 2 to 8, with
# little or no hardening. Over Hertz's half-width, it ends at PLASTIC_WIDTH + PLASTIC_WIDENING r^2 across, and at the
# depth PLASTIC_DEPTH r - 1. Fitted to computed zones.
PLASTIC_WIDTH, PLASTIC_WIDENING, PLASTIC_DEPTH = 0.62, 0.07, 1.2
# Planned width of the zone over that, as a margin for what the fit leaves out: other shapes, two bodies, hardening.
ZONE_MARGIN = 1.25
# Number of tensor fields of plastic strain that a step holds, in plane strain and where strain varies along the length:
# measured on rough cylinders of 48^2 to 128^2 cells.
STRAIN_FIELDS, STRAIN_FIELDS_ALONG = 24, 36
# Factor on the width of a contact that rolls steadily on a body that creeps, whose displacement behind it is not zero.
ROLLING_WIDENING = 1.5
# Factors on the extent of the plastic zone and on the bytes of its operators in passes. Under Hertz's peak pressure of 3
# and 4 times the yield stress, grids 3.9 and 5.4 half-widths wide hold the zone of passes, and grids of 3.6 and 4.4 do
# not. Memory was 3.7 to 7.8 times the operators in 16 runs, and a plan says what is needed at most.
ROLLED_WIDENING, ROLLED_OPERATORS = 1.25, 8
# Number of fields (x, y) that an integration in time holds beside those of creep: pressures, gaps and worn depths of two
# steps and of their half steps.
INTEGRATION_FIELDS = 8
# Number of fields (x, y) that the iteration of a steadily rolling contact holds, with those of its mixed iterates.
ROLLING_FIELDS = 32
# Widening of a contact that wears under partial slip, over the square of ``Q / (mu P)``. By the closed form in
# `_fretting` it is 0.6 to 0.8 for ratios up to 0.97.
SCAR_WIDENING = 0.8
# Loads below this fraction of the largest are not planned for: their grid would have more than ten times the cells, as
# the size of cells goes with the square root of the load.
MIN_LOAD_FRACTION = 0.1


@dataclass(frozen=True)
class PlasticZone:
    """Expected plastic zone: its extent and the cost of its strain.

    Attributes
    ----------
    ratio
        Hertz's peak pressure over the lowest yield stress.
    half_width
        Hertz's half-width [m].
    bodies
        Number of bodies that yield.
    rolls
        True if the contact passes over it, so that strain is kept over all of the grid that moves with the contact.
    """

    ratio: float
    half_width: float
    bodies: int
    rolls: bool

    @property
    def half_extent(self) -> float:
        """Distance [m] across from the axis to the end of the plastic zone, behind a contact that rolls."""
        half_widths = PLASTIC_WIDTH + PLASTIC_WIDENING * self.ratio**2
        widening = ROLLED_WIDENING if self.rolls else 1.0
        return self.half_width * ZONE_MARGIN * half_widths * widening

    def volume(self, grid: Grid) -> Volume:
        """Return the volume of cells below `grid` expected to yield; of a contact that rolls over the whole width."""
        middle = grid.cells[0] // 2
        across = middle if self.rolls else min(round(self.half_extent / grid.cell_size[0]), middle)
        depth = max(PLASTIC_DEPTH * self.ratio - 1, 1.0) * self.half_width
        edges = layers(grid, self.half_width, depth)
        return Volume(grid, middle - across, min(middle + across, grid.cells[0]), edges)

    def bytes(self, grid: Grid) -> int:
        """Return the bytes of operators and fields on `grid`, in addition to one solve."""
        volume = self.volume(grid)
        count, across, along = volume.shape
        # 3 components of a plastic strain in plane strain, else 5, as it keeps the volume; operators are matrices
        # between those of all layers for each wave number
        if along == 1:
            operators = (across + 1) * (3 * count) ** 2
            numbers = operators + STRAIN_FIELDS * 3 * prod(volume.shape)
        else:
            numbers = STRAIN_FIELDS_ALONG * 5 * prod(volume.shape)
        return 8 * self.bodies * numbers * (ROLLED_OPERATORS if self.rolls else 1)


def expected_plastic_zone(scene: Scene) -> PlasticZone | None:
    """Return the expected plastic zone under the largest load of `scene`.

    None where nothing yields, or no curvature determines the width of the contact.
    """
    limits = [float(getattr(body, "yield_stress", 0.0)) for body in filter(yields, scene.solids)]
    if not limits or scene.hertz is None:
        return None
    ratio = scene.hertz.peak_pressure / min(limits)
    return PlasticZone(ratio, scene.hertz.half_width, len(limits), scene.rolls)


@dataclass(frozen=True)
class TransientRequirements:
    """Requirements of the narrowest and the widest contact of a scene in time.

    Attributes
    ----------
    narrow
        Static scene of the smallest load that is planned for, or of the largest where it rolls or yields, before creep
        and wear. Its contact is the narrowest, and needs the finest cells.
    width
        Width [m] of a grid that holds the widest contact.
    least_width
        Width [m] below which a grid that is given may be too narrow for it.
    relaxed
        Bodies once they have crept.
    fields
        Number of fields (x, y) held between solves, in addition to those of one solve.
    warnings
        A sentence for each fault.
    plastic
        Expected plastic zone; None without one.
    length
        Length [m] of a grid that holds the longest contact of a ball; 0 for a line contact.
    """

    narrow: Scene
    width: float
    least_width: float
    relaxed: tuple[Body, Body]
    fields: int
    warnings: tuple[str, ...] = ()
    plastic: PlasticZone | None = None
    length: float = 0.0


def transient_requirements(scene: Scene, end: float | None = None) -> TransientRequirements:
    """Return the requirements of a scene in time.

    The half-width of the contact grows in turn by creep, by the plastic zone, by wear, and by heights under the smallest
    load. Wear takes ``2 (a^3 - a0^3) / (3 R)`` from the section of a cylinder of the radius R as the half-width grows
    from a0 to a.

    Parameters
    ----------
    scene
        The scene, which changes in time or rolls.
    end
        Last time [s]; None ends where the load and the other histories do.
    """
    # forces in time do not change the grid, and belong to loads of other times
    friction = None if getattr(scene.friction, "times", None) else scene.friction
    elastic = replace(
        scene.under(scene.largest_load), solids=instantaneous(scene.solids), wear=None, rolling=None, friction=friction
    )
    start = getattr(scene.load, "start", 0.0)
    ends = [history.end for history in scene.histories]
    last = end if end is not None else max(ends, default=start)
    duration = max(last - start, 0.0)
    hertz = elastic.hertz
    bodies = relaxed(scene.solids, duration)
    modulus = contact_modulus(bodies, hertz.half_width if hertz else None)
    half_width = sqrt(4 * hertz.load_per_length * hertz.radius / (pi * modulus)) if hertz else 0.0
    # creep keeps a field for each of its terms, at both ends of a step
    terms = sum(len(body.creep.terms) + bool(body.creep.fluidity) for body in creeping(scene.solids))
    plastic = expected_plastic_zone(scene)
    if scene.rolls:
        of_zone = plastic.half_extent if plastic else 0.0
        width, least_width = (
            2 * max(WIDTH_FACTOR * half_width * widening, of_zone) for widening in (ROLLING_WIDENING, 1.0)
        )
        return TransientRequirements(elastic, width, least_width, bodies, ROLLING_FIELDS, plastic=plastic)
    if plastic is not None:
        half_width = max(half_width, plastic.half_extent / WIDTH_FACTOR)
    widened = half_width / hertz.half_width if hertz else 1.0
    wear, ellipse, worn_volume = scene.wear, scene.ellipse, 0.0
    # a body that wears around its circumference keeps its shape
    if wear is not None and wear.coefficient and wear.circumference is None and hertz is not None and duration:
        slid = wear.speed * duration
        if isinstance(scene.friction, Fretting):
            widening, slid = _fretting(scene.friction, scene.load, hertz)
            half_width *= widening
        if ellipse is not None:
            worn_volume = wear.coefficient * ellipse.load * slid
            half_width = worn_semi_axis(half_width, *scene.curvatures, worn_volume)
        else:
            worn_area = wear.coefficient * elastic.largest_load * slid
            half_width = float(np.cbrt(half_width**3 + 1.5 * hertz.radius * worn_area))
    narrow = elastic
    warnings: tuple[str, ...] = ()
    if plastic is None:  # else errors are relative to the pressure of the largest load
        least, warnings = _smallest_load(scene, last)
        if least < elastic.largest_load:
            narrow = replace(elastic, load=LineLoad(least))
            if hertz is not None:  # no solve tells how heights, a crown or the hardness widen it
                half_width *= grid_requirements(elastic).half_width / hertz.half_width
    width, length = 2 * WIDTH_FACTOR * half_width, 0.0
    if ellipse is not None:
        assert scene.roller_length is not None
        semi_axis = ellipse.semi_axes[1]
        across, along = scene.curvatures
        longest = worn_semi_axis(widened * semi_axis, along, across, worn_volume)
        length = scene.roller_length * longest / semi_axis
    fields = 2 * terms + INTEGRATION_FIELDS
    return TransientRequirements(narrow, width, width, bodies, fields, warnings, plastic, length)


def worn_semi_axis(semi_axis: float, curvature: float, other: float, volume: float) -> float:
    """Return a semi-axis [m] of the contact of bodies curved both ways, after they have lost a `volume` [m3] to wear.

    A cap of a paraboloid with the semi-axes a and b and the `curvature` [1/m] along a has the volume
    ``pi a^3 b curvature / 4``. The semi-axis b is a times the root of ``curvature / other``, with the `other` curvature
    [1/m].
    """
    return float((semi_axis**4 + 4 * volume / (pi * curvature * sqrt(curvature / other))) ** 0.25)


def _fretting(friction: Fretting, load: AnyLoad, hertz: HertzLine) -> tuple[float, float]:
    """Return by how much partial slip widens the contact until it wears no more, and the distance of gross slip [m].

    Under a force Q a middle of the half-width c, ``c^2 = a^2 (1 - Q / (mu P))``, then bears all of the load. The gap
    beside it, of the slope ``(x^2 - (a^2 + c^2) / 2) / (R (x^2 - c^2)^(1/2))``, is zero again at ``x = c cosh t`` with
    ``sinh 2t / 2t = a^2 / c^2``, up to 1.74 half-widths of Hertz at ``Q / (mu P) = 0.97``. Under a displacement d from
    a datum D ``Q / (mu P)`` is at most ``pi E* d / (2 ln(2 D / a) mu P)``. Where that is 1 or more, the contact may
    slide fully, over each half cycle that a step stands for.
    """
    history = friction.history
    assert history is not None
    limit = friction.coefficient
    if friction.displacements is not None:
        datum = DATUM_OVER_RADIUS * hertz.radius
        limit *= 2 * log(2 * datum / hertz.half_width) / (pi * hertz.contact_modulus)
    loads = {
        time: load.at(time) if isinstance(load, ChangingLoad) else hertz.load_per_length
        for time in history.compared_with(load)
    }
    fractions = (abs(history.at(time)) / (limit * pressed) for time, pressed in loads.items() if pressed)
    fraction = max(fractions, default=0.0)
    if fraction < 1:
        return 1 + SCAR_WIDENING * fraction**2, 0.0
    half_cycles = np.maximum(1, 2 * np.diff(history.times) / (friction.period or inf))
    return 1.0, float(half_cycles @ np.abs(np.diff(history.values)))


def _smallest_load(scene: Scene, end: float) -> tuple[float, tuple[str, ...]]:
    """Return the smallest load [N/m] that is planned for up to the time `end` [s], and a warning of smaller ones."""
    load = scene.load
    if not isinstance(load, ChangingLoad):
        return scene.largest_load, ()
    times = (load.start, *load.breaks(end), *load.turning_points(end), max(end, load.start))
    smallest = min(load.at(time) for time in times if time <= times[-1])
    least = max(smallest, MIN_LOAD_FRACTION * load.largest)
    if smallest >= least:
        return least, ()
    return least, (
        f"The load is below {readable(least, 'N m-1', 3)} at times, where the contact is so narrow that the "
        "discretisation error is larger than planned: give a finer grid, or a larger first load.",
    )


# Tabor parameter taken as the JKR limit where no range is given. Of a contact that does not vary along its length the
# pull-off load is then within 1 %, and of one that does, within 4 %. The cost grows with the square of it.
TABOR_SMOOTH, TABOR_VARYING = 4.0, 2.0
# Distance from the edge at which the attraction of a cylinder has fallen to 1e-6, over the square root of twice the
# product of its radius and the range. It is the root of -ln 1e-6, for a gap that grows with the square of the distance.
DECAY_DISTANCE = 3.7


def plan_of_adhesion(
    scene: Scene,
    error: float,
    period: float | None,
    grid: Grid | None,
    padding: Padding | Paddings | None = None,
    transient: TransientRequirements | None = None,
) -> Plan:
    """Return the plan of a scene with adhesion.

    It has `ZONE_CELLS` cells in the cohesive zone, the length beside the edge of the contact over which the attraction
    acts at its full strength, and room for the attraction beside the contact. Other cells are those of the same scene
    without adhesion.

    Parameters
    ----------
    scene
        The scene, with adhesion and a curved shape.
    error
        Relative L1 error of the pressure.
    period
        Length of the grid [m]; chosen if None.
    grid, padding
        Grid and boundary conditions to keep; chosen if None.
    transient
        Requirements of bodies that creep or yield: the cohesive zone shrinks as the modulus relaxes.
    """
    requirements, adhesion = grid_requirements(scene, padding), scene.adhesion
    radius = scene.radius
    assert adhesion is not None
    assert radius is not None
    bodies = scene.solids if transient is None else transient.relaxed
    modulus = adhesion.zone_modulus(bodies, requirements.hertz.half_width)
    tabor = TABOR_VARYING if requirements.varies else TABOR_SMOOTH
    attraction_range = adhesion.range or tabor_length(radius, adhesion.work, modulus) / tabor
    zone = zone_length(modulus, adhesion.work, adhesion.work / attraction_range)
    if grid is None:
        decay_distance = DECAY_DISTANCE * sqrt(2 * radius * attraction_range)
        load = LineLoad(requirements.hertz.load_per_length)
        pressed = Scene(load, instantaneous(scene.solids), scene.shapes)
        base = first_grids(pressed, grid_requirements(pressed), error, period).grid
        width = max(base.extent[0], requirements.extent(period)[0])
        if transient is not None:
            width = max(width, transient.width)
        grid = _grid(with_width(base, width), requirements, zone / ZONE_CELLS, decay_distance)
    cell = max(grid.cell_size) if requirements.varies else grid.cell_size[0]
    cells = zone / cell
    if adhesion.range is None:  # the range is then chosen for the grid
        cells = ZONE_CELLS
    reason = f"adhesion: {cells:.3g} cells in the cohesive zone, and room for the attraction beside the contact."
    warnings = requirements.warnings(grid)
    if cells < ZONE_CELLS * (1 - 1e-9):
        axis = grid.cell_size.index(cell)
        finer = int(grid.cells[axis] * ZONE_CELLS / cells) + 1
        warnings += (
            f"Grid.cells[{axis}] is {grid.cells[axis]}: {cells:.2g} cells in the cohesive zone, so few that the "
            f"grid pins the edge of the contact (lattice trapping): give {finer} for {ZONE_CELLS:.0f}.",
        )
    return plan_on(scene, grid, requirements.padding(), (*requirements.reasons(grid), reason), warnings)


def _grid(base: Grid, requirements: GridRequirements, cell: float, decay_distance: float) -> Grid:
    """Return the grid `base`, which suits the surfaces alone, made wider by `decay_distance` [m] on either side.

    Its cells are at most `cell` [m] along both axes.
    """
    width = requirements.width(base.extent[0] + 2 * decay_distance)
    across = halvable_count(width / min(base.cell_size[0], cell))
    along = base.cells[1]
    if along > 1:
        along = max(along, halvable_count(base.length / min(base.cell_size[1], cell)))
    return replace(base, cells=(across, along), extent=(width, base.length))
