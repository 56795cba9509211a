"""What is said of a measured surface beside its file, and what a file holds."""

from dataclasses import KW_ONLY
from typing import Annotated, ClassVar, Literal, NamedTuple

import numpy as np

from contactstudy.domain.checks import InvalidInput
from contactstudy.domain.fields import Array
from contactstudy.domain.units import Metres, Number, readable
from contactstudy.domain.validation import FINITE, validated
from contactstudy.scene.surfaces.text_file import length_unit

# Units that a message offers [m].
UNITS = {"nm": 1e-9, "um": 1e-6, "mm": 1e-3, "m": 1.0}
# Reversed directions of a measured surface, and the reversed axes.
Flip = Literal["none", "across", "along", "both"]
REVERSED: dict[Flip, tuple[int, ...]] = {"none": (), "across": (0,), "along": (1,), "both": (0, 1)}
# Whether sizes and heights of a file are checked for plausibility and against the keys beside it.
Sizes = Literal["checked", "confirmed"]


@validated
class Reading:
    """What is said beside a file of a measured surface, where the file itself leaves it open.

    Parameters
    ----------
    extent
        Size (width, length) [m] of all points, of a file without sizes.
    unit
        Unit of the numbers, of a file without units, such as ``"um"``.
    invalid
        Number in the file that stands for a point that was not measured, such as -9999.
    decimal
        Decimal sign of a text file, ``","`` or ``"."``, where it can be read both ways.
    transpose
        Whether across and along are exchanged.
    flip
        Directions that are reversed.
    sizes
        Whether implausible sizes are refused. ``"confirmed"`` takes them, and keys that contradict the file.
    """

    called: ClassVar[str] = "MeasuredSurface"

    _: KW_ONLY
    extent: tuple[Metres, Metres] | None = None
    unit: str | None = None
    invalid: Annotated[Number, FINITE] | None = None
    decimal: Literal[",", "."] | None = None
    transpose: bool = False
    flip: Flip = "none"
    sizes: Sizes = "checked"

    def check_together(self) -> None:
        """Check that the unit is one of length."""
        if self.unit is not None and length_unit(self.unit) is None:
            raise InvalidInput(
                f"MeasuredSurface.unit is {self.unit!r}: give a unit of length, such as {', '.join(UNITS)}."
            )

    @property
    def metre(self) -> float | None:
        """The given unit [m], if any."""
        return None if self.unit is None else length_unit(self.unit)


class FileContent(NamedTuple):
    """Numbers of a file (x, y), nan where one is missing, their unit [m], the sizes [m], and notes on them.

    `assumed` is a note on sizes that the file leaves open, which a given extent replaces.
    """

    values: Array
    unit: float
    sizes: tuple[float, float] | None
    notes: tuple[str, ...] = ()
    invalid: float | None = None
    is_own: bool = False
    assumed: str = ""


def unit_of_heights(name: str, reading: Reading, own: float | None = None, unknown: str | None = None) -> float:
    """Return the unit [m] of heights: that of the file, which a given one must not contradict, or the given one."""
    given = reading.metre
    if own is None and given is None:
        fault = "is None" if unknown is None else f"is None, and its heights are in {unknown!r}"
        raise InvalidInput(
            f"MeasuredSurface.unit of {name!r} {fault}: give the unit of its numbers, one of {', '.join(UNITS)}."
        )
    if given is None or (own is not None and reading.sizes == "checked"):
        assert own is not None
        if given is not None and not np.isclose(given, own, rtol=1e-9, atol=0):
            raise InvalidInput(
                f"MeasuredSurface.unit of {name!r} is {reading.unit!r}: leave it out, since its heights are in "
                f'{unit_name(own)}; or give sizes = "confirmed" too, if the file is wrong.'
            )
        return own
    return given


def unit_name(unit: float) -> str:
    """Return the name of a unit [m]."""
    return next((name for name, size in UNITS.items() if np.isclose(size, unit, atol=0)), readable(unit))
