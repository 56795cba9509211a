"""The floating-point numbers a problem is solved in."""

from enum import Enum

import numpy as np
from numpy.typing import DTypeLike


class Precision(Enum):
    """Half the memory, or all the digits: the residual cannot fall far below the rounding of either.

    SINGLE has some seven digits, DOUBLE sixteen. Influence coefficients are found in double precision
    for both, and rounded once.
    """

    SINGLE = "single"
    DOUBLE = "double"

    @property
    def real(self) -> DTypeLike:
        """The type of fields."""
        return np.float32 if self is Precision.SINGLE else np.float64
