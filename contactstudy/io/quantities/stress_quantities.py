"""Numbers of the stress below a surface: largest values in each part of a body, their depths, and margins to yield.

The stress of one body is a field (component, z, x, y) [Pa] with the components xx, yy, zz, yz, xz and xy, tension
positive. The parts of a layered body are its layers and its substrate; the numbers of the whole body come first. Bounds
of most numbers come later, by their changes between grids. What one grid shows of them is said here: the *rivals* of a
largest value, pairs of a value and its depth that the largest may have as well, at other places or between the cells.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import islice
from math import exp, inf, log
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from contactstudy.accuracy.estimate import unbounded_by_peak, unresolved_interface
from contactstudy.accuracy.plausibility import yield_margin, yield_stresses
from contactstudy.domain.errors import STRESS_FLOOR, ErrorEstimate, ErrorParts
from contactstudy.domain.grid import Array, Grid, Paddings, is_free
from contactstudy.io.quantities.quantity import NO_ESTIMATE, Quantity, with_bound
from contactstudy.problem.problem import Field
from contactstudy.scene.scene import Scene
from contactstudy.scene.solids.bodies import in_part, is_layered

# Least bound of the largest tension at a surface over its fall in the first cell outside the contact: beside the edge
# of a contact that slides it falls like the square root of the distance. At most 3.2 on 68 sliding cylinders of 20 to
# 340 cells, and 1.5 on 14 balls, against closed forms.
TENSION_ERROR = 3.5
# Cells on either side in which the fall of a largest stress counts at a surface, where it may lie at an edge; one,
# which may be at the same height by chance, left out 2 in 3 of the error of the largest shear stress of a sliding
# cylinder.
CELLS_AT_SURFACE = 2
# Part of the bound of the tension by the pressure, over the L1 error of the pressure times the largest von Mises stress
# at the surface. It was set together with `TENSION_ERROR`, on the same contacts.
BY_PRESSURE = 0.5
# Tension over the largest von Mises stress at the surface below which the cells may not show where the tension is
# largest, such as beside a dimple.
LEAST_TENSION = 0.02
# Least bound of so small a tension over that stress, beside the error of the peak pressure: errors were up to 0.4 of
# the stress under dimples, most of it by the peak pressure, and 0.08 on a coating of four layers.
UNSEEN_TENSION = 0.1
UNRESOLVED_SHEAR = (
    "No bound for the orthogonal shear stress: the von Mises stress is largest at a depth of less than a cell, and the "
    "cells do not show the shear beside so small a place, give more cells."
)
# Ratio of two neighbouring depths between which the stress follows a parabola: from the least, below which they are the
# two sides of an interface, to the largest, which the depths that are chosen for a scene keep.
MIN_DEPTH_RATIO, MAX_DEPTH_RATIO = 1.001, 2.0
# Relative difference of largest values that are equal but for the residual of the solver.
SYMMETRY = 1e-7
# Stress over the largest von Mises stress at the surface up to which it is rounding.
ROUNDING = 1e-9
# Number of grids, each three times as wide as the one before, on which the largest tension is sought beyond the grid of
# a layered body: eight reach 6,561 times as far.
WIDER_GRIDS = 8
# Distance up to which the tension is sought at least, over the depth of the substrate times the cube root of the ratio
# of moduli, the length over which a layer on a softer body bends: the largest tension lay within 2 with ratios up to
# 1000.
BENDING_LENGTHS = 4.0
BEYOND_GRID = "No bound: the tension may be larger beyond the grid, where the coating bends; give a wider grid."
AT_END_OF_GRID = "No bound: the largest stress lies at the end of the grid, and a larger one beyond; give a wider grid."


class _Part(NamedTuple):
    """A body, or a layer or the substrate of it.

    Attributes
    ----------
    prefix
        Beginning of the names of its numbers: empty for the whole body, else such as ``"coating_"``.
    words
        What it is called in labels, such as ``"the coating of Scene.solids[0]"``.
    material
        The body or the material of the part.
    inside
        Which of the depths (z,) lie in it.
    thinnest
        Thickness of its thinnest layer [m]; infinite of a half-space.
    """

    prefix: str
    words: str
    material: Any
    inside: NDArray[np.bool_]
    thinnest: float

    @property
    def name_of_mises(self) -> str:
        """Name of its largest von Mises stress among the quantities."""
        return f"{self.prefix}von_mises" if self.prefix else "largest_von_mises"


def _parts(body: Any, name: str, depths: Array) -> list[_Part]:
    """Return the whole `body`, called `name`, and those of its parts that have any of the `depths` (z,) [m]."""
    layers = body.parts if is_layered(body) else {}
    thinnest = min((bottom - top for *_, top, bottom in layers.values()), default=inf)
    parts = [_Part("", name, body, depths >= 0, thinnest)]
    for key, (words, material, top, bottom) in layers.items():
        parts.append(_Part(f"{key}_", f"{words} of {name}", material, in_part(depths, top, bottom), bottom - top))
    return [part for part in parts if part.inside.any()]


class _Samples(NamedTuple):
    """Samples of the stress in a body, or in a part of it: the points where it is known.

    Attributes
    ----------
    x, y, z
        Coordinates (x,) and (y,) of the cells of the surface and depths (z,) [m].
    given
        True if the scene gives the depths.
    last
        Distance [m] across from the axis to the last cell beyond which the surface continues; infinite if it is
        periodic.
    """

    x: Array
    y: Array
    z: Array
    given: bool
    last: float

    def reason_at(self, *places: Mapping[str, float]) -> str:
        """Return why a largest value at one of these `places` has no bound so far."""
        is_at_end = any(abs(place.get("x", 0.0)) >= self.last > 0 for place in places)
        return AT_END_OF_GRID if is_at_end else NO_ESTIMATE


def stress_quantities(
    scene: Scene | None, derived: Mapping[str, Field], grid: Grid, estimate: ErrorEstimate, paddings: Paddings | None
) -> dict[str, Quantity]:
    """Return largest stresses below the surface with their depths and the margin to yield, of a body and its parts.

    These are the von Mises stress, the largest and the orthogonal shear stress; beside them stand the tension at the
    surface, and the shear stress at interfaces. Where the scene gives the depths, the stress between and beyond them
    may be larger, and the labels say so.

    Parameters
    ----------
    scene
        The scene; without one there are no numbers.
    derived
        Fields of the output that the scene names, in one body: ``stress``, ``von_mises`` and depths ``z``.
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
    body, name = scene.solids[index], f"Scene.solids[{index}]"
    stress, von_mises, depths = (derived[field].values for field in ("stress", "von_mises", "z"))
    last = float(grid.x[-1]) if paddings is not None and is_free(paddings[0]) else inf
    samples = _Samples(grid.x, grid.y, depths, given, last)
    layers, parts = body.parts if is_layered(body) else {}, _parts(body, name, depths)
    found = dict[str, Quantity]()
    for part in parts:
        at, within = (
            f"in {part.words}{' at the depths given' if given else ''}",
            samples._replace(z=depths[part.inside]),
        )
        found |= _mises_quantities(part, parts, index, von_mises[part.inside], within, at)
        found |= _shear_quantities(part, stress[:, part.inside], within, at, grid, found[part.name_of_mises])
    for key, (words, _, top, bottom) in layers.items():
        if (at_interface := depths == bottom).any():
            shear = np.hypot(*stress[3:5, at_interface][:, 0])  # yz and xz
            largest, position = largest_place(shear, {"x": grid.x, "y": grid.y})
            below = "" if key == "coating" and len(layers) == 2 else f" below {words}"
            label = f"largest shear stress at the interface{below} of {name}"
            of_interface = "interface_shear" if key == "coating" else f"{key}_shear"
            quantity = Quantity(largest, "Pa", label, inf, samples.reason_at(position), position)
            found[of_interface] = with_bound(quantity, unresolved_interface(grid, bottom - top))
    if not depths[0] and (scale := float(von_mises[0].max())):
        wider: Iterator[tuple[Grid, Array]] = iter(())
        if layers and paddings:
            output = next(output for output in scene.outputs if isinstance(output, stresses.SubsurfaceStress))
            wider = stresses.surface_beyond(output, scene.solids, grid, paddings, stress[:, 0])
        found["surface_tension"] = _surface_tension(stress[:, 0], scale, wider, layers, grid, name, estimate)
    error = estimate.stress
    if error is None or error.total < inf:
        error = unbounded_by_peak(estimate, depths, grid)
    return found if error is None else {key: with_bound(quantity, error) for key, quantity in found.items()}


def _mises_quantities(
    part: _Part, parts: Sequence[_Part], index: int, von_mises: Array, samples: _Samples, at: str
) -> dict[str, Quantity]:
    """Return the largest von Mises stress in a part, its depth, and the margin to yield where the strength is known.

    The largest stress, and the margin by it, are those of the field `von_mises` (z, x, y) [Pa] at its `samples`, and not
    of a parabola. The body has this `index` in the scene. Where its strength varies with depth there is the depth of the
    least margin too, which lies in the weakest of its `parts`. Labels end with `at`.
    """
    found = _with_depth(part.name_of_mises, f"largest von Mises stress {at}", von_mises, samples)
    found[part.name_of_mises] = largest = replace(found[part.name_of_mises], value=float(von_mises.max()))
    least = yield_margin(part.material, index, samples.z, von_mises)
    if least.ratio == inf:
        return found
    where, position = at.removeprefix("in "), largest.position
    if not part.prefix:
        where, position = where.replace(part.words, least.part), None
    label = f"yield stress over von Mises stress in {where}"
    safety = replace(largest, value=least.ratio, unit="1", label=label, position=position, rivals=())
    found[f"{part.prefix}safety_factor"] = safety
    strength = yield_stresses(part.material, samples.z)
    if not part.prefix and strength.min() < strength.max():
        weakest = next(other for other in parts if other.words == least.part)
        demand, depths = (von_mises.max(axis=(1, 2)) / strength)[weakest.inside], samples.z[weakest.inside]
        label = f"depth of the least safety {at}"
        depth = Quantity(between_depths(depths, demand, given=samples.given)[1], "m", label)
        # between the depths of a part of one strength it is as well known as that of the largest stress
        is_between = weakest is not part and len(depths) > 1 and not samples.given and depth.value > 0
        found["safety_factor_depth"] = depth if is_between else _known_to(depth, depths)
    return found


def _shear_quantities(
    part: _Part, stress: Array, samples: _Samples, at: str, grid: Grid, mises: Quantity
) -> dict[str, Quantity]:
    """Return largest and orthogonal shear stress in a part with their depths, and the double amplitude of the latter.

    The `stress` (component, z, x, y) [Pa] is that in the part at its `samples`, and labels end with `at`. The
    orthogonal shear stress is half the range of xz along x, so that it has no place along x. It has no bound in a layer
    of few cells, and where the largest von Mises stress `mises` lies less than a cell deep.
    """
    from contactstudy.scene import stress as stresses  # only where it is named

    largest, orthogonal = stresses.largest_shear(stress), stresses.orthogonal_shear(stress)
    key = f"{part.prefix}orthogonal_shear"
    found = _with_depth(key, f"orthogonal shear stress {at}", orthogonal, samples._replace(x=samples.x[:1]))
    xz, surface = stress[4, orthogonal.max(axis=(1, 2)).argmax()], {"x": samples.x, "y": samples.y}
    if (reason := samples.reason_at(*(largest_place(sign * xz, surface)[1] for sign in (1, -1)))) == AT_END_OF_GRID:
        found = {name: replace(quantity, bound=inf, reason=reason) for name, quantity in found.items()}
    amplitude = found[key]
    doubled = [(2 * value, depth) for value, depth in amplitude.rivals]
    label = f"double amplitude of the {amplitude.label}"
    found[f"{key}_range"] = replace(amplitude, value=2 * amplitude.value, label=label, rivals=doubled)
    unresolved = unresolved_interface(grid, part.thinnest, "orthogonal shear stress")
    if unresolved is None and 0 < (mises.position or {}).get("z", 0.0) < grid.cell_size[0]:
        unresolved = ErrorParts(discretisation=inf, reason=UNRESOLVED_SHEAR)
    found = {name: with_bound(quantity, unresolved) for name, quantity in found.items()}
    return _with_depth(f"{part.prefix}largest_shear_stress", f"largest shear stress {at}", largest, samples) | found


def _with_depth(name: str, label: str, values: Array, samples: _Samples) -> dict[str, Quantity]:
    """Return the largest of `values` (z, x, y) [Pa] by its `name` and with a `label`, and its depth.

    Between depths that the scene does not give, value and depth are those at the vertex of a parabola. The rivals are
    the highest local maxima at all depths, each with its fall to the cells beside it. Where no parabola places the
    largest, it may also lie at the depths next to its own. At a single depth there is no number for the depth.
    """
    depths, given = samples.z, samples.given
    value, position = largest_place(values, {"x": samples.x, "y": samples.y, "z": depths}, ("z", "x", "y"))
    reason = samples.reason_at(position)
    if "z" not in position:
        return {name: Quantity(value, "Pa", label, inf, reason, position)}
    from scipy.ndimage import maximum_filter  # imported late, since it is slow

    peaks = values.max(axis=(1, 2))
    rise, position["z"] = between_depths(depths, peaks, given=given)
    depth = Quantity(position["z"], "m", f"depth of the {label}", reason=reason)
    if (given or not depth.value) and reason == NO_ESTIMATE:
        depth = _known_to(depth, depths)
    highest, rivals = int(peaks.argmax()), []
    for level, maxima in enumerate(values == maximum_filter(values, 3, mode="nearest")):
        if maxima.any():
            cells = 1 if depths[level] else CELLS_AT_SURFACE
            reach = float((values[level] + _falls(values[level], cells))[maxima].max())
            # another maximum lies up to half-way to the depths beside it
            around = depths[max(level - 1, 0) : level + 2]
            places = [position["z"]] if level == highest else ((depths[level] + around) / 2).tolist()
            rivals += [(reach, place) for place in places]
    if 0 < position["z"] < np.diff(samples.x[:2]).max(initial=0.0):  # finer cells may show it higher up
        rivals.append((value, position["z"] / 2))
    if position["z"] == depths[highest]:  # no parabola says where between the depths
        near = slice(max(highest - 1, 0), highest + 2)
        rivals += zip(peaks[near].tolist(), depths[near].tolist(), strict=True)
    # all grids may miss a largest stress between depths; where depths are given it is the largest of those
    floor = 0.0 if given else STRESS_FLOOR
    largest = Quantity(value + rise, "Pa", label, inf, reason, position, rivals=rivals, least_change=floor)
    return {name: largest, f"{name}_depth": depth}


def _known_to(depth: Quantity, depths: Array) -> Quantity:
    """Return a `depth` with a bound: the larger distance from the nearest of some `depths` (z,) [m] to the next ones."""
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
) -> Quantity:
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
        Words, material, and depths [m] at top and bottom of each part of a layered body; empty for another.
    grid, name, estimate
        Cells of the surface, words for the body, and errors of the contact.
    """
    from contactstudy.scene.stress import principal_stresses  # only where it is named

    tension, reason = principal_stresses(stress)[0], ""
    value, position = largest_place(tension, {"x": grid.x, "y": grid.y})
    between_cells = TENSION_ERROR * _fall(tension, stress[2], scale)
    parts = layers.values()
    moduli = [material.youngs_modulus for _, material, *_ in parts if material.youngs_modulus < inf]
    depth_of_substrate = max((top for *_, top, _ in parts), default=0.0)
    farthest = BENDING_LENGTHS * depth_of_substrate * (max(moduli) / min(moduli)) ** (1 / 3) if moduli else 0.0
    before = grid
    for around, stress_around in islice(wider, WIDER_GRIDS):
        axes = {"x": around.x, "y": around.y}
        within = (np.abs(at) < extent / 2 for at, extent in zip(axes.values(), before.extent, strict=True))
        beyond = principal_stresses(stress_around)[0]
        beyond[np.ix_(*within)] = -inf
        largest, place = largest_place(beyond, axes)
        added = [wide - extent for wide, extent in zip(around.extent, grid.extent, strict=True) if wide > extent]
        if largest > max(value, ROUNDING * scale):
            value, position = largest, place
            between_cells = _fall(beyond, stress_around[2], scale)  # it is smooth there
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
        by_peak = estimate.peak_pressure.total * float(np.abs(stress[2]).max())
        reach = max(reach, value + max(by_peak, UNSEEN_TENSION * scale))
    where = position if value else None
    return Quantity(value, "Pa", label, inf, reason or NO_ESTIMATE, where, rivals=((reach, 0.0),))


def between_depths(depths: Array, peaks: Array, *, given: bool) -> tuple[float, float]:
    """Return by how much the largest stress exceeds all `peaks`, and its depth [m].

    The peaks (z,) are the largest values at the `depths` (z,) [m]. The largest of all lies at the vertex of the
    parabola in the logarithm of the depth through the largest peak and its neighbours; at given depths, at the surface
    and beside an interface it is the largest peak itself.
    """
    at = int(peaks.argmax())
    at_peak = 0.0, float(depths[at])
    if given or not 0 < at < len(peaks) - 1 or not depths[at - 1]:
        return at_peak
    steps = [log(depths[at] / depths[at - 1]), log(depths[at + 1] / depths[at])]
    if not all(log(MIN_DEPTH_RATIO) < step < log(MAX_DEPTH_RATIO) for step in steps):
        return at_peak
    fall = [float(peaks[at] - peaks[at - 1]), float(peaks[at] - peaks[at + 1])]
    # peak - slope t - bend t^2 at the logarithmic distance t from the largest peak
    bend = (fall[0] / steps[0] + fall[1] / steps[1]) / (steps[0] + steps[1])
    slope = (fall[1] - bend * steps[1] ** 2) / steps[1]
    if bend <= 0:
        return 0.0, float(depths[at])
    return slope**2 / (4 * bend), float(depths[at]) * exp(-slope / (2 * bend))


def _fall(tension: Array, pressing: Array, scale: float) -> float:
    """Return the fall [Pa] from the largest `tension` at a surface (x, y) to the cells beside it outside the contact.

    It is the larger fall from the largest of all cells and from the largest of those outside. A cell is in contact
    where the stress `pressing` it (x, y), zz, is more than rounding of a `scale` [Pa]; if all are, all count as
    outside.
    """
    touches = np.abs(pressing) > ROUNDING * scale
    outside = tension if touches.all() else np.where(touches, -inf, tension)
    return max(_fall_beside(tension, outside), _fall_beside(outside, outside))


def _falls(values: Array, cells: int) -> Array:
    """Return the falls (x, y) from each of some `values` to the mean of the two some `cells` away, on the steeper axis.

    Beyond the grid the last value is repeated.
    """
    falls = np.zeros(values.shape)
    for axis in (0, 1):
        if (count := values.shape[axis]) > 1:
            at = np.arange(count)
            around = (values.take(at - cells, axis, mode="clip") + values.take(at + cells, axis, mode="clip")) / 2
            falls = np.maximum(falls, values - around)
    return falls


def _fall_beside(values: Array, beside: Array) -> float:
    """Return the fall from the largest of some `values` (x, y) to the mean of the field `beside` on both sides of it.

    It is that to the next cells along the steeper axis, of which infinite ones do not count: half of the second
    difference of a smooth field, wherever its largest value lies.
    """
    place, falls = np.unravel_index(int(values.argmax()), values.shape), [0.0]
    for axis in (0, 1):
        line, at = np.take(beside, place[1 - axis], axis=1 - axis), int(place[axis])
        around = line[[cell for cell in (at - 1, at + 1) if 0 <= cell < len(line)]]
        if (known := np.isfinite(around)).any():
            falls.append(float(values[place] - around[known].mean()))
    return max(falls)


def largest_of(values: Array, unit: str, label: str) -> Quantity:
    """Return the largest of some `values` (x, y) as a quantity, which may lie as high beside it as they fall there."""
    largest = float(values.max())
    return Quantity(largest, unit, label, rivals=((largest + _fall_beside(values, values), 0.0),))


def largest_place(
    values: Array, axes: Mapping[str, Array], dimensions: Sequence[str] = ("x", "y")
) -> tuple[float, dict[str, float]]:
    """Return the largest of some `values` and its coordinates by the names of the `dimensions` of the field.

    The coordinates of each dimension stand in `axes`; of one without, or of a single cell, there is none. Of equal
    largest values it is the nearest to the middle, between two neighbours the mean.
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
