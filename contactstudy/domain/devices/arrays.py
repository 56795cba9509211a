"""The array type of the solver, in either precision, and its products."""

from math import prod

import numpy as np

from contactstudy.domain.devices.device import arrays
from contactstudy.domain.devices.namespace import Array
from contactstudy.domain.devices.rows import in_blocks

__all__ = ["Array", "inner", "mean_over", "product", "total"]


# Up to this many cells BLAS starts no threads, and single precision needs no sums by rows.
SMALL = 1024


def inner(a: Array, b: Array) -> float:
    """Sum of ``a b`` over fields (x, y).

    Row by row: BLAS would start threads for a whole large field, and on a busy machine they
    cost a hundred times what they save.
    """
    return sum(in_blocks(lambda rows: _inner(a[rows, :], b[rows, :]), a.shape))


def _inner(a: Array, b: Array) -> float:
    xp = arrays()
    if prod(a.shape) <= SMALL:
        return float(xp.vecdot(xp.reshape(a, (-1,)), xp.reshape(b, (-1,))))
    return float(xp.sum(xp.vecdot(a, b)))


def total(field: Array) -> float:
    """Sum over a field (x, y)."""
    return sum(in_blocks(lambda rows: float(arrays().sum(field[rows, :])), field.shape))


def mean_over(cells: Array, field: Array) -> float:
    """Mean of ``field`` over the cells where ``cells`` is 1; it is 0 elsewhere."""
    return inner(field, cells) / total(cells)


def product(a: Array, b: Array) -> Array:
    """The matrix product of numpy arrays, row by row for the same reason."""
    return np.asarray(np.matmul(a[:, None], b)[:, 0])
