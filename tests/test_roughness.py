from dataclasses import replace

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.roughness import Roughness

ROUGH = Roughness(rms=2e-7, hurst=0.8, roll_off=5e-5, cut_off=1e-5, seed=3)


def grid(nx: int, ny: int) -> cs.Grid:
    return cs.Grid(cells=(nx, ny), extent=(2e-4, 1e-4))


def test_rms_height_is_what_was_asked() -> None:
    heights = ROUGH.gap(grid(128, 64))
    assert heights.std() == pytest.approx(2e-7, rel=1e-12)
    assert abs(heights.mean()) < 1e-20


def test_a_finer_grid_shows_the_same_surface() -> None:
    """A wave sampled thrice as finely is hit at every third centre."""
    coarse, fine = ROUGH.gap(grid(64, 48)), ROUGH.gap(grid(192, 144))
    np.testing.assert_allclose(fine[1::3, 1::3], coarse, rtol=0, atol=1e-13 * 2e-7 * 64)


def test_a_grid_too_coarse_still_samples_the_same_surface() -> None:
    coarse, fine = ROUGH.gap(grid(16, 12)), ROUGH.gap(grid(144, 108))
    np.testing.assert_allclose(fine[4::9, 4::9], coarse, rtol=0, atol=1e-13 * 2e-7 * 64)


def test_spectrum_falls_with_the_hurst_exponent() -> None:
    wide = replace(ROUGH, roll_off=2e-4, cut_off=2e-6, rms=1.0)
    powers = []
    for seed in range(20):
        spectrum = np.abs(np.fft.fft2(replace(wide, seed=seed).gap(grid(256, 128)))) ** 2
        powers.append(spectrum[4:60, 0])
    k = np.arange(4, 60)
    rate = np.polyfit(np.log(k), np.log(np.mean(powers, axis=0)), 1)[0]
    assert rate == pytest.approx(-2 * 1.8, abs=0.2)


def test_no_height_is_no_surface() -> None:
    assert not replace(ROUGH, rms=0.0).gap(grid(16, 8)).any()


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("rms", -1e-9),
        ("rms", np.nan),
        ("hurst", 0.0),
        ("hurst", 1.0),
        ("cut_off", 0.0),
        ("roll_off", 1e-6),
        ("seed", -1),
    ],
)
def test_a_surface_that_cannot_be_is_refused(field: str, value: float) -> None:
    with pytest.raises(cs.InvalidInput, match=rf"^Roughness\.{field} is "):
        replace(ROUGH, **{field: value})


def test_a_surface_without_room_for_a_wave_is_refused() -> None:
    small = cs.Grid(cells=(32, 32), extent=(5e-6, 5e-6))
    with pytest.raises(cs.InvalidInput, match=r"below the grid's extent"):
        ROUGH.gap(small)
    assert not replace(ROUGH, rms=0.0).gap(small).any()
