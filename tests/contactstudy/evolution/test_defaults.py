"""What a march or rolling takes for the numbers that a user leaves out."""

from collections.abc import Callable
from inspect import signature
from typing import Any

import pytest

import contactstudy as cs


@pytest.mark.parametrize(
    ("made", "field", "value"),
    [
        (cs.roll_repeatedly, "steady", 5e-3),
        (cs.solve_rolling, "change", 1e-6),
        (cs.solve_rolling, "max_passes", 100),
    ],
)
def test_a_number_that_is_left_out_is_this_one(
    made: Callable[..., Any], field: str, value: float
) -> None:
    assert signature(made).parameters[field].default == value
