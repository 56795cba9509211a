"""Line Gauss-Seidel sweep downstream, compiled by numba (extra ``fast``)."""

import numpy as np

from contactstudy.domain.grid import Array
from contactstudy.domain.loops.compiled import exact


@exact
def sweep(
    diagonal: Array, previous: Array, following: Array, upstream: Array, second_upstream: Array, right: Array
) -> Array:
    """Return the solution (x, y) of one downstream sweep of line Gauss-Seidel, with periodic lines along y.

    Coefficients (x, y) are those of the cell, its neighbours along y, and the two cells upstream. Each line is solved by
    Thomas' algorithm with the correction of Sherman & Morrison (1950).
    """
    rows, columns = right.shape
    solution = np.zeros_like(right)
    slope, line, corner = np.empty(columns), np.empty(columns), np.empty(columns)
    for i in range(rows):
        for j in range(columns):
            line[j] = right[i, j]
            if i > 0:
                line[j] -= upstream[i, j] * solution[i - 1, j]
            if i > 1:
                line[j] -= second_upstream[i, j] * solution[i - 2, j]
            corner[j] = 0.0
        shift = -diagonal[i, 0]
        last = columns - 1
        corner[0], corner[last] = shift, following[i, last]
        pivot = diagonal[i, 0] - shift
        slope[0] = following[i, 0] / pivot
        line[0] /= pivot
        corner[0] /= pivot
        for j in range(1, columns):
            entry = diagonal[i, j]
            if j == last:
                entry -= following[i, last] * previous[i, 0] / shift
            pivot = entry - previous[i, j] * slope[j - 1]
            slope[j] = following[i, j] / pivot
            line[j] = (line[j] - previous[i, j] * line[j - 1]) / pivot
            corner[j] = (corner[j] - previous[i, j] * corner[j - 1]) / pivot
        for j in range(columns - 2, -1, -1):
            line[j] -= slope[j] * line[j + 1]
            corner[j] -= slope[j] * corner[j + 1]
        ratio = previous[i, 0] / shift
        weight = (line[0] + ratio * line[last]) / (1 + corner[0] + ratio * corner[last])
        for j in range(columns):
            solution[i, j] = line[j] - weight * corner[j]
    return solution
