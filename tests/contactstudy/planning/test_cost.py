from dataclasses import replace
from math import log

import pytest

import contactstudy as cs
from contactstudy.planning.cost import CALLS, CostModel, Timing, padded_points

EXACT = cs.ExactPeriodicity()


def square(cells: int) -> cs.Grid:
    return cs.Grid((cells, cells), (1.0, 1.0))


def test_one_timing_is_scaled_by_n_log_n_and_the_convolutions() -> None:
    """With the calls that a transform of any size takes, like N log N of 80 x 80 cells."""
    model = CostModel((Timing(square(128), EXACT, 10.0, 1e-3, 1e-2),))
    assert model.seconds(square(128), EXACT, 10.0) == pytest.approx(1.1e-2)
    assert model.seconds(square(128), EXACT, 20.0) == pytest.approx(2.1e-2)
    cells, points = 512**2, 2 * 512**2
    work = (cells * log(cells) + CALLS) / (128**2 * log(128**2) + CALLS)
    transforms = (points * log(points) + CALLS) / (2 * 128**2 * log(2 * 128**2) + CALLS)
    assert model.seconds(square(512), EXACT, 10.0) == pytest.approx(1e-3 * work + 1e-2 * transforms)


def test_timings_of_other_paddings_and_dimensions_are_left_aside() -> None:
    timings = (
        Timing(square(64), EXACT, 10.0, 1.0, 1.0),
        Timing(square(64), cs.CircularSuperposition(2), 10.0, 7.0, 7.0),
        Timing(cs.Grid((64, 1), (1.0, 1.0)), EXACT, 10.0, 30.0, 30.0),
    )
    model = CostModel(timings)
    assert model.seconds(square(64), EXACT, 10.0) == pytest.approx(2.0)
    assert model.seconds(square(64), cs.CircularSuperposition(2), 10.0) == pytest.approx(14.0)
    assert model.seconds(cs.Grid((64, 1), (1.0, 1.0)), EXACT, 10.0) == pytest.approx(60.0)


def test_an_interrupted_run_hardly_counts() -> None:
    timings = [
        Timing(
            square(cells),
            EXACT,
            10.0,
            1e-9 * cells**2,
            1e-8 * cells**2 * (20 if cells == 96 else 1),
        )
        for cells in range(200, 60, -8)
    ]
    timings.append(replace(timings[0], solve=30 * timings[0].solve))
    model, clean = CostModel(timings), CostModel(timings[:-1])
    for cells in (64, 256):
        seconds = model.seconds(square(cells), EXACT, 10.0)
        assert seconds == pytest.approx(clean.seconds(square(cells), EXACT, 10.0), rel=0.1)


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
    assert padded_points(grid, padding) == cs.convolution(1.0, grid, padding, 1.0).work
