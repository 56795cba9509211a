import pytest

import contactstudy as cs
from contactstudy.planning.cost import padded_points


@pytest.mark.parametrize(
    "padding",
    [
        cs.ExactPeriodicity(),
        cs.Superposition(1),
        (cs.ExactPeriodicity(), cs.ExactPeriodicity()),
        (cs.ExactPeriodicity(), cs.ZeroPadding()),
    ],
    ids=repr,
)
@pytest.mark.parametrize("cells", [(64, 32), (67, 31), (128, 1)], ids=str)
def test_points_are_those_of_the_operator(
    cells: tuple[int, int], padding: cs.Padding | tuple[cs.Padding, cs.Padding]
) -> None:
    grid = cs.Grid(cells, (1.0, 1.0))
    assert padded_points(grid, padding) == cs.convolution(1.0, grid, padding, 1.0).transform_size
