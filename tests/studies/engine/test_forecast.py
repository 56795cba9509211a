import json
from math import e, exp, log
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from contactstudy.domain.identity import canonical
from studies.engine.forecast import (
    Estimate,
    Forecast,
    ForecastModel,
    Observation,
    forecast,
    mode,
    observations,
    score,
    total,
)
from studies.engine.options import RunOptions
from studies.engine.run import estimate_cost, run
from studies.reference.line_contact import scene_at
from studies.registry import load
from studies.store.journal import Journal
from studies.store.provenance import machine
from tests.studies.conftest import quiet
from tests.studies.engine import trouble

STORED = [
    Observation(tree, known)
    for tree, known in json.loads(
        (Path(__file__).parents[2] / "reference" / "case_costs.json").read_text(encoding="utf-8")
    )["cases"]
]


def held_out(seed: int) -> list[tuple[float, float]]:
    """Log error and stated log factor of set-up and solve of every stored case, each predicted from four fifths."""
    order = np.random.default_rng(seed).permutation(len(STORED))
    found = []
    for fold in range(5):
        held = [STORED[place] for place in order[fold::5]]
        model = ForecastModel([one for one in STORED if one not in held])
        trees = [one.tree for one in held]
        for quantity in ("setup", "solve"):
            for one, guess in zip(held, model.predict(quantity, trees), strict=True):
                assert guess is not None
                found.append((log(one.quantities[quantity] / guess.value), log(guess.factor)))
    return found


@pytest.mark.parametrize("seed", range(3))
def test_costs_that_were_held_out_are_predicted_within_a_factor_of_2(seed: int) -> None:
    errors = np.array(held_out(seed))[:, 0]
    assert np.mean(np.abs(errors) < log(2)) >= 0.95
    assert abs(np.mean(errors)) < log(1.1)  # no bias


@pytest.mark.parametrize("seed", range(3))
def test_the_stated_factor_holds_in_nineteen_of_twenty_held_out_cases(seed: int) -> None:
    errors, factors = np.array(held_out(seed)).T
    # 290 predictions: the share has a standard error of 1.3 %
    assert np.mean(np.abs(errors) <= factors) >= 0.95 - 2 * 0.013
    assert np.median(factors) < log(2)  # and it is not simply wide


def test_the_stated_factor_serves_for_grids_larger_than_any_stored() -> None:
    def cells(one: Observation) -> int:
        return int(one.tree["grid"]["cells"][0])

    model = ForecastModel([one for one in STORED if cells(one) <= 64])
    large = [one for one in STORED if cells(one) >= 192]
    ratios = []
    for quantity in ("setup", "solve"):
        guesses = model.predict(quantity, [one.tree for one in large])
        for one, guess in zip(large, guesses, strict=True):
            assert guess is not None
            ratios.append(abs(log(one.quantities[quantity] / guess.value)) / log(guess.factor))
    # the factor is two standard deviations; nine and sixteen times the cells are an extrapolation
    assert np.mean(np.array(ratios) <= 1) >= 0.8
    assert max(ratios) <= 2


def test_small_cases_that_worked_do_not_promise_the_time_of_a_large_one_that_failed() -> None:
    """All that worked has one size: how the time grows with it is not known, and not said to be."""

    def row(size: str, seconds: float) -> Observation:
        return Observation({"": "Thing", "size": size}, {"case": seconds})

    for sizes in (["2.5"] * 4, ["2.5", "2.5", "0.0", "0.0"]):
        model = ForecastModel([row(size, 0.01 * (1 + 0.02 * k)) for k, size in enumerate(sizes)])
        (guess,) = model.predict("case", [{"": "Thing", "size": "60.0"}])
        assert guess is not None
        assert 0.24 / guess.value < guess.factor  # 24 times as long, in proportion to the size


@given(power=st.floats(0.5, 2.5), scale=st.floats(1e-6, 1e-2))
def test_a_power_is_found_and_uncertainty_grows_with_distance(power: float, scale: float) -> None:
    def row(size: float) -> Observation:
        return Observation({"": "Thing", "size": str(size)}, {"case": scale * size**power})

    model = ForecastModel([row(size) for size in (1.5, 2.5, 4.5, 8.5, 16.5, 32.5)])
    near, far = model.predict(
        "case", [{"": "Thing", "size": "11.5"}, {"": "Thing", "size": "1000.5"}]
    )
    assert near is not None
    assert far is not None
    assert near.value == pytest.approx(scale * 11.5**power, rel=0.1)
    assert far.factor > near.factor


def test_a_case_that_counts_no_iterations_takes_one(tmp_path: Path) -> None:
    """Else the time of each would be without end, and with it all that is like nothing stored."""
    run(trouble.study([1.0]), tmp_path, options=RunOptions(workers=0, repeats=1), log=quiet)
    journal = Journal(tmp_path / "trouble.journal.jsonl", None, machine())
    (found,) = observations(journal.contents)
    assert found.quantities["iterations"] == 1
    model = ForecastModel([found])
    guess = model.predict("solve", [found.tree])[0]
    assert guess is not None
    assert guess.value == pytest.approx(found.quantities["solve"])


def test_a_tolerance_costs_by_its_digits() -> None:
    """A linearly converging solver: time in proportion to the digits of its tolerance."""

    def row(tolerance: str, seconds: float) -> Observation:
        return Observation({"": "Case", "tolerance": tolerance}, {"solve": seconds})

    digits = [2, 3, 4, 6, 8]
    model = ForecastModel([row(f"1e-{n:02d}", 0.01 * n) for n in digits])
    looser, unseen = (
        model.predict("solve", [{"": "Case", "tolerance": tolerance}])[0]
        for tolerance in ("1e-05", "1e-12")
    )
    assert looser is not None
    assert unseen is not None
    assert 0.05 / looser.factor < looser.value < 0.05 * looser.factor
    assert 0.12 / unseen.factor < unseen.value < 0.12 * unseen.factor
    assert unseen.factor < 2
    # a tolerance that never varied is not taken for a size that grew ten thousandfold
    one = ForecastModel([row("1e-08", 0.08)] * 8)
    (guess,) = one.predict("solve", [{"": "Case", "tolerance": "0.0001"}])
    assert guess is not None
    assert guess.factor < 4


def test_a_mode_that_is_new_is_estimated_from_the_others_with_a_larger_factor() -> None:
    others = [one for one in STORED if one.tree["padding"][""] != "ExactPeriodicity"]
    new = next(one.tree for one in STORED if one.tree["padding"][""] == "ExactPeriodicity")
    guess = ForecastModel(others).predict("setup", [new])[0]
    known = ForecastModel(STORED).predict("setup", [new])[0]
    assert guess is not None
    assert known is not None
    assert guess.factor > 2 > known.factor


def test_with_nothing_stored_nothing_is_claimed() -> None:
    tree = canonical(scene_at({"padding": "exact", "images": 1, "period": 1.0, "grid": 16}))
    assert ForecastModel([]).predict("case", [tree]) == [None]
    assert "not known" in str(forecast(ForecastModel([]), {"a": tree}, {"a": (tree, 2)}))


def test_a_sum_is_as_uncertain_as_its_parts() -> None:
    found = total([Estimate(1.0, 1.2), Estimate(3.0, 1.2)])
    assert (found.value, found.factor) == pytest.approx((4.0, 1.2))


def test_a_forecast_is_scored_by_what_was_taken() -> None:
    each = {"a": Estimate(1.0, 1.1), "b": Estimate(2.0, 1.1)}
    found = score(Forecast(2, total(each.values()), None, None, each), {"a": 2.0, "b": 2.0})
    assert found["predicted_seconds"] == 3.0
    assert found["taken_seconds"] == 4.0
    assert found["prediction_error_factor_largest"] == pytest.approx(2.0)
    assert found["prediction_error_factor_median"] == pytest.approx(exp(log(2) / 2))


def test_a_dry_run_estimates_the_cost_and_leaves_nothing_and_a_run_keeps_its_score(
    tmp_path: Path,
) -> None:
    study = load("grid").override({"padding": "exact,zero", "grid": "16,24,32"})
    said: list[str] = []
    assert (
        estimate_cost(study, tmp_path / "no", options=RunOptions(), log=said.append).seconds is None
    )
    assert not (tmp_path / "no").exists()
    assert "6 distinct cases, 0 stored, 6 to compute" in said[0]
    run(study, tmp_path, workers=0, repeats=0, log=quiet)
    before = sorted(path.name for path in tmp_path.iterdir())
    grown = study.override({"grid": "16,24,32,48"})
    forecast = estimate_cost(grown, tmp_path, options=RunOptions(workers=0), log=quiet)
    assert forecast.cases == 2
    assert forecast.seconds is not None
    assert forecast.size is not None
    assert sorted(path.name for path in tmp_path.iterdir()) == before
    dataset = run(grown, tmp_path, workers=0, repeats=0, log=quiet)
    assert dataset.attrs["predicted_seconds"] == pytest.approx(forecast.seconds.value)
    assert dataset.attrs["taken_seconds"] > 0


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
    assert {name: one.value for name, one in found.by_case.items()} == {"a": 10, "b": 20}
    text = str(found)
    assert text.startswith("30 s (within a factor ")
    assert "to compute (shared by the workers), 32 s (within" in text
    assert "to time, 3 kB (within" in text


def test_of_very_many_cases_every_third_is_looked_at_and_stands_for_three() -> None:
    trees = {str(n): float(n % 3 == 0) for n in range(3000)}
    found = forecast(COSTS, trees, {name: (one, 2) for name, one in trees.items()})
    assert len(found.by_case) == 1000
    assert found.seconds is not None
    assert found.timing is not None
    assert found.seconds.value == pytest.approx(3 * 1000 * 10)
    assert found.timing.value == pytest.approx(3 * 2 * 1000 * 4)
    # two thousand by every second; two thousand and one by every third, each for three
    assert len(forecast(COSTS, dict(list(trees.items())[:2000]), {}).by_case) == 1000
    odd = forecast(COSTS, dict(list(trees.items())[:2001]), {})
    assert len(odd.by_case) == 667
    assert odd.seconds is not None
    assert odd.seconds.value == pytest.approx(2001 * 10)


def test_where_one_case_is_like_none_before_nothing_is_claimed() -> None:
    found = forecast(COSTS, {"a": 1.0, "b": -1.0}, {"a": (1.0, 1)})
    assert (found.cases, found.seconds, found.timing, found.size) == (2, None, None, None)
    assert set(found.by_case) == {"a"}
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
    assert score(predicted, {"d": 9.0}) == {}
    assert score(predicted, {"a": 0.0}) == {}
    assert score(Forecast(3, None, None, None, each), {"a": 1.0}) == {}


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
