"""The settings that no other beats on both counts."""

import numpy as np

from contactstudy.domain.fields import Array


def pareto_front(cost: Array, error: Array) -> np.ndarray[tuple[int], np.dtype[np.intp]]:
    """Indices of the points with no other both cheaper and more accurate, by growing cost.

    ``cost`` and ``error`` are flat and of one length; points with nan are left out.
    """
    order = np.lexsort((error, cost))
    order = order[np.isfinite(cost[order]) & np.isfinite(error[order])]
    best = np.minimum.accumulate(error[order])
    is_better = np.concatenate(([True], best[1:] < best[:-1]))[: len(order)]
    return order[is_better]
