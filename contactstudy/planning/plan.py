"""Which grid and padding a scene calls for, and what that will cost, said before anything runs."""

from dataclasses import dataclass

from contactstudy.domain.checks import InvalidInput, NotDefined, positive
from contactstudy.domain.grid import Grid
from contactstudy.domain.padding import Padding, Paddings
from contactstudy.planning.cost import ROUGH_ITERATIONS, SMOOTH_ITERATIONS, memory, timed
from contactstudy.planning.grid_requirements import Needs
from contactstudy.scene.scene import Scene


@dataclass(frozen=True)
class Plan:
    """A ``grid`` and a ``padding`` for ``scene.problem(plan.grid, plan.padding)``, and what to expect of them.

    ``dimension`` is 1 where nothing varies along the length, else 2. ``error`` is the relative L1 error of
    the pressure to expect, by the measured laws of the cell size; ``seconds`` on one thread of this
    machine, from a transform timed just now, within a factor of some two; ``bytes`` at the most.
    ``period_check`` says how the period suits the scene, ``reasons`` a sentence for each choice, and
    ``warnings`` what is wrong with a grid that was given.
    """

    grid: Grid
    padding: Padding | Paddings
    dimension: int
    error: float
    seconds: float
    bytes: int
    period_check: str
    reasons: tuple[str, ...]
    warnings: tuple[str, ...] = ()


def plan(
    scene: Scene, *, error: float = 1e-3, period: float | None = None, grid: Grid | None = None
) -> Plan:
    """A grid and a padding that solve ``scene`` to a relative L1 ``error`` of the pressure.

    ``period`` [m] is chosen where none is given. With a ``grid``, that one is kept, and the plan says
    what is wrong with it. Raises :class:`~contactstudy.InvalidInput` where a scene leaves open what a
    plan needs: without a curved shape there is no width of contact, without a roller's length no grid.
    """
    error = positive("plan.error", error, "give a relative error above 0, such as 1e-3")
    needs = needs_of(scene)
    if grid is None:
        grid = needs.grid(error, period)
    elif period is not None and period != grid.period:
        raise InvalidInput(f"plan.period is {period!r}: leave it out, since the grid has its own.")
    padding = needs.padding()
    iterations = ROUGH_ITERATIONS if needs.rough else SMOOTH_ITERATIONS
    return Plan(
        grid=grid,
        padding=padding,
        dimension=1 if grid.cells[1] == 1 else 2,
        error=needs.error(grid.cell),
        seconds=timed(grid, padding).seconds(grid, padding, iterations),
        bytes=memory(grid, padding),
        period_check=needs.period_check(grid.period),
        reasons=needs.reasons(grid),
        warnings=needs.warnings(grid),
    )


def needs_of(scene: Scene) -> Needs:
    """What ``scene`` asks of a grid; :class:`~contactstudy.InvalidInput` as for :func:`plan`."""
    if scene.hertz is None:
        raise NotDefined(
            "Scene.shapes have no curvature, so that the contact has no width of its own: "
            "give a Cylinder, or choose the grid yourself."
        )
    for number, shape in enumerate(scene.shapes):
        if not hasattr(shape, "detail"):
            raise InvalidInput(
                f"Scene.shapes[{number}] is {shape!r}, which does not say how fine it is: give it a "
                "`detail`, or choose the grid yourself."
            )
    details = tuple(shape.detail for shape in scene.shapes if hasattr(shape, "detail"))
    return Needs(scene.hertz, details, scene.hardness)
