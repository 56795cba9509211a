"""The one kind of array the solver works on, and its inner product."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def inner(a: Array, b: Array) -> float:
    """Sum of ``a b`` over fields (width, length).

    Not through BLAS, which would start threads for it: beside a busy neighbour they cost a hundred
    times what they save.
    """
    return float(np.einsum("ij,ij->", a, b))
