"""Pressures of a softer body that yields at 4 Pa, by hand."""

import numpy as np
import pytest

from contactstudy.problem.constraint import HardnessLimited

WHICH = HardnessLimited(4.0)


def row(*values: float) -> np.ndarray:
    return np.array([values])


@pytest.mark.parametrize(
    ("heights", "residual"),
    [
        # the mean gap under the pressure of free cells: (2 * 0.3 + 0.5 * 0.8) / 2.5
        ((0.2, 0.3, -0.8, -0.1), 0.4), ((0.6, 0.3, -0.8, -0.1), 0.6), ((-0.6, 0.3, -0.8, -0.7), 0.7),
    ],
)  # fmt: skip
def test_the_residual_is_the_largest_of_three(heights: tuple[float, ...], residual: float) -> None:
    assert WHICH.violation(row(4.0, 2.0, 0.5, 0.0), row(*heights), 6.5) == pytest.approx(residual)
    little = WHICH.violation(row(4.0, 0.5), row(-0.1, 0.25), 4.5)
    assert little == pytest.approx(0.25)
    # where none is free there is no complementarity
    assert WHICH.violation(row(4.0, 0.0), row(-0.5, 0.25), 4.0) == 0
