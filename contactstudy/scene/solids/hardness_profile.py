"""Hardness that falls with depth, as in a case-hardened body."""

from typing import Annotated

import numpy as np

from contactstudy.domain.checks import InvalidInput
from contactstudy.domain.fields import Array
from contactstudy.domain.units import Hardness, Metres, Pascals
from contactstudy.domain.validation import AT_LEAST_ZERO, validated

# Hardness at the case depth (ISO 18203): 550 HV [Pa]; tensile yield stress over hardness (Tabor 1951).
CASE_LIMIT, YIELD_OVER_HARDNESS = 550 * 9.80665e6, 1 / 3


@validated
class HardnessProfile:
    """Hardness or yield stress of a body by its depth: a table, or surface, core and case depth.

    The table is straight between its points and constant beyond the last one. With a case depth the hardness falls
    straight from the surface through 550 HV there to the core. Measured profiles lie above that line.

    Parameters
    ----------
    depths
        Depths of the table [m], growing from zero.
    hardness
        Hardness at each of them [Pa], of which a third is the yield stress (Tabor 1951).
    yield_stresses
        Tensile yield stress at each of them [Pa], in place of the hardness.
    surface, core
        Hardness at the surface and in the core [Pa], in place of a table: above and below 550 HV.
    case_depth
        Case-hardening depth [m], at which the hardness is 550 HV (ISO 18203).

    Raises
    ------
    InvalidInput
        If neither or both are given, or a number is outside these limits.
    """

    depths: tuple[Annotated[Metres, AT_LEAST_ZERO], ...] = ()
    hardness: tuple[Hardness, ...] = ()
    yield_stresses: tuple[Pascals, ...] = ()
    surface: Hardness | None = None
    core: Hardness | None = None
    case_depth: Metres | None = None

    def check_together(self) -> None:
        """Check that there is one description, and that a table has one value for each depth."""
        case = [name for name in ("surface", "core", "case_depth") if getattr(self, name) is not None]
        tables = [name for name in ("hardness", "yield_stresses") if getattr(self, name)]
        if (len(case), len(tables), bool(self.depths)) not in ((3, 0, False), (0, 1, True)):
            raise InvalidInput(
                f"HardnessProfile has {', '.join([*case, *tables]) or 'no values'}: give depths with hardness or "
                "yield_stresses, or surface, core and case_depth."
            )
        if case:
            if not self.core < CASE_LIMIT < self.surface:  # type: ignore[operator]
                raise InvalidInput(
                    f"HardnessProfile.surface is {self.surface!r} Pa and its core {self.core!r} Pa: a case depth is "
                    "where the hardness is 550 HV, 5.394e9 Pa, give depths and hardness in their place."
                )
            return
        (name,) = tables
        depths, values = self.depths, getattr(self, name)
        if len(values) != len(depths) or depths[0] or any(np.diff(depths) <= 0):
            raise InvalidInput(
                f"HardnessProfile.depths is {depths!r}: give as many as {name}, from 0 m, each larger than the last."
            )

    @property
    def points(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Depths [m] and yield stresses [Pa] between which the yield stress is straight."""
        if self.surface is None or self.core is None or self.case_depth is None:
            hardness = tuple(value * YIELD_OVER_HARDNESS for value in self.hardness)
            return self.depths, self.yield_stresses or hardness
        end = self.case_depth * (self.surface - self.core) / (self.surface - CASE_LIMIT)
        return (0.0, end), (self.surface * YIELD_OVER_HARDNESS, self.core * YIELD_OVER_HARDNESS)

    def yield_stress(self, depths: Array) -> Array:
        """Return the yield stress [Pa] at `depths` [m]."""
        return np.interp(depths, *self.points)
