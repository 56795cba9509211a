"""Influence coefficients of a cell repeated along both axes."""

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import gammaln

from contactstudy.domain.devices.arrays import Array
from contactstudy.elasticity.kernels.row import (
    FOURIER_END,
    boussinesq_cell_periodic,
    combined,
    harmonics_across,
    harmonics_along,
    paired,
    points_within,
)


def boussinesq_cell_doubly_periodic(
    x: ArrayLike, y: ArrayLike, dx: float, dy: float, width: float, period: float
) -> Array:
    """The cell repeated with ``width`` along x and ``period`` along y; x and y broadcast.

    Counted from its mean over both periods. Needs ``dx <= width`` and ``dy <= period``. Error below
    1e-13 of ``max(|S|, dx dy / min(width, period))``.

    Source: the rows of :func:`~contactstudy.kernels.boussinesq_cell_periodic`, whose harmonics die
    out within a few of their periods and whose logarithms together are that of a periodic line load,
    ``-2 ln |2 sin(pi x / W)|`` (Johnson 1985, sect. 13.2).
    """
    x = np.asarray(x, dtype=np.float64)
    y = np.asarray(y, dtype=np.float64)
    if period > width:  # the rows that die out sooner; turned, a column and a row are so again
        ndim = max(x.ndim, y.ndim)
        turned = np.array(y, ndmin=ndim).T, np.array(x, ndmin=ndim).T
        return boussinesq_cell_doubly_periodic(*turned, dy, dx, period, width).T
    folded = np.fmod(np.abs(x), width)
    x = np.asarray(np.minimum(folded, width - folded))
    total = boussinesq_cell_periodic(x - width, y, dx, dy, period)
    total += boussinesq_cell_periodic(x, y, dx, dy, period)
    total += dx * dy / period * _further_rows(x, y, dx, dy, width, period).reshape(total.shape)
    return total


def _further_rows(x: Array, y: Array, dx: float, dy: float, width: float, period: float) -> Array:
    """All rows but those at 0 and at W, in units of ``dx dy / period``: no cell reaches the axis."""
    x, y = paired(x, y)
    # beyond these, at more than FOURIER_END periods from any cell, nothing is left but logarithms
    rows = int(np.ceil(FOURIER_END * period / width)) + 1
    waves = [
        harmonics_across(side * x + m * width, dx / 2, period)
        for m in range(rows, 0, -1)
        for side in (1, -1)
        if (m, side) != (1, -1)
    ]
    across = np.zeros((x.size, max(wave.shape[1] for wave in waves)))
    for wave in waves:
        across[:, : wave.shape[1]] += wave
    along = harmonics_along(y, dy / 2, period, across.shape[1])
    total = combined(across, along, np.broadcast_shapes(x.shape, y.shape))
    # ln |x (W - x)| less ln |2 sin(pi x / W)|, by the sine's product
    logarithms = 2 * np.log(width) - np.log(2 * np.pi)
    for node, weight in points_within(2 * width / dx):
        t = (x + node * dx / 2) / width
        logarithms = logarithms + weight * (gammaln(1 + t) + gammaln(2 - t))
    total += 2 * logarithms
    return total
