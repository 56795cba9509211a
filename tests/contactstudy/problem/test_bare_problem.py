"""What all cells carry together, by hand."""

from dataclasses import dataclass, replace
from typing import cast

import numpy as np
import pytest

from contactstudy.problem.bare_problem import BareProblem
from contactstudy.problem.constraint import Compressive, HardnessLimited, PrescribedLoad
from contactstudy.problem.operator import Operator

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


def test_blocks_of_cells_have_the_mean_height_and_the_same_load() -> None:
    coarse = PROBLEM.coarsened()
    assert coarse is not None
    np.testing.assert_array_equal(coarse.undeformed_gap, [[2.0, 2.5]])
    assert coarse.resultant == PrescribedLoad(4.0)
    assert coarse.coarsened() is None
    along = replace(PROBLEM, operator=cast(Operator, Blocks((1, 2)))).coarsened()
    assert along is not None
    np.testing.assert_array_equal(along.undeformed_gap, [[0.5, 3.5], [3.5, 1.5]])
    assert along.resultant == PrescribedLoad(8.0)


class Springs:
    """Displaces each cell by three times its pressure, and all cells by 5."""

    self_compliance = 1.0

    def __call__(self, pressure: np.ndarray) -> np.ndarray:
        return np.asarray(3 * pressure + 5)


@pytest.mark.parametrize("scale", [1.0, 1e-3])
def test_a_winkler_foundation_is_solved_by_its_start(scale: float) -> None:
    heights, load = scale * PROBLEM.undeformed_gap, PrescribedLoad(scale * 16.0)
    bed = replace(
        PROBLEM, operator=cast(Operator, Springs()), undeformed_gap=heights, resultant=load
    )
    pressure = bed.winkler_start()
    gap = bed.gap(pressure, bed.operator(pressure))
    assert bed.residual(pressure, gap) < 1e-14
    for other in (replace(bed, elongation=31.0), replace(bed, elongation=1 / 31)):
        np.testing.assert_array_equal(other.winkler_start(), bed.uniform())
    # springs tell nothing of their compliance where all are equally high
    level = replace(bed, undeformed_gap=np.ones((2, 4)))
    np.testing.assert_allclose(level.winkler_start(), bed.uniform())


def test_where_no_cell_is_free_the_approach_closes_the_widest_gap() -> None:
    hard = replace(PROBLEM, constraint=HardnessLimited(4.0))
    found = hard.gap(np.full((2, 4), 4.0), np.full((2, 4), 0.5))
    assert found.approach == 5.5
    np.testing.assert_array_equal(found.height, HEIGHTS - 5.0)
