"""What pilots say of a larger solve, by hand: their sizes, the extrapolation, and the grid that keeps to an error."""

from types import SimpleNamespace

import pytest

import contactstudy as cs
from contactstudy.planning import plan as pilot
from contactstudy.planning.cost import memory
from contactstudy.planning.plan import Forecast, affordable, finer, forecast
from tests.conftest import LineContact

EXACT = cs.ExactPeriodicity()
KNOWN = Forecast(cs.Grid((64, 32), (4.0, 1.0)), 0.01, 1.5, cut_off=False, said="", seconds=1.0)


def test_an_error_falls_with_the_larger_of_the_two_cells() -> None:
    # cells of 1/16 and 1/32
    assert KNOWN.error_of((1 / 16, 1 / 32)) == pytest.approx(0.01)
    assert KNOWN.error_of((1 / 8, 1 / 32)) == pytest.approx(0.01 * 2**1.5)
    assert KNOWN.error_of((1 / 32, 1 / 8)) == pytest.approx(0.01 * 4**1.5)
    line = Forecast(cs.Grid((64, 1), (4.0, 1.0)), 0.01, 1.0, cut_off=False, said="", seconds=1.0)
    # of one cell along, that across alone
    assert line.error_of((1 / 8, 1 / 32)) == pytest.approx(0.02)
    two = Forecast(cs.Grid((64, 2), (4.0, 1.0)), 0.01, 1.0, cut_off=False, said="", seconds=1.0)
    assert two.error_of((1 / 16, 1.5)) == pytest.approx(0.03)
    assert KNOWN.grid_for(0.01 / 4**1.5).cells == (256, 128)
    assert finer(line.grid, 2.0).cells == (128, 1)
    assert finer(KNOWN.grid, 2.0).extent == KNOWN.grid.extent


def piloted(
    monkeypatch: pytest.MonkeyPatch, grid: cs.Grid, bounds: dict[int, float]
) -> tuple[list[tuple[int, int]], Forecast]:
    """The pilots' cells, and the forecast from bounds in L1 by the cells across; each takes two seconds."""
    seen = []

    def one(_: object, on: cs.Grid, __: object) -> tuple[SimpleNamespace, SimpleNamespace, float]:
        seen.append(on.cells)
        parts = SimpleNamespace(discretisation=bounds[on.cells[0]])
        solution = SimpleNamespace(
            problem=SimpleNamespace(grid=on), status=cs.Status.CONTACT_AT_EDGE
        )
        return (
            solution,
            SimpleNamespace(l1=parts, warnings=("no", "at a sharp edge or corner")),
            2.0,
        )

    monkeypatch.setattr(pilot, "_pilot", one)
    return seen, forecast(None, grid, EXACT)  # type: ignore[arg-type]


def test_a_line_of_32768_cells_is_foreseen_from_8192_and_4096(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    grid = cs.Grid((2**15, 1), (1.0, 1.0))
    seen, found = piloted(monkeypatch, grid, {2**13: 0.03, 2**12: 0.06})
    assert seen == [(2**13, 1), (2**12, 1)]
    # half for each halving, twice; bounds are half as large again as what they stand for
    assert found.rate == pytest.approx(1)
    assert found.error == pytest.approx(0.03 / 1.5 / 4)
    # four times as many points, of which a transform takes the logarithm more: twice 2^15 and 2^13
    assert found.seconds == pytest.approx(2.0 * 4 * 16 / 14)
    assert found.cut_off
    assert found.said == "at a sharp edge or corner"


@pytest.mark.parametrize(("before", "rate"), [(0.031, 0.5), (0.6, 1.5)])
def test_a_rate_is_between_a_step_s_and_a_smooth_contact_s(
    before: float, rate: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    grid = cs.Grid((512, 256), (1.0, 1.0))
    seen, found = piloted(monkeypatch, grid, {256: 0.03, 128: before})
    # at most 65536 cells: 256 x 128
    assert seen == [(256, 128), (128, 64)]
    assert found.rate == rate
    assert found.error == pytest.approx(0.02 / 2**rate)


def test_a_grid_that_is_small_is_its_own_pilot(monkeypatch: pytest.MonkeyPatch) -> None:
    seen, found = piloted(monkeypatch, cs.Grid((128, 64), (1.0, 1.0)), {128: 0.03})
    assert seen == [(128, 64)]
    assert (found.error, found.rate, found.seconds) == pytest.approx((0.02, 1.0, 2.0))
    # a long grid: eight cells along at the least, or as many as it has
    long = cs.Grid((2**17, 8), (1.0, 1.0))
    seen, _ = piloted(monkeypatch, long, {2**13: 0.03, 2**12: 0.06})
    assert seen == [(2**13, 8), (2**12, 8)]
    two = cs.Grid((2**17, 2), (1.0, 1.0))
    seen, _ = piloted(monkeypatch, two, {2**15: 0.03, 2**14: 0.06})
    assert seen == [(2**15, 2), (2**14, 2)]
    thin = cs.Grid((2**17, 3), (1.0, 1.0))
    seen, _ = piloted(monkeypatch, thin, {2**14: 0.03, 2**13: 0.06})
    assert seen == [(2**14, 3), (2**13, 3)]


def test_a_grid_that_memory_does_not_hold_is_made_the_finest_that_it_holds() -> None:
    grid = cs.Grid((1024, 512), (1.0, 1.0))
    assert affordable(grid, EXACT, memory(grid, EXACT)) == grid
    most = memory(cs.Grid((512, 256), (1.0, 1.0)), EXACT)
    found = affordable(grid, EXACT, most)
    assert memory(found, EXACT) <= most
    # a hundredth is left for rounding, and a step more where that was not enough
    assert 0.95 * 512 <= found.cells[0] <= 512
    assert found.cells[0] / found.cells[1] == pytest.approx(2, rel=0.02)
    line = affordable(
        cs.Grid((4096, 1), (1.0, 1.0)), EXACT, memory(cs.Grid((1000, 1), (1, 1)), EXACT)
    )
    assert line.cells[1] == 1
    assert 0.95 * 1000 <= line.cells[0] <= 1000
    two = affordable(
        cs.Grid((4096, 2), (1.0, 1.0)), EXACT, memory(cs.Grid((1000, 2), (1, 1)), EXACT)
    )
    assert two.cells[1] == 2
    # two cells across are the fewest
    fewest = cs.Grid((2, 1), (1.0, 1.0))
    assert affordable(cs.Grid((8, 1), (1.0, 1.0)), EXACT, memory(fewest, EXACT)) == fewest


def test_a_pilot_takes_the_time_between_its_begin_and_its_end(
    line_contact: LineContact, monkeypatch: pytest.MonkeyPatch
) -> None:
    clock = iter([1.5, 4.0])
    monkeypatch.setattr(pilot, "process_time", lambda: next(clock))
    solution, estimate, seconds = pilot._pilot(
        line_contact.scene, line_contact.grid((16, 1), 1.0), EXACT
    )
    assert seconds == 2.5
    assert solution.residual <= 1e-5
    # of that solution, but for the rounding of its transforms
    assert estimate.l1.total == pytest.approx(cs.error_estimate(solution).l1.total, rel=1e-6)
