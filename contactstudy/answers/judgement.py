"""Bounds of numbers by nested grids, and whether the bounds of an answer keep a requested error.

Where a law is known of a number, of its straight edges, its peak or its images, that is its bound; all others are
bounded by the same scene on a half, a third and a quarter of the cells, with longer steps.
"""

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from itertools import combinations
from math import ceil, inf, isfinite
from types import MappingProxyType
from typing import Any

from contactstudy.domain.errors import (
    AREA_FLOOR,
    DEPTH_FLOOR,
    EDGE_ORDER,
    FLOOR,
    INLET,
    MARGIN,
    PRESSURE,
    ErrorParts,
    Request,
)
from contactstudy.domain.grid import Grid
from contactstudy.domain.validation import InvalidInput, readable
from contactstudy.io.quantities.quantity import MAX_RELATIVE, RELATIVE_TO_ZERO, Quantities, Quantity, per_cent

NO_COARSER = "No bound: there is no solution on half the cells to compare with, give more."
# In the names of largest stresses.
OF_STRESS = "von_mises", "safety_factor", "shear_stress", "orthogonal_shear"
# Numbers that depend on where in their cells the edges of a contact lie.
OF_EDGES = "contact_area", "half_width", "mean_pressure", "contact_fraction"
# At the beginning of the names of numbers that plastic strain alone leaves behind.
BY_YIELD = "dent_depth", "shoulder_height", "highest_residual_stress", "lowest_residual_stress"
# Ends of the names of numbers that lie at an edge, of the plastic zone, the contact or its stick zone, beside which
# fields fall like the square root of the distance.
AT_EDGE = "highest_residual_stress", "surface_tension", "largest_shear"
# In the name of a depth, before the index of a body where it has one.
DEPTH = re.compile(r"_depth(?=(_\d)?$)")
# The same as `MARGIN` of numbers that have a law of their own beside.
BESIDE_LAW = {"peak_pressure": 0.75, "pull_off": 0.5} | dict.fromkeys(
    ("traction_coefficient", "creepage", "frictional_power", "largest_slip", "friction_energy"), MARGIN
)
# Power of the cell size with which errors fall beside an edge up to which a pressure rises, as at a flat with rounded
# edges: like the inverse square root of the distance, down to the rounding.
RISING_ORDER = 0.5
NO_COARSER_YIELD = "No bound: nothing yields on half the cells, give more."


def widened(grid: Grid, factor: int) -> Grid:
    """Return a grid with the same cells over `factor` times the width."""
    (nx, ny), (width, length) = grid.cells, grid.extent
    return Grid((factor * nx, ny), (factor * width, length))


def with_nested_bounds(
    quantities: Quantities,
    below: Mapping[int, Quantities],
    l1: ErrorParts,
    replaced: frozenset[str],
    *,
    edge_fraction: float = 0.0,
    order: float = 1.0,
    wider: Quantities | None = None,
    zone_edge: float = 0.0,
    unseen: Mapping[str, float] = MappingProxyType({}),
    of_stress: Mapping[str, float] = MappingProxyType({}),
    by_law: frozenset[str] = frozenset(),
    at_edge: frozenset[str] = frozenset(),
) -> dict[str, Quantity]:
    """Return quantities with bounds by their changes between grids, where their reasons are some of those `replaced`.

    Parameters
    ----------
    quantities
        The numbers of an answer.
    below
        Those on 1 / k of the cells along each axis, by k.
    l1
        Error of the pressure, whose causes but the cells add to each bound.
    replaced
        Reasons of numbers without a bound that get one.
    edge_fraction
        Fraction of the cells in contact that lie at its edge: the boundary of a stick zone is known to a row of cells,
        and the place of a pressure that lags behind the load to a part of one.
    order
        Power of the cell size with which errors fall; beside an edge it is `EDGE_ORDER` at most.
    wider
        Those of a film on half the cells over twice the width, whose inlet is finite.
    zone_edge
        Fraction of the cells of a plastic zone that lie at its edge.
    unseen
        Relative errors that no change shows, by name; those of other numbers are the causes of `l1` but the cells, and
        twice the least change.
    of_stress
        Relative errors that no change of a largest stress shows, by name, beside those causes.
    by_law
        Names of numbers with a law of their own, which need no solution on coarser cells.
    at_edge
        Names of numbers that rise up to an edge, where their law does not hold.
    """
    other_causes = l1.total - (l1.discretisation or 0.0) if isfinite(l1.total) else inf
    found = dict(quantities)
    for name, quantity in quantities.items():
        if isfinite(quantity.bound) or quantity.reason not in replaced:
            continue
        values = {1: quantity.value} | {k: level[name].value for k, level in below.items() if name in level}
        coarser = list(values.values())[1:]
        if not coarser and name not in by_law:
            found[name] = replace(quantity, reason=NO_COARSER)
        elif name.startswith(BY_YIELD) and quantity.value and not any(coarser):
            found[name] = replace(quantity, reason=NO_COARSER_YIELD)
        elif not isfinite(other_causes):
            found[name] = replace(quantity, reason=l1.reason or quantity.reason)
        else:
            size = abs(quantity.value)
            by_l1 = FLOOR * (l1.discretisation or 0.0) / (2 if name in unseen and name not in by_law else 1)
            floor = max(by_l1, quantity.least_change)
            if name.startswith(BY_YIELD):
                floor = max(floor, AREA_FLOOR * zone_edge)
            if name == "rolling_resistance":
                floor = max(floor, AREA_FLOOR * edge_fraction)
            others = unseen.get(name, other_causes)
            if any(stress in name for stress in OF_STRESS):
                floor = max(floor, DEPTH_FLOOR if DEPTH.search(name) else 0.0)
                others += 0.0 if "orthogonal" in name else of_stress.get(name, 0.0)  # that is 0 at the surface
            change = by_changes(values, min(order, EDGE_ORDER) if _is_at_edge(name) else order)
            inlet = 0.0
            if wider is not None and name in wider:
                inlet = max(INLET * abs(values[2] - wider[name].value), FLOOR * (l1.inlet or 0.0) * size)
                others -= l1.inlet or 0.0
            bound = MARGIN * max(change, floor * size) + inlet + others * size
            if name.endswith("stick_fraction"):
                bound = max(bound, edge_fraction)
            reach = max((value for value, _ in quantity.rivals), default=quantity.value)
            bound = max(bound, reach - quantity.value)
            reason = "" if bound else RELATIVE_TO_ZERO
            found[name] = replace(quantity, bound=bound or inf, reason=reason)
    for name, margin in BESIDE_LAW.items():
        if name in quantities and isfinite(bound := quantities[name].bound):
            levels = {1: quantities} | dict(below)
            margin, power = (MARGIN, RISING_ORDER) if name in at_edge else (margin, order)
            change = by_changes({k: level[name].value for k, level in levels.items() if name in level}, power)
            found[name] = replace(found[name], bound=max(bound, margin * change))
    if "pull_off" in found and "load_per_length" in found:  # the load is that
        found["load_per_length"] = replace(found["load_per_length"], bound=found["pull_off"].bound)
    for name, depth in found.items():
        largest = found.get(DEPTH.sub("", name), depth)
        if largest is not depth and isfinite(depth.bound):
            within = largest.value - largest.bound
            away = [abs(at - depth.value) for value, at in largest.rivals if value >= within]
            found[name] = replace(depth, bound=max(depth.bound, *away, 0.0))
    for name in [name for name in found if name.startswith("safety_factor_depth")]:  # of the same place as a stress
        same = [of for other, of in found.items() if "von_mises_depth" in other and of.value == found[name].value]
        if same and isfinite(found[name].bound):
            found[name] = replace(found[name], bound=same[0].bound, reason=same[0].reason)
    return found


def by_changes(
    values: Mapping[int, Any], order: float, distance: Callable[[Any, Any], float] = lambda a, b: abs(a - b)
) -> float:
    """Return the error of a number, or of a field with a `distance`, by its changes between any two of several grids.

    A change between 1 / j and 1 / k of the cells shows an error that falls with a power `order` of the cell size as
    ``k^order - j^order`` times itself. One change may vanish by chance, the largest of six hardly does.

    Parameters
    ----------
    values
        Values on 1 / k of the cells along each axis, by k; that of k = 1 is the one judged.
    order
        The power.
    distance
        Distance between two values.
    """
    pairs = combinations(sorted(values), 2)
    return max((distance(values[j], values[k]) / (k**order - j**order) for j, k in pairs), default=0.0)


def _is_at_edge(name: str) -> bool:
    """Return whether a number lies at an edge; the name may end with the index of a body."""
    return re.sub(r"_\d$", "", name).endswith(AT_EDGE)


# Ends of the names of numbers for which finer cells are no remedy: the depth of a largest stress is known only to the
# distance between the depths at which stress is computed, and so is the last part of the stress itself.
NOT_BY_CELLS = "safety_factor_depth", "von_mises_depth", "shear_stress_depth", "orthogonal_shear_depth"
# What is in the names of numbers for which no grid is refined unless they are named.
NOT_REFINED = "shear_stress", "orthogonal_shear", "_safety_factor", *AT_EDGE
# Names of components, with the whole quantity: the error of a component is relative to the whole, if that is larger.
WHOLE = {"lateral_traction_coefficient": "traction_coefficient"}


@dataclass(frozen=True)
class Judged:
    """Bound of one number of an answer beside the error that is requested of it.

    Attributes
    ----------
    label
        Name for display.
    bound
        Bound of its relative error, or of the error itself where the number is a fraction. Infinite where it has none.
    requested
        Error not to exceed; infinite without a request.
    reason
        Why it has no bound; empty where it has one.
    order
        Power of the cell size with which the bound falls; 0 if finer cells do not lessen it.
    refines
        Whether a grid is refined for it.
    absolute
        The bound as text with its unit where the number is nearly zero beside it; empty elsewhere.
    """

    label: str
    bound: float
    requested: float
    reason: str = ""
    order: float = 1.0
    refines: bool = True
    absolute: str = ""

    @property
    def ratio(self) -> float:
        """Bound over the requested error, or the bound itself without a request."""
        return self.bound / self.requested if isfinite(self.requested) else self.bound

    @property
    def finer(self) -> float:
        """Factor on the cells along an axis with which the bound meets the request.

        It is infinite for a number that finer cells do not help.
        """
        return self.ratio ** (1 / self.order) if self.order else inf

    def __str__(self) -> str:
        """Return the bound and the name, such as ``0.7 % in the half-width``."""
        bound = (self.absolute or per_cent(self.bound)) if isfinite(self.bound) else "no bound"
        return f"{bound} in the {self.label}"


def judged_numbers(quantities: Quantities, request: Request | None) -> dict[str, Judged]:
    """Return the numbers that a request speaks of, by name: all that have an error if it names none.

    A name of the request stands for the number of that name and for all that end with it, so that ``von_mises`` is the
    largest stress of the body, of its coating and of its substrate.

    Raises
    ------
    InvalidInput
        For a name that no number has.
    """
    uncertain = {name: quantity for name, quantity in quantities.items() if _is_uncertain(quantity)}
    if not isinstance(request, Mapping):
        requested = inf if request is None else request
        every = {name: _judged(name, quantities, requested) for name in uncertain}
        return {
            name: replace(one, refines=not any(part in name for part in NOT_REFINED)) for name, one in every.items()
        }
    found: dict[str, Judged] = {}
    for key, requested in request.items():
        if key == PRESSURE:
            continue
        names = [name for name in quantities if _is_named(name, key)]
        if not names:
            known = ", ".join((PRESSURE, *uncertain))
            raise InvalidInput(f"error names {key!r}, which this answer does not have: give some of {known}.")
        # the closest name is the one that is meant
        if key in names:
            names = [key]
        found |= {name: _judged(name, quantities, requested) for name in names if name in uncertain}
    return found


def _is_named(name: str, key: str) -> bool:
    """Return whether `key` is the `name` of a number or its last words, before the index of a body where it has one."""
    return re.sub(r"_\d$", "", name).endswith(f"_{key}") or name == key


def _is_uncertain(quantity: Quantity) -> bool:
    """Return whether a number has a relative error: it is neither exact, nor a formula, nor zero."""
    is_zero = quantity.reason == RELATIVE_TO_ZERO or (isfinite(quantity.bound) and not quantity.value)
    return not (quantity.is_formula or not quantity.bound or is_zero)


def _judged(name: str, quantities: Quantities, requested: float) -> Judged:
    """Return the number `name` of the `quantities`, with a `requested` relative error."""
    quantity = quantities[name]
    whole = quantities.get(WHOLE.get(name, name), quantity)
    scale = 1.0 if quantity.is_fraction else max(abs(quantity.value), abs(whole.value))
    bound = quantity.bound / scale if scale else inf
    label = quantity.label.split(" (")[0] + (" (absolute)" if quantity.is_fraction else "")
    is_of_depths = name.endswith(NOT_BY_CELLS) or MARGIN * quantity.least_change > requested
    order = 0.5 if _is_at_edge(name) else float(not is_of_depths)
    absolute = readable(quantity.bound, quantity.unit, 2) if MAX_RELATIVE < bound < inf else ""
    return Judged(label, bound, requested, quantity.reason, order, absolute=absolute)


def without_bound(numbers: Iterable[Judged]) -> str:
    """Return which numbers have no bound, with the reason of the first; empty if all have one."""
    unknown = [number for number in numbers if not isfinite(number.bound)]
    if not unknown:
        return ""
    first, others = unknown[0], len(unknown) - 1
    beside = f" and {others} other{'s' if others > 1 else ''}" if others else ""
    why = re.sub(r"^No bound[^:]*: ", "", first.reason).rstrip(".")
    return f"no bound for the {first.label}{beside}: {why}"


def finer_grid(grid: Grid, factor: float) -> Grid:
    """Return a grid of the same extent with `factor` times the cells along each axis that has several."""
    across, along = (count if count == 1 else ceil(count * factor) for count in grid.cells)
    return Grid((across, along), grid.extent)
