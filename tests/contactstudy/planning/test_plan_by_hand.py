"""What a plan makes of forecasts that are written here."""

from dataclasses import replace
from math import inf
from types import SimpleNamespace
from typing import Any

import contactstudy as cs
from contactstudy.planning.grid_search import GridForecast
from contactstudy.planning.plan import _warnings

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
