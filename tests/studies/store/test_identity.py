from dataclasses import dataclass, field, make_dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import contactstudy as cs
from contactstudy import InvalidInput
from studies.model.axis import Axis
from studies.reference.line_contact import scene_at
from studies.store.identity import canonical, differences, key

CASE = scene_at({"padding": "superposed", "images": 2, "period": 0.3, "grid": 16})


def name(value: object) -> str:
    return key(canonical(value))


def test_numbers_that_differ_in_rounding_are_one_case() -> None:
    other = scene_at({"padding": "superposed", "images": 2, "period": 3 * 0.1, "grid": 16})
    assert other != CASE
    assert name(other) == name(CASE)
    assert name(2) == name(2.0) == name(np.float64(2)) == name(np.int64(2))
    assert name(-0.0) == name(0.0)


@given(st.floats(1e-300, 1e300))
def test_rounding_does_not_matter_and_a_millionth_does(value: float) -> None:
    assert (
        name(Axis("a", (value,), "a").values[0])
        == name(Axis("a", (float(np.nextafter(value, 1e301)),), "a").values[0])
        or f"{value:.12g}" != f"{np.nextafter(value, 1e301):.12g}"
    )
    assert name(value) != name(value * (1 + 1e-6))


def test_axis_values_that_differ_in_rounding_are_one() -> None:
    assert Axis("a", (0.1, 0.3), "a").override([0.3, 3 * 0.1, 0.1 + 0.2]).values == (0.3,)


@pytest.mark.parametrize(
    "other",
    [
        replace(CASE, options=cs.SolveOptions(1e-9)),
        replace(CASE, padding=cs.Superposition(images=3)),
        replace(CASE, padding=cs.CircularSuperposition(images=2)),
        replace(CASE, options=cs.SolveOptions(solver=cs.PolonskyKeer())),
        replace(CASE, scene=replace(CASE.scene, load=cs.LineLoad(2e5))),
        replace(CASE, grid=cs.Grid(cells=(16, 17), extent=CASE.grid.extent)),
    ],
)
def test_scene_grid_padding_solver_and_tolerance_each_make_another_case(other: object) -> None:
    assert name(other) != name(CASE)
    assert differences(canonical(CASE), canonical(other))


@dataclass(frozen=True)
class Thing:
    size: float


def test_a_new_field_at_its_default_makes_no_other_case() -> None:
    grown = make_dataclass(
        "Thing", [("size", float), ("colour", str, field(default="red"))], frozen=True
    )
    assert name(grown(1.0)) == name(Thing(1.0))
    assert differences(canonical(Thing(1.0)), canonical(grown(1.0))) == []
    assert name(grown(1.0, "blue")) != name(Thing(1.0))


def test_a_default_that_changed_is_noticed() -> None:
    red, blue = (
        make_dataclass("Thing", [("colour", str, field(default=colour))], frozen=True)()
        for colour in ("red", "blue")
    )
    assert name(red) == name(blue)
    assert differences(canonical(red), canonical(blue)) == ['case.colour was "red" and is "blue"']


def test_arrays_are_told_apart_by_their_content() -> None:
    heights = np.arange(4.0)
    assert name(heights) == name(heights.copy())
    assert name(heights) != name(heights[::-1])
    assert name(heights) != name(heights.reshape(2, 2))


def test_every_kind_of_plain_value_has_a_form() -> None:
    for value in (
        None,
        True,
        "a",
        (1, [2.0]),
        {"b": 1, "a": 2},
        {3, 1},
        Path("a"),
        1j,
        cs.Status.STALLED,
    ):
        assert name(value) == name(value)
    assert name(not 0) != name(1)


def test_what_is_known_by_its_address_is_refused() -> None:
    with pytest.raises(InvalidInput, match="make its class a frozen dataclass"):
        canonical(object())
