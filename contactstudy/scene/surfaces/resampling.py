"""Resampling of measured heights to the means of grid cells."""

from typing import Literal

import numpy as np

from contactstudy.domain.fields import Array

# The boundary condition of scipy.interpolate.CubicSpline.
Ends = Literal["periodic", "not-a-knot"]


def cell_means(
    heights: Array, axis: int, *, extent: float, cells: int, width: float, ends: Ends
) -> Array:
    """Means over ``cells`` equal cells of ``width`` in all of the smooth surface through ``heights``.

    Along ``axis``, the points are the means of equal pieces of ``extent``; both are centred on the
    same origin, and ``width`` lies within the extent unless the ``ends`` are periodic. The integral of
    the surface is known at every border between two pieces; a cubic spline through it is read at the
    borders of the cells. So a cell made of whole pieces has their mean, smaller cells make up the mean of
    a larger one, and in the limit they show a surface without kinks.
    """
    from scipy.interpolate import CubicSpline  # imported only where it is needed

    count = heights.shape[axis]
    if (cells, width) == (count, extent):
        return heights
    mean = heights.mean(axis=axis, keepdims=True)
    integral = np.cumsum(heights - mean, axis=axis)
    start = np.zeros_like(mean)
    # rounding aside, the integral of what is left of the mean closes to zero
    inner = np.take(integral, range(count - 1), axis=axis)
    integral = np.concatenate([start, inner, start], axis=axis) * (extent / count)
    borders = (np.arange(count + 1) / count - 0.5) * extent
    spline = CubicSpline(borders, integral, axis=axis, bc_type=ends)
    faces = (np.arange(cells + 1) / cells - 0.5) * width
    if ends != "periodic":
        faces = np.clip(faces, borders[0], borders[-1])
    return np.asarray(mean + np.diff(spline(faces), axis=axis) * (cells / width))
