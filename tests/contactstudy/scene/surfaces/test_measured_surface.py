import pickle
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import xarray as xr

import contactstudy as cs
from contactstudy.scene.surfaces.preparation import Ends, cell_means

GRID = cs.Grid(cells=(24, 16), extent=(2e-4, 1e-4))

HEIGHTS = np.random.default_rng(0).standard_normal(GRID.cells) * 1e-7


def smooth(nx: int, ny: int) -> np.ndarray:
    """Means over cells of ``sin u cos v``, periodic along the length."""
    u, v = (np.linspace(-np.pi, np.pi, n + 1) for n in (nx, ny))
    across = -np.diff(np.cos(u + 0.3)) * nx / (2 * np.pi)
    along = np.diff(np.sin(v + 0.7)) * ny / (2 * np.pi)
    return across[:, None] * along


def test_heights_without_sizes_stand_cell_for_cell_and_close_the_gap() -> None:
    np.testing.assert_array_equal(cs.MeasuredSurface(HEIGHTS).gap(GRID), -HEIGHTS)


def test_a_finer_grid_shows_the_same_surface() -> None:
    surface = cs.MeasuredSurface(HEIGHTS, GRID.extent, trend="plane", seam=cs.Tapered())
    fine = surface.gap(replace(GRID, cells=(72, 80)))
    blocks = fine.reshape(24, 3, 16, 5).mean(axis=(1, 3))
    np.testing.assert_allclose(blocks, surface.gap(GRID), rtol=0, atol=1e-13 * 1e-7 * 80)


def test_finer_points_show_a_smooth_surface_at_third_order() -> None:
    grid, errors = replace(GRID, cells=(30, 22)), []
    for n in (12, 24, 48):
        surface = cs.MeasuredSurface(smooth(n, n), GRID.extent)
        errors.append(np.abs(surface.gap(grid) + smooth(30, 22)).max())
    assert np.log2(errors[0] / errors[2]) / 2 > 2.7, errors


def test_a_wider_grid_shows_the_same_surface() -> None:
    surface = cs.MeasuredSurface(HEIGHTS, GRID.extent, trend="quadratic")
    narrow = cs.Grid(cells=(12, 16), extent=(1e-4, 1e-4))
    np.testing.assert_allclose(surface.gap(narrow), surface.gap(GRID)[6:18], rtol=0, atol=1e-13 * 1e-7 * 24)


def test_a_mirrored_surface_fills_twice_the_period() -> None:
    surface = cs.MeasuredSurface(HEIGHTS, GRID.extent, seam=cs.Mirrored())
    twice = cs.Grid(cells=(24, 32), extent=(2e-4, 2e-4))
    np.testing.assert_array_equal(surface.gap(twice), np.concatenate([-HEIGHTS, -HEIGHTS[:, ::-1]], axis=1))
    with pytest.raises(cs.InvalidInput, match=r"^MeasuredSurface period is 0\.0002: give a length"):
        surface.gap(replace(GRID, extent=(2e-4, 3e-4)))


@pytest.mark.parametrize("seam", [cs.AsMeasured(), cs.Mirrored(), cs.Tapered()], ids=repr)
def test_a_shorter_period_shows_the_middle_of_the_surface(seam: cs.Mirrored) -> None:
    surface = cs.MeasuredSurface(HEIGHTS, GRID.extent, seam=seam)
    short = cs.Grid(cells=(24, 10 * seam.lengths), extent=(2e-4, 10 / 16 * 1e-4 * seam.lengths))
    expected = -seam.periodic(HEIGHTS[:, 3:13])
    np.testing.assert_allclose(surface.gap(short), expected, rtol=0, atol=1e-13 * 1e-7 * 16)
    fine = surface.gap(replace(short, cells=(24, 3 * short.cells[1])))
    blocks = fine.reshape(24, -1, 3).mean(axis=2)
    np.testing.assert_allclose(blocks, expected, rtol=0, atol=1e-13 * 1e-7 * 48)


def test_a_measured_profile_is_the_same_all_along() -> None:
    profile = cs.MeasuredSurface(HEIGHTS[:, :1], extent=(2e-4, 1e-6))
    np.testing.assert_array_equal(profile.gap(GRID), -HEIGHTS[:, :1])
    np.testing.assert_array_equal(cs.MeasuredSurface(HEIGHTS[:, :1]).gap(GRID), -HEIGHTS[:, :1])


def test_turned_grooves_run_across() -> None:
    groove = np.zeros((24, 16))
    groove[5] = -1e-6
    surface = cs.MeasuredSurface(groove, GRID.extent)
    turned = surface.turned()
    assert surface.gap(GRID).shape == (24, 1)
    assert turned.extent == (1e-4, 2e-4)
    across = turned.gap(cs.Grid(cells=(16, 24), extent=(1e-4, 2e-4)))
    np.testing.assert_array_equal(across, np.rot90(-groove))
    rough = cs.MeasuredSurface(HEIGHTS, GRID.extent).turned()
    np.testing.assert_array_equal(rough.gap(cs.Grid(cells=(16, 24), extent=(1e-4, 2e-4))), np.rot90(-HEIGHTS))
    back = turned.turned().turned().turned()
    assert back == surface
    np.testing.assert_array_equal(back.heights, surface.heights)


def test_surfaces_are_equal_by_their_heights_and_all_that_is_done_to_them() -> None:
    surface = cs.MeasuredSurface(HEIGHTS, GRID.extent)
    same = cs.MeasuredSurface(np.asfortranarray(HEIGHTS), list(GRID.extent))  # type: ignore[arg-type]
    assert surface == same
    assert hash(surface) == hash(same)
    assert repr(surface) == repr(same)
    assert len(repr(surface)) < 300
    for other in (
        cs.MeasuredSurface(HEIGHTS + 1e-20, GRID.extent),
        cs.MeasuredSurface(HEIGHTS.reshape(16, 24), GRID.extent),
        cs.MeasuredSurface(HEIGHTS),
        replace(surface, seam=cs.Mirrored()),
    ):
        assert other != surface
        assert repr(other) != repr(surface)
    assert pickle.loads(pickle.dumps(surface)) == surface


def test_labelled_heights_bring_their_sizes() -> None:
    coordinates = {"width": GRID.x, "length": GRID.y}
    labelled = xr.DataArray(HEIGHTS, dims=("width", "length"), coords=coordinates)
    assert cs.MeasuredSurface(labelled).extent == pytest.approx(GRID.extent, rel=1e-12)
    with pytest.raises(cs.InvalidInput, match=r"^MeasuredSurface\.extent is .*: leave it out"):
        cs.MeasuredSurface(labelled, extent=(1.0, 1.0))


def test_tiles_are_counted_along_the_length_first_and_keep_the_size_of_a_point() -> None:
    heights = np.arange(42.0).reshape(6, 7)
    surface = cs.MeasuredSurface(heights, (0.6, 1.4), trend="none")
    cut = surface.cut(cs.Tile((2, 3), 4))
    np.testing.assert_array_equal(cut.heights, [[23, 24], [30, 31], [37, 38]])
    assert cut.extent == pytest.approx((0.3, 0.4), rel=1e-12)
    assert cut.turned().extent == pytest.approx((0.4, 0.3), rel=1e-12)
    np.testing.assert_array_equal(cut.turned().heights, [[24, 31, 38], [23, 30, 37]])


def test_the_last_tile_is_the_one_before_the_count() -> None:
    assert cs.Tile((2, 3), 5).number == 5
    for number in (6, -1):
        with pytest.raises(cs.InvalidInput, match=r"Tile\.number"):
            cs.Tile((2, 3), number)
    narrow = cs.MeasuredSurface(np.zeros((5, 4)), trend="none")
    assert narrow.cut(cs.Tile((2, 2), 3)).heights.shape == (2, 2)
    with pytest.raises(cs.InvalidInput, match="2 x 2"):
        narrow.cut(cs.Tile((2, 3)))


X, Y = np.meshgrid(np.linspace(-3, 2, 13), np.linspace(0, 7, 9), indexing="ij")

FORMS = {
    "none": 0 * X,
    "mean": 0 * X + 3,
    "plane": 3 - 2 * X + 0.5 * Y,
    "quadratic": 3 - 2 * X + 0.5 * Y + X**2 - 3 * X * Y + 2 * Y**2,
}


def less(trend: Any, heights: np.ndarray) -> np.ndarray:
    return cs.MeasuredSurface(heights, trend=trend).prepared


@pytest.mark.parametrize("trend", FORMS)
def test_trend_takes_off_its_own_form_and_no_more(trend: str) -> None:
    rough = np.random.default_rng(0).standard_normal(X.shape)
    left = less(trend, rough)
    np.testing.assert_allclose(less(trend, rough + FORMS[trend]), left, rtol=0, atol=1e-12)
    np.testing.assert_allclose(less(trend, left), left, rtol=0, atol=1e-13)
    for form in list(FORMS.values())[1 : list(FORMS).index(trend) + 1]:  # least squares: nothing of it is left
        assert abs((left * form).sum()) < 1e-11


def test_trend_leaves_the_forms_beyond_it() -> None:
    """Products of deviations from the mean are orthogonal to every polynomial of lower total degree."""
    x, y = X - X.mean(), Y - Y.mean()
    for trend, beyond in (
        ("mean", x),
        ("plane", x * y),
        ("quadratic", (x**2 - (x**2).mean()) * y),
    ):
        np.testing.assert_allclose(less(trend, beyond), beyond, rtol=0, atol=1e-12)


@pytest.mark.parametrize("shape", [(1, 1), (5, 1), (2, 2), (1, 3)])
def test_few_points_have_no_more_trend_than_they_show(shape: tuple[int, int]) -> None:
    heights = np.random.default_rng(0).standard_normal(shape)
    left = less("quadratic", heights)
    assert left.shape == shape
    assert abs(left.sum()) < 1e-14 * heights.size


ROUGH = np.random.default_rng(0).standard_normal((5, 24)) + 7


@pytest.mark.parametrize("count", [1, 2, 3])
@pytest.mark.parametrize("ends", ["periodic", "not-a-knot"])
def test_few_points_keep_their_means_too(count: int, ends: Ends) -> None:
    few = ROUGH[:, :count]
    fine = cell_means(few, 1, extent=1.0, cells=4 * count, width=1.0, ends=ends)
    np.testing.assert_allclose(fine.reshape(5, count, 4).mean(axis=2), few, rtol=1e-13)
