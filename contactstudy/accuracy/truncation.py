"""What leaving out far images costs, from the window alone."""

from dataclasses import dataclass
from math import inf

import numpy as np

from contactstudy.domain.checks import NotDefined
from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid
from contactstudy.domain.padding import Padding, Paddings

# Hertz's ellipse made narrower by a small share changes by 4 / pi of it in L1.
NARROWER = 4 / np.pi
# The line load of a window centred on the domain varies by END (a / L)^0.7 / (2 n + 1)^2 in the mean
# over the length: measured for L from 0.15 to 9.6 half-widths, on 32 to 288 cells.
END, END_POWER = 0.5, 0.7


def truncation(pressure: Array, grid: Grid, paddings: Paddings) -> tuple[float, float]:
    """Relative error of the peak pressure, and of all of it in L1, by the images a padding leaves out.

    ``pressure`` (x, y). A window that reaches D to each side takes ``x^2 / (2 D^2)`` from
    the logarithm of each image row, and so makes the contact, of half-width ``a = 2 rms(x)``, too highly curved
    by the factor ``1 + a^2 / (4 D^2)``. Centred on the domain it also misses more at its ends, by
    ``-ln(1 - (2 y / L)^2 / (2 n + 1)^2)``: under that kink the pressure rises, j cells from the end by
    the share ``(2 / pi) (a / L) ln(cells / (2 j + 1)) / (2 n + 1)^2``. Without any images the solution's own
    line load at the ends tells. Zero where all images are summed, or a free length holds the whole contact.
    Raises :class:`~contactstudy.NotDefined` for a window on one axis beside images on the other.
    """
    across, along = paddings
    if across.window is not None and len(across.window) > 1:
        pressure, (along, across) = pressure.T, (across, along)
        period, other = grid.extent[0], grid.y
    else:
        period, other = grid.extent[1], grid.x
    free = not (hasattr(along, "images") or along.wraps or _reaches(pressure))
    if along.window is None or (free and len(along.window) == 1):
        return 0.0, 0.0
    if across.window is None or len(across.window) > 1 or across.wraps:
        raise NotDefined(
            f"padding is {paddings!r}: give ExactPeriodicity() for the axis that counts images, or "
            "ZeroPadding() for the other; only then is the error of a window known."
        )
    narrower = _narrower(_half_width(pressure, other), period, pressure.shape[1], along)
    peak, mean = _ends(pressure, along, _half_width(pressure, other) / period)
    return float((1 + narrower) * (1 + peak) - 1), float(NARROWER * narrower + mean)


@dataclass(frozen=True)
class ExpectedTruncation:
    """Relative errors of the peak pressure, of all of it in L1, and of the half-width."""

    peak_pressure: float
    l1: float
    half_width: float


def expected_truncation(half_width: float, grid: Grid, along: Padding) -> ExpectedTruncation:
    """What :func:`truncation` will find of a contact of ``half_width`` [m] that is uniform along its length.

    Infinite where a length without images is not periodic at all.
    """
    if along.window is None:
        return ExpectedTruncation(0.0, 0.0, 0.0)
    if len(along.window) == 1 and not along.wraps:
        return ExpectedTruncation(inf, inf, inf)
    narrower = _narrower(half_width, grid.period, grid.cells[1], along)
    ratio = half_width / grid.period
    risen = mean = 0.0
    if not along.wraps:
        kink = _kink(ratio, len(along.window), grid.cells[1])
        risen, mean = float(kink.max()) - 1, END * ratio**END_POWER / len(along.window) ** 2
    return ExpectedTruncation(
        (1 + narrower) * (1 + risen) - 1,
        NARROWER * narrower + mean,
        narrower / (1 + narrower),
    )


def _narrower(half_width: float, period: float, cells: int, along: Padding) -> float:
    """By what share the images left out raise the peak of a contact and narrow it."""
    assert along.window is not None
    reach = along.reach(period)
    # a whole number of cells, if even, cannot lie evenly about the observer's own
    aside = period / cells / 2 if along.wraps and len(along.window) * cells % 2 == 0 else 0.0
    inverse_square = ((reach + aside) ** -2 + (reach - aside) ** -2) / 2
    return float(np.sqrt(1 + half_width**2 * inverse_square / 4) - 1)


def _kink(ratio: float, window: int, cells: int) -> Array:
    """Rise of the pressure towards the ends of a window centred on the domain, in each row of cells."""
    odd = 2 * np.minimum(np.arange(cells), np.arange(cells)[::-1]) + 1
    return np.asarray(1 + 2 / np.pi * ratio * np.log(cells / odd) / window**2)


def _ends(pressure: Array, along: Padding, ratio: float) -> tuple[float, float]:
    """The same two errors, by what varies along the length; ``ratio`` of half-width to period."""
    assert along.window is not None
    if along.wraps:
        return 0.0, 0.0
    if len(along.window) == 1 and _reaches(pressure):
        load = pressure.sum(axis=0) / pressure.sum(axis=0).mean()
        return max(load[0], load[-1], 1.0) - 1, float(np.abs(load - 1).mean())
    kink = _kink(ratio, len(along.window), pressure.shape[1])
    highest = pressure.max(axis=0)
    # a maximum away from the ends owes them nothing
    risen = float(highest.max() / (highest / kink).max()) - 1
    return risen, END * ratio**END_POWER / len(along.window) ** 2


def _reaches(pressure: Array) -> bool:
    """Whether there is contact at the ends of the length."""
    return bool(pressure[:, [0, -1]].any())


def _half_width(pressure: Array, x: Array) -> float:
    """Of the Hertz contact that spreads its load as far."""
    share = pressure.sum(axis=1) / pressure.sum()
    middle = (share * x).sum()
    return 2 * float(np.sqrt((share * (x - middle) ** 2).sum()))
