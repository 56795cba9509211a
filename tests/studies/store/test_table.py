from typing import Any

import numpy as np
import xarray as xr

from studies.model.axis import Axis
from studies.model.outcome import CaseStatus, Outcome
from studies.store.table import assemble

SIDE = Axis("side", ("left", "mid", "right"), "which side")
SIZE = Axis("size", (1.0, 2.0), "how large", "m")


def variable(value: Any, *dims: str, **attrs: Any) -> xr.Variable:
    return xr.Variable(dims, value, attrs)


def assembled(axes: tuple[Axis, ...], keys: str, **found: dict[str, xr.Variable]) -> xr.Dataset:
    outcomes = {name: Outcome(CaseStatus.OK, variables) for name, variables in found.items()}
    return assemble(axes, keys.split(), outcomes.get, lambda _: (), {"title": "by hand"})


def test_of_variables_that_differ_those_of_the_most_cases_are_kept() -> None:
    """Whatever their order; of another unit, type or dimension."""
    few = {"n": variable(5.0, units="s"), "t": variable("x")}
    most = {"n": variable(1.5, units="m"), "t": variable(7.0)}
    for keys, expected in (("a b c", [np.nan, 1.5, 1.5]), ("b c a", [1.5, 1.5, np.nan])):
        dataset = assembled((SIDE,), keys, a=few, b=most, c=most)
        np.testing.assert_array_equal(dataset["n"], expected)
        assert dataset["n"].attrs["units"] == "m"
        np.testing.assert_array_equal(dataset["t"], np.divide(expected, 1.5) * 7)
        assert dataset.attrs["left_out"] == (
            "n of 1 of 3 cases, which differs from the others' in dimensions, type or units; "
            "t of 1 of 3 cases, which differs from the others' in dimensions, type or units"
        )


def test_text_that_a_case_lacks_is_empty_and_a_number_is_not_a_number() -> None:
    dataset = assembled(
        (SIDE,),
        "a b c",
        a={"word": variable("long"), "words": variable(["p", "q"], "k")},
        c={"word": variable("l"), "whole": variable(3), "single": variable(np.float32(0.5))},
    )
    assert dataset["word"].values.tolist() == ["long", "", "l"]
    assert dataset["words"].values.tolist() == [["p", "q"], ["", ""], ["", ""]]
    np.testing.assert_array_equal(dataset["whole"], [np.nan, np.nan, 3.0])
    assert dataset["single"].dtype == np.float32
    ok, not_run = CaseStatus.OK, CaseStatus.NOT_RUN
    assert dataset["case_status"].values.tolist() == [ok, not_run, ok]


def test_a_variable_named_like_its_dimension_is_its_coordinate() -> None:
    depth = variable([0.5, 1.5], "depth", units="m")
    one = {"depth": depth, "stress": variable([1.0, 2.0], "depth")}
    two = {"depth": depth, "stress": variable([3.0, 4.0], "depth")}
    dataset = assembled((SIZE,), "a b", a=one, b=two)
    assert dataset["depth"].dims == ("depth",)
    assert dataset["stress"].sel(size=2.0, depth=1.5).item() == 4.0
    assert "left_out" not in dataset.attrs


def test_dimensions_that_contradict_another_variable_s_are_left_out() -> None:
    """Another length of one dimension; a dimension called like a variable that is no coordinate."""
    first = variable([1.0, 2.0], "k")
    for second, dim in ((variable([1.0, 2.0, 3.0], "k"), "k"), (variable([1.0, 2.0], "first"), "first")):
        dataset = assembled((SIZE,), "a a", a={"first": first, "second": second})
        assert dataset["first"].shape == (2, 2)
        assert dataset.attrs["left_out"] == f"second, since another variable has another {dim}"
