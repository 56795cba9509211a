"""Edges of a smooth contact on cells of constant pressure: position and error, by a law without free parameters.

Next to a straight edge, many cells from any other, the kernel is the half-plane's logarithm. In units of a cell, its
coefficients ``K_j = -int ln|x| dx`` over cell j have the transform

    K(t) = 2 pi sin(t / 2) sum_m sgn(t + 2 pi m) (-1)^m / (t + 2 pi m)^2
         = (pi / |t|) (1 - t^2 / 24 + ...),

and the pressures that leave the gap of a half-line of cells a polynomial are the coefficients
of ``z^j`` in ``(1 - z)^(1/2 - k) e(z)``, with ``|1 - z| K / pi = 1 / |e(z)|^2``: the modes k of an edge. The factor e is
found by the method of Wiener & Hopf (1931); the expansion in modes is derived in :func:`far_field_powers`.
"""

from dataclasses import dataclass
from functools import cache
from math import gamma

import numpy as np
from numpy.typing import NDArray

from contactstudy.domain.fields import Array
from contactstudy.elasticity.kernels.displacement_cell import mean_gauss_rule

# modes k = 1 ... MODES behave like d^(k - 3/2) at d cells from the edge
MODES = 4


@dataclass(frozen=True)
class EdgeConstants:
    """Constants of the law of an edge, with their effect on single edges and on line contacts of 40 to 300 cells.

    Attributes
    ----------
    series_terms
        Terms of e(z), whose coefficients fall like j^-4. With 200 all errors are the same to the last bit.
    symbol_samples
        Points at which its symbol is sampled. With half as many errors change by 6e-10.
    positions
        Positions of the edge in cells outward of the last centre in contact: further inward that cell loses contact,
        further outward the next one gains it.
    steps
        Number of positions. Half or twice as many change the error of an edge by 0.5 % in the mean, and near its jump by
        up to 9 %.
    cells
        Cells over which the error is summed. Half or twice as many change it by 1.5 %.
    jump_range
        Distance in cells within which the largest error counts. Without it the error is up to 41 % smaller.
    fitted_cells
        Cells that the law is fitted to. From 4 to 8 the error of the half-width changes by 0.8 to 1.4 times.
    min_touching
        Cells that touch without a break beside a resolved edge. From 6 to 24 nothing changes on smooth contacts.
    max_misfit
        Largest misfit of a pressure over the largest one at a resolved edge. From 1e-4 to 1e-2 nothing changes on smooth
        contacts.
    """

    series_terms: int = 400
    symbol_samples: int = 4096
    positions: tuple[float, float] = (-0.175, 0.83)
    steps: int = 200
    cells: int = 200
    jump_range: float = 0.06
    fitted_cells: int = 6
    min_touching: int = 12
    max_misfit: float = 1e-3


CONSTANTS = EdgeConstants()


@cache
def edge_modes(count: int) -> Array:
    """Return the pressure of each mode in the first `count` cells inward from the edge, shape (count, MODES)."""
    from scipy import fft  # imported late, since it is slow

    angle = np.pi * (np.arange(CONSTANTS.symbol_samples) + 0.5) / CONSTANTS.symbol_samples
    # ln e(z) is half of the cepstrum; the other half belongs to 1 / z
    log = -fft.dct(_log_symbol(angle))[: CONSTANTS.series_terms] / (2 * CONSTANTS.symbol_samples)
    order = np.arange(CONSTANTS.series_terms)
    smooth = np.zeros(CONSTANTS.series_terms)
    smooth[0] = np.exp(log[0] / 2)
    for j in range(1, CONSTANTS.series_terms):
        smooth[j] = (order[1 : j + 1] * log[1 : j + 1]) @ smooth[j - 1 :: -1] / j
    steps = np.arange(1, count)
    root = np.cumprod(np.append(1.0, (steps - 1.5) / steps))
    mode = np.convolve(smooth, root)[:count]
    columns = []
    for _ in range(MODES):
        mode = np.cumsum(mode)
        columns.append(mode)
    return np.stack(columns, axis=1)


@cache
def edge_offset() -> float:
    """Return the position of d = 0, in cells outward of the centre of the outermost touching cell."""
    slope = 0.0
    for node, weight in mean_gauss_rule(200):
        angle = np.pi * (node + 1) / 2
        slope -= weight * float(_log_symbol(np.array([angle]))[0]) / np.sin(angle / 2) ** 2
    return 0.25 + slope / 4


@cache
def far_field_powers() -> Array:
    """Return the coefficients of ``d^(q - 3/2)`` in each mode far from the edge, shape (MODES + 1, MODES), from q = 0.

    They are those of the continuous pressure that the cells discretise, which differs at their
    centres by ``p'' / 24``. In ``s = -ln z`` mode k is ``s^(1/2) (1 - s^2 / 48) (2 sinh(s / 2))^-k
    exp(s (k - 1) / 2)`` and more, of which ``s^(1/2 - q)`` gives ``d^(q - 3/2) / gamma(q - 1/2)``.
    """
    count = MODES + 1
    # of s / (1 - exp(-s)) and, for d to count from its own zero, exp(-s / 2)
    outward = _reciprocal(np.array([(-1) ** i / gamma(i + 2) for i in range(count)]))
    common = np.array([(-0.5) ** i / gamma(i + 1) for i in range(count)])
    common = np.convolve(common, [1, 0, 1 / 48])[:count]  # (1 - s^2 / 48) / (1 - s^2 / 24)
    result = np.zeros((count, MODES))
    series = common
    for k in range(1, MODES + 1):
        series = np.convolve(series, outward)[:count]
        for q in range(k + 1):
            result[q, k - 1] = series[k - q] / gamma(q - 0.5)
    return result


def edge_error(last: Array, inner: Array) -> Array:
    """Return the L1 pressure error at an edge, ``sum |p - true|``, from the two cells next to it.

    The true pressure is taken at the centres or as its mean in the cells, whichever error is larger. The ratio of the
    two cells tells where in its cell the edge of a smooth contact lies. The error jumps where the edge passes the
    centre of a cell, so the largest error within `jump_range` cells to either side counts. Where a single cell
    touches, or `last` is the higher, the law no longer holds, and the edge is taken to lie as far out as it can.

    Parameters
    ----------
    last
        Pressure of the last touching cell at each edge.
    inner
        Pressure of the next cell inward; 0 where it does not touch.
    """
    ratio, error = _edge_errors()
    inner = np.maximum(inner, last / ratio[-1])
    return np.asarray(np.interp(last / inner, ratio, error) * inner)


def edge_position(last: Array, inner: Array) -> Array:
    """Return the position of each edge, in cells outward of the centre of the last touching cell.

    Where a single cell touches, it is half-way between the innermost and the outermost possible position.

    Parameters
    ----------
    last
        Pressure of the last touching cell at each edge.
    inner
        Pressure of the next cell inward; 0 where it does not touch.
    """
    edge, _, _, outer, second = _edge_discretisations()
    ratio = np.where(inner > 0, last / np.where(inner > 0, inner, 1), np.nan)
    position = np.interp(ratio, outer / second, edge)
    return np.asarray(np.where(inner > 0, position, sum(CONSTANTS.positions) / 2))


@cache
def _edge_errors() -> tuple[Array, Array]:
    """Return the ratio of the last two cells, and the L1 error over the inner one, for edges from inside outwards."""
    edge, at_centres, of_means, last, inner = _edge_discretisations()
    error = np.maximum(at_centres, of_means)
    near = np.abs(edge[:, None] - edge) <= CONSTANTS.jump_range
    return last / inner, np.where(near, error / inner, 0).max(axis=1)


@cache
def _edge_discretisations() -> tuple[Array, Array, Array, Array, Array]:
    """Return the pressure of the cells next to an edge at several positions, and its error.

    The continuous pressure is the square root of the distance from the edge. Returned are positions of the edge, in
    cells outward of the last touching centre; L1 errors against the pressure at the centres, and against its means in
    the cells; the pressures of the last touching cell, and of the next one inward.
    """
    amplitudes = far_field_powers()[1:3, :2]
    edge = np.linspace(*CONSTANTS.positions, CONSTANTS.steps)  # from the last centre
    shift = edge - edge_offset()
    strength = np.linalg.solve(amplitudes, np.stack([shift / 2, np.ones_like(shift)]))
    cells = np.arange(CONSTANTS.cells)[:, None]
    pressure = edge_modes(CONSTANTS.cells)[:, :2] @ strength
    error = np.abs(pressure - np.sqrt(np.maximum(cells + edge, 0))).sum(axis=0)
    # the cell beyond the last may hold the edge too
    border = np.maximum(np.arange(-1, CONSTANTS.cells + 1)[:, None] + edge - 0.5, 0)
    means = np.diff(border**1.5, axis=0) * (2 / 3)
    error_of_means = np.abs(pressure - means[1:]).sum(axis=0) + means[0]
    return edge, error, error_of_means, pressure[0], pressure[1]


def _log_symbol(angle: Array) -> Array:
    """Return ``ln(|1 - z| K / pi)`` at ``z = exp(i angle)``, which is 0 at z = 1."""
    fraction = angle / (2 * np.pi)
    from scipy.special import zeta  # imported late, as above

    alternating = sum((zeta(2, u / 2) - zeta(2, (u + 1) / 2)) / 4 for u in (fraction, 1 - fraction))
    return np.asarray(np.log(np.sin(angle / 2) ** 2 * alternating / np.pi**2))


def _reciprocal(series: Array) -> Array:
    """Return the power series of the reciprocal of a power series."""
    result = np.zeros_like(series)
    result[0] = 1 / series[0]
    for i in range(1, len(series)):
        result[i] = -(series[1 : i + 1] @ result[i - 1 :: -1]) / series[0]
    return result


@dataclass(frozen=True)
class _Edges:
    """Resolved edges on the side of growing x: straight over three lines of cells, and fitted by the law.

    Attributes
    ----------
    iy
        Indices along the length at which an edge is resolved.
    last
        Index across of the last touching cell at each of them.
    outward
        Position of the edge, in cells outward of the centre of the last touching cell.
    """

    iy: NDArray[np.intp]
    last: NDArray[np.intp]
    outward: Array


def half_widths(pressure: Array, x: Array) -> Array:
    """Return half the width of the contact at each place along the length, shape (y,) [unit of x].

    Where the edge is smooth, straight over three lines of cells and a dozen cells from any other edge, the cells next
    to it follow the law of this module, and the error falls like the cell cubed: on a smooth line contact, 2e-7 of the
    half-width with 128 cells across 2.4 half-widths. Elsewhere the outer faces of the touching cells count; the width is
    0 where no cell touches.

    Parameters
    ----------
    pressure
        Pressure (x, y) as solved for.
    x
        Cell centres (x,), equidistant.
    """
    return (_positions(pressure, x) + _positions(pressure[::-1], -x[::-1])) / 2


def resolved_edges(pressure: Array) -> tuple[Array, Array] | None:
    """Return the places of both edges across, (y,) each, in cells outward of the middle of the grid.

    None unless every edge across is straight and smooth: each place along the length touches without a gap, and both its
    edges follow the law of this module.
    """
    touching = pressure > 0
    if len(pressure) < CONSTANTS.min_touching or not touching.any(axis=0).all():
        return None
    if np.count_nonzero(np.diff(touching, axis=0)) != 2 * pressure.shape[1]:
        return None
    right, left = (_resolved(side) for side in (pressure, pressure[::-1]))
    if min(len(right.iy), len(left.iy)) < pressure.shape[1]:
        return None
    middle = (len(pressure) - 1) / 2
    return right.last + right.outward - middle, left.last + left.outward - middle


def _positions(pressure: Array, x: Array) -> Array:
    """Return the position of the edge on the side of growing x, at each place along the length."""
    last, step = _last(pressure), x[1] - x[0]
    position = np.where((pressure > 0).any(axis=0), x[last] + step / 2, 0.0)
    edges = _resolved(pressure)
    position[edges.iy] = x[edges.last] + edges.outward * step
    return position


def _last(pressure: Array) -> NDArray[np.intp]:
    """Return the index across of the last touching cell at each place along the length."""
    return np.asarray(len(pressure) - 1 - np.argmax(pressure[::-1] > 0, axis=0))


def _resolved(pressure: Array) -> _Edges:
    """Return the edges on the side of growing x that the law can be fitted to."""
    last, count = _last(pressure), len(pressure)
    # cells that touch without a break, from the last inward
    inward = np.minimum(np.arange(count)[:, None], last)
    touching = (pressure[last - inward, np.arange(pressure.shape[1])] > 0).cumprod(axis=0)
    within = np.arange(count)[:, None] <= last
    touching = (touching * within).sum(axis=0)
    straight = (last == np.roll(last, 1)) & (last == np.roll(last, -1)) & (last < count - 1)
    iy = np.flatnonzero(straight & (touching >= CONSTANTS.min_touching))
    beside = pressure[last[iy] - np.arange(CONSTANTS.fitted_cells)[:, None], iy]
    strength = np.linalg.lstsq(edge_modes(CONSTANTS.fitted_cells), beside, rcond=None)[0]
    misfit = np.abs(edge_modes(CONSTANTS.fitted_cells) @ strength - beside).max(axis=0, initial=0)
    fits = misfit <= CONSTANTS.max_misfit * beside.max(axis=0, initial=0)
    iy = iy[fits]
    return _Edges(iy, last[iy], _outward(strength[:, fits]))


def _outward(strength: Array) -> Array:
    """Return the edge, in cells beyond the last centre, of the continuous contact behind a sum of modes.

    Its pressure at D cells inside the edge is ``sqrt(D) (A + B D + G D^2)``. Away from the edge both are equal but for a
    multiple of ``(2 b d - d^2)^(-3/2)``, b = -A / (4 B), which carries no load: so their powers of d are compared, with
    ``D = d + shift`` and that multiple unknown.
    """
    singular, inverse, root, cubed, g = far_field_powers() @ strength
    a, b, shift = root, cubed, 2 * inverse / root
    for _ in range(4):  # each gains two orders of cell over radius
        b = cubed - 2.5 * g * shift
        multiple = singular + a * shift**2 / 8
        a = root - 1.5 * b * shift - 7.5 * (b / a) ** 2 * multiple - 15 / 8 * g * shift**2
        # the square of the shift drops out
        shift = 2 * (inverse + 3 * b * singular / a) / a
    return np.asarray(edge_offset() + shift)
