"""Times by which settings are compared: rounds in random order, and the sign test of the paired times."""

from collections.abc import Callable, Iterable, Sequence
from random import Random
from time import process_time
from typing import TypeVar

import numpy as np
from scipy.stats import binomtest

# With these rounds the sign test distinguishes times that differ by a tenth in nearly all cases.
ROUNDS = 15

T = TypeVar("T")


def timed_call(run: Callable[[], T]) -> tuple[float, T]:
    """Return the processor time [s] of a call, and its result."""
    start = process_time()
    result = run()
    return process_time() - start, result


def times_in_rounds(
    runs: Sequence[Callable[[], object]], count: int, has_time: Callable[[], bool]
) -> list[list[float]]:
    """Return the processor times [s] of several calls, a list for each complete round, for at most `count` rounds.

    Every round makes all calls in a new random order, so that a load on the machine slows none of them alone. No round
    begins where `has_time` is not true.
    """
    order, shuffle = list(range(len(runs))), Random(1).shuffle
    rounds: list[list[float]] = []
    while len(rounds) < count and has_time():
        shuffle(order)
        times = [0.0] * len(runs)
        for index in order:
            times[index] = timed_call(runs[index])[0]
        rounds.append(times)
    return rounds


def median_ratio_and_p(first: Iterable[float], second: Iterable[float]) -> tuple[float, float]:
    """Return the median ratio of paired times, and the p-value of the two-sided sign test.

    Pairs with nan are left out; without any, the ratio is nan and the p-value 1.
    """
    pairs = [
        (a, b) for a, b in zip(first, second, strict=True) if np.isfinite(a) and np.isfinite(b)
    ]
    if not pairs:
        return float("nan"), 1.0
    quicker = sum(a < b for a, b in pairs)
    unequal = sum(a != b for a, b in pairs)
    p_value = binomtest(quicker, unequal).pvalue if unequal else 1.0
    return float(np.median([a / b for a, b in pairs])), float(p_value)
