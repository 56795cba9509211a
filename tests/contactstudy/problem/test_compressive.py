"""Pressures that are never tensile, by hand."""

import numpy as np
import pytest

from contactstudy.problem.constraint import Compressive, Gap

WHICH = Compressive()


def row(*values: float) -> np.ndarray:
    return np.array([values])


@pytest.mark.parametrize(
    ("heights", "residual"),
    [
        # the mean gap under the pressure, (2 * 0.3 + 0.5 * 0.8) / 2.5
        ((0.3, -0.8, -0.25, 0.9), 0.4),
        # the deepest penetration where there is none
        ((0.3, -0.8, -0.75, 0.9), 0.75),
    ],
)
def test_the_residual_is_of_complementarity_or_penetration(
    heights: tuple[float, ...], residual: float
) -> None:
    gap = Gap(row(*heights), 0.0)
    assert WHICH.residual(row(2.0, 0.5, 0.0, 0.0), gap, 2.5) == pytest.approx(residual)
