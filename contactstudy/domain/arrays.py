"""The array type of the solver, in either precision, and its products."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from contactstudy.domain.rows import in_blocks

Array = NDArray[np.floating[Any]]


# Up to this many cells BLAS starts no threads, and single precision needs no sums by rows.
SMALL = 1024


def inner(a: Array, b: Array) -> float:
    """Sum of ``a b`` over fields (x, y).

    Row by row: BLAS would start threads for a whole large field, and on a busy machine they
    cost a hundred times what they save.
    """
    return sum(in_blocks(lambda rows: _inner(a[rows], b[rows]), a.shape))


def _inner(a: Array, b: Array) -> float:
    if a.size <= SMALL:
        return float(np.dot(a.ravel(), b.ravel()))
    return float(np.matmul(a[:, None, :], b[:, :, None]).sum())


def total(field: Array) -> float:
    """Sum over a field (x, y)."""
    return sum(in_blocks(lambda rows: float(field[rows].sum()), field.shape))


def mean_over(cells: Array, field: Array) -> float:
    """Mean of ``field`` over the cells where ``cells`` is 1; it is 0 elsewhere."""
    return inner(field, cells) / total(cells)


def product(a: Array, b: Array) -> Array:
    """The matrix product, row by row for the same reason."""
    return np.asarray(np.matmul(a[:, None], b)[:, 0])
