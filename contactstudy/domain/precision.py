"""The floating-point numbers a problem is solved in."""

from enum import Enum

import numpy as np
from numpy.typing import DTypeLike

from contactstudy.domain.checks import InvalidInput


class Precision(Enum):
    """Single or double precision; the residual cannot fall far below the rounding of either.

    SINGLE has about 7 digits and takes half the memory; DOUBLE has about 16. Influence coefficients are computed in
    double precision for both, and rounded once.
    """

    SINGLE = "single"
    DOUBLE = "double"

    @classmethod
    def named(cls, value: "Precision | str") -> "Precision":
        """``value``, or the precision of that name; :class:`~contactstudy.InvalidInput` for any other."""
        if isinstance(value, Precision):
            return value
        names = {one.value: one for one in cls}
        if value not in names:
            raise InvalidInput(f"precision is {value!r}: give 'single' or 'double'.")
        return names[value]

    @property
    def real(self) -> DTypeLike:
        """The type of fields."""
        return np.float32 if self is Precision.SINGLE else np.float64

    @property
    def bytes(self) -> int:
        """Of a number."""
        return np.dtype(self.real).itemsize
