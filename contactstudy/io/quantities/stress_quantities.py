"""Numbers of the stress below a surface: largest values in each part of a body, their depths, and margins to yield."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import islice
from math import exp, inf, log
from typing import Any

import numpy as np

from contactstudy.accuracy.estimate import unbounded_by_peak, unresolved_interface
from contactstudy.accuracy.plausibility import yield_margin, yield_stresses
from contactstudy.domain.errors import STRESS_FLOOR, ErrorEstimate, ErrorParts
from contactstudy.domain.grid import Array, Grid, Paddings, is_free
from contactstudy.io.quantities.quantity import NO_ESTIMATE, Quantity, with_bound
from contactstudy.problem.problem import Field
from contactstudy.scene.scene import Scene
from contactstudy.scene.solids.bodies import in_part, is_layered

# Least bound of the largest tension at a surface over its fall in the first cell outside the contact: beside the edge of
# a contact that slides it falls like the square root of the distance. At most 3.2 on 68 sliding cylinders of 20 to 340
# cells, and 1.5 on 14 balls, against closed forms.
TENSION_ERROR = 3.5
# Cells on either side in which the fall of a largest stress counts at a surface, where it may lie at an edge; one, which
# may be at the same height by chance, left out 2 in 3 of the error of the largest shear stress of a sliding cylinder.
AT_SURFACE = 2
# Part of the same bound by the error of the pressure, over its L1 error times the largest von Mises stress at the
# surface.
BY_PRESSURE = 0.5
# Tension over the largest von Mises stress at the surface below which the cells may not show where it is, such as beside
# a dimple, and the part of that stress which its bound then is at least, beside that of the peak pressure: it was up to
# 0.4 of the stress under dimples, and 0.08 on a coating of four layers.
LEAST_TENSION, UNSEEN_TENSION = 0.02, 0.1
UNRESOLVED_SHEAR = (
    "No bound for the orthogonal shear stress: the von Mises stress is largest at a depth of less than a cell, and the "
    "cells do not show the shear beside so small a place, give more cells."
)
# Ratio of two depths up to which the stress between them follows a parabola, and above which they are no two sides of
# an interface.
MAX_STEP, MIN_STEP = 2.0, 1.001
# Relative difference of largest values that are equal but for the residual of the solver, and stress over the largest
# von Mises stress at the surface that is rounding.
SYMMETRY, ROUNDING = 1e-7, 1e-9
# Number of grids, each three times as wide, on which the largest tension is sought beyond that of a layered body; and
# how far at least, over the thickness times the cube root of the ratio of moduli: within 2 with ratios up to 1000.
WIDER, BENDING_LENGTHS = 8, 4.0
BEYOND_GRID = "No bound: the tension may be larger beyond the grid, where the coating bends; give a wider grid."
AT_END_OF_GRID = "No bound: the largest stress lies at the end of the grid, and a larger one beyond; give a wider grid."


def stress_quantities(
    scene: Scene | None, derived: Mapping[str, Field], grid: Grid, estimate: ErrorEstimate, paddings: Paddings | None
) -> dict[str, Quantity]:
    """Return largest stresses below the surface with their depths and the margin to yield, of a body and its parts.

    These are the von Mises stress, the largest and the orthogonal shear stress; beside them stand the tension at the
    surface, and the shear stress at interfaces. Where the scene gives the depths, the stress between and beyond them may
    be larger, and the labels say so.

    Parameters
    ----------
    scene
        The scene; without one there are no numbers.
    derived
        Fields of the output that the scene names, in one body.
    grid
        Cells of the surface.
    estimate
        Errors of the contact.
    paddings
        Paddings of its axes; None for an operator that has none.
    """
    if scene is None or "von_mises" not in derived:
        return {}
    from contactstudy.scene import stress as stresses  # only where it is named

    index = next(output.body for output in scene.outputs if hasattr(output, "body"))
    given = any(isinstance(getattr(output, "depths", None), tuple) for output in scene.outputs)
    at_depths = " at the depths given" if given else ""
    body, name = scene.solids[index], f"Scene.solids[{index}]"
    coordinates = {"x": grid.x, "y": grid.y}
    stress, von_mises, depths = (derived[of].values for of in ("stress", "von_mises", "z"))
    layers = body.parts if is_layered(body) else {}
    # by what begins the names of their numbers: label, material, and whether a depth is inside
    parts: dict[str, tuple[str, Any, Any]] = {"": (name, body, depths >= 0)}
    for part, (said, material, top, bottom) in layers.items():
        if (inside := in_part(depths, top, bottom)).any():
            parts[f"{part}_"] = f"{said} of {name}", material, inside
    found, of_weakest = dict[str, Quantity](), ""
    # places of the ends of ranges along x
    ends: dict[str, list[Mapping[str, float]]] = {}
    for before, (where, material, inside) in parts.items():
        axes, at = {**coordinates, "z": depths[inside]}, f"in {where}{at_depths}"
        mises, of_mises = von_mises[inside], f"largest von Mises stress {at}"
        name_of_mises = f"{before}von_mises" if before else "largest_von_mises"
        found |= _with_depth(name_of_mises, of_mises, mises, axes, given=given, beyond=False)
        least = yield_margin(material, index, axes["z"], mises)
        if least.ratio < inf:
            label = f"yield stress over von Mises stress in {where if before else least.part}{at_depths}"
            position = found[name_of_mises].position if before else None
            found[f"{before}safety_factor"] = replace(
                found[name_of_mises], value=least.ratio, unit="1", label=label, position=position, rivals=()
            )
        strength = yield_stresses(material, axes["z"])
        if not before and strength.min() < strength.max() and least.ratio < inf:
            key_of_weakest, weakest = next(
                (key, inside) for key, (part, _, inside) in parts.items() if part == least.part
            )
            of_weakest = f"{key_of_weakest}von_mises_depth"
            demand = mises.max(axis=(1, 2)) / strength
            depth = between_depths(depths[weakest], demand[weakest], given=given)[1]
            least_safe = Quantity(depth, "m", f"depth of the least safety {at}")
            found["safety_factor_depth"] = _known_to(least_safe, depths)
        if before and of_weakest == f"{before}von_mises_depth" and of_weakest in found:  # a part of one strength
            label = found["safety_factor_depth"].label
            found["safety_factor_depth"] = replace(found[of_weakest], label=label)
        shear, of_shear = stresses.largest_shear(stress[:, inside]), f"largest shear stress {at}"
        name_of_shear = f"{before}largest_shear_stress"
        found |= _with_depth(name_of_shear, of_shear, shear, axes, given=given)
        # a range along x has no place on it, and its ends have depths of their own at which it is largest
        shear, name_of_range = stresses.orthogonal_shear(stress[:, inside]), f"{before}orthogonal_shear"
        along = {axis: places for axis, places in axes.items() if axis != "x"}
        found |= _with_depth(name_of_range, f"orthogonal shear stress {at}", shear, along, given=given)
        amplitude = found[name_of_range]
        label = f"double amplitude of the {amplitude.label}"
        doubled = [(2 * value, depth) for value, depth in amplitude.rivals]
        found[f"{name_of_range}_range"] = replace(amplitude, value=2 * amplitude.value, label=label, rivals=doubled)
        of_part = [layers[before.removesuffix("_")]] if before else layers.values()
        unresolved = unresolved_interface(grid, min((bottom - top for *_, top, bottom in of_part), default=inf))
        if unresolved is not None:
            reason = unresolved.reason.replace("shear stress at the interface", "orthogonal shear stress")
            unresolved = replace(unresolved, reason=reason)
        elif 0 < (found[name_of_mises].position or {}).get("z", 0.0) < grid.cell_size[0]:
            unresolved = ErrorParts(discretisation=inf, reason=UNRESOLVED_SHEAR)
        if unresolved is not None:
            found |= {key: with_bound(of, unresolved) for key, of in found.items() if key.startswith(name_of_range)}
        of_range = stress[4, inside][shear.max(axis=(1, 2)).argmax()]
        ends[name_of_range] = [largest_place(sign * of_range, coordinates)[1] for sign in (1, -1)]
    for part, (said, _, top, bottom) in layers.items():
        if (at_interface := depths == bottom).any():
            shear = np.hypot(*stress[3:5, at_interface][:, 0])  # yz and xz
            largest, position = largest_place(shear, coordinates)
            below = "" if part == "coating" and len(layers) == 2 else f" below {said}"
            label = f"largest shear stress at the interface{below} of {name}"
            of_interface = "interface_shear" if part == "coating" else f"{part}_shear"
            at_bottom = Quantity(largest, "Pa", label, position=position)
            found[of_interface] = with_bound(at_bottom, unresolved_interface(grid, bottom - top))
    if paddings is not None and is_free(paddings[0]):
        places = {key: [of.position] for key, of in found.items() if of.position} | ends
        for key, of in found.items():
            of_largest = places.get(key.removesuffix("_depth").removesuffix("_range"), [])
            if any(abs(place.get("x", 0.0)) >= grid.x[-1] > 0 for place in of_largest):
                found[key] = replace(of, bound=inf, reason=AT_END_OF_GRID)
    if not depths[0] and (scale := float(von_mises[0].max())):
        wider: Iterator[tuple[Grid, Array]] = iter(())
        if layers and paddings:
            output = next(one for one in scene.outputs if isinstance(one, stresses.SubsurfaceStress))
            wider = stresses.surface_beyond(output, scene.solids, grid, paddings, stress[:, 0])
        found |= _surface_tension(stress[:, 0], scale, wider, layers, grid, name, estimate)
    error = estimate.stress
    if error is None or error.total < inf:
        error = unbounded_by_peak(estimate, depths, grid)
    return found if error is None else {key: with_bound(of, error) for key, of in found.items()}


def _with_depth(
    name: str, label: str, values: Array, axes: Mapping[str, Array], *, given: bool, beyond: bool = True
) -> dict[str, Quantity]:
    """Return the largest of `values` (z, x, y) [Pa] and its depth, by the `name` and with the `label` of the largest.

    Its rivals are the highest local maxima at all depths, each with its fall to the cells beside it. Depths and
    coordinates stand in `axes` by their names. Between depths that were not `given` the depth is that of a parabola, and
    the value that at its vertex if it goes `beyond` the values. The largest of all depths lies up to beside the
    neighbouring given ones.
    """
    value, position = largest_place(values, axes, ("z", "x", "y"))
    if "z" not in position:
        return {name: Quantity(value, "Pa", label, position=position)}
    from scipy.ndimage import maximum_filter  # imported late, since it is slow

    depths, peaks = axes["z"], values.max(axis=(1, 2))
    rise, position["z"] = between_depths(depths, peaks, given=given)
    depth = Quantity(position["z"], "m", f"depth of the {label}")
    if given or not depth.value:
        depth = _known_to(depth, depths)
    at, rivals = int(peaks.argmax()), []
    for number, maxima in enumerate(values == maximum_filter(values, 3, mode="nearest")):
        if maxima.any():
            cells = 1 if depths[number] else AT_SURFACE
            reach = float((values[number] + _falls(values[number], cells))[maxima].max())
            # another maximum lies up to half-way to the depths beside it
            around = depths[max(number - 1, 0) : number + 2]
            places = [position["z"]] if number == at else ((depths[number] + around) / 2).tolist()
            rivals += [(reach, place) for place in places]
    if "x" in axes and 0 < position["z"] < np.diff(axes["x"][:2]).max(initial=0.0):  # finer cells may show it higher up
        rivals.append((value, position["z"] / 2))
    if position["z"] == depths[at]:  # no parabola says where between the depths
        near = slice(max(at - 1, 0), at + 2)
        rivals += zip(peaks[near].tolist(), depths[near].tolist(), strict=True)
    floor = 0.0 if given else STRESS_FLOOR
    largest = Quantity(value + rise * beyond, "Pa", label, position=position, rivals=rivals, least_change=floor)
    return {name: largest, f"{name}_depth": depth}


def _known_to(depth: Quantity, depths: Array) -> Quantity:
    """Return a depth that is known to the distance of the neighbouring ones of some `depths`."""
    place = int(np.abs(depths - depth.value).argmin())
    around = float(np.diff(depths[max(place - 1, 0) : place + 2]).max(initial=0.0))
    return replace(depth, bound=around, reason="")


def _surface_tension(
    stress: Array,
    scale: float,
    wider: Iterator[tuple[Grid, Array]],
    layers: Mapping[str, tuple[str, Any, float, float]],
    grid: Grid,
    name: str,
    estimate: ErrorEstimate,
) -> dict[str, Quantity]:
    """Return the largest tensile stress at the surface of a body.

    A stiff layer bends beyond the grid. Its largest tension there is sought on `wider` grids, up to one that reaches
    beyond the bending length and shows no larger one.

    Parameters
    ----------
    stress
        Stress (component, x, y) [Pa] at the surface.
    scale
        Its largest von Mises stress [Pa].
    wider
        Larger and larger grids, and stress on them.
    layers
        Parts of the body that has layers.
    grid, name, estimate
        Cells of the surface, words for the body, and errors of the contact.
    """
    from contactstudy.scene.stress import principal_stresses  # only where it is named

    tension, reason = principal_stresses(stress)[0], ""
    value, position = largest_place(tension, {"x": grid.x, "y": grid.y})
    between_cells = TENSION_ERROR * _fall(tension, stress[2], scale)
    moduli = [part[1].youngs_modulus for part in layers.values()]
    elastic = [modulus for modulus in moduli if modulus < inf]
    depth = max((part[2] for part in layers.values()), default=0.0)
    farthest = BENDING_LENGTHS * depth * (max(elastic) / min(elastic)) ** (1 / 3) if elastic else 0.0
    before = grid
    for around, below in islice(wider, WIDER):
        axes = {"x": around.x, "y": around.y}
        within = zip(axes.values(), before.extent, strict=True)
        beyond = principal_stresses(below)[0]
        beyond[np.ix_(*(np.abs(at) < extent / 2 for at, extent in within))] = -inf
        largest, place = largest_place(beyond, axes)
        added = [more - of for more, of in zip(around.extent, grid.extent, strict=True) if more > of]
        if largest > max(value, ROUNDING * scale):
            value, position = largest, place
            between_cells = _fall(beyond, below[2], scale)  # it is smooth there
        elif min(added) > 2 * farthest:
            break
        before = around
    else:
        reason = BEYOND_GRID if before is not grid else ""
    if value <= ROUNDING * scale:  # what is compressed in its plane may be in tension between two cells
        in_plane = np.maximum(stress[0], stress[1])
        value, between_cells = 0.0, max(in_plane.max() + TENSION_ERROR * _fall(in_plane, stress[2], scale), 0.0)
    label = f"largest tensile stress at the surface of {name}"
    reach = value + between_cells + BY_PRESSURE * estimate.l1.total * scale
    if value < LEAST_TENSION * scale and estimate.peak_pressure is not None:
        of_peak = estimate.peak_pressure.total * float(np.abs(stress[2]).max())
        reach = max(reach, value + max(of_peak, UNSEEN_TENSION * scale))
    where, rivals = position if value else None, ((reach, 0.0),)
    tensile = Quantity(value, "Pa", label, inf, reason or NO_ESTIMATE, where, rivals=rivals)
    return {"surface_tension": tensile}


def between_depths(depths: Array, peaks: Array, *, given: bool) -> tuple[float, float]:
    """Return by how much the largest stress exceeds the largest of some `peaks` at their depths, and its depth.

    It lies at the vertex of the parabola in the logarithm of the depth through the largest peak and its neighbours; at
    given depths, at the surface and beside an interface it is the largest peak itself.
    """
    at = int(peaks.argmax())
    if given or not 0 < at < len(peaks) - 1 or not depths[at - 1]:
        return 0.0, float(depths[at])
    steps = [log(depths[at] / depths[at - 1]), log(depths[at + 1] / depths[at])]
    if not all(log(MIN_STEP) < step < log(MAX_STEP) for step in steps):
        return 0.0, float(depths[at])
    fall = [float(peaks[at] - peaks[at - 1]), float(peaks[at] - peaks[at + 1])]
    # peak - slope t - bend t^2 at the logarithmic distance t from the largest peak
    bend = (fall[0] / steps[0] + fall[1] / steps[1]) / (steps[0] + steps[1])
    slope = (fall[1] - bend * steps[1] ** 2) / steps[1]
    if bend <= 0:
        return 0.0, float(depths[at])
    return slope**2 / (4 * bend), float(depths[at]) * exp(-slope / (2 * bend))


def _fall(tension: Array, pressing: Array, scale: float) -> float:
    """Return the fall of a surface `tension` (x, y) to the cells outside the contact beside the largest one.

    That is the largest of all cells, or of those outside. A cell is in contact where the stress `pressing` it (x, y) is
    no rounding beside a `scale`; where all are, all count.
    """
    touches = np.abs(pressing) > ROUNDING * scale
    outside = tension if touches.all() else np.where(touches, -inf, tension)
    return max(fall_beside(tension, outside), fall_beside(outside, outside))


def _falls(values: Array, cells: int) -> Array:
    """Return the falls (x, y) of `values` to the means of those some `cells` away, along the steeper axis."""
    falls = np.zeros(values.shape)
    for axis in (0, 1):
        if (count := values.shape[axis]) > 1:
            at = np.arange(count)
            around = (values.take(at - cells, axis, mode="clip") + values.take(at + cells, axis, mode="clip")) / 2
            falls = np.maximum(falls, values - around)
    return falls


def fall_beside(values: Array, beside: Array, cells: int = 1) -> float:
    """Return the fall from the largest of some `values` (x, y) to the mean of those `beside` it along the steeper axis.

    Those are as many `cells` away, on both sides. Infinite ones do not count. In one cell it is half of the second
    difference of a smooth field, wherever its largest value lies.
    """
    place, falls = np.unravel_index(int(values.argmax()), values.shape), [0.0]
    for axis in (0, 1):
        line, at = np.take(beside, place[1 - axis], axis=1 - axis), int(place[axis])
        around = line[[one for one in (at - cells, at + cells) if 0 <= one < len(line)]]
        if (known := np.isfinite(around)).any():
            falls.append(float(values[place] - around[known].mean()))
    return max(falls)


def largest_of(values: Array, unit: str, label: str) -> Quantity:
    """Return the largest of some `values` (x, y) as a quantity, which may lie as high beside it as they fall there."""
    largest = float(values.max())
    return Quantity(largest, unit, label, rivals=((largest + fall_beside(values, values), 0.0),))


def largest_place(
    values: Array, axes: Mapping[str, Array], dimensions: Sequence[str] = ("x", "y")
) -> tuple[float, dict[str, float]]:
    """Return the largest value and where it is: of equal ones the nearest to the middle, between two of them the mean.

    Along an axis of one cell there is no position.
    """
    largest = values.max()
    equal = values >= largest * (1 - SYMMETRY) if largest > 0 else values == largest
    indices = np.argwhere(equal)
    distances = np.abs(indices - [(size - 1) / 2 for size in values.shape]).sum(axis=1)
    nearest = indices[distances == distances.min()]
    neighbours = nearest[np.abs(nearest - nearest[0]).max(axis=1) <= 1]
    position = {
        name: float(axes[name][at].mean())
        for name, at in zip(dimensions, neighbours.T, strict=True)
        if name in axes and len(axes[name]) > 1
    }
    return float(largest), position
