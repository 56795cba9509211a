"""The forecast's arithmetic, by hand."""

from math import e, exp, log

import pytest

from studies.engine.forecast_model import Estimate, ForecastModel, Observation, mode, total
from studies.engine.workers.messages import REQUEST, SETUP


def case(cells: int, padding: str = "Exact", tolerance: str = "1e-8") -> dict[str, object]:
    grid = {"": "Grid", "cells": [str(cells), "1"]}
    return {"": "Case", "grid": grid, "padding": {"": padding}, "tolerance": tolerance}


def test_a_sum_is_as_uncertain_as_its_parts_by_their_shares() -> None:
    found = total([Estimate(1.0, e), Estimate(3.0, e**2)])
    assert found.value == 4
    assert found.factor == pytest.approx(exp((1 * 1 + 3 * 2) / 4), rel=1e-12)
    assert total([]) == Estimate(0.0, 1.0)


def test_a_mode_is_what_is_named_and_not_how_large_it_is() -> None:
    assert mode(case(64)) == mode(case(128, tolerance="1e-4"))
    assert mode(case(64)) != mode(case(64, "Zero"))
    assert mode({"": "A", "x": "0.0"}) != mode({"": "A", "x": "1.5"})
    assert mode({"": "A", "x": "inf"}) != mode({"": "A", "x": "1.5"})
    # a count may be zero
    assert mode({"": "A", "x": "0"}) == mode({"": "A", "x": "7"})


@pytest.mark.parametrize("quantity", ["solve", "bytes"])
def test_equal_cases_are_predicted_as_they_were(quantity: str) -> None:
    known = [Observation(case(64), {quantity: 2.0})] * 20
    [found] = ForecastModel(known).predict(quantity, [case(64)])
    assert found is not None
    assert found.value == pytest.approx(2.0, rel=1e-9)
    assert 1 < found.factor < e


def test_times_grow_as_n_log_n_beside_the_time_of_a_small_transform() -> None:
    """N counts a cell more by a half on each axis."""

    def work(cells: int) -> float:
        n = (cells + 0.5) * 1.5
        return n * log(n) + 5e4

    sizes = [2**k for k in range(6, 17)]
    known = [Observation(case(n), {"solve": 1e-8 * work(n)}) for n in sizes]
    [found] = ForecastModel(known).predict("solve", [case(1000)])
    assert found is not None
    assert found.value == pytest.approx(1e-8 * work(1000), rel=1e-6)


def test_an_unknown_mode_is_predicted_from_the_others_within_a_larger_factor() -> None:
    model = ForecastModel([Observation(case(64), {"solve": 2.0})] * 20)
    [known] = model.predict("solve", [case(64)])
    [unknown] = model.predict("solve", [case(64, "Zero")])
    assert known is not None
    assert unknown is not None
    assert unknown.value == pytest.approx(2.0, rel=1e-9)
    # a standard deviation of one in the logarithm, twice
    assert log(unknown.factor) == pytest.approx((log(known.factor) ** 2 + 4) ** 0.5, rel=1e-6)
    assert model.predict("bytes", [case(64)]) == [None]
    assert model.predict("solve", [{"": "Other", "x": "1.5"}]) == [None]


def test_what_is_no_case_has_a_number_that_no_case_has() -> None:
    assert REQUEST < 0
    assert SETUP < 0
    assert REQUEST != SETUP
