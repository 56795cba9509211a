"""Warnings about implausible solutions, with the unit that was likely mistaken."""

from math import inf, sqrt

import numpy as np

from contactstudy.analytic import first_yield
from contactstudy.domain.fields import BLOCK_CELLS, Array
from contactstudy.scene.scene import Scene, scene_of
from contactstudy.scene.solids.bodies import HalfSpace
from contactstudy.solvers.solution import Solution

# Beyond these a contact is not one of elastic half-spaces: peak pressure over E*, slope of the heights, approach over
# the radius, and width of the grid over that of the contact.
MAX_PRESSURE, MAX_SLOPE, MAX_APPROACH, MAX_WIDTH = 0.1, 1.0, 1.0, 1e3
# A modulus below this [Pa] is softer than any gel: that of a metal or a polymer was given in GPa or MPa.
MIN_MODULUS = 1e3


def implausible(solution: Solution) -> str:
    """Return one sentence about implausible numbers, with the unit that was likely mistaken; else ``""``."""
    scene, grid, pressure = scene_of(solution.problem), solution.problem.grid, solution.pressure
    if scene is None or not np.isfinite(pressure).all():
        return ""
    peak, modulus, hertz = solution.peak_pressure, scene.contact_modulus, scene.hertz
    slope = _slope(solution)
    width = float(np.count_nonzero(pressure.any(axis=1)) * grid.cell_size[0])
    hints = {
        "heights": "are heights given in µm as if they were m?",
        "modulus": "is a modulus given in GPa or MPa as if it were Pa?",
        "extent": "is a length of the grid or the load given in another unit, such as mm or N/mm?",
        "load": "is the load or a radius given in another unit, such as N/mm or mm?",
    }
    facts, hint = [], "modulus" if modulus < MIN_MODULUS else ""
    if slope > MAX_SLOPE:
        facts.append(f"the heights have slopes of {slope:.2g}")
        hint = hint or "heights"
    if peak > MAX_PRESSURE * modulus:
        facts.append(f"the peak pressure is {peak / modulus:.2g} times the contact modulus E*")
        hint = hint or "load"
    if hertz is not None and abs(solution.approach) > MAX_APPROACH * hertz.radius:
        facts.append(
            f"the approach is {abs(solution.approach) / hertz.radius:.2g} times the radius"
        )
        hint = hint or "load"
    if 0 < width < grid.extent[0] / MAX_WIDTH:
        facts.append(f"the grid is {grid.extent[0] / width:.2g} times as wide as the contact")
        hint = hint or "extent"
    return f"The input is implausible: {', '.join(facts)}; {hints[hint]}" if facts else ""


def beyond_strength(solution: Solution) -> str:
    """Return a sentence if the peak pressure is beyond the hardness or the first yield of an elastic body, or ``""``.

    Hardness and yield stress are those of the bodies, the load at first yield that of the smooth line contact. Nothing
    is said of a body that yields, nor together with ``Scene.hardness``, which caps the pressure.
    """
    scene, peak = scene_of(solution.problem), solution.peak_pressure
    if scene is None or scene.hardness < inf:
        return ""
    surfaces = [getattr(body, "coating", body) for body in scene.solids]
    hardness = [getattr(body, "hardness", inf) for body in surfaces]
    if peak > min(hardness):
        softer = hardness.index(min(hardness))
        return (
            f"The peak pressure of {peak / 1e9:.3g} GPa is {peak / hardness[softer]:.2g} times the hardness of "
            f"Scene.solids[{softer}], {hardness[softer] / 1e9:.3g} GPa: give Scene.hardness, or a body that yields."
        )
    for number, body in enumerate(scene.solids):
        # first yield is above the yield stress
        if not isinstance(body, HalfSpace) or not body.yield_stress < peak:
            continue
        limit = body.yield_stress
        radius = scene.hertz.radius if scene.hertz else 1.0
        first = first_yield(radius, scene.contact_modulus, limit, body.poisson_ratio)
        if peak > first.peak_pressure:
            at = f" at {first.load_per_length / 1e3:.3g} N/mm" if scene.hertz else ""
            return (
                f"The peak pressure of {peak / 1e9:.3g} GPa is {peak / first.peak_pressure:.2g} times that at which "
                f"Scene.solids[{number}] first yields in a smooth line contact{at}: give an ElasticPlasticHalfSpace, or "
                "the yield_stress of your material."
            )
    return ""


def yield_stress_of_outputs(scene: Scene) -> float:
    """Return the lowest yield stress [Pa] of the elastic bodies whose stress is an output; infinite if none is known."""
    solids = (scene.solids[out.body] for out in scene.outputs if hasattr(out, "body"))
    return min((body.yield_stress for body in solids if isinstance(body, HalfSpace)), default=inf)


def stress_beyond_yield(scene: Scene, von_mises: float) -> str:
    """Return a sentence if the von Mises stress [Pa] below the surface is beyond the yield stress, or ``""``."""
    limit = yield_stress_of_outputs(scene)
    if von_mises <= limit:
        return ""
    return (
        f"The von Mises stress of {von_mises / 1e6:.3g} MPa is {von_mises / limit:.3g} times the yield stress: "
        "give an ElasticPlasticHalfSpace, or the yield_stress of your material."
    )


def _slope(solution: Solution) -> float:
    """Return the slope of the heights: the larger of its median over the grid and its rms between touching cells.

    It is 0 if no slope is above `MAX_SLOPE`.
    """
    gap, touching = solution.problem.undeformed_gap, solution.pressure > 0
    largest = 0.0
    for axis, step in enumerate(solution.problem.grid.cell_size):
        if gap.shape[axis] < 3:
            continue
        if _steepest(gap, axis) <= MAX_SLOPE * step:  # as are median and rms
            continue
        slopes = np.abs(np.diff(gap, axis=axis)) / step
        both = np.take(touching, range(1, gap.shape[axis]), axis) & np.take(
            touching, range(gap.shape[axis] - 1), axis
        )
        within = sqrt(float((slopes[both] ** 2).mean())) if both.any() else 0.0
        largest = max(largest, float(np.median(slopes)), within)
    return largest


def _steepest(field: Array, axis: int) -> float:
    """Return the largest difference between neighbours along an axis, by blocks of rows that share one."""
    rows = max(1, BLOCK_CELLS // field.shape[1])
    largest = 0.0
    for begin in range(0, len(field) - 1, rows):
        differences = np.diff(field[begin : begin + rows + 1], axis=axis)
        largest = max(largest, float(differences.max()), -float(differences.min()))
    return largest
