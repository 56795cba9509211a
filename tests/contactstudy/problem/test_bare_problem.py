"""The problem that a solver sees, in numbers by hand."""

from dataclasses import dataclass, replace
from typing import cast

import numpy as np
import pytest

from contactstudy.problem.bare_problem import BareProblem
from contactstudy.problem.compressive import Compressive
from contactstudy.problem.operator import Operator
from contactstudy.problem.resultant import PrescribedLoad

HEIGHTS = np.array([[0.0, 1.0, 2.0, 5.0], [3.0, 4.0, 1.0, 2.0]])


@dataclass(frozen=True)
class Blocks:
    """Stands for an operator on blocks of cells."""

    blocks: tuple[int, int]

    def coarsened(self) -> "Blocks":
        return Blocks((1, 1))


PROBLEM = BareProblem(HEIGHTS, cast(Operator, Blocks((2, 2))), Compressive(), PrescribedLoad(16.0))


def test_the_load_is_spread_over_all_cells() -> None:
    np.testing.assert_array_equal(PROBLEM.uniform(), np.full((2, 4), 2.0))


def test_the_gap_counts_from_the_mean_of_the_cells_that_bear() -> None:
    pressure = np.array([[1.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]])
    found = PROBLEM.gap(pressure, np.full((2, 4), 0.5))
    assert found.approach == pytest.approx((0 + 1 + 1) / 3 + 0.5)
    level = 2 / 3
    assert found.height == pytest.approx(HEIGHTS - level)


@pytest.mark.parametrize("displacement", [(-3.0, 1.0), (-1.0, 3.0), (2.0, 3.0)])
def test_rounding_is_that_of_the_displacement_farthest_from_zero(
    displacement: tuple[float, float],
) -> None:
    field = np.tile(displacement, (2, 2))
    assert PROBLEM.rounding(field) == 2 * 2.0**-52 * 3
    assert PROBLEM.rounding(field.astype(np.float32)) == 2 * 2.0**-23 * 3


def test_an_iteration_ends_at_the_tolerance_or_at_rounding_or_where_it_has_no_number() -> None:
    field = np.full((2, 4), 1e6)
    rounding = 2 * 2.0**-52 * 1e6
    assert not PROBLEM.ends(1e-7, field, 1e-8)
    assert PROBLEM.ends(1e-8, field, 1e-8)
    assert PROBLEM.ends(rounding, field, 1e-14)
    assert not PROBLEM.ends(2 * rounding, field, 1e-14)
    assert PROBLEM.ends(np.inf, field, 1e-8)
    assert PROBLEM.ends(np.nan, field, 1e-8)


def test_blocks_of_cells_have_the_mean_height_and_bear_the_same_load() -> None:
    coarse = PROBLEM.coarsened()
    assert coarse is not None
    np.testing.assert_array_equal(coarse.undeformed_gap, [[2.0, 2.5]])
    assert coarse.resultant == PrescribedLoad(4.0)
    assert coarse.coarsened() is None
    along = replace(PROBLEM, operator=cast(Operator, Blocks((1, 2)))).coarsened()
    assert along is not None
    np.testing.assert_array_equal(along.undeformed_gap, [[0.5, 3.5], [3.5, 1.5]])
    assert along.resultant == PrescribedLoad(8.0)
