from math import pi, sqrt

import numpy as np
import pytest
from scipy import ndimage

import contactstudy as cs
from contactstudy.io.quantities.surface_parameters import parameters_text, surface_parameters

NOISE = np.random.default_rng(0).standard_normal((300, 360))
SMOOTH = 1e-6 * ndimage.gaussian_filter(NOISE, (3, 6))


def test_a_sine_has_the_parameters_of_the_books() -> None:
    """Whitehouse (1994): Rq = A / sqrt 2, Ra = 2 A / pi, skewness 0, kurtosis 3/2, slope sqrt 2 pi A / wavelength."""
    wave = 1e-6 * np.sin(2 * pi * np.arange(400) / 50)[:, None]
    expected = {
        "Rq": 1e-6 / sqrt(2), "Ra": 2e-6 / pi, "Rt": 2e-6, "Rsk": 0.0, "Rku": 1.5, "Rdq": sqrt(2) * pi / 50,
    }  # fmt: skip
    found = surface_parameters(cs.MeasuredSurface(wave, (4e-4, 1e-6)))
    assert {name: value for name, (value, *_) in found.items()} == pytest.approx(expected, rel=3e-3, abs=1e-12)


def test_the_autocorrelation_length_is_that_of_a_gaussian_one() -> None:
    """Noise smoothed by a Gaussian of deviation s has exp(-(r / 2 s)^2), which falls to 0.2 at 2 s sqrt(ln 5)."""
    found = surface_parameters(cs.MeasuredSurface(SMOOTH, (3e-4, 3.6e-4)))
    assert found["Sal"][0] == pytest.approx(6e-6 * sqrt(np.log(5)), rel=0.1)
    assert found["Str"][0] == pytest.approx(0.5, rel=0.2)


def test_a_groove_along_the_surface_has_no_longest_correlation_and_the_text_says_so() -> None:
    grooved = np.tile(1e-6 * np.sin(np.arange(60) / 3)[:, None], (1, 40))
    found = surface_parameters(cs.MeasuredSurface(grooved, (6e-5, 4e-5)))
    assert np.isnan(found["Str"][0])
    assert any("too small" in line for line in parameters_text(found))
