"""Pressures that are never tensile, by hand."""

from math import inf, isnan

import numpy as np
import pytest

from contactstudy.problem.constraint import Compressive, Gap, project_capped_simplex

WHICH = Compressive()


def row(*values: float) -> np.ndarray:
    return np.array([values])


def test_cells_with_any_pressure_are_free_and_any_tension_is_cut_off() -> None:
    assert WHICH.free(row(0.5, 0.0, 3.0)).tolist() == [[1, 0, 1]]
    assert not WHICH.exceeded_by(row(0.0, 0.5))
    assert WHICH.exceeded_by(row(2.0, -1e-9))
    assert WHICH.clip(row(0.5, -2.0, 3.0)).tolist() == [[0.5, 0, 3]]
    assert WHICH.capacity(3) == inf
    assert isnan(WHICH.approach(row(0.0), row(1.0)))
    assert WHICH.in_unit(row(0.5, 3.0), 4.0).tolist() == [[2, 12]]
    assert WHICH.scaled(2.0) == WHICH


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
    assert WHICH.shift_to_load(trial, cells, total) == pytest.approx(row(*shifted), abs=1e-14)


def test_what_is_cut_off_on_the_way_down_bears_no_more() -> None:
    """Four cells down by 0.625, which leaves 5.125 in three, and these by a third of 0.125."""
    found = WHICH.shift_to_load(row(3.0, 1.5, 2.5, 0.5), np.ones((1, 4)), 5.0)
    assert found == pytest.approx(row(3 - 2 / 3, 1.5 - 2 / 3, 2.5 - 2 / 3, 0))


def test_a_load_is_not_drowned_by_numbers_far_above_it() -> None:
    found = WHICH.shift_to_load(row(1e20, 1.0, 2.0, -5.0), row(1.0, 1, 0, 1), 3.0)
    # what is not chosen bears nothing
    assert found.tolist() == [[3, 0, 0, 0]]


def test_cells_without_pressure_that_penetrate_are_released() -> None:
    pressure, height = row(0.0, 0.0, 2.0, 0.0), row(-0.5, 0.5, -0.5, 0.0)
    assert WHICH.to_release(pressure, height).tolist() == [[1, 0, 0, 0]]


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
