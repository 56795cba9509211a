"""What a gap violates, by hand."""

from math import isnan, nan

import numpy as np

from contactstudy.problem.constraint import largest, violation


def test_a_limit_is_violated_by_penetration_without_pressure_and_by_a_gap_at_the_upper_one() -> (
    None
):
    # three cells without pressure, a free one, three at the upper limit
    pressure = np.array([[0.0, 0.0, 0.0, 1.0, 2.0, 2.0, 2.0]])
    free = np.array([[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]])
    height = np.array([[-0.3, 0.4, 0.0, 0.9, 0.25, -0.6, 0.0]])
    found = violation(pressure, height, free)
    assert found.tolist() == [[0.3, 0, 0, 0, 0.25, 0, 0]]
    # of a free cell neither counts
    assert violation(pressure, -height, free)[0, 3] == 0


def test_the_largest_measure_counts_and_one_that_is_none() -> None:
    assert largest(0.2, 0.7, 0.5) == 0.7
    assert isnan(largest(0.2, nan))
    assert isnan(largest(nan, 0.2))
