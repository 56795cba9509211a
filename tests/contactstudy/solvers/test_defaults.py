"""What a solver takes for the numbers that a user leaves out."""

from collections.abc import Callable
from inspect import signature
from typing import Any

import pytest

import contactstudy as cs


@pytest.mark.parametrize(
    ("made", "field", "value"),
    [
        (cs.SolveOptions, "tolerance", 1e-8),
        (cs.SolveOptions, "max_iterations", 2000),
        (cs.PolonskyKeer, "patience", 400),
        (cs.PreconditionedCG, "patience", 40),
        (cs.PreconditionedCG, "coarse_tolerance", 1e-3),
    ],
)
def test_a_number_that_is_left_out_is_this_one(
    made: Callable[..., Any], field: str, value: float
) -> None:
    assert signature(made).parameters[field].default == value
