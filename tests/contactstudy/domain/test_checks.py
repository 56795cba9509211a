import re
from dataclasses import replace
from inspect import signature
from typing import Any

import pytest

import contactstudy as cs


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
