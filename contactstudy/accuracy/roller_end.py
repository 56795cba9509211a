"""The ends of a roller: by how much free faces lower their pressure, and the drop that relieves them."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from contactstudy.domain.checks import InvalidInput
from contactstudy.domain.fields import Array
from contactstudy.domain.units import readable
from contactstudy.scene.scene import PosedScene
from contactstudy.scene.shapes.profile import EndRelief, ProfilePoints
from contactstudy.scene.shapes.roller import Crown, LundbergProfile
from contactstudy.scene.shapes.shape import length_scales_of
from contactstudy.scene.solids.free_faces import FreeFaces
from contactstudy.solvers.solution import Solution
from contactstudy.solvers.solve import SolveOptions, solve_contact

# Most cells of a contact that is solved once more, and the residual at which that ends.
MOST_CELLS, TOLERANCE = 2**17, 1e-4
# Pressure at the ends over that of the rest up to which these are relieved, and parts of Lundberg's drop to try.
RELIEVED, PARTS = 1.05, (1.0, 1.5, 2.25, 3.4)
# Shapes that another profile takes the place of.
PROFILES = Crown, LundbergProfile, EndRelief, ProfilePoints


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
            with_faces = replace(scene, solids=solids, outputs=()).problem(problem.grid, posed.padding)
            softer = solve_contact(with_faces, SolveOptions(TOLERANCE), solution.pressure)
            lower = _at_ends(softer.pressure, rows) / _at_ends(solution.pressure, rows)
            remedy = f"with {key} it is {1 - lower:.0%} lower on this grid"
        except InvalidInput:  # an effect of the scene that is not computed with them
            remedy = f"{remedy}, where its other effects allow it"
    return f"A roller's end is stiffer as a part of a half-space, and its pressure an upper estimate: {remedy}."


def unrelieved_ends(solution: Solution) -> str:
    """Return a sentence if a smooth roller's ends carry more than the rest of it, with a drop that would relieve them.

    The suggested drop is that of the profile which Lundberg (1939) makes for the load and the length, or one and a half
    or more times as large where a solve with it finds that the ends still carry more.
    """
    problem, posed = solution.problem, solution.problem.description
    if not isinstance(posed, PosedScene) or problem.source is None or not problem.source.ends_along:
        return ""
    scene, hertz, length = posed.scene, posed.scene.hertz, posed.scene.roller_length
    scales = length_scales_of(scene.shapes)
    if hertz is None or length is None or any(each.height for each in scales):
        return ""
    on_roller = problem.covered_fractions
    rows = np.arange(problem.grid.cells[1]) if on_roller is None else np.flatnonzero(on_roller)
    excess = _excess(solution.pressure, rows)
    if excess <= RELIEVED or length < 2 * hertz.half_width or solution.pressure.size > MOST_CELLS:
        return ""
    said = f"The ends carry up to {excess:.2f} times as much as the rest of the roller"
    even = LundbergProfile.for_load(
        hertz.load_per_length, contact_modulus=hertz.contact_modulus, radius=hertz.radius, length=length
    )  # fmt: skip
    kept = tuple(shape for shape in scene.shapes if not isinstance(shape, PROFILES))
    for part in PARTS:
        amplitude, drop = part * even.amplitude, part * even.end_drop
        shapes = (*kept, LundbergProfile(amplitude, drop, length))
        try:
            problem = replace(scene, shapes=shapes, outputs=()).problem(posed.grid, posed.padding)
            relieved = solve_contact(problem, SolveOptions(TOLERANCE))
        except InvalidInput:  # an effect of the scene that is not computed with it
            break
        if _excess(relieved.pressure, rows) <= RELIEVED:
            highest = [readable(float(p.max()), "Pa") for p in (solution.pressure, relieved.pressure)]
            return (
                f"{said}: suggested drop {readable(drop)} at each end, by LundbergProfile(amplitude={amplitude:.3g}, "
                f"end_drop={drop:.3g}, length={length:.6g}), with which the highest pressure on this grid is "
                f"{highest[1]} and not {highest[0]}."
            )
    return f"{said}, and Lundberg's profile for this load does not relieve them: lower the load or the tilt."


def _excess(pressure: Array, rows: NDArray[np.intp]) -> float:
    """Return the highest pressure in the outer tenths of the `rows` along y over that between them."""
    along = pressure.max(axis=0)[rows]
    count = max(len(rows) // 10, 1)
    between = along[count:-count].max(initial=0.0)
    return float(max(along[:count].max(), along[-count:].max()) / between) if between else 0.0


def _at_ends(pressure: Array, rows: NDArray[np.intp]) -> float:
    """Return the larger of the peak pressures in the first and the last of `rows` along y."""
    return float(pressure[:, rows[[0, -1]]].max())
