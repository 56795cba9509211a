"""Numbers of the stress in a body that decide on its fatigue, by part of the body."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from math import exp, inf, log
from typing import Any

import numpy as np

from contactstudy.domain.errors import ErrorEstimate
from contactstudy.domain.fields import Array
from contactstudy.io.quantities.quantity import Quantity

# Bound of the largest tension at a surface over its fall in the first cell outside the contact: beside the edge of a
# contact that slides it falls like the square root of the distance. At most 3.2 on 68 sliding cylinders of 20 to 340
# cells, and 1.5 on 14 balls, against closed forms.
TENSION_ERROR = 3.5
# The same over the L1 error of the pressure times the largest von Mises stress at the surface.
BY_PRESSURE = 0.5
# Ratio of two depths up to which the stress between them follows a parabola, and above which they are no two sides of
# an interface.
MAX_STEP, MIN_STEP = 2.0, 1.001
DIMENSIONS = "z", "x", "y"
# Returns the largest of some values (z, x, y), and where it is.
Largest = Callable[[Array, Mapping[str, Array], tuple[str, ...]], tuple[float, dict[str, float]]]


def fatigue_quantities(
    stress: Array,
    axes: Mapping[str, Array],
    parts: Mapping[str, tuple[str, Any, Any]],
    estimate: ErrorEstimate,
    largest: Largest,
    *,
    given: bool,
) -> dict[str, Quantity]:
    """Return largest and orthogonal shear stress with their depths, the tension at the surface, and margins of parts.

    Parameters
    ----------
    stress
        Stress (component, z, x, y) [Pa].
    axes
        Depths and coordinates by their names.
    parts
        By what the names of their numbers begin with: name, material, and depths (z,) of the parts of the body; the
        whole body under "".
    estimate
        Errors of the contact.
    largest
        Function that finds the largest value.
    given
        Whether the depths are given, or were chosen for the largest von Mises stress.
    """
    from contactstudy.scene.stress import (
        largest_shear,
        orthogonal_shear,
        principal_stresses,
        von_mises,
    )  # imported only where it is named

    found: dict[str, Quantity] = {}
    measures = {
        "largest_shear_stress": ("largest shear stress", largest_shear),
        "orthogonal_shear": ("orthogonal shear stress", orthogonal_shear),
        "von_mises": ("largest von Mises stress", von_mises),
    }
    for before, (where, material, inside) in parts.items():
        depths, within = axes["z"][inside], stress[:, inside]
        for name, (label, measure) in measures.items():
            if name == "von_mises" and not before:  # that of the whole body has bounds of its own
                continue
            values = measure(within)
            value, position = largest(values, {**axes, "z": depths}, DIMENSIONS)
            if name == "orthogonal_shear":  # a range along x has no place on it
                position.pop("x", None)
            depth = None
            if "z" in position:
                shift, position["z"] = between_depths(depths, values.max(axis=(1, 2)), given=given)
                value += shift * (name != "von_mises")
                depth = Quantity(position["z"], "m", f"depth of the {label} in {where}")
                if given:  # the largest of all depths lies up to beside the neighbouring ones
                    place = int(np.flatnonzero(depths == depth.value)[0])
                    around = float(np.diff(depths[max(place - 1, 0) : place + 2]).max())
                    depth = replace(depth, bound=around, reason="")
            if name == "von_mises":
                ratio = getattr(material, "yield_stress", inf) / value if value else inf
                if ratio < inf:
                    margin = f"yield stress over von Mises stress in {where}"
                    found[f"{before}safety_factor"] = Quantity(
                        ratio, "1", margin, position=position
                    )
            else:
                found[before + name] = Quantity(
                    value, "Pa", f"{label} in {where}", position=position
                )
            if name == "orthogonal_shear":
                both = f"double amplitude of the {label} in {where}"
                found[f"{before}{name}_range"] = Quantity(2 * value, "Pa", both, position=position)
            if depth is not None:
                found[f"{before}{name}_depth"] = depth
    scale = float(von_mises(stress[:, 0]).max())
    if axes["z"][0] == 0 and scale:
        tension = principal_stresses(stress[:, 0])[0]
        value, position = largest(tension, axes, DIMENSIONS[1:])
        value = value if value > 1e-9 * scale else 0.0
        bound = TENSION_ERROR * _fall(tension, stress[2, 0], scale) * bool(value)
        bound += BY_PRESSURE * estimate.l1.total * scale
        reason = "" if bound < inf else estimate.l1.reason
        label = f"largest tensile stress at the surface of {parts[''][0].partition(' at ')[0]}"
        found["surface_tension"] = Quantity(
            value, "Pa", label, bound, reason, position if value else None
        )
    return found


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
    """Return the largest fall of a surface `tension` (x, y) from the cell outside the contact where it is the largest.

    A cell is in contact where the stress `pressing` it (x, y) is no rounding beside a `scale`; where all are, all count.
    """
    touches = np.abs(pressing) > 1e-9 * scale
    outside = tension if touches.all() else np.where(touches, -inf, tension)
    place = np.unravel_index(int(outside.argmax()), outside.shape)
    falls = [0.0]
    for axis in (0, 1):
        line = np.take(outside, place[1 - axis], axis=1 - axis)
        beside = [
            line[place[axis] + step] for step in (-1, 1) if 0 <= place[axis] + step < len(line)
        ]
        falls += [float(outside[place] - other) for other in beside if other > -inf]
    return max(falls)
