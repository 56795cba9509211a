"""What all cells carry together, by hand."""

from types import SimpleNamespace
from typing import Any

import pytest

from contactstudy.problem.resultant import PrescribedLoad

LOAD = PrescribedLoad(6.0)


@pytest.mark.parametrize(("capacity", "met"), [(6.5, True), (6.0, True), (5.9, False)])
def test_a_load_is_met_by_cells_that_bear_it_exactly_or_more(capacity: float, met: bool) -> None:  # noqa: FBT001
    constraint: Any = SimpleNamespace(capacity=lambda cells: capacity if cells == 12 else 0.0)
    assert LOAD.is_met_by(constraint, 12) == met


def test_a_load_is_over_the_area_of_a_cell() -> None:
    assert LOAD.uniform(12) == 0.5
    assert LOAD.scaled(2.0) == PrescribedLoad(12.0)
    # on cells four times as large
    assert LOAD.scaled(2.0, 4) == PrescribedLoad(3.0)
    assert LOAD.error(6.6) == pytest.approx(0.1)
    assert LOAD.error(5.4) == pytest.approx(0.1)
