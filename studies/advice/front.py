"""The Pareto front of settings: those that no other beats in both cost and error."""

import numpy as np

from contactstudy.domain.fields import Array


def pareto_front(cost: Array, error: Array) -> np.ndarray[tuple[int], np.dtype[np.intp]]:
    """Return the indices of the points that no other beats in both cost and error, by growing cost.

    Parameters
    ----------
    cost, error
        Flat arrays of one length; points with nan are left out.
    """
    order = np.lexsort((error, cost))
    order = order[np.isfinite(cost[order]) & np.isfinite(error[order])]
    best = np.minimum.accumulate(error[order])
    is_better = np.concatenate(([True], best[1:] < best[:-1]))[: len(order)]
    return order[is_better]
