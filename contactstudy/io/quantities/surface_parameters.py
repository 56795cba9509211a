"""Parameters of a measured surface (ISO 25178-2, ISO 21920-2), as its picture and the command line list them."""

import numpy as np
from scipy.fft import irfft2, rfft2

from contactstudy.domain.grid import Array
from contactstudy.domain.validation import NotDefined, readable
from contactstudy.scene.surfaces.measured_surface import MeasuredSurface

# Height of the autocorrelation at which it counts as decayed (ISO 25178-2, default of Sal and Str).
DECAYED = 0.2
# Value, SI unit and label of each parameter, by the symbol of the standard.
Parameters = dict[str, tuple[float, str, str]]


def surface_parameters(surface: MeasuredSurface) -> Parameters:
    """Return parameters of the heights that enter a contact: form removed, filtered, holes filled, ends as measured.

    They are Sq, Sa, Sz, Ssk, Sku, Sdq, Sal and Str of a surface, and Rq, Ra, Rt, Rsk, Rku and Rdq of a profile, which
    is one point wide along an axis. Slopes are those between neighbouring points. Sal and Str are nan where the surface
    is too small for its waves, and left out of a plane.

    Raises
    ------
    NotDefined
        If the surface has no size.
    """
    if surface.extent is None:
        raise NotDefined("A surface without a size has no slopes: give its extent, on the command line --extent.")
    heights = surface.prepared - surface.prepared.mean()
    steps = [side / count for side, count in zip(surface.extent, heights.shape, strict=True)]
    is_profile = 1 in heights.shape
    letter, largest = ("R", "Rt") if is_profile else ("S", "Sz")
    rms = float(np.sqrt((heights**2).mean()))
    slopes = sum(
        (np.diff(heights, axis=axis) ** 2).mean() / step**2
        for axis, step in enumerate(steps)
        if heights.shape[axis] > 1
    )
    scaled = heights / (rms or 1.0)
    parameters: Parameters = {
        f"{letter}q": (rms, "m", "root mean square height"),
        f"{letter}a": (float(np.abs(heights).mean()), "m", "arithmetical mean height"),
        largest: (float(np.ptp(heights)), "m", "largest height"),
        f"{letter}sk": (float((scaled**3).mean()), "1", "skewness"),
        f"{letter}ku": (float((scaled**4).mean()), "1", "kurtosis"),
        f"{letter}dq": (float(np.sqrt(slopes)), "1", "root mean square slope"),
    }
    if not is_profile and rms:
        shortest, longest = _decay_lengths(scaled, steps)
        parameters["Sal"] = shortest, "m", "autocorrelation length"
        parameters["Str"] = shortest / longest, "1", "texture aspect ratio"
    return parameters


def parameters_text(parameters: Parameters) -> list[str]:
    """Return a line of text for each of the `parameters`: symbol, value with unit, and label."""
    return [
        f"{name:<4} {'none' if np.isnan(value) else readable(value, unit):<12} {label}"
        + ", which the surface is too small to show" * bool(np.isnan(value))
        for name, (value, unit, label) in parameters.items()
    ]


def _decay_lengths(heights: Array, steps: list[float]) -> tuple[float, float]:
    """Return the shortest and the longest distance [m] at which the autocorrelation falls to :data:`DECAYED`.

    The autocorrelation is the mean product of two `heights` (x, y) over all pairs of points at a distance, relative to
    that at no distance; neighbouring points are the `steps` [m] apart. It is computed by transforms padded with zeros,
    and followed along rays in 360 directions. A length that is not reached within half the surface is nan.
    """
    shape = heights.shape
    padded = [2 * count for count in shape]
    pairs = irfft2(np.abs(rfft2(np.ones(shape), padded)) ** 2, padded)
    products = irfft2(np.abs(rfft2(heights, padded)) ** 2, padded)
    half = [count // 2 for count in shape]
    lags = [np.arange(-count, count + 1) for count in half]
    correlation = (products / np.maximum(pairs, 0.5))[np.ix_(*lags)]
    correlation = correlation / correlation[half[0], half[1]]
    angles = np.linspace(0, np.pi, 360, endpoint=False)
    # along rays from the middle, in steps of an eighth of a point
    reach = np.hypot(half[0] * steps[0], half[1] * steps[1])
    radii = np.arange(0, reach, min(steps) / 8)
    x = half[0] + np.outer(np.cos(angles), radii) / steps[0]
    y = half[1] + np.outer(np.sin(angles), radii) / steps[1]
    from scipy.ndimage import map_coordinates  # imported only where it is needed

    along = map_coordinates(correlation, [x, y], order=1, cval=np.nan)
    has_decayed = (along <= DECAYED).any(axis=1)
    if not has_decayed.any():
        return np.nan, np.nan
    after = (along[has_decayed] <= DECAYED).argmax(axis=1)
    rows = np.flatnonzero(has_decayed)
    high, low = along[rows, after - 1], along[rows, after]
    lengths = radii[after - 1] + (high - DECAYED) / (high - low) * radii[1]
    return float(lengths.min()), float(lengths.max()) if has_decayed.all() else np.nan
