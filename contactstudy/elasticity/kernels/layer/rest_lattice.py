"""The layer's rest under a cell repeated along both axes."""

import numpy as np
from scipy.special import digamma, zeta

from contactstudy.domain.devices.arrays import Array
from contactstudy.elasticity.kernels.layer.frf import LayerResponse
from contactstudy.elasticity.kernels.layer.rest_row import END, FAR, harmonics, rest_strip
from contactstudy.elasticity.kernels.layer.tables import LAST_WAVE, rest_in_space

# Waves that a Fourier series of both axes may take, and one of the strips; beyond them it is summed in space.
MOST_WAVES, MOST_ACROSS = 4e6, 3000


def rest_lattice(
    response: LayerResponse,
    thickness: float,
    x: Array,
    y: Array,
    dx: float,
    dy: float,
    width: float,
    period: float,
) -> Array:
    """The rest repeated with ``width`` along x and ``period`` along y, counted from its mean.

    x a column and y a row. A Fourier series where the layer is thick. Where it is thin, rows of the shorter
    period: what varies along these dies out within a few of their periods, and what does not is
    :func:`rest_strips`.
    """
    largest = LAST_WAVE / thickness / (2 * np.pi)
    waves = int(largest * width), int(largest * period)
    if waves[0] * waves[1] <= MOST_WAVES:
        return _series(response, thickness, x.ravel(), y.ravel(), (dx, dy), (width, period), waves)
    if period > width:
        turned = y.reshape(-1, 1), x.reshape(1, -1)
        return rest_lattice(response, thickness, *turned, dy, dx, period, width).T
    across, along = np.abs(np.fmod(x.ravel(), width)), y.ravel()
    rows = int(np.ceil(END * period / width)) + 1
    shifts = width * np.arange(-rows, rows + 1.0)
    distances = np.abs(across + shifts[:, None])
    varying = harmonics(response, thickness, distances.ravel(), along, dx, dy, period)
    mean = rest_strips(response, thickness, across, dx, width) * (dy / period)
    return np.asarray(mean[:, None] + varying.reshape(*distances.shape, along.size).sum(axis=0))


def _series(
    response: LayerResponse,
    thickness: float,
    x: Array,
    y: Array,
    cell: tuple[float, float],
    periods: tuple[float, float],
    waves: tuple[int, int],
) -> Array:
    q, fields = [], []
    for offset, size, period, count in zip((x, y), cell, periods, waves, strict=True):
        q.append(2 * np.pi / period * np.arange(count + 1))
        weight = 2 * size / period * np.sinc(q[-1] * size / (2 * np.pi))
        weight[0] /= 2
        fields.append(np.cos(np.multiply.outer(offset, q[-1])) * weight)
    wave = np.hypot(q[0][:, None], q[1])
    within = (wave > 0) & (wave * thickness < LAST_WAVE)
    spectrum = np.zeros(wave.shape)
    spectrum[within] = 2 * np.pi * np.real(response.rest(wave[within] * thickness)) / wave[within]
    return np.asarray(fields[0] @ spectrum @ fields[1].T)


def rest_strips(
    response: LayerResponse, thickness: float, x: Array, dx: float, width: float
) -> Array:
    """Strips of width ``dx``, endless along y, repeated with ``width`` along x and counted from their mean."""
    waves = int(LAST_WAVE / thickness * width / (2 * np.pi))
    if waves <= MOST_ACROSS:
        q = 2 * np.pi / width * np.arange(1, waves + 1)
        share = np.real(response.rest(q * thickness)) / q * np.sinc(q * dx / (2 * np.pi))
        return np.asarray(np.cos(np.multiply.outer(x, q)) @ share * (4 * np.pi / width * dx))
    felt = FAR * thickness / response.nearest_pole
    last = int(np.ceil(max(felt, 2 * dx) / width)) + 20
    total = -2 * np.pi * response.slope * thickness * dx / width * np.ones_like(x)
    second, fourth, sixth = rest_in_space(response).taylor
    share = thickness / width
    for side in (1, -1):
        # beyond, the integral over a strip is between ends of 2 r2 h^2 / x - 4 r4 h^4 / x^3 + 48 r6 h^6 / x^5
        for end in (1, -1):
            edge = last + 1 + (side * x + end * dx / 2) / width
            far = -2 * second * share * digamma(edge)
            far -= 4 * fourth * share**3 * zeta(3, edge)
            far += 48 * sixth * share**5 * zeta(5, edge)
            total += end * thickness * far
        for image in range(1, last + 1):
            total += rest_strip(response, thickness, image * width + side * x, dx)
    return np.asarray(total + rest_strip(response, thickness, x, dx))
