"""A sweep over lines of cells downstream, compiled by numba (extra ``fast``)."""

import numpy as np

from contactstudy.domain.compiled import exact
from contactstudy.domain.fields import Array


@exact
def sweep(
    own: Array, before: Array, behind: Array, upstream: Array, further: Array, right: Array
) -> Array:
    """Solve one line along y after the other, each with what lies upstream already known.

    Thomas' algorithm for cyclic lines, with the correction of Sherman & Morrison (1950).
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
                line[j] -= further[i, j] * solution[i - 2, j]
            corner[j] = 0.0
        shift = -own[i, 0]
        last = columns - 1
        corner[0], corner[last] = shift, behind[i, last]
        pivot = own[i, 0] - shift
        slope[0] = behind[i, 0] / pivot
        line[0] /= pivot
        corner[0] /= pivot
        for j in range(1, columns):
            diagonal = own[i, j]
            if j == last:
                diagonal -= behind[i, last] * before[i, 0] / shift
            pivot = diagonal - before[i, j] * slope[j - 1]
            slope[j] = behind[i, j] / pivot
            line[j] = (line[j] - before[i, j] * line[j - 1]) / pivot
            corner[j] = (corner[j] - before[i, j] * corner[j - 1]) / pivot
        for j in range(columns - 2, -1, -1):
            line[j] -= slope[j] * line[j + 1]
            corner[j] -= slope[j] * corner[j + 1]
        ratio = before[i, 0] / shift
        weight = (line[0] + ratio * line[last]) / (1 + corner[0] + ratio * corner[last])
        for j in range(columns):
            solution[i, j] = line[j] - weight * corner[j]
    return solution
