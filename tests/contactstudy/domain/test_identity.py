import math
from dataclasses import dataclass, field, make_dataclass, replace
from pathlib import Path, PurePosixPath

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import contactstudy as cs
from contactstudy import InvalidInput
from contactstudy.domain.identity import CanonicalMemo, canonical, differences, key
from studies.reference.line_contact import case_at

CASE = case_at({"padding": "superposed", "images": 2, "period": 0.3, "grid": 16})


def name(value: object) -> str:
    return key(canonical(value))


@given(st.floats(allow_nan=False), st.floats(allow_nan=False))
def test_numbers_are_one_to_the_last_bit_or_two(one: float, other: float) -> None:
    is_one = np.float64(one).tobytes() == np.float64(other).tobytes()
    assert (name(one) == name(other)) is is_one
    assert name(one) != name(float(np.nextafter(one, 0.5 if one != 0.5 else 1.0)))


def test_values_of_different_types_have_different_trees() -> None:
    values = [
        1, 1.0, True, "1", "1.0", np.float32(1), np.float64(1), np.int64(1), 1 + 0j, b"1", None, "None",
        0.0, -0.0, (1, 2), [1, 2], {1, 2}, frozenset({1, 2}), {1: 2}, {"1": 2}, (), [], "", math.nan, "nan",
        Path("u"), PurePosixPath("u"), "u", cs.Status.STALLED, "Status.STALLED", 1e-300, 2e-300, 0.3, 3 * 0.1,
        1.0000000000001, 1.0000000000002, 1700000000.1234, 1700000000.1239, np.array([1.0]), np.array([1]),
    ]  # fmt: skip
    assert len({name(value) for value in values}) == len(values)


def test_two_classes_of_one_name_are_refused() -> None:
    def made(number: int) -> type:
        @dataclass(frozen=True)
        class Model:
            factor: float = 1.0

            def value(self) -> int:
                return number

        return Model

    memory = CanonicalMemo()
    canonical(made(1)(), memory)
    with pytest.raises(InvalidInput, match="give each a name of its own"):
        canonical(made(2)(), memory)


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
    grown.__module__ = Thing.__module__
    assert name(grown(1.0)) == name(Thing(1.0))
    assert differences(canonical(Thing(1.0)), canonical(grown(1.0))) == []
    assert name(grown(1.0, "blue")) != name(Thing(1.0))


def test_a_default_that_changed_is_noticed() -> None:
    red, blue = (
        make_dataclass("Thing", [("colour", str, field(default=colour))], frozen=True)()
        for colour in ("red", "blue")
    )
    assert name(red) == name(blue)
    assert differences(canonical(red), canonical(blue)) == ["case.colour was 'red' and is 'blue'"]


def test_arrays_are_told_apart_by_their_content() -> None:
    heights = np.arange(4.0)
    assert name(heights) == name(heights.copy())
    assert name(heights) != name(heights[::-1])
    square = heights.reshape(2, 2)
    assert name(heights) != name(square)
    assert name(square) != name(np.asfortranarray(square))  # a sum may differ in its last bit


def test_masked_arrays_are_told_apart_by_mask_fill_value_and_hardness() -> None:
    masked = np.ma.masked_array([1.0, 2.0], mask=[False, True])
    others = [np.ma.masked_array([1.0, 2.0], mask=[True, False])]
    others += [masked.data, np.ma.masked_array(masked, fill_value=7.0)]
    others += [np.ma.masked_array(masked, hard_mask=True)]  # assignment leaves its masked values
    assert name(masked) == name(masked.copy())
    assert len({name(masked), *map(name, others)}) == 5


class Celsius(np.float64):
    """A number of numpy that may keep its unit."""


def with_a_unit(values: np.ndarray) -> np.ndarray:
    values.unit = "mm"  # type: ignore[attr-defined]
    return values


@pytest.mark.parametrize(
    "value",
    [
        object(), Celsius(1.0), with_a_unit(np.ma.masked_array([1.0])),
        with_a_unit(np.rec.array([(1.0,)], [("a", "f8")])),
    ],
    ids=lambda value: type(value).__name__,
)  # fmt: skip
def test_objects_identified_by_their_address_or_with_hidden_state_are_refused(
    value: object,
) -> None:
    with pytest.raises(InvalidInput, match="make its class a frozen dataclass"):
        canonical(value)
