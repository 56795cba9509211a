"""Nested grids."""

from math import log

import pytest

from studies.advice.ladder import MULTIPLES, is_reference, unit_of


@pytest.mark.parametrize("cells", [(640, 480), (128, 400), (600, 144), (128, 128), (50, 2000)])
def test_a_unit_has_nearly_the_ratio_of_its_grid_and_no_prime_factor_above_five(
    cells: tuple[int, int],
) -> None:
    unit = unit_of(cells)
    assert abs(log(unit[0] / unit[1] * cells[1] / cells[0])) < 0.1
    for count in unit:
        for factor in (2, 3, 5):
            while count % factor == 0:
                count //= factor
        assert count == 1


def test_all_rungs_up_to_a_third_of_a_reference_nest_in_it() -> None:
    for reference in filter(is_reference, MULTIPLES):
        assert all(reference % rung == 0 for rung in MULTIPLES if rung <= reference // 3)
