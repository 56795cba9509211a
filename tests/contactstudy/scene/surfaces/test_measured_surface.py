"""Measured surfaces: heights on grids, missing points, form, filter and seam."""

import pickle
import re
from dataclasses import replace
from math import cos, pi, sin
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import xarray as xr

import contactstudy as cs
from contactstudy.scene.surfaces.measurement import measurement
from contactstudy.scene.surfaces.preparation import Ends, cell_means, trend_text

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
    for extent in (None, (2e-4, 1e-6)):  # one profile, the same all along
        np.testing.assert_array_equal(cs.MeasuredSurface(HEIGHTS[:, :1], extent).gap(GRID), -HEIGHTS[:, :1])


def test_heights_are_the_same_in_any_form_of_an_array() -> None:
    strided = np.full((48, 48), np.nan)
    strided[::2, ::3] = HEIGHTS
    read_only = HEIGHTS.copy()
    read_only.setflags(write=False)
    labelled = xr.DataArray(HEIGHTS, dims=("width", "length"))
    for form in (
        strided[::2, ::3], read_only, HEIGHTS.astype(">f8"), np.ma.asarray(HEIGHTS), HEIGHTS.tolist(),
        labelled.transpose(), labelled.chunk({"width": 8, "length": 5}),
    ):  # fmt: skip
        np.testing.assert_array_equal(cs.MeasuredSurface(form).gap(GRID), -HEIGHTS)


def test_finer_and_narrower_grids_show_the_same_surface() -> None:
    surface = cs.MeasuredSurface(HEIGHTS, GRID.extent, trend="quadratic", seam=cs.Tapered())
    fine = surface.gap(replace(GRID, cells=(72, 80)))
    blocks = fine.reshape(24, 3, 16, 5).mean(axis=(1, 3))
    np.testing.assert_allclose(blocks, surface.gap(GRID), rtol=0, atol=1e-13 * 1e-7 * 80)
    narrow = cs.Grid(cells=(12, 16), extent=(1e-4, 1e-4))
    np.testing.assert_allclose(surface.gap(narrow), surface.gap(GRID)[6:18], rtol=0, atol=1e-13 * 1e-7 * 24)


def test_finer_points_show_a_smooth_surface_at_third_order() -> None:
    grid, errors = replace(GRID, cells=(30, 22)), []
    for n in (12, 24, 48):
        surface = cs.MeasuredSurface(smooth(n, n), GRID.extent)
        errors.append(np.abs(surface.gap(grid) + smooth(30, 22)).max())
    assert np.log2(errors[0] / errors[2]) / 2 > 2.7, errors


def test_a_mirrored_surface_fills_twice_the_period() -> None:
    surface = cs.MeasuredSurface(HEIGHTS, GRID.extent, seam=cs.Mirrored())
    twice = cs.Grid(cells=(24, 32), extent=(2e-4, 2e-4))
    np.testing.assert_array_equal(surface.gap(twice), np.concatenate([-HEIGHTS, -HEIGHTS[:, ::-1]], axis=1))
    with pytest.raises(cs.InvalidInput, match=r"MeasuredSurface is 200 µm, and the grid's 300 µm is no"):
        surface.gap(replace(GRID, extent=(2e-4, 3e-4)))


@pytest.mark.parametrize("seam", [cs.AsMeasured(), cs.Mirrored(), cs.Tapered()], ids=repr)
def test_a_shorter_period_shows_the_middle_of_the_surface(seam: cs.Mirrored) -> None:
    surface = cs.MeasuredSurface(HEIGHTS, GRID.extent, seam=seam)
    short = cs.Grid(cells=(24, 10 * seam.lengths), extent=(2e-4, 10 / 16 * 1e-4 * seam.lengths))
    expected = -seam.periodic(HEIGHTS[:, 3:13])
    np.testing.assert_allclose(surface.gap(short), expected, rtol=0, atol=1e-13 * 1e-7 * 16)


def test_tapered_keeps_the_middle_and_meets_the_mean_at_the_ends() -> None:
    heights = np.random.default_rng(0).standard_normal((6, 40)) + 3
    closed, mean = cs.Tapered(fraction=0.5).periodic(heights), heights.mean()
    np.testing.assert_allclose(closed[:, 10:30], heights[:, 10:30], rtol=1e-14)
    # half a point from the end of a taper of ten, sin^2 is small
    end = np.sin(np.pi / 2 * 0.5 / 10) ** 2
    np.testing.assert_allclose(closed[:, [0, -1]] - mean, end * (heights[:, [0, -1]] - mean), rtol=1e-9)


def test_a_seam_across_closes_the_width_as_a_seam_along_closes_the_length() -> None:
    heights = np.random.default_rng(0).standard_normal((6, 40))
    along = cs.MeasuredSurface(heights, (6e-3, 4e-2), seam=cs.Tapered(0.2))
    across = cs.MeasuredSurface(heights.T, (4e-2, 6e-3), seam_across=cs.Tapered(0.2))
    for width, length in ((6e-3, 4e-2), (6e-3, 2e-2)):
        grids = cs.Grid((6, 40), (width, length)), cs.Grid((40, 6), (length, width))
        np.testing.assert_allclose(along.gap(grids[0]), across.gap(grids[1]).T, rtol=1e-9)
    cell_by_cell = cs.MeasuredSurface(heights.T, seam_across=cs.Mirrored()).gap(cs.Grid((80, 6), (1.0, 1.0)))
    np.testing.assert_array_equal(cell_by_cell, cell_by_cell[::-1])


def test_turned_surfaces_run_across() -> None:
    surface = cs.MeasuredSurface(HEIGHTS, GRID.extent)
    turned = surface.turned()
    across = turned.gap(cs.Grid(cells=(16, 24), extent=(1e-4, 2e-4)))
    np.testing.assert_array_equal(across, np.rot90(-HEIGHTS))
    assert turned.turned().turned().turned() == surface


def test_surfaces_are_equal_by_their_heights_and_all_that_is_done_to_them() -> None:
    surface = cs.MeasuredSurface(HEIGHTS, GRID.extent)
    same = cs.MeasuredSurface(np.asfortranarray(HEIGHTS), list(GRID.extent))  # type: ignore[arg-type]
    assert (surface, hash(surface), repr(surface)) == (same, hash(same), repr(same))
    for other in (
        cs.MeasuredSurface(HEIGHTS + 1e-20, GRID.extent),
        cs.MeasuredSurface(HEIGHTS.reshape(16, 24), GRID.extent),
        replace(surface, seam=cs.Mirrored()),
    ):
        assert other != surface
    assert pickle.loads(pickle.dumps(surface)) == surface


@pytest.mark.parametrize("names", [("width", "length"), ("x", "y"), ("row", "column")])
def test_coordinates_of_labelled_heights_give_the_sizes(names: tuple[str, str]) -> None:
    """Of as many cells as there are points, wherever the coordinates start, rising or falling."""
    heights = np.random.default_rng(0).standard_normal((6, 4))
    x, y = 1e-6 * np.arange(6) + 3, 2e-6 * np.arange(4) - 1
    array = xr.DataArray(heights, dims=names, coords={names[0]: x, names[1]: y})
    falling = array.isel({names[1]: slice(None, None, -1)})
    for labelled in (array, falling, *([array.T.chunk(3)] if names[0] != "row" else [])):
        surface = cs.MeasuredSurface(labelled)
        assert surface.extent == pytest.approx((6e-6, 8e-6))
        np.testing.assert_array_equal(surface.heights, heights)
    with pytest.raises(cs.InvalidInput, match=r"^MeasuredSurface\.extent is .*: leave it out"):
        cs.MeasuredSurface(array, extent=(1.0, 1.0))


def test_tiles_are_counted_along_the_length_first_and_keep_the_size_of_a_point() -> None:
    heights = np.arange(42.0).reshape(6, 7)
    surface = cs.MeasuredSurface(heights, (0.6, 1.4), trend="none")
    cut = surface.cut(cs.Tile((2, 3), 4))
    np.testing.assert_array_equal(cut.heights, [[23, 24], [30, 31], [37, 38]])
    assert cut.extent == pytest.approx((0.3, 0.4), rel=1e-12)
    with pytest.raises(cs.InvalidInput, match=r"Tile\.number is 6: give a number from 0 to 5"):
        cs.Tile((2, 3), 6)
    with pytest.raises(cs.InvalidInput, match="2 x 2"):
        cs.MeasuredSurface(np.zeros((5, 4)), trend="none").cut(cs.Tile((2, 3)))


X, Y = np.meshgrid(np.linspace(-3, 2, 13), np.linspace(0, 7, 9), indexing="ij")
U, V = X - X.mean(), Y - Y.mean()
# each form, and what it leaves: products of deviations from the mean are orthogonal to polynomials of lower degree
FORMS = {
    "none": (0 * X, X),
    "mean": (0 * X + 3, U),
    "plane": (3 - 2 * X + 0.5 * Y, U * V),
    "quadratic": (3 - 2 * X + 0.5 * Y + X**2 - 3 * X * Y + 2 * Y**2, (U**2 - (U**2).mean()) * V),
}


@pytest.mark.cases(4)
@pytest.mark.parametrize("trend", FORMS)
def test_trend_takes_off_its_own_form_and_no_more(trend: Any) -> None:
    form, beyond = FORMS[trend]
    np.testing.assert_allclose(cs.MeasuredSurface(form + beyond, trend=trend).prepared, beyond, rtol=0, atol=1e-12)


@pytest.mark.parametrize("angle", [0.0, 25.0, -40.0, 90.0])
@pytest.mark.parametrize("radius", [2e-3, -5e-3])
def test_a_cylinder_is_taken_off_with_its_radius_and_its_axis(angle: float, radius: float) -> None:
    x, y = np.meshgrid(np.linspace(-4e-4, 4e-4, 50), np.linspace(-5e-4, 5e-4, 60), indexing="ij")
    c, d = cos(np.radians(angle)), sin(np.radians(angle))
    across = x * c + y * d - 1e-4
    form = np.sign(radius) * np.sqrt(radius**2 - across**2) + 0.02 * (y * c - x * d)
    rough = 1e-8 * np.random.default_rng(0).standard_normal(x.shape)
    extent = 8e-4 * 50 / 49, 1e-3 * 60 / 59
    surface = cs.MeasuredSurface(form + rough, extent, trend="cylinder")
    np.testing.assert_allclose(surface.prepared, rough, atol=2e-9)
    computed = re.search(r"a cylinder of radius (\S+) mm, its axis at (\S+) degrees", surface.description)
    assert computed is not None, surface.description
    assert float(computed[1]) == pytest.approx(1e3 * radius, rel=1e-3)
    assert (float(computed[2]) - angle + 90) % 180 == pytest.approx(90, abs=0.1)  # an axis has no direction


def test_the_fit_of_a_cylinder_starts_along_its_axis(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("scipy.optimize.least_squares", lambda _, start, **options: SimpleNamespace(x=np.array(start)))
    x, y = (np.linspace(-1, 1, 60) for _ in range(2))
    form = -((x[:, None] * cos(pi / 9) + y * sin(pi / 9)) ** 2)
    assert "its axis at 20.0 degrees" in trend_text("cylinder", 1e-6 * form, (1e-3, 1e-3))


@pytest.mark.parametrize("wavelength", [20e-6, 80e-6])
def test_a_gaussian_filter_passes_waves_as_the_standard_says(wavelength: float) -> None:
    """ISO 16610-21, eq. 4: the mean line has 2^-(cutoff / wavelength)^2 of the amplitude, half of it at the cut-off."""
    step, middle = 1e-6, slice(140, 260)
    wave = np.cos(2 * pi * (np.arange(401) - 200) * step / wavelength)
    passed = 0.5 ** ((40e-6 / wavelength) ** 2)
    for heights, extent in ((wave[:, None], (401 * step, step)), (wave[None], (step, 401 * step))):
        low = cs.GaussianFilter(lambda_s=40e-6).filtered(heights, extent).ravel()
        high = cs.GaussianFilter(lambda_c=40e-6).filtered(heights, extent).ravel()
        np.testing.assert_allclose(low[middle], passed * wave[middle], atol=2e-3)
        np.testing.assert_allclose(high[middle], (1 - passed) * wave[middle], atol=2e-3)
    kept = cs.GaussianFilter(lambda_s=1e-5).filtered(np.full((30, 20), 7.0), (3e-5, 2e-5))  # up to the ends
    np.testing.assert_allclose(kept, 7.0, rtol=1e-13)


@pytest.mark.parametrize("count", [1, 2, 3])
@pytest.mark.parametrize("ends", ["periodic", "not-a-knot"])
def test_few_points_keep_their_means_and_have_no_more_trend_than_they_show(count: int, ends: Ends) -> None:
    few = np.random.default_rng(0).standard_normal((5, count)) + 7
    fine = cell_means(few, 1, extent=1.0, cells=4 * count, width=1.0, ends=ends)
    np.testing.assert_allclose(fine.reshape(5, count, 4).mean(axis=2), few, rtol=1e-13)
    assert abs(cs.MeasuredSurface(few, trend="quadratic").prepared.sum()) < 1e-12


AT_X, AT_Y = np.meshgrid(np.arange(12.0), np.arange(9.0), indexing="ij")
HARMONIC = 2 - AT_X + 3 * AT_Y + AT_X**2 - AT_Y**2 + AT_X * AT_Y  # on five points too
HOLES = np.zeros(HARMONIC.shape, dtype=bool)
HOLES[3:6, 4:7] = HOLES[8, 2] = True


def test_holes_in_a_harmonic_surface_are_filled_with_it() -> None:
    filled = cs.HarmonicFill().fill(np.where(HOLES, np.nan, HARMONIC))
    np.testing.assert_allclose(filled, HARMONIC, rtol=1e-12)
    corner = np.isnan(at_a_corner := np.where(np.arange(9) + np.arange(12)[:, None] < 3, np.nan, HARMONIC))
    filled = cs.HarmonicFill(up_to=0.5).fill(at_a_corner)
    assert HARMONIC[~corner].min() <= filled.min() <= filled.max() <= HARMONIC[~corner].max()


def test_missing_points_are_refused_with_their_count() -> None:
    heights = np.where(HOLES, np.nan, HARMONIC)
    with pytest.raises(cs.InvalidInput, match="has 10 missing of 108 points: fill them, or give"):
        cs.MeasuredSurface(heights)
    with pytest.raises(cs.InvalidInput, match=r"has 10 missing of 108 points, a fraction of 0\.093: give"):
        cs.MeasuredSurface(heights, missing=cs.HarmonicFill(up_to=0.05))
    assert cs.MeasuredSurface(heights, missing=cs.HarmonicFill())
    assert np.isnan(measurement(np.ma.masked_less(HARMONIC, -20))[0]).sum() == (HARMONIC < -20).sum() > 0
    assert np.isnan(measurement(np.array([[np.inf, 1.0, -np.inf]]))[0]).sum() == 2
