"""Pressures of a softer body that yields at 4 Pa, by hand."""

import numpy as np
import pytest

from contactstudy.problem.constraint import Gap, HardnessLimited

WHICH = HardnessLimited(4.0)


def row(*values: float) -> np.ndarray:
    return np.array([values])


def test_in_another_unit_what_yields_is_at_the_hardness_there() -> None:
    """A 49th of 4 Pa, which is no number: 49 times that is a little less."""
    there = WHICH.scaled(1 / 49).hardness
    assert there * 49 < 4
    assert WHICH.in_unit(row(there, 0.0625, 2.0), 49.0).tolist() == [[4, 3.0625, 4]]


@pytest.mark.parametrize(
    ("trial", "total", "carried"),
    [
        # one factor for all, 2, at which two yield
        ((1.0, 2.0, -1.0, 5.0), 10.0, (2.0, 4.0, 0.0, 4.0)),
        ((0.1, 0.2, -0.1, 0.5), 10.0, (2.0, 4.0, 0.0, 4.0)),
        ((1.0, 2.0, -1.0, 5.0), 4.0, (0.5, 1.0, 0.0, 2.5)),
        # as it is, where it carries the load and some yield
        ((4.0, 1.0, 2.0, 0.0), 7.0, (4.0, 1.0, 2.0, 0.0)),
        # more than the cells that bear can carry: the others share the rest
        ((1.0, 2.0, -1.0, 0.0), 9.0, (4.0, 4.0, 0.5, 0.5)),
        ((1.0, 2.0, -1.0, 0.0), 8.0, (4.0, 4.0, 0.0, 0.0)),
        ((1.0, 2.0, -1.0, 3.0), 15.0, (4.0, 4.0, 3.0, 4.0)),
        # and no more than the hardness
        ((1.0, 2.0, -1.0, 0.0), 100.0, (4.0, 4.0, 4.0, 4.0)),
        ((1.0, 2.0, 3.0, 1.0), 100.0, (4.0, 4.0, 4.0, 4.0)),
    ],
)
def test_a_trial_carries_the_load_by_one_factor_up_to_the_hardness(
    trial: tuple[float, ...], total: float, carried: tuple[float, ...]
) -> None:
    assert WHICH.scale_to_load(row(*trial), total) == pytest.approx(row(*carried))


@pytest.mark.parametrize(
    ("total", "levelled"),
    [
        # the first is cut off at 4, and the two that are chosen bear the rest alike
        (8.0, (4.0, 1.5, 2.5, 0.0)),
        (11.5, (4.0, 3.5, 4.0, 0.0)),
        (4.5, (4.0, 0.0, 0.5, 0.0)),
        # all carry it where these cannot: twice the factor of (4, 1, 2), and what the last one has to
        (10.0, (4.0, 2.5, 3.5, 0.0)),
        (12.0, (4.0, 4.0, 4.0, 0.0)),
        (13.0, (4.0, 4.0, 4.0, 1.0)),
        (3.5, (2.0, 0.5, 1.0, 0.0)),
        (4.0, (16 / 7, 4 / 7, 8 / 7, 0.0)),
    ],
)
def test_the_chosen_cells_are_shifted_where_they_can_make_up_for_the_others(
    total: float, levelled: tuple[float, ...]
) -> None:
    found = WHICH.project_to_load(row(5.0, 1.0, 2.0, -1.0), row(0.0, 1, 1, 0), total)
    assert found == pytest.approx(row(*levelled), abs=1e-12)


@pytest.mark.parametrize(
    ("heights", "residual"),
    [
        # the mean gap under the pressure of free cells: (2 * 0.3 + 0.5 * 0.8) / 2.5
        ((0.2, 0.3, -0.8, -0.1), 0.4),
        ((0.6, 0.3, -0.8, -0.1), 0.6),
        ((-0.6, 0.3, -0.8, -0.7), 0.7),
    ],
)
def test_the_residual_is_the_largest_of_three(heights: tuple[float, ...], residual: float) -> None:
    gap = Gap(row(*heights), 0.0)
    assert WHICH.residual(row(4.0, 2.0, 0.5, 0.0), gap, 6.5) == pytest.approx(residual)
    little = WHICH.residual(row(4.0, 0.5), Gap(row(-0.1, 0.25), 0.0), 4.5)
    assert little == pytest.approx(0.25)
    # where none is free there is no complementarity
    closed = Gap(row(-0.5, 0.25), 0.0)
    assert WHICH.residual(row(4.0, 0.0), closed, 4.0) == 0
