"""Pressures that are never tensile, by hand."""

from math import inf

import numpy as np
import pytest

from contactstudy.problem.constraint import Compressive, Gap, project_capped_simplex

WHICH = Compressive()


def row(*values: float) -> np.ndarray:
    return np.array([values])


def test_a_trial_is_scaled_or_shifted_to_the_load() -> None:
    assert WHICH.scale_to_load(row(0.5, -2.0, 1.5), 6.0).tolist() == [[1.5, 0, 4.5]]
    assert WHICH.project(row(3.0, 1.0, -1.0), 3.0).tolist() == [[2.5, 0.5, 0]]


@pytest.mark.parametrize(
    ("total", "shifted"),
    [
        # of the first four, 0 of the second and the last: 5.5 Pa
        (4.0, (2.5, 0.0, 1.5, 0.0, 0.0)),
        (2.0, (1.5, 0.0, 0.5, 0.0, 0.0)),
        (0.5, (0.5, 0.0, 0.0, 0.0, 0.0)),
        (5.5, (3.0, 0.0, 2.0, 0.5, 0.0)),
        (11.0, (6.0, 0.0, 4.0, 1.0, 0.0)),
    ],
)
def test_the_chosen_cells_are_lowered_alike_or_scaled(
    total: float, shifted: tuple[float, ...]
) -> None:
    trial, cells = row(3.0, -1.0, 2.0, 0.5, 7.0), row(1.0, 1, 1, 1, 0)
    assert WHICH.project_to_load(trial, cells, total) == pytest.approx(row(*shifted), abs=1e-14)


def test_a_load_is_not_drowned_by_numbers_far_above_it() -> None:
    found = WHICH.project_to_load(row(1e20, 1.0, 2.0, -5.0), row(1.0, 1, 0, 1), 3.0)
    # what is not chosen bears nothing
    assert found.tolist() == [[3, 0, 0, 0]]


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


@pytest.mark.parametrize(
    ("total", "most", "nearest"),
    [
        (3.0, inf, (2.5, 0.5, 0.0, 0.0)),
        (9.0, inf, (5.0, 3.0, 1.0, 0.0)),
        (13.0, inf, (6.0, 4.0, 2.0, 1.0)),
        (3.0, 2.0, (2.0, 1.0, 0.0, 0.0)),
        (5.0, 2.0, (2.0, 2.0, 1.0, 0.0)),
        (7.5, 2.0, (2.0, 2.0, 2.0, 1.5)),
    ],
)
def test_one_shift_gives_the_sum_between_the_limits(
    total: float, most: float, nearest: tuple[float, ...]
) -> None:
    assert project_capped_simplex(row(3.0, 1.0, -1.0, -2.0), total, most) == pytest.approx(
        row(*nearest)
    )
