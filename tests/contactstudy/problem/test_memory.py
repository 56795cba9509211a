import pytest

import contactstudy as cs
from contactstudy.problem import memory
from tests.conftest import LineContact

PADDINGS = cs.ZeroPadding(), cs.ExactPeriodicity()

GRID = cs.Grid((64, 16), (1.0, 1.0))

# fourteen fields, and two of the padded grid, which is twice as wide
BYTES = 8 * (14 * 64 * 16 + 2 * 128 * 16)


def left(monkeypatch: pytest.MonkeyPatch, amount: float) -> None:
    monkeypatch.setattr(memory, "FREE_ON_ANY_MACHINE", 0)
    monkeypatch.setattr(memory, "available_bytes", lambda: amount)


def test_a_solve_is_refused_where_one_byte_of_memory_is_missing(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    assert memory.solve_bytes(GRID, PADDINGS) == BYTES
    left(monkeypatch, BYTES)
    memory.refuse_too_large(GRID, PADDINGS)
    left(monkeypatch, BYTES - 1)
    with pytest.raises(cs.InvalidInput, match=r"a solve needs 0\.000147 GB and this machine has"):
        memory.refuse_too_large(GRID, PADDINGS)


@pytest.mark.parametrize("precision", list(cs.Precision))
def test_beside_a_problem_its_gap_and_half_a_padded_field_are_there_already(
    precision: cs.Precision, line_contact: LineContact, monkeypatch: pytest.MonkeyPatch
) -> None:
    problem = line_contact.scene.problem(line_contact.grid((64, 16), 1.0), PADDINGS)
    more = precision.bytes * (13 * 64 * 16 + 1.5 * 128 * 16)
    left(monkeypatch, more)
    memory.refuse_solve(problem, precision)
    left(monkeypatch, more - 1)
    with pytest.raises(cs.InvalidInput, match="GB more and this machine has"):
        memory.refuse_solve(problem, precision)
