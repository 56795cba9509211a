import numpy as np
import pytest

import contactstudy as cs
from contactstudy.domain.device import threads
from contactstudy.planning import cost
from contactstudy.planning.cost import Timed, memory, padded, times_faster


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


def test_set_up_grows_with_a_power_of_the_cells_and_is_never_less_than_the_sample() -> None:
    """To the power 0.8: 16 times the cells cost 9.19 times as much, where the transform is free."""
    exact, sample = cs.ExactPeriodicity(), cs.Grid((128, 128), (1.0, 1.0))
    timed = Timed(cells=128**2, work=padded(sample, exact), setup=1e-3, convolution=0.0)
    for cells, seconds in ((64, 1e-3), (128, 1e-3), (512, 9.18958684e-3)):
        grid = cs.Grid((cells, cells), (1.0, 1.0))
        assert timed.seconds(grid, exact, 10) == pytest.approx(seconds, rel=1e-8)


def test_an_iteration_is_three_and_a_half_convolutions() -> None:
    exact, sample = cs.ExactPeriodicity(), cs.Grid((128, 128), (1.0, 1.0))
    timed = Timed(cells=128**2, work=padded(sample, exact), setup=0.0, convolution=1e-3)
    assert timed.seconds(sample, exact, 10) == pytest.approx(10 * 3.5e-3)


def test_memory_is_fourteen_fields_and_a_complex_one_of_the_padded_grid() -> None:
    grid = cs.Grid((64, 32), (1.0, 1.0))
    assert memory(grid, cs.ExactPeriodicity()) == 8 * (14 * 64 * 32 + 2 * 128 * 32)


def test_one_thread_is_no_faster_than_one_thread_and_not_timed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(cost, "perf_counter", None)
    assert times_faster(cs.Grid((64, 64), (1.0, 1.0)), cs.ExactPeriodicity(), cs.Cpu()) == 1.0


@pytest.mark.parametrize(
    ("cells", "sample"), [((64, 32), (64, 32)), ((4096, 1), (512, 1)), ((600, 700), (512, 512))]
)
def test_threads_are_as_many_times_faster_as_a_convolution_on_at_most_512_cells_either_way(
    cells: tuple[int, int], sample: tuple[int, int], monkeypatch: pytest.MonkeyPatch
) -> None:
    """By a clock that is wound by hand: 2 s on one thread, 1.25 s on three, at the least."""
    at, seen = [0.0], set()

    def applied(operator: cs.Convolution, pressure: np.ndarray) -> np.ndarray:
        seen.add(operator.cells)
        at[0] += {1: 2.0, 3: 1.25}[threads()] + 7.0 * (at[0] == 0)
        return pressure

    monkeypatch.setattr(cs.Convolution, "__call__", applied)
    monkeypatch.setattr(cost, "perf_counter", lambda: at[0])
    found = times_faster(cs.Grid(cells, (1.0, 1.0)), cs.ExactPeriodicity(), cs.Cpu(3))
    assert found == 1.6
    assert seen == {sample}


@pytest.mark.parametrize(("along", "cells"), [(1, (128, 1)), (2, (128, 128)), (500, (128, 128))])
def test_the_quickest_of_three_samples_counts(
    along: int, cells: tuple[int, int], monkeypatch: pytest.MonkeyPatch
) -> None:
    """By a clock that is wound by hand: set up in 3, 2 and 5 s, convolved in 2, 4 and 1 s."""
    clock = iter([1.0, 4, 6, 10, 12, 16, 20, 25, 26])
    monkeypatch.setattr(cost, "perf_counter", lambda: next(clock))
    found = cost.timed(cs.Grid((1024, along), (3.0, 2.0)), cs.ExactPeriodicity())
    work = padded(cs.Grid(cells, (3.0, 2.0)), cs.ExactPeriodicity())
    assert found == Timed(cells[0] * cells[1], work, setup=2.0, convolution=1.0)
