"""Cohesive laws: the attraction between two surfaces as a function of their gap."""

from dataclasses import dataclass
from math import pi

import numpy as np

from contactstudy.domain.grid import Array


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

    It falls from zero gap on: the law of Xu & Needleman (1994), J. Mech. Phys. Solids 42, 1397, has a rising part first.
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


# Half the width of the fall of Dugdale's law over its range, and the least of it times the cells of the cohesive zone: a
# sharper fall is trapped between two cells. On 24 cylinders with a ramp of 0.1 the contact was as if the work of
# adhesion were off by up to 30 % on 3.5 cells in the zone, 17 % on 6 and 3 % on 14; with these by 2, 0.9 and 0.8 %.
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
        """Return the distance to the gap without traction, over the range."""
        return np.asarray(1 + self.ramp - gap / self.range)


# Attraction between two surfaces as a function of their gap, which it falls with.
CohesiveLaw = Exponential | Dugdale
