"""The one kind of array the solver works on, in either precision, and its products."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.floating[Any]]


# Up to so many cells BLAS has no use for threads, and rounding in single precision none for rows.
SMALL = 1024


def inner(a: Array, b: Array) -> float:
    """Sum of ``a b`` over fields (width, length).

    Row by row, for BLAS would start threads for a large field as a whole: beside a busy neighbour they
    cost a hundred times what they save.
    """
    if a.size <= SMALL:
        return float(np.dot(a.ravel(), b.ravel()))
    return float(np.matmul(a[:, None, :], b[:, :, None]).sum())


def mean_over(cells: Array, field: Array) -> float:
    """Mean of ``field`` over the ``cells`` that are 1, of others that are 0."""
    return float(inner(field, cells) / cells.sum())


def product(a: Array, b: Array) -> Array:
    """The matrix product, row by row for the same reason."""
    return np.asarray(np.matmul(a[:, None], b)[:, 0])
