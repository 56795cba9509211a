"""What all cells carry together, by hand."""

from dataclasses import dataclass, replace
from typing import cast

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.problem import memory
from contactstudy.problem.bare_problem import BareProblem
from contactstudy.problem.constraint import Compressive, HardnessLimited, PrescribedLoad
from contactstudy.problem.operator import Operator
from tests.conftest import LineContact

HEIGHTS = np.array([[0.0, 1.0, 2.0, 5.0], [3.0, 4.0, 1.0, 2.0]])


@dataclass(frozen=True)
class Blocks:
    """Stands for an operator on blocks of cells."""

    blocks: tuple[int, int]

    def coarsened(self) -> "Blocks":
        return Blocks((1, 1))


PROBLEM = BareProblem(HEIGHTS, cast(Operator, Blocks((2, 2))), Compressive(), PrescribedLoad(16.0))


def test_the_gap_counts_from_the_mean_of_the_active_set() -> None:
    pressure = np.array([[1.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]])
    found = PROBLEM.gap(pressure, np.full((2, 4), 0.5))
    assert found.approach == pytest.approx((0 + 1 + 1) / 3 + 0.5)
    level = 2 / 3
    assert found.height == pytest.approx(HEIGHTS - level)


def test_an_iteration_ends_at_the_tolerance_or_at_rounding_or_where_it_has_no_number() -> None:
    field = np.full((2, 4), 1e6)
    rounding = 2 * 2.0**-52 * 1e6
    assert not PROBLEM.ends(1e-7, field, 1e-8)
    assert PROBLEM.ends(1e-8, field, 1e-8)
    assert PROBLEM.ends(rounding, field, 1e-14)
    assert not PROBLEM.ends(2 * rounding, field, 1e-14)
    assert PROBLEM.ends(np.inf, field, 1e-8)
    assert PROBLEM.ends(np.nan, field, 1e-8)


def test_where_no_cell_is_free_the_approach_closes_the_widest_gap() -> None:
    hard = replace(PROBLEM, constraint=HardnessLimited(4.0))
    found = hard.gap(np.full((2, 4), 4.0), np.full((2, 4), 0.5))
    assert found.approach == 5.5
    np.testing.assert_array_equal(found.height, HEIGHTS - 5.0)


PADDINGS = cs.ZeroPadding(), cs.ExactPeriodicity()

GRID = cs.Grid((64, 16), (1.0, 1.0))

# fourteen fields, and two of the padded grid, which is twice as wide
BYTES = 8 * (14 * 64 * 16 + 2 * 128 * 16)


def left(monkeypatch: pytest.MonkeyPatch, amount: float) -> None:
    monkeypatch.setattr(memory, "ALWAYS_THERE", 0)
    monkeypatch.setattr(memory, "available_bytes", lambda: amount)


def test_a_solve_is_refused_where_a_byte_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
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
