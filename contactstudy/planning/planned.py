"""A plan: grid and padding for a scene, with expected error and cost."""

from dataclasses import dataclass, field
from math import inf
from typing import TYPE_CHECKING

from contactstudy.domain.checks import set_fields
from contactstudy.domain.device import ONE_THREAD, Device
from contactstudy.domain.grid import Grid, Padding, Paddings
from contactstudy.domain.notebook import InNotebook
from contactstudy.scene.scene import Scene

if TYPE_CHECKING:
    from contactstudy.planning.refinement import FirstGrids


@dataclass(frozen=True, kw_only=True)
class Plan(InNotebook):
    """A grid and a padding for a scene, with expected error and cost.

    Solve it with ``solve(plan.scene, plan.grid, plan.padding)``.

    Attributes
    ----------
    scene
        The scene. Its random surfaces have an extent: where the contact is narrower than they are, the grid is too.
    grid
        The grid on which a solve to the error is expected to end; a reason may name that on which it begins.
    padding
        The boundary conditions.
    dimension
        Dimension of the surface grid: 1 in plane strain, where nothing varies along the length; 2 of a contact in three
        dimensions.
    error
        Bound of the relative L1 error of the pressure to expect, with all its causes but the steps in time, from
        solutions on coarse grids. Of a film, the error requested. Infinite where they give none.
    seconds
        Seconds of processor time (with a device, of wall time) of a solve to the error: its plan, all grids and steps,
        their estimates, and the stress that a steady scene names, from solves on coarser grids just now. Imports,
        compilation, tables of a material, files and plots are not counted. Infinite where no coarser grid can be solved.
    bytes
        Bytes that a solve holds at most.
    period_check
        A sentence on how the period suits the scene.
    reasons
        A sentence for each choice.
    warnings
        A sentence for each fault of a grid that was given, and on a requested error that is out of reach.
    solves
        Number of contacts or films that are solved one after the other, where a scene changes in time or
        rolls.
    device
        Device that the seconds are for.
    first_grids
        Solutions of a static contact on the grids with which its solve begins; None of others, or on a given grid.
    """

    scene: Scene = field(repr=False)
    grid: Grid
    padding: Padding | Paddings
    dimension: int = field(init=False)
    error: float = inf
    seconds: float = inf
    bytes: int
    period_check: str
    reasons: tuple[str, ...]
    warnings: tuple[str, ...] = ()
    solves: int = 1
    device: Device = ONE_THREAD
    first_grids: "FirstGrids | None" = field(default=None, repr=False)

    def __post_init__(self) -> None:
        set_fields(self, dimension=1 if self.grid.cells[1] == 1 else 2)
