"""How a grid of constant-pressure cells renders the edge of a smooth contact: a law without parameters.

Beside a straight edge and many cells from any other, the cells see the half-plane's logarithm
alone. In units of a cell, its coefficients ``K_j = -int ln|x| dx`` over cell j have the transform

    K(t) = 2 pi sin(t / 2) sum_m sgn(t + 2 pi m) (-1)^m / (t + 2 pi m)^2
         = (pi / |t|) (1 - t^2 / 24 + ...),

and the pressures that leave the gap of a half-line of cells a polynomial are the coefficients
of ``z^j`` in ``(1 - z)^(1/2 - k) e(z)``, with ``|1 - z| K / pi = 1 / |e(z)|^2`` (Wiener & Hopf 1931).
"""

from functools import cache
from math import gamma

import numpy as np

from contactstudy.domain.fields import Array
from contactstudy.elasticity.kernels.displacement import gauss

# modes k = 1 ... MODES behave like d^(k - 3/2) at d cells from the edge
MODES = 4
# where the edge can lie, in cells outward of the last touching centre: further in that cell would lose
# contact, further out the next would gain it
EDGE_RANGE, EDGE_STEPS, EDGE_CELLS, LEAP = (-0.175, 0.83), 200, 200, 0.06
# e(z) has coefficients that fall like j^-4
TERMS, SAMPLES = 400, 4096


@cache
def modes(count: int) -> Array:
    """Pressure of each mode in the cells 0, 1 ... inward from the edge, shape (count, MODES)."""
    from scipy import fft  # as heavy as all else together

    angle = np.pi * (np.arange(SAMPLES) + 0.5) / SAMPLES
    # ln e(z) is half the cepstrum, and the other half belongs to 1 / z
    log = -fft.dct(_log_symbol(angle))[:TERMS] / (2 * SAMPLES)
    order = np.arange(TERMS)
    smooth = np.zeros(TERMS)
    smooth[0] = np.exp(log[0] / 2)
    for j in range(1, TERMS):
        smooth[j] = (order[1 : j + 1] * log[1 : j + 1]) @ smooth[j - 1 :: -1] / j
    steps = np.arange(1, count)
    root = np.cumprod(np.append(1.0, (steps - 1.5) / steps))
    mode = np.convolve(smooth, root)[:count]
    found = []
    for _ in range(MODES):
        mode = np.cumsum(mode)
        found.append(mode)
    return np.stack(found, axis=1)


@cache
def offset() -> float:
    """Where d = 0 lies, in cells outward of the centre of the outermost touching cell."""
    slope = 0.0
    for node, weight in gauss(200):
        angle = np.pi * (node + 1) / 2
        slope -= weight * float(_log_symbol(np.array([angle]))[0]) / np.sin(angle / 2) ** 2
    return 0.25 + slope / 4


@cache
def powers() -> Array:
    """What the modes are far from the edge: coefficients of ``d^(q - 3/2)``, shape (MODES + 1, MODES).

    From q = 0 on, and for the continuous pressure that the cells stand for, which beside their
    centres differs by ``p'' / 24``. In ``s = -ln z`` mode k is ``s^(1/2) (1 - s^2 / 48) (2 sinh(s / 2))^-k
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
    """L1 pressure error at an edge, ``sum |p - true|``, from the last two cells beside it.

    Against the true pressure at the centres or its mean in the cells, whichever is larger.

    The ratio of ``last`` and ``inner`` tells where in its cell the edge of a smooth contact lies. The
    error leaps where the edge passes the centre of a cell; so it is the largest within ``LEAP`` of a cell
    to either side. Where a single cell touches (``inner`` is zero), or ``last`` is the higher, the law
    has ended, and the edge is taken to lie as far out as it can.
    """
    ratio, error = _edge_errors()
    inner = np.maximum(inner, last / ratio[-1])
    return np.asarray(np.interp(last / inner, ratio, error) * inner)


def edge_place(last: Array, inner: Array) -> Array:
    """Where the edge lies, in cells outward of the last centre, from the last two cells beside it.

    Where a single cell touches, half-way between as far in and as far out as it can.
    """
    edge, _, outer, second = _edge_renderings()
    ratio = np.where(inner > 0, last / np.where(inner > 0, inner, 1), np.nan)
    place = np.interp(ratio, outer / second, edge)
    return np.asarray(np.where(inner > 0, place, sum(EDGE_RANGE) / 2))


def worst_edge_error() -> float:
    """The largest L1 error an edge can have, over cell^1.5, where the pressure is the root of the depth."""
    return float(_edge_renderings()[1].max())


@cache
def _edge_errors() -> tuple[Array, Array]:
    """Ratio of the last two cells' pressures, and L1 error over the inner one's, as the edge moves out."""
    edge, error, last, inner = _edge_renderings()
    near = np.abs(edge[:, None] - edge) <= LEAP
    return last / inner, np.where(near, error / inner, 0).max(axis=1)


@cache
def _edge_renderings() -> tuple[Array, Array, Array, Array]:
    """Where the edge may lie, the L1 error there, and the last two cells, under the root of the depth."""
    amplitudes = powers()[1:3, :2]
    edge = np.linspace(*EDGE_RANGE, EDGE_STEPS)  # from the last centre
    shift = edge - offset()
    strength = np.linalg.solve(amplitudes, np.stack([shift / 2, np.ones_like(shift)]))
    cells = np.arange(EDGE_CELLS)[:, None]
    found = modes(EDGE_CELLS)[:, :2] @ strength
    error = np.abs(found - np.sqrt(np.maximum(cells + edge, 0))).sum(axis=0)
    # the cell beyond the last may hold the edge too
    border = np.maximum(np.arange(-1, EDGE_CELLS + 1)[:, None] + edge - 0.5, 0)
    means = np.diff(border**1.5, axis=0) * (2 / 3)
    against_means = np.abs(found - means[1:]).sum(axis=0) + means[0]
    return edge, np.maximum(error, against_means), found[0], found[1]


def _log_symbol(angle: Array) -> Array:
    """``ln(|1 - z| K / pi)`` at ``z = exp(i angle)``, zero at one."""
    share = angle / (2 * np.pi)
    from scipy.special import zeta  # likewise

    alternating = sum((zeta(2, u / 2) - zeta(2, (u + 1) / 2)) / 4 for u in (share, 1 - share))
    return np.asarray(np.log(np.sin(angle / 2) ** 2 * alternating / np.pi**2))


def _reciprocal(series: Array) -> Array:
    result = np.zeros_like(series)
    result[0] = 1 / series[0]
    for i in range(1, len(series)):
        result[i] = -(series[1 : i + 1] @ result[i - 1 :: -1]) / series[0]
    return result
