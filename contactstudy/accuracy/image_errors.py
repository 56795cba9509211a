"""Image errors: those due to the images that a padding leaves out."""

import numpy as np

from contactstudy.domain.checks import NotDefined
from contactstudy.domain.fields import Array
from contactstudy.domain.grid import ExactPeriodicity, Grid, Padding, Paddings

# A cylinder that is cut off by a domain has neighbours; a sphere, or a roller that ends, may have none.
IMAGES_REMEDY = (
    "give ExactPeriodicity along their axis, or for a body without neighbours ZeroPadding and a grid that holds its "
    "contact"
)
# L1 change of Hertz's ellipse over the small fraction of its half-width by which it is made narrower, or shifted.
L1_OVER_NARROWING = 4 / np.pi
# The line load of a window centred on the domain varies by END_VARIATION (a / L)^0.7 / (2 n + 1)^2 in the mean
# over the length: measured for L from 0.15 to 9.6 half-widths, on 32 to 288 cells.
END_VARIATION, END_VARIATION_POWER = 0.5, 0.7
# Bound over the errors of a roller that ends, by the law of an endless contact with the larger of the half-widths across
# and along: they were at most 1.31 times that on 336 sharp and Lundberg rollers of 2.5 to 30 half-widths, on grids of 1
# to 3 times the length with 1 to 4 images on either axis.
ENDS_MARGIN = 1.5


def image_errors(pressure: Array, grid: Grid, paddings: Paddings, *, ends_along: bool = False) -> tuple[float, float]:
    """Return the relative errors of the peak pressure and of the pressure in L1 due to images left out by a padding.

    A window that reaches D to each side takes ``x^2 / (2 D^2)`` from the logarithm of each image row, and so makes the
    contact, of half-width ``a = 2 rms(x)``, too highly curved by the factor ``1 + a^2 / (4 D^2)``. A window centred on
    the domain also misses more at its ends, by ``-ln(1 - (2 y / L)^2 / (2 n + 1)^2)``: under that kink the pressure
    rises, j cells from the end by the fraction ``(2 / pi) (a / L) ln(cells / (2 j + 1)) / (2 n + 1)^2``. Without any
    images the solution's own line load shows the error at the ends. The errors are zero where all images are summed, or
    a length without images holds the whole contact. A body that ends along the length is not uniform along it, so that
    the images bend it along both axes, by its larger half-width, within `ENDS_MARGIN`.

    Parameters
    ----------
    pressure
        Pressure (x, y).
    grid
        Its grid.
    paddings
        Paddings (across, along).
    ends_along
        Whether a body ends along the length, where contact may reach the ends of a length without images.

    Raises
    ------
    NotDefined
        For a window on one axis with images on the other.
    """
    across, along = paddings
    if _counts_images(across):
        pressure, (along, across) = pressure.T, (across, along)
        period, positions, others = grid.extent[0], grid.y, grid.x
    else:
        period, positions, others = grid.extent[1], grid.x, grid.y
    reaches_ends = not ends_along and _reaches_ends(pressure)
    free = not (hasattr(along, "images") or along.wraps or reaches_ends)
    if along.window is None or (free and len(along.window) == 1):
        return 0.0, 0.0
    if across.window is None or _counts_images(across) or across.wraps:
        raise NotDefined(
            f"padding is {paddings!r}: give ExactPeriodicity() for the axis that counts images, or "
            "ZeroPadding() for the other; only then is the error of a window known."
        )
    half_width, margin = _half_width(pressure, positions), 1.0
    if ends_along:
        half_width, margin = max(half_width, _half_width(pressure.T, others)), ENDS_MARGIN
    narrowing = margin * _narrowing(half_width, period, pressure.shape[1], along)
    peak, mean = _end_errors(pressure, along, half_width / period)
    return float((1 + narrowing) * (1 + peak) - 1), float(L1_OVER_NARROWING * narrowing + mean)


def coupling_image_error(pressure: Array, shear: Array, grid: Grid, along: Padding, beta: float) -> float:
    """Return the relative error in L1 by the images of a traction along x on bodies with Dundurs' `beta`.

    Images of the line load Q of the traction beyond the distance D tilt the surfaces by ``2 beta Q / (pi E* D)``, which
    shifts a contact under the line load W by ``beta Q / W a^2 / (2 D)``.

    Parameters
    ----------
    pressure
        Pressure (x, y).
    shear
        Tangential traction along x (x, y).
    grid
        Their grid.
    along
        Padding along; images that are left out across balance each other.
    beta
        Dundurs' beta.
    """
    if along.window is None:
        return 0.0
    half_width, reach = _half_width(pressure, grid.x), along.reach(grid.length)
    distances = np.full(2, reach) if along.wraps else np.concatenate([reach - grid.y, reach + grid.y])
    inverse = float((1 / np.maximum(distances, half_width)).mean())
    shift = abs(beta * float(shear.sum()) / float(pressure.sum())) * half_width * inverse / 2
    return L1_OVER_NARROWING * shift


def with_all_images(paddings: Paddings) -> Paddings:
    """Return `paddings` with infinitely many images along the axis whose errors :func:`image_errors` finds."""
    across, along = paddings
    return (ExactPeriodicity(), along) if _counts_images(across) else (across, ExactPeriodicity())


def _counts_images(padding: Padding) -> bool:
    """Return whether a `padding` has images, a finite number of them."""
    return padding.window is not None and len(padding.window) > 1


def _narrowing(half_width: float, period: float, cells: int, along: Padding) -> float:
    """Return the fraction by which the images left out raise the peak of a contact and narrow it."""
    assert along.window is not None
    reach = along.reach(period)
    # an even number of cells cannot lie symmetrically about the cell whose displacement is summed
    asymmetry = period / cells / 2 if along.wraps and len(along.window) * cells % 2 == 0 else 0.0
    inverse_square = ((reach + asymmetry) ** -2 + (reach - asymmetry) ** -2) / 2
    return float(np.sqrt(1 + half_width**2 * inverse_square / 4) - 1)


def _kink(ratio: float, window: int, cells: int) -> Array:
    """Return the rise of the pressure towards the ends of a window centred on the domain, in the cells along it."""
    odd = 2 * np.minimum(np.arange(cells), np.arange(cells)[::-1]) + 1
    return np.asarray(1 + 2 / np.pi * ratio * np.log(cells / odd) / window**2)


def _end_errors(pressure: Array, along: Padding, ratio: float) -> tuple[float, float]:
    """Return the errors of peak pressure and pressure in L1 by the variation along the length.

    Parameters
    ----------
    pressure
        Pressure (x, y).
    along
        Padding along the length.
    ratio
        Half-width over period.
    """
    assert along.window is not None
    if along.wraps or pressure.shape[1] == 1:  # a window is centred on the only cell
        return 0.0, 0.0
    if len(along.window) == 1 and _reaches_ends(pressure):
        load = pressure.sum(axis=0) / pressure.sum(axis=0).mean()
        return max(load[0], load[-1], 1.0) - 1, float(np.abs(load - 1).mean())
    kink = _kink(ratio, len(along.window), pressure.shape[1])
    row_peaks = pressure.max(axis=0)
    # a maximum away from the ends is not raised by them
    peak_rise = float(row_peaks.max() / (row_peaks / kink).max()) - 1
    return peak_rise, END_VARIATION * ratio**END_VARIATION_POWER / len(along.window) ** 2


def _reaches_ends(pressure: Array) -> bool:
    """Return whether there is contact at the ends of the length."""
    return bool(pressure[:, [0, -1]].any())


def _half_width(pressure: Array, x: Array) -> float:
    """Return the half-width of the Hertz contact whose load has the same rms distance from its axis."""
    fraction = pressure.sum(axis=1) / pressure.sum()
    middle = (fraction * x).sum()
    return 2 * float(np.sqrt((fraction * (x - middle) ** 2).sum()))
