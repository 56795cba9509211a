"""Influence coefficients of a cell repeated along both axes."""

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import gammaln

from contactstudy.arrays import Array
from contactstudy.influence import CELL_POINTS, FOURIER_END, boussinesq_cell_periodic, gauss


def boussinesq_cell_doubly_periodic(
    x: ArrayLike, y: ArrayLike, dx: float, dy: float, width: float, period: float
) -> Array:
    """The cell repeated with ``width`` along x and ``period`` along y; x and y broadcast.

    Counted from its mean over both periods. Needs ``dx <= width`` and ``dy <= period``. Error below
    1e-13 of ``max(|S|, dx dy / min(width, period))``.

    Source: the rows of :func:`~contactstudy.influence.boussinesq_cell_periodic`, whose harmonics die
    out within a few of their periods and whose logarithms together are that of a periodic line load,
    ``-2 ln |2 sin(pi x / W)|`` (Johnson 1985, sect. 13.2).
    """
    if period > width:  # the rows that die out sooner
        return boussinesq_cell_doubly_periodic(y, x, dy, dx, period, width)
    x, y = np.abs(np.asarray(x, dtype=np.float64)), np.asarray(y, dtype=np.float64)
    x = np.fmod(x, width)
    x = np.minimum(x, width - x)
    # beyond these rows, at more than FOURIER_END periods from any cell, nothing is left but logarithms
    rows = int(np.ceil(FOURIER_END * period / width)) + 1
    total = sum(
        boussinesq_cell_periodic(x + m * width, y, dx, dy, period)
        for m in sorted(range(-rows, rows + 1), key=abs, reverse=True)
    )
    # sum of ln |x + m W| over the rows, less ln |2 sin(pi x / W)|: the sine's product without them
    logarithms = (
        (2 * rows + 1) * np.log(width)
        - np.log(2 * np.pi)
        + sum(
            weight * gammaln(rows + 1 + sign * (x + node * dx / 2) / width)
            for node, weight in gauss(CELL_POINTS)
            for sign in (1, -1)
        )
    )
    return np.asarray(total + 2 * dx * dy / period * logarithms)
