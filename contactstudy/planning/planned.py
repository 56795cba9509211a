"""A plan: grid and padding for a scene, with expected error and cost."""

from dataclasses import dataclass, field

from contactstudy.domain.checks import set_fields
from contactstudy.domain.device import ONE_THREAD, Device
from contactstudy.domain.grid import Grid, Padding, Paddings
from contactstudy.domain.notebook import InNotebook
from contactstudy.scene.scene import Scene


@dataclass(frozen=True)
class Plan(InNotebook):
    """A grid and a padding for a scene, with expected error and cost.

    Solve it with ``solve(plan.scene, plan.grid, plan.padding)``.

    Attributes
    ----------
    scene
        The scene. Its random surfaces have an extent: where the contact is narrower than they are, the grid is too.
    grid
        The grid.
    padding
        The boundary conditions.
    dimension
        Dimension of the surface grid: 1 in plane strain, where nothing varies along the length; 2 of a contact in three
        dimensions.
    error
        Relative L1 error of the pressure to expect of the cells: of dry contacts from solutions on coarse grids, where
        these give no bound and with adhesion by a law, as of a smooth contact on a grid that was given; of the images
        that a given padding leaves out, and of the range of an attraction that the grid chooses. Of a scene in time that
        of the steps adds to it. Of a film, the one requested. Infinite where it is not predicted.
    seconds
        Seconds of processor time (with a device, of wall time) of a solve to the error: its plan, all grids and steps,
        their estimates, and the stress that a steady scene names, from solves on coarser grids just now. Imports,
        compilation, files and plots are not counted. Infinite where no coarser grid can be solved.
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
    coarse_seconds
        Seconds of them for the coarser grids that were solved for the plan of a static contact, as its solve does.
    """

    scene: Scene = field(repr=False)
    grid: Grid
    padding: Padding | Paddings
    dimension: int = field(init=False)
    error: float
    seconds: float
    bytes: int
    period_check: str
    reasons: tuple[str, ...]
    warnings: tuple[str, ...] = ()
    solves: int = 1
    device: Device = ONE_THREAD
    coarse_seconds: float = 0.0

    def __post_init__(self) -> None:
        set_fields(self, dimension=1 if self.grid.cells[1] == 1 else 2)
