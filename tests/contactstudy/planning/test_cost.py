import pytest

import contactstudy as cs
from contactstudy.planning.cost import Timed, memory, padded


def test_seconds_grow_like_n_log_n_and_with_the_iterations() -> None:
    exact, sample = cs.ExactPeriodicity(), cs.Grid((128, 128), (1.0, 1.0))
    timed = Timed(cells=128**2, work=padded(sample, exact), setup=0.0, convolution=1e-3)
    once, twice = (timed.seconds(sample, exact, count) for count in (10, 20))
    assert twice == pytest.approx(2 * once)
    larger = cs.Grid((256, 256), (1.0, 1.0))
    assert timed.seconds(larger, exact, 10) == pytest.approx(4 * 17 / 15 * once)
    # a padded length is twice the points
    doubled = timed.seconds(sample, cs.Superposition(1), 10)
    assert doubled == pytest.approx(2 * 16 / 15 * once)


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
    assert padded(grid, padding) == cs.convolution(1.0, grid, padding, 1.0).work


def test_memory_counts_the_padded_grid() -> None:
    grid = cs.Grid((64, 32), (1.0, 1.0))
    fewer, more = (
        memory(grid, padding) for padding in (cs.ExactPeriodicity(), cs.Superposition(1))
    )
    assert more - fewer == 8 * 2 * 2 * 64 * 32
