"""The trend that is subtracted from a measured surface: its mean, its tilt, its form."""

from enum import Enum

import numpy as np

from contactstudy.domain.fields import Array


class Trend(Enum):
    """The least-squares polynomial that is subtracted; the value is its total degree."""

    NONE = -1
    MEAN = 0
    PLANE = 1
    QUADRATIC = 2

    def subtracted(self, heights: Array) -> Array:
        """``heights`` (x, y) less the polynomial, fitted to all points alike."""
        if self is Trend.NONE:
            return heights
        x, y = (_from_middle(count) for count in heights.shape)
        powers = [
            (i, j)
            for i in range(self.value + 1)
            for j in range(self.value + 1 - i)
            if i < heights.shape[0] and j < heights.shape[1]
        ]
        basis = np.stack([(x[:, None] ** i * y**j).ravel() for i, j in powers], axis=1)
        coefficients = np.linalg.lstsq(basis, heights.ravel(), rcond=None)[0]
        return np.asarray(heights - (basis @ coefficients).reshape(heights.shape))


def _from_middle(count: int) -> Array:
    """Positions of points from -1 to 1, so that powers of them stay apart."""
    return np.asarray((2 * np.arange(count) - (count - 1)) / max(count - 1, 1), dtype=np.float64)
