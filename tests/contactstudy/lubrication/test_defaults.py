"""What a lubricated solve takes for the numbers that a user leaves out."""

from collections.abc import Callable
from inspect import signature
from typing import Any

import pytest

import contactstudy as cs


@pytest.mark.parametrize(
    ("made", "field", "value"),
    [
        (cs.solve_lubricated, "tolerance", 1e-8),
        (cs.solve_lubricated, "max_iterations", 300),
        (cs.evolve_lubricated, "tolerance", 1e-6),
        (cs.film_grid, "error", 1e-2),
        (cs.film_grid, "period", 1e-3),
        (cs.film_grid, "longer", 1),
        (cs.film_grid, "finer", 1),
    ],
)
def test_a_number_that_is_left_out_is_this_one(
    made: Callable[..., Any], field: str, value: float
) -> None:
    assert signature(made).parameters[field].default == value
