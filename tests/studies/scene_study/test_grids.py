"""The grids of a sweep by hand: the width of the widest, the cells of the finest, one surface on all."""

from dataclasses import dataclass, replace
from math import inf
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import contactstudy as cs
from studies.scene_study import grids
from tests.conftest import STEEL

SURFACE = cs.MeasuredSurface(np.eye(8) * 1e-9, extent=(3.0, 2.0), seam=cs.Tapered())
ROUGH = cs.Roughness(1e-9, hurst=0.8, roll_off=0.5, cut_off=0.1, seed=1)


@dataclass(frozen=True)
class Asked:
    """What a file says of its plan."""

    error: float = 0.1
    period: float | None = None


def point(load: float, *shapes: cs.Shape, grid: cs.Grid | None = None, error: float = 0.1) -> Any:
    """A point of a sweep; its plan is told by its load."""
    scene = cs.Scene(cs.LineLoad(load), (STEEL, STEEL), (cs.Cylinder(0.01), *shapes))
    return SimpleNamespace(scene=scene, grid=grid, padding=None, plan_settings=Asked(error))


@pytest.fixture
def planned(monkeypatch: pytest.MonkeyPatch) -> dict[float, cs.Grid]:
    """Grids by the load; periods that need a longer one say so."""
    made: dict[float, cs.Grid] = {}

    def needs(scene: cs.Scene) -> Any:
        return SimpleNamespace(
            grid=lambda *_: made[scene.load.largest],
            period_check=lambda period: "too short: give more" if period < 1.5 else "fine",
            padding=cs.ExactPeriodicity,
        )

    monkeypatch.setattr(grids, "needs_of", needs)
    return made


def test_one_grid_is_as_wide_as_the_widest_and_as_fine_as_the_finest(
    planned: dict[float, cs.Grid],
) -> None:
    # cells of 1/16, 1/32 and 1/20 across, 1/16 and 1/32 along
    planned |= {
        1.0: cs.Grid((64, 32), (4.0, 2.0)),
        2.0: cs.Grid((64, 64), (2.0, 2.0)),
        3.0: cs.Grid((120, 32), (6.0, 2.0)),
    }
    found, notes = grids.posed([point(load) for load in planned])
    assert {one.grid for one in found} == {cs.Grid((192, 64), (6.0, 2.0))}
    assert notes == ("grid 192 x 64 cells over 6 m x 2 m, planned once for 3 points",)
    assert found[0].padding == cs.ExactPeriodicity()


def test_one_cell_along_stays_one_unless_another_point_varies(
    planned: dict[float, cs.Grid],
) -> None:
    planned |= {1.0: cs.Grid((64, 1), (4.0, 2.0)), 2.0: cs.Grid((64, 1), (2.0, 2.0))}
    assert grids.posed([point(1.0), point(2.0)])[0][0].grid.cells == (128, 1)
    planned[3.0] = cs.Grid((32, 40), (2.0, 2.0))
    assert grids.posed([point(1.0), point(3.0)])[0][0].grid.cells == (64, 40)
    planned[1.0] = cs.Grid((64, 2), (4.0, 2.0))
    assert grids.posed([point(1.0)])[0][0].grid.cells[1] > 1


def test_the_longest_period_is_taken_where_it_suits_all_and_else_each_has_its_own(
    planned: dict[float, cs.Grid],
) -> None:
    planned |= {1.0: cs.Grid((64, 32), (4.0, 1.0)), 2.0: cs.Grid((64, 32), (4.0, 2.0))}
    found, notes = grids.posed([point(1.0), point(2.0)])
    assert {one.grid for one in found} == {cs.Grid((64, 64), (4.0, 2.0))}
    planned[2.0] = cs.Grid((64, 32), (4.0, 1.4))
    found, notes = grids.posed([point(1.0), point(2.0)])
    assert [one.grid.period for one in found] == [1.0, 1.4]
    assert notes[0].startswith("no period suits all of 2 points")
    assert grids.posed([point(1.0)])[1] == (
        "grid 64 x 32 cells over 4 m x 1 m, planned once for 1 point",
    )


def test_a_measured_surface_bounds_the_width_and_the_period(planned: dict[float, cs.Grid]) -> None:
    planned |= {1.0: cs.Grid((64, 32), (4.0, 1.0)), 2.0: cs.Grid((64, 32), (3.0, 2.0))}
    found, notes = grids.posed([point(1.0, SURFACE), point(2.0, SURFACE)])
    # 3 m of cells of 3/64, one m of cells of 1/32
    assert {one.grid for one in found} == {cs.Grid((64, 32), (3.0, 1.0))}
    assert "may become 4 m wide, but a measured surface is 3 m wide" in notes[1]
    # of two the narrower one
    narrow = cs.MeasuredSurface(np.eye(8) * 1e-9, extent=(2.25, 2.0), seam=cs.Tapered())
    found, notes = grids.posed([point(1.0, SURFACE), point(2.0, narrow)])
    assert {one.grid.extent for one in found} == {(2.25, 1.0)}
    assert "a measured surface is 2.25 m wide" in notes[1]
    # one that has its width needs no note
    planned[1.0] = cs.Grid((64, 32), (3.0, 1.0))
    assert len(grids.posed([point(1.0, SURFACE), point(2.0, SURFACE)])[1]) == 1


def test_points_that_ask_for_another_error_or_give_a_grid_have_grids_of_their_own(
    planned: dict[float, cs.Grid],
) -> None:
    planned |= {1.0: cs.Grid((64, 32), (4.0, 2.0)), 2.0: cs.Grid((128, 32), (4.0, 2.0))}
    given = cs.Grid((48, 48), (3.0, 3.0))
    first, second, third = grids.posed([point(1.0), point(2.0), point(1.0, grid=given)])[0]
    assert (first.grid, third.grid) == (second.grid, given)
    both = grids.posed([point(1.0), point(2.0, error=0.01)])[0]
    assert [one.grid.cells[0] for one in both] == [64, 128]


def test_random_surfaces_get_the_widest_extent_and_the_part_that_periods_share(
    planned: dict[float, cs.Grid],
) -> None:
    rough = [point(1.0, ROUGH, grid=cs.Grid((64, 32), size)) for size in ((4.0, 2.0), (3.0, 6.0))]
    found, notes = grids.posed(rough)
    assert {one.scene.shapes[1].extent for one in found} == {(4.0, 2.0)}  # type: ignore[attr-defined]
    assert "random surfaces are fixed at 4 m x 2 m for all points" in notes
    # one that names its extent keeps it, and nothing is said
    own = replace(ROUGH, extent=(3.0, 1.0))
    kept, notes = grids.posed([point(1.0, own, grid=cs.Grid((64, 32), (4.0, 2.0)))])
    assert kept[0].scene.shapes[1].extent == (3.0, 1.0)  # type: ignore[attr-defined]
    assert len(notes) == 1
    apart = [point(1.0, ROUGH, grid=cs.Grid((64, 32), size)) for size in ((4.0, 2.0), (3.0, 3.0))]
    found, notes = grids.posed(apart)
    assert {one.scene.shapes[1].extent for one in found} == {None}  # type: ignore[attr-defined]
    assert "the periods of the grids have no common part" in notes[-1]


@pytest.mark.parametrize(
    ("shape", "grid", "said"),
    [
        (SURFACE, cs.Grid((32, 32), (3.0, 1.0)), ""),
        (SURFACE, cs.Grid((32, 32), (3.01, 1.0)), "is 3 m wide, and the grid 3.01 m"),
        # two lengths of a surface that is turned round at its seam
        (SURFACE, cs.Grid((32, 32), (3.0, 3.0)), "period"),
        (SURFACE, cs.Grid((32, 2), (3.0, 3.0)), "period"),
        (SURFACE, cs.Grid((32, 1), (3.0, 3.0)), ""),
        (replace(ROUGH, extent=(3.0, 1.0)), cs.Grid((32, 32), (4.0, 2.0)), ""),
        (replace(ROUGH, extent=(3.0, 1.5)), cs.Grid((32, 32), (4.0, 2.0)), "extent"),
        (replace(ROUGH, rms=0.0, extent=(3.0, 1.5)), cs.Grid((32, 32), (4.0, 2.0)), ""),
    ],
)
def test_a_surface_that_a_grid_cannot_hold_is_refused(
    shape: cs.Shape, grid: cs.Grid, said: str, planned: dict[float, cs.Grid]
) -> None:
    if said:
        with pytest.raises(cs.InvalidInput, match=said):
            grids.posed([point(1.0, shape, grid=grid)])
    else:
        assert grids.posed([point(1.0, shape, grid=grid)])[0][0].grid == grid
    assert inf not in planned
