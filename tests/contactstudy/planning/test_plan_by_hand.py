"""How a plan goes from grid to grid, by forecasts that are written here."""

from dataclasses import replace
from math import inf
from types import SimpleNamespace
from typing import Any

import pytest

import contactstudy as cs
from contactstudy.planning import in_time
from contactstudy.planning import plan as planning
from contactstudy.planning.cost import memory
from contactstudy.planning.in_time import Extremes, Yielding
from contactstudy.planning.plan import (
    ALMOST,
    ROUNDS,
    WASTE,
    Forecast,
    _warnings,
    expected,
    reaching,
)
from tests.conftest import LineContact

EXACT = cs.ExactPeriodicity()
GRID = cs.Grid((64, 32), (4.0, 2.0))
LARGE = cs.Grid((640, 320), (4.0, 2.0))


def seen(error: float, *, cut_off: bool = False, said: str = "") -> Forecast:
    return Forecast(GRID, error, 1.0, cut_off=cut_off, said=said, seconds=1.0)


def needing(grid: cs.Grid = GRID, **more: Any) -> Any:
    asked = {"widest": inf, "finest": (inf, inf)} | more
    return SimpleNamespace(grid=lambda *_: grid, padding=lambda: EXACT, **asked)


def reached(
    monkeypatch: pytest.MonkeyPatch, needs: Any, *answers: Forecast, error: float = 0.1
) -> list[cs.Grid]:
    """The grids that are asked after, the last of which is taken; the last answer is given for ever."""
    asked: list[cs.Grid] = []

    def answer(_: object, __: object, grid: cs.Grid) -> Forecast:
        asked.append(grid)
        return replace(answers[min(len(asked), len(answers)) - 1], grid=grid)

    monkeypatch.setattr(planning, "expected", answer)
    scene: Any = None
    found = reaching(scene, needs, error, None, memory(LARGE, EXACT))
    assert found.grid == asked[-1]
    return asked


@pytest.mark.parametrize("share", [0.5, ALMOST, 1 / WASTE])
def test_a_grid_that_keeps_to_the_error_without_waste_is_taken(
    share: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert reached(monkeypatch, needing(), seen(0.3 * share), error=0.3) == [GRID]


def test_too_coarse_a_grid_is_made_as_fine_as_its_rate_says(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    first, second = reached(monkeypatch, needing(), seen(4 * ALMOST * 0.1), seen(0.09))
    assert (first, second.cells, second.extent) == (GRID, (256, 128), GRID.extent)
    # what has been made finer is not made coarser again
    asked = reached(monkeypatch, needing(), seen(4 * ALMOST * 0.1), seen(0.001))
    assert len(asked) == 2


def test_too_fine_a_grid_is_made_coarser_as_long_as_it_shows_the_waves(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    _, second = reached(monkeypatch, needing(LARGE), seen(0.01), seen(0.05))
    assert second.cells == (64, 32)
    # the error grows with the square of the cell
    _, second = reached(
        monkeypatch, needing(LARGE), replace(seen(0.001), rate=2.0), replace(seen(0.05), rate=2.0)
    )
    assert second.cells == (64, 32)
    # cells of 1/160 m: eight in the shortest wave across, four in that along, of which it needs two
    waves = needing(LARGE, finest=(0.05, 0.025))
    _, second = reached(monkeypatch, waves, seen(0.01), seen(0.05))
    assert second.cells == (320, 160)
    shown = needing(LARGE, finest=(0.05, 2 / 160))
    assert reached(monkeypatch, shown, seen(0.01)) == [LARGE]


def test_a_contact_that_outgrows_its_grid_is_given_half_as_much_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    cut = seen(0.05, cut_off=True)
    _, second = reached(monkeypatch, needing(), cut, seen(0.05))
    assert (second.extent, second.cells) == ((6, 2), (96, 32))
    # as far as the surface is known
    known = reached(monkeypatch, needing(widest=5.0), cut)
    assert [(grid.extent[0], grid.cells[0]) for grid in known] == [(4, 64), (5, 80)]
    assert len(reached(monkeypatch, needing(), cut)) == ROUNDS


def test_what_memory_does_not_hold_is_not_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    double = cs.Grid((1280, 640), (4.0, 2.0))
    (within,) = reached(monkeypatch, needing(double), seen(0.4))
    assert memory(within, EXACT) <= memory(LARGE, EXACT)


def warned(
    grid: cs.Grid, forecast: Forecast, error: float = inf, limit: float = inf, **more: Any
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
    assert warned(GRID, seen(0.2, said="sharp"), error=0.3) == ["sharp"]


def test_a_smooth_contact_is_foreseen_by_its_law_and_one_that_yields_by_pilots(
    line_contact: LineContact, monkeypatch: pytest.MonkeyPatch
) -> None:
    a, highest = line_contact.hertz.half_width, line_contact.hertz.peak_pressure
    monkeypatch.setattr(
        planning, "timed", lambda *_: SimpleNamespace(seconds=lambda *asked: 2.0 * asked[2])
    )
    monkeypatch.setattr(planning, "forecast", lambda *_: seen(0.3))
    scene = line_contact.scene
    needs = planning.needs_of(scene)
    grid = cs.Grid((64, 1), (2 * a, a))
    found = expected(scene, needs, grid)
    assert (found.error, found.rate, found.cut_off) == (needs.error(grid.cell), 1.5, False)
    assert found.seconds == 2.0 * planning.SMOOTH_ITERATIONS
    assert expected(scene, needs, replace(grid, extent=(1.99 * a, a))).cut_off
    assert expected(replace(scene, hardness=highest), needs, grid) == seen(0.3)
    assert expected(replace(scene, hardness=1.01 * highest), needs, grid) == found


def test_where_pilots_show_no_error_the_law_counts_twice(
    line_contact: LineContact, monkeypatch: pytest.MonkeyPatch
) -> None:
    needs: Any = SimpleNamespace(
        smooth=False, padding=lambda: EXACT, error=lambda cell: cell[0] + 2 * cell[1]
    )
    for pilot, error, rate in (
        (seen(inf), 2 * 3 / 16, 1.5), (seen(inf, cut_off=True), inf, 1.0), (seen(0.3), 0.3, 1.0),
    ):  # fmt: skip
        monkeypatch.setattr(planning, "forecast", lambda *_, pilot=pilot: pilot)
        found = expected(line_contact.scene, needs, GRID)
        assert (found.error, found.rate) == (error, rate)


@pytest.mark.parametrize(("along", "dimension"), [(1, 1), (2, 2), (32, 2)])
def test_a_plan_of_a_given_grid_is_that_grid(
    along: int, dimension: int, line_contact: LineContact, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Within four fifths of the memory."""
    grid = cs.Grid((64, along), (1e-3, 5e-4))
    needed = memory(grid, EXACT)
    for share, fits in ((0.801, False), (0.799, True)):
        monkeypatch.setattr(planning, "available_bytes", lambda share=share: needed / share)
        monkeypatch.setattr(planning, "timed", lambda *_: SimpleNamespace(seconds=lambda *_: 8.0))
        found = cs.plan(line_contact.scene, grid=grid, period=5e-4)
        assert (found.grid, found.dimension, found.bytes) == (grid, dimension, needed)
        assert (found.seconds, found.steps) == (8, 1)
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
    return asked, planning._plan_in_time(scene, error=0.4, period=1.0, grid=grid)


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
    extremes = Extremes(line_contact.scene, 1.0, 7, 5, ("time",), plastic)
    asked, found = planned(monkeypatch, extremes)
    assert asked[0]["error"] == asked[1]["error"] == pytest.approx(0.05)
    assert found.error == pytest.approx(0.08)
    assert found.seconds == 21 * plastic.contacts(NARROW.grid)
    assert found.bytes == 1000 + 8 * 5 * 80 + plastic.bytes(NARROW.grid)
    assert found.reasons == ("a", "time", plastic.reason(NARROW.grid))
    _, elastic = planned(monkeypatch, replace(extremes, plastic=None))
    assert (elastic.error, elastic.seconds) == (0.01, 21)
