import re
from collections.abc import Callable
from dataclasses import replace
from inspect import signature
from math import inf, nan
from typing import Any

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.domain.checks import (
    InvalidInput,
    in_range,
    in_range_from_zero,
    in_range_or_zero,
    non_negative,
    pair,
    positive,
    sequence,
    suggestion,
    whole_number,
    whole_quotient,
)

NUMBERS: list[tuple[Callable[[str, object, str], float], list[float], list[object]]] = [
    (positive, [5e-324, 0.5, 1e61], [0.0, -0.5, inf, nan, True, "1", 10**400]),
    (non_negative, [0.0, 0.5, 1e-61], [-5e-324, inf]),
    (in_range, [1e-60, 0.5, 1e60], [0.0, -1.0, 0.9e-60, 1.1e60]),
    (in_range_or_zero, [0.0, 1e-60, -1e-60, 0.5, 1e60, -1e60], [0.9e-60, -0.9e-60, 1.1e60, -1.1e60]),
    (in_range_from_zero, [0.0, 1e-60, 1e60], [-1e-60, 0.9e-60, 1.1e60]),
]  # fmt: skip


@pytest.mark.parametrize(
    ("check", "good", "bad"), NUMBERS, ids=[check.__name__ for check, *_ in NUMBERS]
)
def test_a_number_is_admitted_up_to_its_limits(
    check: Callable[[str, object, str], float], good: list[float], bad: list[object]
) -> None:
    for value in good:
        assert check("Grid.width", value, "give more") == value
    for other in bad:
        with pytest.raises(InvalidInput, match=r"^Grid\.width is .*: give more"):
            check("Grid.width", other, "give more")


def test_a_whole_number_is_not_below_the_least() -> None:
    assert whole_number("n", np.int64(3), 3, "give 3") == 3
    for value in (2, 3.0, True):
        with pytest.raises(InvalidInput, match=f"^n is {value!r}: give 3"):
            whole_number("n", value, 3, "give 3")


def test_a_pair_has_two_and_a_sequence_is_flat() -> None:
    assert pair("p", [5, "b"], "give two") == (5, "b")
    assert sequence("s", np.array([3.0, 1.0, 2.0]), "give some") == (3.0, 1.0, 2.0)
    for value in ((1, 2, 3), (1,), 2):
        with pytest.raises(InvalidInput, match=r"^p is .*: give two"):
            pair("p", value, "give two")
    with pytest.raises(InvalidInput, match=r"^s is "):
        sequence("s", np.zeros((2, 2)), "give some")


def test_a_length_divides_a_period_to_a_billionth_of_it() -> None:
    assert whole_quotient("pitch", 2.0, 6.0) == 3
    assert whole_quotient("pitch", 1.0, 1000 + 0.5e-6) == 1000
    assert whole_quotient("pitch", 1.0, 1000 - 0.5e-6) == 1000
    for period in (1000 + 1.5e-6, 1000 - 1.5e-6, 1 + 1.5e-9, 2.5):
        with pytest.raises(InvalidInput, match=r"^pitch is 1\.0: give a length that divides"):
            whole_quotient("pitch", 1.0, period)


def test_an_unknown_name_is_answered_with_the_most_similar_one_or_all() -> None:
    assert suggestion("radus", ["load", "radius", "radii"]) == "did you mean 'radius'"
    assert suggestion("Zero", ["ExactPeriodicity", "ZeroPadding"]) == "did you mean 'ZeroPadding'"
    assert suggestion("x", ["load", "radius"]) == "choose from load, radius"


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: cs.Cylinder(radious=1), "Cylinder.radious is not known: did you mean 'radius'"),  # type: ignore[call-arg]
        (lambda: cs.Grid(cell=(1, 2)), "Grid.cell is not known: did you mean 'cells'"),  # type: ignore[call-arg]
        (lambda: cs.LineLoad(force=1.0), "LineLoad.force is not known: choose from per_length"),  # type: ignore[call-arg]
    ],
)
def test_a_misspelt_keyword_is_answered_with_the_right_one(make: Any, sentence: str) -> None:
    with pytest.raises(cs.InvalidInput, match=re.escape(sentence)) as refused:
        make()
    assert isinstance(refused.value, TypeError)


def test_a_constructor_that_suggests_fields_keeps_its_signature() -> None:
    assert list(signature(cs.Cylinder).parameters) == ["radius"]
    assert cs.Cylinder(0.1) == cs.Cylinder(radius=0.1) == replace(cs.Cylinder(0.2), radius=0.1)
