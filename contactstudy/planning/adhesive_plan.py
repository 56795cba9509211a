"""Plan of a scene with adhesion: six cells in the cohesive zone, and a width that holds the attraction."""

from dataclasses import replace
from math import inf, sqrt

from contactstudy.accuracy.range_errors import l1_range_error
from contactstudy.domain.grid import Grid, Padding, Paddings
from contactstudy.domain.units import readable
from contactstudy.planning.cost import memory
from contactstudy.planning.forecast import images_error, images_warning, with_width
from contactstudy.planning.grid_requirements import (
    GridRequirements,
    grid_requirements,
    halvable_count,
)
from contactstudy.planning.planned import Plan
from contactstudy.planning.transient_requirements import TransientRequirements
from contactstudy.scene.adhesion import ZONE_CELLS
from contactstudy.scene.loads.constant_load import LineLoad
from contactstudy.scene.scene import Scene
from contactstudy.scene.solids.bodies import contact_modulus, instantaneous
from contactstudy.solvers.cohesive_law import tabor_length, zone_length

# Tabor parameter taken as the JKR limit: of a contact that does not vary along its length, where
# the pull-off load is then within 1 %, and of one that does, within 4 %. Cost grows with its square.
TABOR_SMOOTH, TABOR_VARYING = 4.0, 2.0
# Distance at which the attraction of a cylinder has fallen to 1e-6, over the square root of twice the product of its
# radius and the range.
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
    strength = adhesion.work / attraction_range
    zone = zone_length(modulus, adhesion.work, strength)
    if grid is None:
        decay_distance = DECAY_DISTANCE * sqrt(2 * radius * attraction_range)
        base = requirements.grid(error, period)
        if transient is not None and transient.width > base.extent[0]:
            base = with_width(base, transient.width)
        grid = _grid(base, requirements, zone / ZONE_CELLS, decay_distance)
    cell = max(grid.cell_size) if requirements.varies else grid.cell_size[0]
    load, by_range, cells = requirements.hertz.load_per_length, 0.0, zone / cell
    if adhesion.range is None:
        modulus = contact_modulus(bodies, ZONE_CELLS * cell)
        attraction_range, cells = adhesion.cohesive(modulus, cell).range, ZONE_CELLS
        edges, force = 2 * grid.length, load * grid.length
        by_range = l1_range_error(edges, modulus, attraction_range, force)
    tabor = tabor_length(radius, adhesion.work, modulus) / attraction_range
    padding = requirements.padding()
    images = 0.0
    if padding != replace(requirements, given_padding=None).padding():
        pressed = Scene(LineLoad(load), instantaneous(scene.solids), scene.shapes)
        images = images_error(pressed, grid, padding)
    reason = (
        f"adhesion: {cells:.3g} cells in the cohesive zone at a Tabor parameter of {tabor:.3g}, and room for the "
        f"attraction beside the contact."
    )
    warnings = requirements.warnings(grid)
    if cells < ZONE_CELLS * (1 - 1e-9):
        axis = grid.cell_size.index(cell)
        finer = int(grid.cells[axis] * ZONE_CELLS / cells) + 1
        warnings += (
            f"Grid.cells[{axis}] is {grid.cells[axis]}: {cells:.2g} cells in the cohesive zone, so few that the "
            f"grid pins the edge of the contact (lattice trapping): give {finer} for six.",
        )
    if by_range > error:
        warnings += (
            f"plan.error is {error:.2g}: the range of {readable(attraction_range)} that the grid chooses in place of "
            f"the JKR limit contributes {by_range:.2g}, give Adhesion.range, or finer cells.",
        )
    expected_error = requirements.error(grid.cell_size)
    return Plan(
        scene=scene,
        grid=grid,
        padding=padding,
        error=expected_error + images + by_range,
        seconds=inf,
        bytes=memory(grid, padding),
        period_check=requirements.period_check(grid.length),
        reasons=(*requirements.reasons(grid, expected_error), reason),
        warnings=(*warnings, *images_warning(padding, images, error)),
    )


def _grid(base: Grid, requirements: GridRequirements, cell: float, decay_distance: float) -> Grid:
    """Return the grid `base` of the surfaces alone, wider by `decay_distance` [m], with cells of at most `cell` [m]."""
    width = requirements.width(base.extent[0] + 2 * decay_distance)
    across = halvable_count(width / min(base.cell_size[0], cell))
    along = base.cells[1]
    if along > 1:
        along = max(along, halvable_count(base.length / min(base.cell_size[1], cell)))
    return replace(base, cells=(across, along), extent=(width, base.length))
