"""The shares of a step in what wears, by hand."""

import numpy as np
import pytest

from contactstudy.evolution.state_variables import Step, WearState, explicit_limit

# 3 m/(Pa s) for 2 s: 6 m for each pascal.
WEAR = WearState(3.0)


@pytest.mark.parametrize(
    ("explicit", "loads", "mean", "shares"),
    [
        # a load that is held: as the scheme says
        (0.4, (1.0, 1.0), 1.0, (2.4, 3.6)),
        # 0.68 would be carried, and both are scaled to 0.6
        (0.4, (0.2, 1.0), 0.6, (2.4 * 0.6 / 0.68, 3.6 * 0.6 / 0.68)),
        # 0.52 would be carried: 0.08 more explicitly, and 0.6 - 0.48 by what follows
        (0.4, (1.0, 0.2), 0.6, (6 * 0.48, 6 * 0.12 / 0.2)),
        (0.4, (2.0, 0.4), 1.2, (6 * 0.48, 6 * 0.24 / 0.4)),
        # no more than half of the rest explicitly
        (0.0, (1.0, 0.2), 0.9, (6 * 0.5, 6 * 0.4 / 0.2)),
        (0.2, (1.0, 0.2), 0.9, (6 * 0.6, 6 * 0.3 / 0.2)),
        # none comes after, or none was before
        (0.0, (2.0, 0.0), 0.5, (6 * 0.25, 0.0)),
        (0.0, (0.0, 0.0), 0.5, (0.0, 0.0)),
        (0.0, (0.0, 0.0), 0.0, (0.0, 0.0)),
        (0.4, (0.0, 2.0), 1.8, (2.4, 6 * 0.9)),
    ],
)
def test_a_step_wears_by_the_mean_load(
    explicit: float, loads: tuple[float, float], mean: float, shares: tuple[float, float]
) -> None:
    step = Step(1.0, 3.0, loads, mean, explicit)
    assert WEAR._fractions(step) == pytest.approx(shares)
    first, last = shares
    worn, before, after = np.array([[0.5]]), np.array([[4.0]]), np.array([[7.0]])
    found = WEAR.contribution({"worn_depth": worn}, before, step)
    assert found.gap == pytest.approx(0.5 + 4 * first)
    assert found.local_compliance == pytest.approx(last)
    now = WEAR.update({"worn_depth": worn}, before, after, step)
    assert now["worn_depth"] == pytest.approx(0.5 + 4 * first + 7 * last)


def test_nothing_is_worn_to_begin_with() -> None:
    np.testing.assert_array_equal(WEAR.start((2, 3))["worn_depth"], np.zeros((2, 3)))


def test_an_explicit_step_is_shorter_than_twice_the_softest_wave_allows() -> None:
    """``2 * 0.742 dx / (rate E*)``."""
    assert explicit_limit(4.0, 5.0, 0.3) == pytest.approx(2 * 0.742 * 0.3 / 20)
