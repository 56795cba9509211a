"""A problem under another load, with the heights and coefficients it has."""

from dataclasses import replace

from contactstudy.domain.checks import InvalidInput
from contactstudy.problem.bare_problem import PrescribedLoad
from contactstudy.problem.problem import Problem
from contactstudy.scene.loads.load import LineLoad
from contactstudy.scene.scene import PosedScene


def under_load(problem: Problem, load: LineLoad) -> Problem:
    """``problem``, made from a scene, under ``load``: it shares heights and operator, and so costs nothing.

    The operator keeps its datum, so that approaches under several loads count from one place.
    Raises :class:`~contactstudy.InvalidInput` for a problem that was not made from a scene.
    """
    posed = problem.description
    if not isinstance(posed, PosedScene):
        raise InvalidInput(
            "under_load.problem was not made from a scene: give scene.problem(grid, padding)."
        )
    grid, scene = posed.grid, replace(posed.scene, load=load)
    return replace(
        problem,
        resultant=PrescribedLoad(load.per_length * grid.period / grid.cell_area),
        scales=scene.scales(grid),
        source=scene.source_on(grid, posed.padding),
        description=PosedScene(scene, grid, posed.padding),
    )
