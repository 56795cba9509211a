import tracemalloc
from math import prod

import pytest

import contactstudy as cs
from contactstudy.domain.grid import across_and_along
from contactstudy.elasticity.convolution import padded_cells
from contactstudy.problem import problem as memory
from tests.conftest import LineContact


def test_a_solve_is_refused_where_half_of_what_it_takes_is_left(
    line_contact: LineContact, monkeypatch: pytest.MonkeyPatch
) -> None:
    problem = line_contact.scene.problem(line_contact.grid((128, 64), 1.0), cs.ExactPeriodicity())
    cs.solve(problem)
    tracemalloc.start()
    cs.solve(problem)
    taken = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    monkeypatch.setattr(memory, "FREE_ON_ANY_MACHINE", 0)
    monkeypatch.setattr("contactstudy.domain.device.available_bytes", lambda: 2 * taken)
    cs.solve(problem)
    monkeypatch.setattr("contactstudy.domain.device.available_bytes", lambda: taken / 2)
    with pytest.raises(cs.InvalidInput, match=r"a solve needs 0\.00.* GB and this machine ha"):
        cs.solve(problem)


@pytest.mark.parametrize("padding", [cs.ExactPeriodicity(), cs.ZeroPadding()])
def test_the_memory_named_before_a_solve_is_what_it_takes(padding: cs.Padding, line_contact: LineContact) -> None:
    grid = line_contact.grid((128, 64), 1.0)
    cs.solve(line_contact.scene, grid, padding)
    tracemalloc.start()
    cs.solve(line_contact.scene, grid, padding)
    taken = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert 0.7 < memory.solve_bytes(grid, prod(padded_cells(grid, across_and_along(padding)))) / taken < 1.5
