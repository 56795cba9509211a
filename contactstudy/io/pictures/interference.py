"""Colours of a film between two reflecting surfaces, as an optical test rig shows them."""

from collections.abc import Sequence

import numpy as np

from contactstudy.domain.checks import in_range
from contactstudy.domain.fields import Array

# White light: wavelengths [nm], of equal energy, so close that a film of 20 um has no fringes.
WHITE = np.arange(380.0, 781.0, 2.0)
# The CIE colour matching functions of 1931 as sums of piecewise Gaussians by Wyman, Sloan & Shirley (2013):
# amplitude, centre, width to the left and to the right [nm].
COLOUR_MATCHING = (
    ((1.056, 599.8, 37.9, 31.0), (0.362, 442.0, 16.0, 26.7), (-0.065, 501.1, 20.4, 26.2)),
    ((0.821, 568.8, 46.9, 40.5), (0.286, 530.9, 16.3, 31.1)),
    ((1.217, 437.0, 11.8, 36.0), (0.681, 459.0, 26.0, 13.8)),
)
# CIE XYZ to linear sRGB (IEC 61966-2-1).
TO_RGB = np.array(
    [[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]]
)


def interference_colours(
    film: Array, refractive_index: float = 1.5, wavelengths: Sequence[float] | None = None
) -> Array:
    """Return the colours of two-beam interference in a film at normal incidence, as sRGB from 0 to 1.

    Both beams are equally bright, and half a wave apart where the film vanishes, so that such places are dark. The
    intensity is ``sin^2(2 pi n h / wavelength)`` (Tolansky 1973), white where all light is reflected.

    Parameters
    ----------
    film
        Film thickness [m], of any shape.
    refractive_index
        Refractive index n of the lubricant, above 0.
    wavelengths
        Wavelengths [m] of a source with lines of equal brightness; white light if None.

    Returns
    -------
    Array
        Red, green and blue in a last dimension.
    """
    remedy = "give an index above 0, such as 1.5"
    index = in_range("plot.refractive_index", refractive_index, remedy)
    lines = WHITE if wavelengths is None else np.array(
        [
            1e9 * in_range("plot.wavelengths", wavelength, "give wavelengths [m] such as 550e-9")
            for wavelength in wavelengths
        ]
    )  # fmt: skip
    weights = colour_matching(lines) @ TO_RGB.T
    source = weights.sum(axis=0)
    weights /= source if wavelengths is None else source.max()
    linear = np.zeros((*np.shape(film), 3))
    for line, weight in zip(lines, weights, strict=True):
        reflected = np.sin(2e9 * np.pi * index * np.asarray(film) / line) ** 2
        linear += reflected[..., None] * weight
    linear = np.clip(linear, 0, 1)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def colour_matching(wavelengths: Array) -> Array:
    """Return the colour matching functions (wavelength, 3) at wavelengths [nm]."""
    functions = []
    for gaussians in COLOUR_MATCHING:
        total = np.zeros_like(wavelengths)
        for amplitude, centre, width_below, width_above in gaussians:
            width = np.where(wavelengths < centre, width_below, width_above)
            total += amplitude * np.exp(-(((wavelengths - centre) / width) ** 2) / 2)
        functions.append(total)
    return np.stack(functions, axis=-1)
