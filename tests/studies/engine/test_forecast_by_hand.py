"""Sums, samples and scores of forecasts, of predictions that are written here."""

from math import exp, log
from types import SimpleNamespace
from typing import Any

import pytest

from studies.engine.forecast import Forecast, describe_score, forecast, score
from studies.engine.forecast_model import Estimate


def model(**values: float) -> Any:
    """Each tree is a number, and each quantity so many times that, within a factor of 2; none below zero."""

    def predict(quantity: str, trees: list[float]) -> list[Estimate | None]:
        return [Estimate(values[quantity] * one, 2.0) if one >= 0 else None for one in trees]

    return SimpleNamespace(predict=predict)


COSTS = model(case=10.0, setup=1.0, solve=3.0, bytes=1000.0)


def test_seconds_and_bytes_of_all_cases_add_up_and_repeats_count_in_the_timing() -> None:
    found = forecast(COSTS, {"a": 1.0, "b": 2.0}, {"a": (1.0, 3), "c": (5.0, 1)})
    assert found.cases == 2
    assert found.seconds is not None
    assert found.timing is not None
    assert found.size is not None
    assert found.seconds.value == pytest.approx(30)
    assert found.timing.value == pytest.approx((1 + 3) * (3 * 1 + 5))
    assert found.size.value == pytest.approx(3000)
    assert {name: one.value for name, one in found.each.items()} == {"a": 10, "b": 20}
    text = str(found)
    assert text.startswith("30 s (within a factor ")
    assert "to compute (shared by the workers), 32 s (within" in text
    assert "to time, 3 kB (within" in text


def test_of_very_many_cases_every_third_is_looked_at_and_stands_for_three() -> None:
    trees = {str(n): float(n % 3 == 0) for n in range(3000)}
    found = forecast(COSTS, trees, {name: (one, 2) for name, one in trees.items()})
    assert len(found.each) == 1000
    assert found.seconds is not None
    assert found.timing is not None
    assert found.seconds.value == pytest.approx(3 * 1000 * 10)
    assert found.timing.value == pytest.approx(3 * 2 * 1000 * 4)
    # two thousand by every second; two thousand and one by every third, each for three
    assert len(forecast(COSTS, dict(list(trees.items())[:2000]), {}).each) == 1000
    odd = forecast(COSTS, dict(list(trees.items())[:2001]), {})
    assert len(odd.each) == 667
    assert odd.seconds is not None
    assert odd.seconds.value == pytest.approx(2001 * 10)


def test_where_one_case_is_like_none_before_nothing_is_claimed() -> None:
    found = forecast(COSTS, {"a": 1.0, "b": -1.0}, {"a": (1.0, 1)})
    assert (found.cases, found.seconds, found.timing, found.size) == (2, None, None, None)
    assert set(found.each) == {"a"}
    assert "not known" in str(found)
    nothing = forecast(COSTS, {}, {})
    assert nothing.cases == 0


def test_a_score_is_the_factor_by_which_cases_were_off_either_way() -> None:
    each = {name: Estimate(value, 1.5) for name, value in (("a", 1.0), ("b", 4.0), ("c", 10.0))}
    predicted = Forecast(3, Estimate(15.0, 3.0), None, None, each)
    found = score(predicted, {"a": 2.0, "b": 1.0, "c": 30.0, "d": 9.0, "e": 0.0})
    assert found == pytest.approx(
        {
            "predicted_seconds": 15.0,
            "predicted_within_factor": 3.0,
            "taken_seconds": 33.0,
            # twice, a quarter, thrice
            "prediction_error_factor_median": exp(log(3)),
            "prediction_error_factor_largest": 4.0,
        }
    )
    assert describe_score(found) == (
        "predicted 15 s of CPU time, taken 33 s; half of the cases within a factor 3"
    )
    assert score(predicted, {"d": 9.0}) == {}
    assert score(predicted, {"a": 0.0}) == {}
    assert score(Forecast(3, None, None, None, each), {"a": 1.0}) == {}
