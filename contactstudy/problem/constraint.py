"""What surfaces may exert on each other: limits of the pressure, what closes the problem, and attraction.

:class:`Constraint` has the limits of the pressure in each cell, and projects a pressure to them; :class:`Control` is
the load, or the approach, that is prescribed; :class:`Gap` is what a solver finds under a pressure. A ``CohesiveLaw``
is the attraction of two surfaces at a gap.

Pressures and heights are fields (x, y) in any units, unless a unit is given. The active set is the cells at no limit of
their pressure, in which the gap should be zero; it is a field that is 1 there and 0 elsewhere.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import inf, isnan, nan, pi, prod
from typing import Self

import numpy as np
from numpy.typing import NDArray

from contactstudy.domain.device import arrays
from contactstudy.domain.grid import Array, dot, replace_blocks
from contactstudy.domain.grid import total as sum_of


def zone_length(modulus: float, work: float, strength: float) -> float:
    """Return the length [m] of the cohesive zone at the edge of a contact: ``pi E* w / (4 sigma0^2)``.

    `modulus` is the contact modulus E* [Pa], `work` that of adhesion w [J/m^2], and `strength` the largest traction
    sigma0 [Pa]. Source: Dugdale (1960).
    """
    return pi * modulus * work / (4 * strength**2)


def tabor_length(radius: float, work: float, modulus: float) -> float:
    """Return the length [m] ``(R w^2 / E*^2)^(1/3)``, which over the range of an attraction is Tabor's parameter.

    `radius` is R [m], `work` that of adhesion w [J/m^2], `modulus` the contact modulus E* [Pa]. Source: Tabor (1977).
    """
    return float(np.cbrt(radius * (work / modulus) ** 2))


@dataclass(frozen=True)
class WorkAndRange:
    """Work of adhesion w [J/m^2] and range rho [m] of an attraction between two surfaces."""

    work: float
    range: float

    @property
    def strength(self) -> float:
        """Largest traction [Pa], ``w / rho``."""
        return self.work / self.range


@dataclass(frozen=True)
class Exponential(WorkAndRange):
    """Cohesive law ``sigma = w / rho exp(-g / rho)`` with the work of adhesion w [J/m^2] and the range rho [m].

    It falls from zero gap on: the law of Xu & Needleman (1994), J. Mech. Phys. Solids 42, 1397, has a rising part
    first.
    """

    def traction(self, gap: Array) -> Array:
        """Return the traction [Pa] at a `gap` [m]."""
        return self.strength * np.exp(np.maximum(gap, 0) / -self.range)

    def slope(self, gap: Array) -> Array:
        """Return ``-d traction / d gap`` [Pa/m] at a `gap` [m]."""
        return self.traction(gap) / self.range

    def remaining_work(self, gap: Array) -> Array:
        """Return the work [J/m^2] to separate surfaces from a `gap` [m]."""
        return self.work * np.exp(np.maximum(gap, 0) / -self.range)


# Half the width of the fall of Dugdale's law over its range; and the smallest product of that and the number of cells
# in the cohesive zone, below which the edge of the contact is trapped between two cells. On 24 cylinders with a ramp of
# 0.1 the contact was as if the work of adhesion were off by up to 30 % on 3.5 cells in the zone, 17 % on 6 and 3 % on
# 14; with a ramp of 3 over the cells by 2, 0.9 and 0.8 %.
RAMP, CELLS_ON_RAMP = 0.1, 3.0


@dataclass(frozen=True)
class Dugdale(WorkAndRange):
    """Cohesive law of Dugdale: a constant traction that falls to zero around the range, at any fall with the same work.

    Source: Maugis (1992), J. Colloid Interface Sci. 150, 243, there with a sharp fall.

    Parameters
    ----------
    work
        Work of adhesion w [J/m^2].
    range
        Range rho [m]: the traction is ``w / rho`` up to ``(1 - ramp) rho`` and zero from ``(1 + ramp) rho`` on.
    ramp
        Half the width of the fall over the range, at most 1.
    """

    ramp: float = RAMP

    @classmethod
    def on_cells(cls, work: float, attraction_range: float, cells: float) -> "Dugdale":
        """Return the law whose fall is the sharpest that is not trapped on this number of `cells` in its zone."""
        return cls(work, attraction_range, min(max(RAMP, CELLS_ON_RAMP / cells), 1.0))

    def traction(self, gap: Array) -> Array:
        """Return the traction [Pa] at a `gap` [m]."""
        fraction = np.clip(self._remaining(gap) / (2 * self.ramp), 0, 1)
        return np.asarray(self.strength * fraction)

    def slope(self, gap: Array) -> Array:
        """Return ``-d traction / d gap`` [Pa/m] at a `gap` [m]."""
        on_ramp = np.abs(self._remaining(gap) - self.ramp) < self.ramp
        return np.asarray(on_ramp * self.strength / (2 * self.ramp * self.range))

    def remaining_work(self, gap: Array) -> Array:
        """Return the work [J/m^2] to separate surfaces from a `gap` [m]."""
        remaining = np.maximum(self._remaining(np.maximum(gap, 0)), 0)
        on_ramp = np.minimum(remaining, 2 * self.ramp)
        return self.work * (remaining - on_ramp + on_ramp**2 / (4 * self.ramp))

    def _remaining(self, gap: Array) -> Array:
        """Return by how much a `gap` [m] is smaller than the smallest one without traction, over the range."""
        return np.asarray(1 + self.ramp - gap / self.range)


# Attraction between two surfaces as a function of their gap; it falls where the gap grows.
CohesiveLaw = Exponential | Dugdale


@dataclass(frozen=True, eq=False)
class Gap:
    """Gap between the bodies under a pressure, in units of the gap scale of the problem.

    Under a given load the approach is such that the mean height over the active set is zero; else it is the given one.
    The gap should be zero in the active set, not below zero in cells without pressure, and not above zero in cells at
    the hardness.

    Parameters
    ----------
    height
        Height (x, y) of the gap, counted from the approach.
    approach
        Approach of the bodies.
    violation
        Largest violation of the complementarity conditions, see :meth:`~contactstudy.Constraint.violation`.
    load
        Load over the area of a cell: the sum of the pressure.
    largest_displacement
        Largest absolute value of the displacement.
    """

    height: Array
    approach: float
    violation: float
    load: float
    largest_displacement: float


def scaled_in_double(field: Array, factor: float) -> Array:
    """Return `field` times `factor` in double precision, in place if it has that precision."""
    double = arrays().astype(field, arrays().float64, copy=False)
    double *= factor
    return double


def cell_violation(pressure: Array, height: Array, active: Array) -> Array:
    """Return by how much cells (x, y) outside the `active` set violate their condition: a height, at least 0.

    Cells without pressure should not penetrate, and cells at the upper limit should have no open gap.
    """
    xp = arrays()
    return xp.maximum(xp.where(pressure == 0, -height, height) * (1 - active), 0)


def largest_of(*measures: float) -> float:
    """Return the largest of measures at least 0, or nan if one is nan, which Python's ``max`` may miss."""
    return nan if isnan(sum(measures)) else float(max(measures))


def project_capped_simplex(trial: Array, total: float, limit: float) -> Array:
    """Shift a `trial` pressure by one value such that, cut off at 0 and `limit`, it has the sum `total`, in place.

    The cells must be able to carry the sum. It is piecewise linear in the shift, with a breakpoint where a cell comes
    into contact and where it reaches `limit`. Source: Held, Wolfe & Crowder (1974), here with an upper limit.
    """
    xp = arrays()
    # counted from the highest cell: where there is pressure, numbers are then of the size of the load
    depths = xp.astype(trial, xp.float64, copy=False)
    depths -= float(xp.max(depths))
    breakpoints = xp.sort(xp.reshape(-depths, (-1,)))
    cells = breakpoints.shape[0]
    loaded = xp.arange(1, cells + 1, dtype=xp.float64)
    if limit < inf:
        breakpoints = xp.concat([breakpoints, breakpoints + limit])
        order = xp.argsort(breakpoints, stable=True)
        breakpoints = xp.take(breakpoints, order, axis=0)
        loaded = xp.cumulative_sum(1 - 2 * xp.astype(order >= cells, xp.float64))
    carried = xp.diff(breakpoints)
    carried *= loaded[:-1]
    carried = xp.cumulative_sum(carried)
    segment = int(xp.searchsorted(carried, xp.full_like(breakpoints[:1], total))[0])
    missing = total - (float(carried[segment - 1]) if segment else 0.0)
    count = max(float(loaded[segment]), 1.0)
    shift = float(breakpoints[segment]) + missing / count
    del breakpoints, loaded, carried
    # correct the shift for the rounding of the cumulative sum
    shift += (total - float(xp.sum(xp.clip(depths + shift, 0.0, limit)))) / count
    depths += shift
    trial[...] = xp.astype(xp.clip(depths, 0.0, limit), trial.dtype, copy=False)
    return trial


def shift_to_load(
    load: float,
    current_load: float,
    loaded_cells: float,
    load_above: Callable[[float], tuple[float, float]],
    epsilon: float,
) -> tuple[float, float]:
    """Return shift and factor with which ``max(p - shift, 0) factor`` of a pressure p at least 0 has the sum `load`.

    The shift is the Lagrange multiplier of the load, by Newton's steps. The pressure has the sum `current_load` in a
    number of `loaded_cells`; `load_above` returns both for a shift. A pressure with less than the load is not shifted.
    The factor, to the load from what is left, is 1 within 16 machine epsilons (`epsilon`).
    """
    shift, before = 0.0, -1.0
    while current_load > load and loaded_cells != before:
        shift, before = shift + (current_load - load) / loaded_cells, loaded_cells
        current_load, loaded_cells = load_above(shift)
    return shift, 1.0 if abs(current_load / load - 1) <= 16 * epsilon else load / current_load


@dataclass(frozen=True)
class Constraint:
    """Limits of the pressure of each cell: ``0 <= p <= hardness``, those of an elastic-perfectly plastic contact.

    Where the pressure is at the hardness the bodies may overlap, by the plastic indentation of the softer one. The
    active set is the cells at no limit of their pressure: in them the constraint ``gap >= 0`` is active, and the gap
    should be zero. Source: Almqvist, Sahlin, Larsson & Glavatskih (2007), sect. 2.

    Parameters
    ----------
    hardness
        Largest pressure, in the unit of the pressure, above 0; infinite for elastic bodies.
    """

    hardness: float = inf

    def scaled(self, factor: float) -> Self:
        """Return this constraint on pressures times `factor`: the same one in another unit."""
        return replace(self, hardness=float(self.hardness * factor))

    def in_unit(self, pressure: Array, unit: float) -> Array:
        """Return ``pressure * unit``, in the unit of this constraint, from a `pressure` (x, y) in multiples of `unit`.

        Cells at the hardness of ``scaled(1 / unit)`` are at the hardness to the last bit. The given array may be
        overwritten.
        """
        if self.hardness == inf:
            return scaled_in_double(pressure, unit)
        yielding = self.scaled(1 / unit).yielded(pressure)
        return arrays().where(yielding, self.hardness, scaled_in_double(pressure, unit))

    def capacity(self, cells: int) -> float:
        """Return the largest sum of pressure that a number of `cells` can have."""
        return self.hardness * cells

    def yielded(self, pressure: Array) -> NDArray[np.bool_]:
        """Return the cells (x, y) at the hardness."""
        return pressure >= self.hardness

    def active(self, pressure: Array) -> Array:
        """Return 1 for cells (x, y) of the active set, and 0 for the others, as numbers of the type of the pressure.

        They are not booleans: on a rough contact, selecting by a mask costs ten times a product.
        """
        chosen = pressure > 0
        if self.hardness < inf:
            chosen &= pressure < self.hardness
        return arrays().astype(chosen, pressure.dtype)

    def approach_without_active_cells(self, pressure: Array, height: Array) -> float:
        """Return the smallest approach that leaves no gap open where all cells have yielded.

        `height` (x, y) is that of the gap at no approach. The approach is nan without pressure, since a load needs some
        cells in contact.
        """
        loaded = height[pressure > 0]
        return float(arrays().max(loaded)) if loaded.shape[0] else nan

    def exceeded_by(self, trial: Array) -> bool:
        """Return whether a `trial` pressure is beyond a limit in any cell."""
        xp = arrays()
        return bool(xp.min(trial) < 0) or (self.hardness < inf and bool(xp.max(trial) > self.hardness))

    def clip(self, trial: Array) -> Array:
        """Cut a `trial` pressure off at the limits, in place."""
        xp = arrays()
        if self.hardness == inf:
            return replace_blocks(trial, lambda block: xp.maximum(block, 0))
        return replace_blocks(trial, lambda block: xp.clip(block, 0.0, self.hardness))

    def scale_to_load(self, trial: Array, total: float | None) -> Array:
        """Cut a `trial` pressure off at the limits and scale it to the sum `total`, if one is given, in place.

        Where the loaded cells cannot carry the sum at the hardness, the others carry the rest evenly, up to the
        hardness.
        """
        if total is None or self.hardness == inf:
            self.clip(trial)
            if total is not None:
                trial *= float(np.divide(total, sum_of(trial)))
            return trial
        xp = arrays()
        replace_blocks(trial, lambda block: xp.maximum(block, 0))
        loaded = trial > 0
        count = int(xp.count_nonzero(loaded))
        if count * self.hardness <= total:
            unloaded = max(prod(trial.shape) - count, 1)
            spread = min((total - self.hardness * count) / unloaded, self.hardness)
            trial[~loaded] = spread
            trial[loaded] = self.hardness
            return trial
        carried = trial[loaded]
        rounding = 8 * float(xp.finfo(trial.dtype).eps)
        if xp.max(carried) == self.hardness and abs(float(xp.sum(carried)) / total - 1) <= rounding:
            return trial  # a factor one bit below 1 would release yielding cells
        # the load is a concave, piecewise linear function of the factor: Newton's steps from the left never pass the
        # root, and end on its segment
        factor = total / float(xp.sum(carried))
        while True:
            yielding = carried * factor >= self.hardness
            remaining = total - self.hardness * int(xp.count_nonzero(yielding))
            below = float(xp.sum(carried[~yielding]))
            if not (below > 0 and remaining / below > factor):
                break
            factor = remaining / below
        return replace_blocks(trial, lambda block: xp.minimum(block * factor, self.hardness))

    def project(self, trial: Array, total: float | None) -> Array:
        """Replace a `trial` pressure by the nearest one in L2 within the limits, with the sum `total` if one is given.

        A step against the gap from a pressure to this one is along a descent direction of the energy.
        """
        return self.clip(trial) if total is None else project_capped_simplex(trial, total, self.hardness)

    def project_to_load(self, trial: Array, active: Array, total: float | None) -> Array:
        """Shift a `trial` pressure on the `active` set (1, others 0) to the sum `total` over all cells, in place.

        Without a given sum it is cut off at the limits.

        The shift is one value for the whole set, and the limits cut its cells off. Without a hardness other cells
        become zero, and the shift is found in Newton's steps, each of which cuts off more: the sum is convex in it.
        With one, other cells keep their pressure, cut off at the limits; where the set cannot carry the load less that
        of the others, all cells are scaled to the load.
        """
        if total is None:
            return self.clip(trial)
        xp = arrays()
        if self.hardness == inf:
            trial *= active
        self.clip(trial)
        loaded, chosen = trial[trial != 0], active > 0
        # Newton's steps round in units of the largest pressure, which must not be more than the load
        if self.hardness == inf and not (loaded.shape[0] and float(xp.max(loaded)) > total):

            def load_above(shift: float) -> tuple[float, float]:
                """Return the sum of the pressure above a shift, and the number of cells there."""
                above = loaded[loaded > shift]
                return float(xp.sum(above)) - shift * above.shape[0], above.shape[0]

            epsilon = float(xp.finfo(trial.dtype).eps)
            shift, factor = shift_to_load(total, float(xp.sum(loaded)), loaded.shape[0], load_above, epsilon)
            return replace_blocks(trial, lambda block: xp.maximum(block - shift, 0) * factor)
        remaining = total - float(xp.sum(trial[~chosen]))
        if not 0 < remaining < self.capacity(int(xp.count_nonzero(chosen))):
            return self.scale_to_load(trial, total)
        trial[chosen] = project_capped_simplex(trial[chosen], remaining, self.hardness)
        return trial

    def to_release(self, pressure: Array, height: Array) -> Array:
        """Return 1 for cells that should leave their limit, and 0 for the others, as numbers of the type of `height`.

        These penetrate without pressure, or have an open gap at the hardness.
        """
        released = (pressure == 0) & (height < 0)
        if self.hardness < inf:
            released |= (pressure >= self.hardness) & (height > 0)
        return arrays().astype(released, height.dtype)

    def violation(self, pressure: Array, height: Array) -> float:
        """Return the largest violation of the complementarity conditions, in units of the gap scale.

        It is the largest of the mean absolute gap of the active set weighted by pressure, the penetration of cells
        without pressure, and the open gap of cells at the hardness. `height` is that of the gap (x, y). See
        :class:`~contactstudy.SolveOptions`.
        """
        xp = arrays()
        violated = xp.where(pressure == 0, -height, 0.0)
        if self.hardness < inf:
            at_limit = pressure >= self.hardness
            violated, pressure = xp.where(at_limit, height, violated), xp.where(at_limit, 0.0, pressure)
        load = sum_of(pressure)
        complementarity = dot(pressure, xp.abs(height)) / load if load else 0.0
        return largest_of(complementarity, float(xp.max(violated)))


class Control:
    """Condition that closes the problem: a prescribed `total` or `approach`, of which the other is None.

    `total` is the load over the area of a cell, which is the sum of the pressure over all cells. Subclasses are
    :class:`PrescribedLoad` and :class:`PrescribedApproach`.
    """

    total: float | None
    approach: float | None

    def scaled(self, factor: float, cells: int = 1) -> "Control":
        """Return this condition for pressures times `factor`, on larger cells that are blocks of so many `cells`."""
        return self if self.total is None else PrescribedLoad(float(self.total * factor / cells))

    def is_met_by(self, constraint: Constraint, cells: int) -> bool:
        """Return whether a number of `cells` under `constraint` can carry the load, if one is given."""
        return self.total is None or constraint.capacity(cells) >= self.total

    def uniform(self, cells: int) -> float:
        """Return the pressure of the load spread evenly over a number of `cells`, or 0 without a load."""
        return 0.0 if self.total is None else self.total / cells

    def error(self, load: float) -> float:
        """Return the relative error ``|load / total - 1|``, infinite where the total is zero; 0 without a given load."""
        if self.total is None:
            return 0.0
        return abs(load / self.total - 1) if self.total else inf


@dataclass(frozen=True)
class PrescribedLoad(Control):
    """Load control: ``sum(p) = total``.

    `total` is the load over the area of a cell, in the unit of p.
    """

    total: float
    approach = None


@dataclass(frozen=True)
class PrescribedApproach(Control):
    """Approach control, with a given `approach` [m], from which heights are counted: the load follows, or is zero."""

    approach: float
    total = None
