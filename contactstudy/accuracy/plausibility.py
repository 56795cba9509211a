"""Warnings about implausible solutions, with the unit that was likely mistaken."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import inf, isinf, pi, sqrt
from typing import Any

import numpy as np

from contactstudy.analytic import first_yield, first_yield_of_ball
from contactstudy.domain.fields import BLOCK_CELLS, Array
from contactstudy.domain.grid import ExactPeriodicity
from contactstudy.problem.problem import Field
from contactstudy.scene.scene import Scene, scene_of
from contactstudy.scene.solids.bodies import (
    Body,
    HalfSpace,
    in_part,
    is_layered,
    modulus_at_own_width,
)
from contactstudy.solvers.solution import Solution, Status

# Beyond these a contact is not one of elastic half-spaces: peak pressure over E*, slope of the heights, approach over
# the radius, and width of the grid over that of the contact.
MAX_PRESSURE, MAX_SLOPE, MAX_APPROACH, MAX_WIDTH = 0.1, 1.0, 1.0, 1e3
# The substrate's side of an interface, over the thickness, and what to do about a material beyond its strength.
BELOW_INTERFACE = 1 + 1e-9
GIVE_STRENGTH = "give an ElasticPlasticHalfSpace, or the strength of your material."
# A modulus below this [Pa] is softer than any gel: that of a metal or a polymer was given in GPa or MPa.
MIN_MODULUS = 1e3


def implausible(solution: Solution) -> str:
    """Return one sentence about implausible numbers, with the unit that was likely mistaken; else ``""``."""
    scene, grid, pressure = scene_of(solution.problem), solution.problem.grid, solution.pressure
    if scene is None or not np.isfinite(pressure).all():
        return ""
    peak, hertz = solution.peak_pressure, scene.hertz
    modulus = scene.contact_modulus if hertz is None else hertz.contact_modulus
    slope = _slope(solution)
    width = float(np.count_nonzero(pressure.any(axis=1)) * grid.cell_size[0])
    hints = {
        "heights": "are heights given in µm as if they were m?",
        "modulus": "is a modulus given in GPa or MPa as if it were Pa?",
        "extent": "is a length of the grid or the load given in another unit, such as mm or N/mm?",
        "load": "is the load or a radius given in another unit, such as N/mm or mm? If not, strains are too large for "
        "linear elasticity.",
    }
    facts, hint = [], "modulus" if modulus < MIN_MODULUS else ""
    if slope > MAX_SLOPE:
        facts.append(f"the heights have slopes of {slope:.2g}")
        hint = hint or "heights"
    if peak > MAX_PRESSURE * modulus:
        facts.append(f"the peak pressure is {peak / modulus:.2g} times the contact modulus E*")
        hint = hint or ("extent" if solution.status is Status.CONTACT_AT_EDGE else "load")
    if hertz is not None and abs(solution.approach) > MAX_APPROACH * hertz.radius:
        facts.append(f"the approach is {abs(solution.approach) / hertz.radius:.2g} times the radius")
        hint = hint or "load"
    if 0 < width < grid.extent[0] / MAX_WIDTH:
        facts.append(f"the grid is {grid.extent[0] / width:.2g} times as wide as the contact")
        hint = hint or "extent"
    return f"The input is implausible: {', '.join(facts)}; {hints[hint]}" if facts else ""


def beyond_strength(solution: Solution) -> str:
    """Return a sentence if the contact is beyond the hardness or the yield stress of an elastic body, or ``""``.

    Hardness and yield stress are those of the bodies, of a coated one of both its materials. The load at first yield is
    that of the smooth line contact under the traction over the pressure. Nothing is said of a body that yields, nor
    together with ``Scene.hardness``, which caps the pressure.
    """
    scene, peak = scene_of(solution.problem), solution.peak_pressure
    if scene is None or scene.hardness < inf or not peak > 0:
        return ""
    shear = 0.0 if solution.traction is None else float(np.hypot(*solution.traction.shear).max())
    for number, body in enumerate(scene.solids):
        limit = getattr(getattr(body, "coating", body), "hardness", inf)
        if peak > limit:
            return (
                f"The peak pressure of {peak / 1e9:.3g} GPa is {peak / limit:.3g} times the hardness of "
                f"Scene.solids[{number}], {limit / 1e9:.3g} GPa: give Scene.hardness, or a body that yields."
            )
        if is_layered(body) or getattr(body, "hardness_profile", None) is not None:
            if said := _beyond_varying_strength(solution, number, body, shear):
                return said
            continue
        if not isinstance(body, HalfSpace) or isinf(body.yield_stress):
            continue
        radius = scene.hertz.radius if scene.hertz else 1.0
        first = first_yield(radius, scene.contact_modulus, body.yield_stress, body.poisson_ratio, shear / peak)
        pressure, kind = first.peak_pressure, "line"
        if scene.ellipse is not None:
            kind, by_point = "point", first_yield_of_ball(body.yield_stress, body.poisson_ratio)
            pressure = min(pressure, by_point)
        if peak > pressure:
            load = _load_of_peak(pressure, radius, scene.solids)
            if scene.ellipse is not None:
                load = 1e3 * scene.ellipse.load * (pressure / scene.ellipse.peak_pressure) ** 3
            unit = "N/mm" if kind == "line" else "N"
            at = f" at {load / 1e3:.3g} {unit}" if scene.hertz else ""
            return (
                f"The peak pressure of {peak / 1e9:.3g} GPa is {peak / pressure:.3g} times that at which "
                f"Scene.solids[{number}] first yields in a smooth {kind} contact{at}: give an ElasticPlasticHalfSpace, "
                "or the yield_stress of your material."
            )
    return ""


def _load_of_peak(pressure: float, radius: float, solids: tuple[Body, ...]) -> float:
    """Return the load [N/m] of the smooth line contact with this peak `pressure` [Pa], by the modulus at its width."""
    modulus = modulus_at_own_width(lambda modulus: 2 * pressure * radius / modulus, solids)
    return pi * radius * pressure**2 / modulus


def _beyond_varying_strength(solution: Solution, number: int, body: Any, shear: float) -> str:
    """Return a sentence if a body whose strength varies with depth is beyond its yield stress or hardness, or ``""``.

    The stress is that at the surface, in the middle of each layer, on both sides of its lower interface, and where that
    in a half-space is largest; of a hardness profile, at depths up to those of its points. The pressure on what is below
    a layer is compared with its hardness.
    """
    parts, name = list(getattr(body, "parts", {}).values()), f"Scene.solids[{number}]"
    if parts and all(isinf(min(one.yield_stress, one.hardness)) for _, one, *_ in parts):
        return ""
    # the stress in a half-space is at most its pressure; a stiff layer takes the strain of what is below
    moduli = [one.youngs_modulus for _, one, *_ in parts if not isinf(one.youngs_modulus)] or [1.0]
    largest = (solution.peak_pressure + 2 * shear) * max(moduli) / min(moduli)
    if parts and largest < min(min(one.yield_stress, one.hardness) for _, one, *_ in parts):
        return ""
    from contactstudy.scene.stress import (
        SubsurfaceStress,
        von_mises,
    )  # imported only where it is needed

    problem = solution.problem
    assert problem.paddings is not None
    width = np.count_nonzero(solution.pressure.any(axis=1)) * problem.grid.cell_size[0]
    found = {0.0}
    if not parts:
        found |= {0.1 * width, 0.2 * width, 0.7 * width, width, *body.hardness_profile.points[0]}
    for _, _, top, bottom in parts[:-1]:
        found |= {(top + bottom) / 2, bottom, bottom * BELOW_INTERFACE}
    depths = tuple(sorted({*found, max(*found, 0.35 * width) if parts else 0.35 * width}))
    # neighbours hardly matter at these depths, and each image of a window takes a second
    paddings = problem.paddings[0], ExactPeriodicity()
    operator = SubsurfaceStress(depths, number).of((body, body), problem.grid, paddings)
    if solution.traction is not None:
        operator = operator.with_shear(solution.traction.shear)
    stress = operator(solution.net_pressure)
    for said, material, top, _ in parts[1:]:
        pressed = -float(stress[2, depths.index(top * BELOW_INTERFACE)].min())
        if pressed > (hardness := material.hardness):
            return (
                f"The pressure on {said} of {name} of {pressed / 1e9:.3g} GPa is "
                f"{pressed / hardness:.2g} times its hardness, {hardness / 1e9:.3g} GPa: {GIVE_STRENGTH}"
            )
    margin = yield_margin(body, number, np.array(depths), von_mises(stress))
    return margin.sentence


@dataclass(frozen=True)
class YieldMargin:
    """Yield stress over the largest von Mises stress [Pa] at the `depth` [m] and `part` of a body where it is least."""

    ratio: float = inf
    von_mises: float = 0.0
    part: str = ""
    depth: float = 0.0

    @property
    def sentence(self) -> str:
        """A sentence if the stress is beyond the yield stress, or ``""``."""
        if self.ratio >= 1:
            return ""
        return (
            f"The von Mises stress of {self.von_mises / 1e6:.3g} MPa in {self.part} is {1 / self.ratio:.3g} times the "
            f"yield stress: {GIVE_STRENGTH}"
        )


def stress_margin(scene: Scene, derived: Mapping[str, Field]) -> YieldMargin:
    """Return the margin to yield by the fields `derived` of the body whose stress is an output of `scene`."""
    number = next(output.body for output in scene.outputs if hasattr(output, "body"))
    depths, stress = derived["z"].values, derived["von_mises"].values
    return yield_margin(scene.solids[number], number, depths, stress)


def yield_margin(body: Any, number: int, depths: Array, von_mises: Array) -> YieldMargin:
    """Return the margin to yield of the elastic body `number` of a scene, of a coated one that of the weakest part.

    The stress `von_mises` (z, x, y) [Pa] is that at `depths` (z,) [m]; a depth of the thickness is in the coating.
    """
    largest, strength = von_mises.max(axis=(1, 2)), yield_stresses(body, depths)
    ratios = np.divide(strength, largest, out=np.full(largest.shape, inf), where=largest > 0)
    level = int(ratios.argmin())
    if isinf(ratios[level]):
        return YieldMargin()
    depth, part = float(depths[level]), f"Scene.solids[{number}]"
    for said, _, top, bottom in body.parts.values() if is_layered(body) else ():
        if in_part(np.array(depth), top, bottom):
            part = f"{said} of {part}"
    return YieldMargin(float(ratios[level]), float(largest[level]), part, depth)


def yield_stresses(body: Any, depths: Array) -> Array:
    """Return the yield stress [Pa] of an elastic body at `depths` [m], infinite where it is not known."""
    if is_layered(body):
        of_parts = (
            np.where(in_part(depths, top, bottom), material.yield_stress, inf)
            for _, material, top, bottom in body.parts.values()
        )
        return np.asarray(np.minimum.reduce(list(of_parts)))
    if (profile := getattr(body, "hardness_profile", None)) is not None:
        return np.asarray(profile.yield_stress(depths))
    stress = body.yield_stress if isinstance(body, HalfSpace) else inf
    return np.full(depths.shape, stress)


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
        both = np.take(touching, range(1, gap.shape[axis]), axis) & np.take(touching, range(gap.shape[axis] - 1), axis)
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
