from dataclasses import replace

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.scene.shapes.roughness import RmsSlope, Roughness
from tests.conftest import STEEL

ROUGH = Roughness(rms=2e-7, hurst=0.8, roll_off=5e-5, cut_off=1e-5, seed=3)


def grid(nx: int, ny: int) -> cs.Grid:
    return cs.Grid(cells=(nx, ny), extent=(2e-4, 1e-4))


def plane(surface: Roughness, extent: tuple[float, float]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return all waves of an extent, and the part of the mean square height that each has by its formula."""
    counts = [int(side / surface.cut_off + 1e-9) for side in extent]
    m, n = np.meshgrid(*(np.arange(-count, count + 1) for count in counts), indexing="ij")
    kx, ky = m / extent[0], n / extent[1]
    k = np.hypot(kx, ky)
    low, high, p = 1 / surface.roll_off, 1 / surface.cut_off, 2 * (1 + surface.hurst)
    whole = np.pi * low**2 + 2 * np.pi * low**p * (low ** (2 - p) - high ** (2 - p)) / (p - 2)
    density = np.where(k <= high * (1 + 1e-9), np.maximum(k / low, 1) ** -p / whole, 0)
    density[k == 0] = 0
    return kx, ky, density / (extent[0] * extent[1])


def test_each_wave_has_the_density_of_the_formula() -> None:
    """Of extents of several roll-offs, where the density hardly varies between neighbouring waves."""
    extent = (4e-4, 3e-4)
    heights = ROUGH.gap(cs.Grid((128, 96), extent))
    powers = np.abs(np.fft.fft2(heights, norm="forward")) ** 2
    kx, ky, fractions = plane(ROUGH, extent)
    found = powers[np.round(kx * extent[0]).astype(int), np.round(ky * extent[1]).astype(int)]
    np.testing.assert_allclose(found / 2e-7**2, fractions, rtol=0.03, atol=1e-12)
    assert heights.std() == pytest.approx(2e-7 * np.sqrt(fractions.sum()), rel=1e-3)
    assert abs(heights.mean()) < 1e-20


@pytest.mark.parametrize("roll_off", [1e-3, 1e-2])
def test_a_roll_off_beyond_the_extent_leaves_the_slopes_as_they_are(roll_off: float) -> None:
    """The extent holds the part of the height in its own waves, which falls with the power H of the roll-off."""
    surface = replace(ROUGH, roll_off=roll_off, cut_off=4e-6)
    extent = (2e-4, 2e-4)
    heights = surface.gap(cs.Grid((128, 128), extent))
    ratio = heights.std() / replace(surface, roll_off=2 * roll_off).gap(cs.Grid((128, 128), extent)).std()
    assert ratio == pytest.approx(2**0.8, rel=0.01)
    kx, ky, fractions = plane(surface, extent)
    slope = 2 * np.pi * 2e-7 * np.sqrt((fractions * (kx**2 + ky**2)).sum())
    waves = np.fft.fft2(heights, norm="forward")
    k = 2 * np.pi * np.fft.fftfreq(128, extent[0] / 128)
    assert np.sqrt((np.abs(waves * np.hypot(k[:, None], k)) ** 2).sum()) == pytest.approx(slope, rel=0.05)


def test_an_answer_says_what_part_of_the_height_its_extent_holds() -> None:
    long, square = replace(ROUGH, roll_off=2e-4), cs.Grid((32, 32), (1e-4, 1e-4))
    scene = cs.Scene(cs.LineLoad(1e5), (STEEL, STEEL), (cs.Cylinder(0.01), long))
    held = long.gap(square).std() / 2e-7
    assert held < 0.9
    both = cs.solve(scene, square).error, cs.plan(scene, grid=square)
    for said in both:
        assert any(f"hold {held:.2g} of its rms height of 200 nm" in text for text in said.warnings)
    assert not long.left_out(cs.Grid((32, 32), (4e-4, 4e-4)))


@pytest.mark.parametrize("narrow", [2e-5, 1e-4])
def test_a_narrow_extent_holds_no_more_than_the_whole_height(narrow: float) -> None:
    """Waves along the length stand for a strip of wave numbers as wide as one over the width."""
    tall = ROUGH.gap(cs.Grid((32, 1024), (narrow, 1e-3))).std()
    assert 0.7 * 2e-7 < tall < 2e-7
    assert ROUGH.gap(cs.Grid((1024, 32), (1e-3, narrow))).std() == pytest.approx(tall, rel=1e-9)


@pytest.mark.parametrize(("cut_off", "same"), [(1e-5 * (1 - 1e-12), 1 - 1e-12), (5e-6, 0.98)])
def test_a_shorter_cut_off_adds_detail_to_the_same_surface(cut_off: float, same: float) -> None:
    fine = grid(128, 64)
    found = [surface.gap(fine).ravel() for surface in (ROUGH, replace(ROUGH, cut_off=cut_off))]
    assert same <= np.corrcoef(*found)[0, 1]
    other = replace(ROUGH, seed=2**70).gap(fine).ravel()
    assert abs(np.corrcoef(found[0], other)[0, 1]) < 0.3


@pytest.mark.parametrize(("cells", "times"), [((64, 48), 3), ((16, 12), 9)])
def test_a_finer_grid_shows_the_same_surface(cells: tuple[int, int], times: int) -> None:
    """A wave sampled thrice as finely is hit at every third centre, on a grid too coarse for it too."""
    coarse, fine = ROUGH.gap(grid(*cells)), ROUGH.gap(grid(times * cells[0], times * cells[1]))
    middles = slice(times // 2, None, times)
    np.testing.assert_allclose(fine[middles, middles], coarse, rtol=0, atol=1e-13 * 2e-7 * 64)


def test_a_surface_without_room_for_a_wave_is_refused() -> None:
    small = cs.Grid(cells=(32, 32), extent=(5e-6, 5e-6))
    with pytest.raises(cs.InvalidInput, match=r"below the grid's extent"):
        ROUGH.gap(small)
    assert not replace(ROUGH, rms=0.0).gap(small).any()


def test_rms_slope_is_what_was_asked() -> None:
    """By the derivatives of the trigonometric polynomial that the heights are samples of."""
    wide, fine = (4e-4, 4e-4), (256, 256)
    heights = replace(ROUGH, rms=RmsSlope(0.05)).gap(cs.Grid(cells=fine, extent=wide))
    kx, ky = (2j * np.pi * np.fft.fftfreq(n, size / n) for n, size in zip(fine, wide, strict=True))
    waves = np.fft.fft2(heights)
    slopes = [np.fft.ifft2(k * waves).real for k in (kx[:, None], ky)]
    assert np.sqrt((slopes[0] ** 2 + slopes[1] ** 2).mean()) == pytest.approx(0.05, rel=0.01)


@pytest.mark.parametrize("peklenik", [0.2, 5.0])
def test_lay_stretches_the_surface_along_itself(peklenik: float) -> None:
    """The ratio of rms slopes is that of the lengths."""
    square = cs.Grid(cells=(256, 256), extent=(3e-3, 3e-3))
    lay = replace(ROUGH, roll_off=4e-5, cut_off=3e-5, peklenik=peklenik)
    heights = lay.gap(square)
    assert heights.std() == pytest.approx(2e-7, rel=0.01)
    powers, k = np.abs(np.fft.fft2(heights)) ** 2, np.fft.fftfreq(256)
    across, along = (powers * k[:, None] ** 2).sum(), (powers * k**2).sum()
    assert np.sqrt(along / across) == pytest.approx(peklenik, rel=0.02)


def test_no_wave_is_shorter_than_the_cut_off_whatever_the_lay() -> None:
    square = cs.Grid(cells=(128, 128), extent=(2e-4, 2e-4))
    for peklenik in (0.3, 1.0, 3.0):
        spectrum = np.abs(np.fft.fft2(replace(ROUGH, peklenik=peklenik).gap(square)))
        k = np.fft.fftfreq(128, 2e-4 / 128)
        short = np.hypot(k[:, None], k) > 1e5 * (1 + 1e-12)
        assert spectrum[short].max() < 1e-12 * spectrum.max()


def test_a_wider_grid_shows_the_same_surface_of_an_extent_of_its_own() -> None:
    own = replace(ROUGH, extent=(2e-4, 1e-4))
    narrow = own.gap(grid(64, 32))
    np.testing.assert_array_equal(narrow, ROUGH.gap(grid(64, 32)))
    for more in (2, 16, 64):  # cells on each side
        wide = cs.Grid(cells=(64 + 2 * more, 32), extent=(2e-4 * (64 + 2 * more) / 64, 1e-4))
        heights = own.gap(wide)
        np.testing.assert_allclose(heights[more:-more], narrow, rtol=0, atol=1e-12 * 2e-7)
    # beyond its extent it starts again
    np.testing.assert_allclose(heights[:64], heights[64:128], rtol=0, atol=1e-12 * 2e-7)


def test_a_seed_keeps_its_surface() -> None:
    """Heights of a release, so that studies can be repeated."""
    heights = ROUGH.gap(grid(64, 48))
    found = [heights[0, 0], heights[10, 30], heights[-1, -1]]
    first = [1.6181056345384904e-07, -1.6806476276436883e-07, 8.3331545735676e-08]
    assert found == pytest.approx(first, rel=1e-11)
    assert Roughness(2e-7, 0.8, 5e-5, 1e-5) == replace(ROUGH, seed=0)


def test_sa_is_the_mean_height_of_a_gaussian_surface() -> None:
    grid = cs.Grid((256, 256), (1e-3, 1e-3))
    by_sa = cs.Roughness(cs.Sa(4e-7), hurst=0.8, roll_off=2e-4, cut_off=2e-5, seed=3)
    by_rms = replace(by_sa, rms=4e-7 * np.sqrt(np.pi / 2))
    np.testing.assert_array_equal(by_sa.gap(grid), by_rms.gap(grid))
    # of some hundred independent heights, so that the mean varies by a tenth
    assert np.abs(by_sa.gap(grid)).mean() == pytest.approx(4e-7, rel=0.1)
    assert not cs.Sa(0.0)
