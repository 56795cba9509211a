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


def rms_slopes(heights: np.ndarray, extent: tuple[float, float]) -> np.ndarray:
    """Along each axis, by the derivatives of the trigonometric polynomial that the heights are samples of."""
    waves = np.fft.fft2(heights, norm="forward")
    kx, ky = (2 * np.pi * np.fft.fftfreq(n, size / n) for n, size in zip(heights.shape, extent, strict=True))
    return np.sqrt([(np.abs(waves * k) ** 2).sum() for k in (kx[:, None], ky)])


def test_each_wave_has_the_density_of_the_formula() -> None:
    """Of extents of several roll-offs, where the density hardly varies between neighbouring waves."""
    extent = (4e-4, 3e-4)
    heights = ROUGH.gap(cs.Grid((128, 96), extent))
    powers = np.abs(np.fft.fft2(heights, norm="forward")) ** 2
    kx, ky, fractions = plane(ROUGH, extent)
    computed = powers[np.round(kx * extent[0]).astype(int), np.round(ky * extent[1]).astype(int)]
    np.testing.assert_allclose(computed / 2e-7**2, fractions, rtol=0.03, atol=1e-12)
    assert heights.std() == pytest.approx(2e-7 * np.sqrt(fractions.sum()), rel=1e-3)
    assert abs(heights.mean()) < 1e-20


@pytest.mark.parametrize("roll_off", [1e-3, 1e-2])
def test_a_roll_off_beyond_the_extent_leaves_the_slopes_as_they_are(roll_off: float) -> None:
    """The extent holds the part of the height in its own waves, which falls with the power H of the roll-off."""
    surface, extent = replace(ROUGH, roll_off=roll_off, cut_off=4e-6), (2e-4, 2e-4)
    heights = surface.gap(cs.Grid((128, 128), extent))
    ratio = heights.std() / replace(surface, roll_off=2 * roll_off).gap(cs.Grid((128, 128), extent)).std()
    assert ratio == pytest.approx(2**0.8, rel=0.01)
    kx, ky, fractions = plane(surface, extent)
    slope = 2 * np.pi * 2e-7 * np.sqrt((fractions * (kx**2 + ky**2)).sum())
    assert np.hypot(*rms_slopes(heights, extent)) == pytest.approx(slope, rel=0.05)


def test_an_answer_says_what_part_of_the_height_its_extent_holds() -> None:
    long, square = replace(ROUGH, roll_off=2e-4), cs.Grid((32, 32), (1e-4, 1e-4))
    scene = cs.Scene(cs.LineLoad(1e5), (STEEL, STEEL), (cs.Cylinder(0.01), long))
    held = long.gap(square).std() / 2e-7
    assert held < 0.9
    for said in (cs.solve(scene, square).error, cs.plan(scene, grid=square)):
        assert any(f"hold {held:.2g} of its rms height of 200 nm" in text for text in said.warnings)
    assert not long.left_out(cs.Grid((32, 32), (4e-4, 4e-4)))


@pytest.mark.parametrize(("cut_off", "same"), [(1e-5 * (1 - 1e-12), 1 - 1e-12), (5e-6, 0.98)])
def test_a_shorter_cut_off_adds_detail_to_the_same_surface(cut_off: float, same: float) -> None:
    fine = grid(128, 64)
    computed = [surface.gap(fine).ravel() for surface in (ROUGH, replace(ROUGH, cut_off=cut_off))]
    assert same <= np.corrcoef(*computed)[0, 1]
    other = replace(ROUGH, seed=2**70).gap(fine).ravel()
    assert abs(np.corrcoef(computed[0], other)[0, 1]) < 0.3


@pytest.mark.parametrize(("cells", "times"), [((64, 48), 3), ((16, 12), 9)])
def test_a_finer_grid_shows_the_same_surface(cells: tuple[int, int], times: int) -> None:
    """A wave sampled thrice as finely is hit at every third centre, on a grid too coarse for it too."""
    coarse, fine = ROUGH.gap(grid(*cells)), ROUGH.gap(grid(times * cells[0], times * cells[1]))
    middles = slice(times // 2, None, times)
    np.testing.assert_allclose(fine[middles, middles], coarse, rtol=0, atol=1e-13 * 2e-7 * 64)


def test_a_wider_grid_shows_the_same_surface_of_an_extent_of_its_own() -> None:
    own = replace(ROUGH, extent=(2e-4, 1e-4))
    narrow = own.gap(grid(64, 32))
    np.testing.assert_array_equal(narrow, ROUGH.gap(grid(64, 32)))
    for more in (2, 64):  # cells on each side
        wide = cs.Grid(cells=(64 + 2 * more, 32), extent=(2e-4 * (64 + 2 * more) / 64, 1e-4))
        heights = own.gap(wide)
        np.testing.assert_allclose(heights[more:-more], narrow, rtol=0, atol=1e-12 * 2e-7)
    # beyond its extent it starts again
    np.testing.assert_allclose(heights[:64], heights[64:128], rtol=0, atol=1e-12 * 2e-7)


@pytest.mark.parametrize("peklenik", [0.2, 5.0])
def test_lay_stretches_the_surface_along_itself_and_no_wave_is_shorter_than_the_cut_off(peklenik: float) -> None:
    """The ratio of rms slopes is that of the lengths."""
    square = cs.Grid(cells=(256, 256), extent=(3e-3, 3e-3))
    lay = replace(ROUGH, roll_off=4e-5, cut_off=3e-5, peklenik=peklenik)
    heights = lay.gap(square)
    assert heights.std() == pytest.approx(2e-7, rel=0.01)
    across, along = rms_slopes(heights, square.extent)
    assert along / across == pytest.approx(peklenik, rel=0.02)
    spectrum, k = np.abs(np.fft.fft2(heights)), np.fft.fftfreq(256, 3e-3 / 256)
    assert spectrum[np.hypot(k[:, None], k) * 3e-5 > 1 + 1e-12].max() < 1e-12 * spectrum.max()


def test_the_rms_slope_and_the_mean_height_are_what_was_asked() -> None:
    wide = cs.Grid((256, 256), (4e-4, 4e-4))
    slopes = rms_slopes(replace(ROUGH, rms=RmsSlope(0.05)).gap(wide), wide.extent)
    assert np.hypot(*slopes) == pytest.approx(0.05, rel=0.01)
    by_sa = replace(ROUGH, rms=cs.Sa(4e-7)).gap(wide)
    np.testing.assert_array_equal(by_sa, replace(ROUGH, rms=4e-7 * np.sqrt(np.pi / 2)).gap(wide))
    # of some sixty independent heights, so that the mean varies by a tenth
    assert np.abs(by_sa).mean() == pytest.approx(4e-7, rel=0.1)


def test_a_seed_keeps_its_surface() -> None:
    """Heights of a release, so that studies can be repeated."""
    heights = ROUGH.gap(grid(64, 48))
    first = [1.6181056345384904e-07, -1.6806476276436883e-07, 8.3331545735676e-08]
    assert [heights[0, 0], heights[10, 30], heights[-1, -1]] == pytest.approx(first, rel=1e-11)
