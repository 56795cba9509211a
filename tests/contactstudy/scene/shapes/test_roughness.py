from dataclasses import replace

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.scene.shapes.roughness import RmsSlope, Roughness

ROUGH = Roughness(rms=2e-7, hurst=0.8, roll_off=5e-5, cut_off=1e-5, seed=3)


def grid(nx: int, ny: int) -> cs.Grid:
    return cs.Grid(cells=(nx, ny), extent=(2e-4, 1e-4))


def test_rms_height_is_what_was_asked() -> None:
    heights = ROUGH.gap(grid(128, 64))
    assert heights.std() == pytest.approx(2e-7, rel=1e-12)
    assert abs(heights.mean()) < 1e-20


@pytest.mark.parametrize(("cells", "times"), [((64, 48), 3), ((16, 12), 9)])
def test_a_finer_grid_shows_the_same_surface(cells: tuple[int, int], times: int) -> None:
    """A wave sampled thrice as finely is hit at every third centre, on a grid too coarse for it too."""
    coarse, fine = ROUGH.gap(grid(*cells)), ROUGH.gap(grid(times * cells[0], times * cells[1]))
    middles = slice(times // 2, None, times)
    np.testing.assert_allclose(fine[middles, middles], coarse, rtol=0, atol=1e-13 * 2e-7 * 64)


def test_spectrum_falls_with_the_hurst_exponent() -> None:
    wide = replace(ROUGH, roll_off=2e-4, cut_off=2e-6, rms=1.0)
    powers = []
    for seed in range(20):
        spectrum = np.abs(np.fft.fft2(replace(wide, seed=seed).gap(grid(256, 128)))) ** 2
        powers.append(spectrum[4:60, 0])
    k = np.arange(4, 60)
    rate = np.polyfit(np.log(k), np.log(np.mean(powers, axis=0)), 1)[0]
    assert rate == pytest.approx(-2 * 1.8, abs=0.2)


def test_a_surface_without_room_for_a_wave_is_refused() -> None:
    small = cs.Grid(cells=(32, 32), extent=(5e-6, 5e-6))
    with pytest.raises(cs.InvalidInput, match=r"below the grid's extent"):
        ROUGH.gap(small)
    assert not replace(ROUGH, rms=0.0).gap(small).any()


def test_rms_slope_is_what_was_asked() -> None:
    """By the derivatives of the trigonometric polynomial that the heights are samples of."""
    wide, fine = grid(128, 64).extent, (256, 128)
    heights = replace(ROUGH, rms=RmsSlope(0.05)).gap(cs.Grid(cells=fine, extent=wide))
    kx, ky = (2j * np.pi * np.fft.fftfreq(n, size / n) for n, size in zip(fine, wide, strict=True))
    waves = np.fft.fft2(heights)
    slopes = [np.fft.ifft2(k * waves).real for k in (kx[:, None], ky)]
    assert np.sqrt((slopes[0] ** 2 + slopes[1] ** 2).mean()) == pytest.approx(0.05, rel=1e-12)


def test_surface_by_its_slope_is_the_one_by_its_height_scaled() -> None:
    by_slope, by_height = (
        replace(ROUGH, rms=RmsSlope(0.05)).gap(grid(64, 32)),
        ROUGH.gap(grid(64, 32)),
    )
    np.testing.assert_allclose(by_slope * (2e-7 / by_slope.std()), by_height, rtol=1e-9, atol=1e-20)


@pytest.mark.parametrize("peklenik", [0.2, 5.0])
def test_lay_stretches_the_surface_along_itself(peklenik: float) -> None:
    """Below the roll-off, the ratio of rms slopes is that of the lengths, but for the few waves' scatter."""
    square = cs.Grid(cells=(128, 128), extent=(1e-3, 1e-3))
    ratios = []
    for seed in range(20):
        lay = replace(ROUGH, roll_off=4e-5, cut_off=3e-5, peklenik=peklenik, seed=seed)
        heights = lay.gap(square)
        assert heights.std() == pytest.approx(2e-7, rel=1e-12)
        across, along = (np.diff(heights, axis=axis).std() for axis in (0, 1))
        ratios.append(along / across)
    assert np.mean(ratios) == pytest.approx(
        peklenik, rel=4 * np.std(ratios) / peklenik / 20**0.5 + 0.03
    )


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


def test_a_period_of_two_lengths_shows_the_surface_twice() -> None:
    own = replace(ROUGH, extent=(2e-4, 1e-4))
    twice = own.gap(cs.Grid(cells=(64, 64), extent=(2e-4, 2e-4)))
    np.testing.assert_allclose(twice[:, :32], twice[:, 32:], rtol=0, atol=1e-12 * 2e-7)
    np.testing.assert_allclose(twice.std(), 2e-7, rtol=1e-12)


def test_a_seed_keeps_its_surface() -> None:
    """Heights of the first release, so that studies can be repeated."""
    heights = ROUGH.gap(grid(64, 48))
    found = [heights[0, 0], heights[10, 30], heights[-1, -1]]
    first = [-2.8157134508736897e-08, -6.989830739011437e-08, -2.5776133684319015e-08]
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
