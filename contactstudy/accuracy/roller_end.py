"""The end of a roller that is computed as a part of a half-space, and by how much free faces lower its peak."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from contactstudy.domain.checks import InvalidInput
from contactstudy.domain.fields import Array
from contactstudy.domain.units import readable
from contactstudy.scene.scene import PosedScene
from contactstudy.scene.solids.free_faces import FreeFaces
from contactstudy.solvers.solution import Solution
from contactstudy.solvers.solve import SolveOptions, solve_contact

# Most cells of a contact that is solved once more, and the residual at which that ends.
MOST_CELLS, TOLERANCE = 2**17, 1e-4


def end_of_half_space(solution: Solution) -> str:
    """Return a sentence if a roller's ends carry more than its middle without free faces, else ``""``.

    It says by how much free faces lower the pressure there, where the contact is quickly solved with them.
    """
    problem, posed = solution.problem, solution.problem.description
    if not isinstance(posed, PosedScene) or problem.source is None or not problem.source.ends_along:
        return ""
    scene, length = posed.scene, posed.scene.roller_length
    on_roller = problem.covered_fractions
    rows = np.arange(problem.grid.cells[1]) if on_roller is None else np.flatnonzero(on_roller)
    middle = solution.pressure[:, rows[len(rows) // 2]].max()
    if scene.free_length < np.inf or length is None or _at_ends(solution.pressure, rows) <= middle:
        return ""
    number = next(number for number, body in enumerate(scene.solids) if body.compliance)
    key = f'free_faces = "{readable(length)}" of Scene.solids[{number}]'
    remedy = f"{key} ends the body too"
    if solution.pressure.size <= MOST_CELLS:
        try:
            ended = FreeFaces(scene.solids[number], length)  # type: ignore[arg-type]
            solids = (ended, scene.solids[1]) if number == 0 else (scene.solids[0], ended)
            with_faces = replace(scene, solids=solids, outputs=()).problem(
                problem.grid, posed.padding
            )
            softer = solve_contact(with_faces, SolveOptions(TOLERANCE), solution.pressure)
            lower = _at_ends(softer.pressure, rows) / _at_ends(solution.pressure, rows)
            remedy = f"with {key} it is {1 - lower:.0%} lower on this grid"
        except InvalidInput:  # an effect of the scene that is not computed with them
            remedy = f"{remedy}, where its other effects allow it"
    return f"A roller's end is stiffer as a part of a half-space, and its pressure an upper estimate: {remedy}."


def _at_ends(pressure: Array, rows: NDArray[np.intp]) -> float:
    """Return the larger of the peak pressures in the first and the last of `rows` along y."""
    return float(pressure[:, rows[[0, -1]]].max())
