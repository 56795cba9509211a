"""Plan of a scene with adhesion: six cells in the cohesive zone, and a width that holds the attraction."""

from dataclasses import replace
from math import sqrt

from contactstudy.domain.grid import Grid, Padding, Paddings
from contactstudy.planning.grid_requirements import GridRequirements, grid_requirements, halvable_count
from contactstudy.planning.planned import Plan, memory
from contactstudy.planning.refinement import first_grids, with_width
from contactstudy.planning.transient_requirements import TransientRequirements
from contactstudy.scene.adhesion import ZONE_CELLS
from contactstudy.scene.loads.constant_load import LineLoad
from contactstudy.scene.scene import Scene
from contactstudy.scene.solids.bodies import instantaneous
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
    padding = requirements.padding()
    reason = f"adhesion: {cells:.3g} cells in the cohesive zone, and room for the attraction beside the contact."
    warnings = requirements.warnings(grid)
    if cells < ZONE_CELLS * (1 - 1e-9):
        axis = grid.cell_size.index(cell)
        finer = int(grid.cells[axis] * ZONE_CELLS / cells) + 1
        warnings += (
            f"Grid.cells[{axis}] is {grid.cells[axis]}: {cells:.2g} cells in the cohesive zone, so few that the "
            f"grid pins the edge of the contact (lattice trapping): give {finer} for six.",
        )
    return Plan(
        scene=scene,
        grid=grid,
        padding=padding,
        bytes=memory(grid, padding),
        period_check=requirements.period_check(grid.length),
        reasons=(*requirements.reasons(grid), reason),
        warnings=warnings,
    )


def _grid(base: Grid, requirements: GridRequirements, cell: float, decay_distance: float) -> Grid:
    """Return the grid `base` of the surfaces alone, wider by `decay_distance` [m], with cells of at most `cell` [m]."""
    width = requirements.width(base.extent[0] + 2 * decay_distance)
    across = halvable_count(width / min(base.cell_size[0], cell))
    along = base.cells[1]
    if along > 1:
        along = max(along, halvable_count(base.length / min(base.cell_size[1], cell)))
    return replace(base, cells=(across, along), extent=(width, base.length))
