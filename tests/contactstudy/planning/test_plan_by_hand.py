"""What a plan makes of forecasts that are written here."""

from dataclasses import replace
from math import inf
from types import SimpleNamespace
from typing import Any

import pytest

import contactstudy as cs
from contactstudy.planning import grid_search as search
from contactstudy.planning import in_time
from contactstudy.planning import plan as planning
from contactstudy.planning.cost import memory
from contactstudy.planning.grid_requirements import needs_of
from contactstudy.planning.grid_search import GridForecast, expected
from contactstudy.planning.in_time import Extremes, Yielding
from contactstudy.planning.plan import _warnings
from tests.conftest import LineContact

EXACT = cs.ExactPeriodicity()
GRID = cs.Grid((64, 32), (4.0, 2.0))


def seen(error: float, *, cut_off: bool = False, message: str = "") -> GridForecast:
    """Half of an error across and half along, which fall like the cell."""
    return GridForecast(
        GRID,
        (error / 2, error / 2),
        (1.0, 1.0),
        (16, 16),
        cut_off=cut_off,
        message=message,
        seconds=1.0,
    )


def needing(grid: cs.Grid = GRID, **more: Any) -> Any:
    asked = {"widest": inf, "finest": (inf, inf), "roller": 0.0} | more
    return SimpleNamespace(grid=lambda *_: grid, padding=lambda: EXACT, **asked)


def test_errors_of_both_axes_add_up_and_fall_at_their_own_rates() -> None:
    known = replace(seen(0.0), errors=(0.01, 0.02), rates=(1.5, 0.5))
    assert known.error == pytest.approx(0.03)
    # cells of 1/16 m either way
    assert known.error_of((1 / 8, 1 / 4)) == pytest.approx(0.01 * 2**1.5 + 0.02 * 2)
    line = replace(known, grid=cs.Grid((64, 1), (4.0, 2.0)), errors=(0.01, 0.0))
    assert line.error_of((1 / 8, 99.0)) == pytest.approx(0.01 * 2**1.5)


def test_the_product_of_cells_is_least_where_rates_times_errors_are_alike() -> None:
    """0.08 falls like 1/n and 0.03 like n^-1/2: of 0.03 a third across and two thirds along."""
    known = replace(seen(0.0), errors=(0.08, 0.03), rates=(1.0, 0.5))
    found = known.grid_for(0.03)
    assert found.cells == (512, 72)
    assert found.extent == GRID.extent
    counts = [
        nx * ny for nx in range(100, 2000, 4) for ny in range(16, 600, 4)
        if 0.08 * 64 / nx + 0.03 * (32 / ny) ** 0.5 <= 0.03
    ]  # fmt: skip
    assert min(counts) <= 512 * 72 <= 1.02 * min(counts)


def test_an_axis_at_its_fewest_cells_leaves_the_error_to_the_other() -> None:
    known = replace(seen(0.0), errors=(0.08, 0.0001))
    found = known.grid_for(0.04)
    # 0.0002 are left to 16 cells along: 0.08 * 64 / 0.0398, in steps of four
    assert found.cells == (132, 16)
    assert replace(known, errors=(0.08, 0.0)).grid_for(0.04).cells == (128, 32)


def warned(
    grid: cs.Grid, forecast: GridForecast, error: float = inf, limit: float = inf, **more: Any
) -> list[str]:
    return list(_warnings(needing(**more), forecast, grid, limit, error=error))


def test_a_grid_that_is_too_narrow_is_said_with_the_width_to_try() -> None:
    cut = seen(0.1, cut_off=True)
    (said,) = warned(GRID, cut)
    assert said == "Grid.extent[0] is 4 m: the contact outgrows it, give a width of 6 m."
    assert warned(GRID, cut, widest=6.0) == [said]
    (said,) = warned(GRID, cut, widest=5.0)
    assert "known over 5 m only; give a smaller load, or a surface as wide as 6 m." in said
    assert warned(GRID, seen(0.1)) == []


def test_what_memory_lacks_is_said_of_a_machine_that_has_a_quarter_more() -> None:
    """Of 14 fields and 2 padded ones: 294912 bytes; a plan takes four fifths of what there is."""
    assert warned(GRID, seen(0.1), limit=294912.0) == []
    (said,) = warned(GRID, seen(0.1), limit=240000.0)
    assert "needs 0.000295 GB, and this machine has 0.0003 GB" in said


def test_an_error_that_is_not_reached_is_said_with_what_stands_between() -> None:
    assert warned(GRID, seen(0.2), error=0.2) == []
    assert warned(GRID, seen(inf), error=0.1) == []
    # twice as many cells either way are four times as many bytes
    (said,) = warned(GRID, seen(0.2), error=0.1, limit=4 * 294912.0)
    assert (
        said == "plan.error is 0.1: this grid reaches 0.2; the error of this surface falls slowly."
    )
    (said,) = warned(GRID, seen(0.2), error=0.1, limit=1e6)
    assert "that takes 128 x 64 cells and 0.00118 GB, and this machine has 0.00125 GB" in said
    assert warned(GRID, seen(0.2, message="sharp"), error=0.3) == ["sharp"]


class Costs:
    """A cost model that says so many seconds whatever is asked, without timing anything."""

    def seconds(self, _: object, __: object, convolutions: float) -> float:
        return 2.0 * convolutions


def test_a_smooth_contact_is_foreseen_by_its_law_and_one_that_yields_by_small_solutions(
    line_contact: LineContact, monkeypatch: pytest.MonkeyPatch
) -> None:
    a, highest = line_contact.hertz.half_width, line_contact.hertz.peak_pressure
    monkeypatch.setattr(search, "CostModel", Costs)
    monkeypatch.setattr(search, "forecast", lambda *_: seen(0.3))
    scene = line_contact.scene
    needs = needs_of(scene)
    grid = cs.Grid((64, 1), (2 * a, a))
    found = expected(scene, needs, grid)
    assert (found.error, found.rates[0], found.cut_off) == (needs.error(grid.cell), 1.5, False)
    assert found.seconds == 2.0 * search.SMOOTH_CONVOLUTIONS
    assert expected(scene, needs, replace(grid, extent=(1.99 * a, a))).cut_off
    assert expected(replace(scene, hardness=highest), needs, grid) == seen(0.3)
    assert expected(replace(scene, hardness=1.01 * highest), needs, grid) == found


def test_where_small_solutions_show_no_error_the_law_counts_twice(
    line_contact: LineContact, monkeypatch: pytest.MonkeyPatch
) -> None:
    needs: Any = SimpleNamespace(
        smooth=False, padding=lambda: EXACT, errors=lambda cell: (cell[0], 2 * cell[1]),
        finest=(inf, inf), roller=0.0,
    )  # fmt: skip
    for pilot, errors, rate in (
        (seen(inf), (2 / 16, 4 / 16), 1.5), (seen(inf, cut_off=True), (inf, inf), 1.0),
        (seen(0.3), (0.15, 0.15), 1.0),
    ):  # fmt: skip
        monkeypatch.setattr(search, "forecast", lambda *_, pilot=pilot: pilot)
        found = expected(line_contact.scene, needs, GRID)
        assert (found.errors, found.rates[0]) == (errors, rate)


@pytest.mark.parametrize(("along", "dimension"), [(1, 1), (2, 2), (32, 2)])
def test_a_plan_of_a_given_grid_is_that_grid(
    along: int, dimension: int, line_contact: LineContact, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Within four fifths of the memory."""
    grid = cs.Grid((64, along), (1e-3, 5e-4))
    needed = memory(grid, EXACT)
    monkeypatch.setattr(search, "CostModel", Costs)
    for share, fits in ((0.801, False), (0.799, True)):
        monkeypatch.setattr(planning, "available_bytes", lambda share=share: needed / share)
        found = cs.plan(line_contact.scene, grid=grid, period=5e-4)
        assert (found.grid, found.dimension, found.bytes) == (grid, dimension, needed)
        assert (found.seconds, found.steps) == (planning.JUDGED * 2 * search.SMOOTH_CONVOLUTIONS, 1)
        assert any("this machine has" in said for said in found.warnings) == (not fits)
    with pytest.raises(cs.InvalidInput, match=r"^plan\.period is 0\.0006: leave it out"):
        cs.plan(line_contact.scene, grid=grid, period=6e-4)


NARROW = cs.Plan(
    cs.Grid((40, 2), (2.0, 1.0)), EXACT, 2, 0.01, 3.0, 1000, "", ("a",), ("b",),
)  # fmt: skip


def planned(
    monkeypatch: pytest.MonkeyPatch, extremes: Extremes, grid: cs.Grid | None = None
) -> tuple[list[dict[str, Any]], cs.Plan]:
    """What is asked of the plan of the narrow scene, and that of the whole."""
    asked: list[dict[str, Any]] = []

    def plan(_: object, **named: Any) -> cs.Plan:
        asked.append(named)
        return replace(NARROW, grid=named.get("grid") or NARROW.grid)

    monkeypatch.setattr(planning, "plan", plan)
    monkeypatch.setattr(in_time, "extremes", lambda *_: extremes)
    scene: Any = None
    return asked, planning._plan_in_time(scene, 0.4, 1.0, grid, None)


def test_a_plan_in_time_is_as_wide_as_the_widest_and_costs_all_its_steps(
    line_contact: LineContact, monkeypatch: pytest.MonkeyPatch
) -> None:
    extremes = Extremes(line_contact.scene, 6.0, steps=7, fields=5, reasons=("time",))
    asked, found = planned(monkeypatch, extremes)
    assert asked[0] == {"error": 0.4, "period": 1.0}
    assert asked[1] == {"error": 0.4, "grid": cs.Grid((120, 2), (6.0, 1.0))}
    assert (found.seconds, found.steps) == (21, 7)
    # five fields of 240 cells
    assert found.bytes == 1000 + 8 * 5 * 240
    assert found.reasons == ("a", "time")
    assert found.error == 0.01
    _, warm = planned(monkeypatch, replace(extremes, share=0.6))
    assert warm.seconds == pytest.approx(0.6 * 21)
    asked, found = planned(monkeypatch, replace(extremes, width=1.5))
    assert asked[1]["grid"] == NARROW.grid
    asked, found = planned(monkeypatch, extremes, GRID)
    assert asked == [{"error": 0.4, "period": 1.0, "grid": GRID}]
    assert found.grid == GRID


def test_cells_of_what_yields_are_finer_by_as_much_as_they_err_more(
    line_contact: LineContact, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Twelve times the yield stress: 4^1.5 times the elastic error, and so much less is asked for."""
    plastic = Yielding(ratio=12.0, half_width=0.2, bodies=1)
    extremes = Extremes(line_contact.scene, 1.0, 7, 5, ("time",), (), plastic)
    asked, found = planned(monkeypatch, extremes)
    assert asked[0]["error"] == asked[1]["error"] == pytest.approx(0.05)
    assert found.error == pytest.approx(0.08)
    assert found.seconds == 21 * plastic.contacts(NARROW.grid)
    assert found.bytes == 1000 + 8 * 5 * 80 + plastic.bytes(NARROW.grid)
    assert found.reasons == ("a", "time", plastic.reason(NARROW.grid))
    _, elastic = planned(monkeypatch, replace(extremes, plastic=None))
    assert (elastic.error, elastic.seconds) == (0.01, 21)
