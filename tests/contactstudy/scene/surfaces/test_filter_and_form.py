import re
from math import cos, pi, sin

import numpy as np
import pytest

import contactstudy as cs

COUNT, STEP = 401, 1e-6
PLACES = (np.arange(COUNT) - COUNT // 2) * STEP
MIDDLE = slice(COUNT // 2 - 60, COUNT // 2 + 60)


@pytest.mark.parametrize("wavelength", [20e-6, 40e-6, 80e-6])
def test_a_gaussian_filter_passes_waves_as_the_standard_says(wavelength: float) -> None:
    """ISO 16610-21, eq. 4: the mean line has 2^-(cutoff / wavelength)^2 of the amplitude, half of it at the cut-off."""
    wave = np.cos(2 * pi * PLACES / wavelength)
    size = COUNT * STEP
    passed = 0.5 ** ((40e-6 / wavelength) ** 2)
    for heights, extent in ((wave[:, None], (size, STEP)), (wave[None], (STEP, size))):
        low = cs.GaussianFilter(lambda_s=40e-6).filtered(heights, extent).ravel()
        high = cs.GaussianFilter(lambda_c=40e-6).filtered(heights, extent).ravel()
        np.testing.assert_allclose(low[MIDDLE], passed * wave[MIDDLE], atol=2e-3)
        np.testing.assert_allclose(high[MIDDLE], (1 - passed) * wave[MIDDLE], atol=2e-3)


def test_a_gaussian_filter_keeps_a_constant_up_to_the_ends() -> None:
    flat = np.full((30, 20), 7.0)
    kept = cs.GaussianFilter(lambda_s=1e-5).filtered(flat, (3e-5, 2e-5))
    np.testing.assert_allclose(kept, flat, rtol=1e-13)


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
    found = re.search(r"a cylinder of radius (\S+) mm, its axis at (\S+) degrees", surface.description)
    assert found is not None, surface.description
    assert float(found[1]) == pytest.approx(1e3 * radius, rel=1e-3)
    assert (float(found[2]) - angle + 90) % 180 == pytest.approx(90, abs=0.1)  # an axis has no direction


def test_a_cylinder_is_taken_off_a_profile() -> None:
    x = np.linspace(-5e-4, 5e-4, 200)
    form = np.sqrt(5e-3**2 - x**2)[:, None]
    surface = cs.MeasuredSurface(form, (1e-3 * 200 / 199, 1e-6), trend="cylinder")
    np.testing.assert_allclose(surface.prepared, 0, atol=1e-12)
    assert "a cylinder of radius 5 mm, its axis at 0.0 degrees" in surface.description
