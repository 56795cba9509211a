"""Times in turns, and what they decide."""

from math import nan

import pytest

from studies.advice.rounds import in_rounds, ratio, sign_test


def test_the_sign_test_counts_the_tosses_of_a_fair_coin() -> None:
    # all of eight alike: two of 256 outcomes; seven of eight: 2 (1 + 8) of them
    assert sign_test(8, 0) == 2 / 256
    assert sign_test(1, 7) == 18 / 256
    assert sign_test(4, 4) == 1
    assert sign_test(0, 0) == 1


def test_paired_times_are_compared_within_their_round() -> None:
    # a slow third round slows both: the ratio stays 2
    found, chance = ratio([2.0, 4.0, 200.0, nan], [1.0, 2.0, 100.0, 1.0])
    assert found == pytest.approx(2)
    assert chance == 0.25


def test_every_round_takes_each_call_once_and_not_always_in_one_order() -> None:
    taken: list[int] = []
    calls = [lambda k=k: taken.append(k) for k in range(5)]
    rounds = in_rounds(calls, 4, lambda: True)
    orders = [tuple(taken[5 * k : 5 * k + 5]) for k in range(4)]
    assert [len(times) for times in rounds] == [5, 5, 5, 5]
    assert all(sorted(order) == [0, 1, 2, 3, 4] for order in orders)
    assert len(set(orders)) > 1


def test_no_round_begins_without_time_for_it() -> None:
    left = iter([True, True, False])
    assert len(in_rounds([lambda: None], 10, lambda: next(left))) == 2
