"""Viscoelastic bodies: relaxation and creep as sums of exponentials, and the influence coefficients of rolling ones.

A body is linear and has one Poisson's ratio for all times: its displacement is that of an elastic body times a
:class:`Creep` function. In steady rolling the hereditary integral over time becomes one along the direction of motion:
:class:`RetardedCoefficients` are its influence coefficients, integrated by Gauss points on panels of a cell's size.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from itertools import pairwise
from math import exp, isinf

import numpy as np
from scipy.special import eval_legendre, ive

from contactstudy.domain.grid import Array
from contactstudy.elasticity.convolution import Coefficients

# Bisections, in the logarithm, of a bracket from the smallest to the largest floating-point number: down to rounding.
BISECTIONS = 80


@dataclass(frozen=True)
class Creep:
    """Creep function ``instantaneous + fluidity t + sum(J_i (1 - exp(-t / lambda_i)))``.

    It is the strain, or a displacement in proportion to it, under a unit step of stress.

    Parameters
    ----------
    instantaneous
        Value at time zero.
    terms
        Pairs of a compliance and its retardation time (J_i, lambda_i [s]), J_i in the unit of `instantaneous`.
    fluidity
        Rate of flow after infinite time, in that unit per second.
    """

    instantaneous: float
    terms: tuple[tuple[float, float], ...] = ()
    fluidity: float = 0.0

    def __call__(self, time: float | Array) -> Array:
        """Return the value at a `time` [s] at least 0."""
        time = np.asarray(time, dtype=np.float64)
        value = self.instantaneous + self.fluidity * time
        for size, duration in self.terms:
            value = value - size * np.expm1(-time / duration)
        return value

    def scaled(self, factor: float) -> "Creep":
        """Return this creep function times `factor`."""
        terms = tuple((factor * size, duration) for size, duration in self.terms)
        return Creep(factor * self.instantaneous, terms, factor * self.fluidity)


def creep_from_relaxation(equilibrium_modulus: float, relaxation: tuple[tuple[float, float], ...]) -> Creep:
    """Return the creep of a body whose modulus relaxes as ``E_inf + sum(E_i exp(-t / tau_i))``.

    The zeros of ``E(s) = E_inf + sum(E_i s / (s + 1 / tau_i))`` are at ``s = -1 / lambda_i``. The rates 1 / lambda_i are
    bracketed: one is between each pair of neighbouring rates 1 / tau_i, and one below them all, at 0 in a fluid.
    Source: Park & Schapery (1999), Int. J. Solids Struct. 36, eqs. 13 to 23.

    Parameters
    ----------
    equilibrium_modulus
        Modulus E_inf after infinite time [Pa]; 0 for a Maxwell fluid.
    relaxation
        Pairs (E_i > 0 [Pa], tau_i > 0 [s]).

    Returns
    -------
    Creep
        Creep function [1/Pa].
    """
    merged: dict[float, float] = {}
    for modulus, time in relaxation:
        merged[1 / time] = merged.get(1 / time, 0.0) + modulus
    rates = np.array(sorted(merged))
    moduli = np.array([merged[rate] for rate in rates])
    instantaneous = 1 / (equilibrium_modulus + float(moduli.sum()))
    if equilibrium_modulus == 0:
        # one zero is at s = 0: the flow
        fluidity = 1 / float((moduli / rates).sum())
        low, high = rates[:-1], rates[1:]
    else:
        fluidity = 0.0
        # so far below the first rate 1 / tau_1 that E(-z) >= 0: z / (1 / tau_i - z) <= 2 z tau_1 <= E_inf / sum E_i
        slowest = rates[:1] * min(0.5, equilibrium_modulus / (2 * moduli.sum())) if rates.size else rates
        low, high = np.concatenate([slowest, rates[:-1]]), rates
    zeros = _zeros(equilibrium_modulus, moduli, rates, low.copy(), high.copy())
    steepness = (moduli * rates / (rates - zeros[:, None]) ** 2).sum(axis=1)
    sizes = 1 / (zeros * steepness)
    terms = tuple((float(size), float(1 / zero)) for size, zero in zip(sizes, zeros, strict=True))
    return Creep(instantaneous, terms, fluidity)


def _zeros(equilibrium_modulus: float, moduli: Array, rates: Array, low: Array, high: Array) -> Array:
    """Return where ``E_inf + sum(E_i z / (z - 1 / tau_i))`` falls through zero in each bracket, by bisection.

    `rates` are 1 / tau_i; `low` and `high` are the ends of the brackets.
    """
    for _ in range(BISECTIONS):
        middle = np.sqrt(low) * np.sqrt(high)
        # between the ends, which may be poles
        middle = np.clip(middle, np.nextafter(low, high), np.nextafter(high, low))
        value = equilibrium_modulus + (moduli * middle[:, None] / (middle[:, None] - rates)).sum(axis=1)
        low, high = np.where(value > 0, middle, low), np.where(value > 0, high, middle)
    return np.asarray(np.sqrt(low) * np.sqrt(high))


# Number of Gauss points in a panel, the size of a cell. Coefficients are smooth beyond the loaded cell: 8 points leave
# less than 1e-8 of the largest one, 12 points 1e-14.
POINTS = 8
NODES, WEIGHTS = np.polynomial.legendre.leggauss(POINTS)
# Legendre polynomials (degree, node) at the nodes.
LEGENDRE = np.array([eval_legendre(n, NODES) for n in range(POINTS)])
# The first panel has a kink at half a cell, the edge of the load: it is divided into panels whose size halves so many
# times towards the kink. Without them the error is 2e-5 of the largest coefficient; from 5 on nothing changes.
HALVINGS = 10
# A pressure older than this multiple of the retardation time has no effect left: exp(-40) ~ 4e-18.
NEGLIGIBLE_AGE = 40.0

# Coefficients along the axis of motion: from offsets (n,) along it to values (n, m) at m offsets along the other axis.
Kernel = Callable[[Array], Array]


@dataclass(frozen=True)
class RetardedCoefficients:
    """Influence coefficients of the retarded displacement under a moving pressure.

    They are the even or the odd part of ``V(x) = int_0^inf exp(-t / length) / length K(x + t) dt`` with the
    coefficients K of `inner` and the distance t travelled since. V is the displacement at x by a pressure at 0 that
    moves to larger x at a speed v, in a body with the retardation time ``length / v``.

    Parameters
    ----------
    inner
        Coefficients K, even or odd along each axis.
    length
        Distance travelled during the retardation time of the body.
    sign
        1 for the part of V that is even along the axis of motion, -1 for the odd part.
    axis
        Axis of motion, 0 for x and 1 for y.
    """

    inner: Coefficients
    length: float
    sign: int
    axis: int = 0

    @property
    def parity(self) -> tuple[int, int]:
        """Parity along each axis: that of the part along the axis of motion, that of K along the other."""
        even_x, even_y = self.inner.parity
        return (self.sign, even_y) if self.axis == 0 else (even_x, self.sign)

    def swap_axes(self) -> "RetardedCoefficients":
        """Return the coefficients of motion along the other axis."""
        return replace(self, inner=self.inner.swap_axes(), axis=1 - self.axis)

    def cell(self, x: Array, y: Array, dx: float, dy: float) -> Array:
        """Return the response (m, n) to one cell at every x with every y, of which one is (n,), the other (m, 1)."""
        if self.axis == 1:
            return self.swap_axes().cell(y, x, dy, dx)
        part = self._part(lambda s: self.inner.cell(s[:, None], np.ravel(y), dx, dy), x, dx)
        return part if np.ndim(y) < 2 else part.T

    def row(self, x: Array, y: Array, dx: float, dy: float, period: float) -> Array:
        """Return the response to an infinite row of images along y; x is a column, y a row."""
        cell, across, along = (dx, dy, period), np.ravel(x), np.ravel(y)
        if self.axis == 0:
            return self._part(lambda s: self.inner.row(s[:, None], along, *cell), x, dx)
        return self._part(lambda s: self.inner.row(across[:, None], s, *cell).T, y, dy, period).T

    def lattice(self, x: Array, y: Array, dx: float, dy: float, width: float, period: float) -> Array:
        """Return the response to an infinite lattice of images along both axes; x is a column, y a row."""
        if self.axis == 1:
            return self.swap_axes().lattice(y.T, x.T, dy, dx, period, width).T
        cell, along = (dx, dy, width, period), np.ravel(y)
        return self._part(lambda s: self.inner.lattice(s[:, None], along, *cell), x, dx, width)

    def _part(self, kernel: Kernel, offsets: Array, step: float, period: float | None = None) -> Array:
        """Return the even or odd part of V at `offsets` along the axis of motion, where K repeats after a `period`."""
        parity, places = self.inner.parity[self.axis], np.ravel(offsets)
        if period is None:
            ahead, behind = _open_axis(kernel, places, step, self.length, parity)
        else:
            ahead, behind = _periodic_axis(kernel, places, step, period, self.length, parity)
        return (ahead + self.sign * behind) / 2


def retarded(response: Mapping[Coefficients, float], distance: float) -> Mapping[Coefficients, float]:
    """Return the retarded `response` of a body under a contact that moves over it: the weights of even and odd parts.

    Parameters
    ----------
    response
        Weight of each kind of coefficients of the response to a sudden load.
    distance
        Distance [m] along x that the contact moves in the retardation time of the body, negative to smaller x. At 0 m
        the response is that of a contact at rest, at an infinite distance there is none.
    """
    if distance == 0 or isinf(distance):
        return {} if distance else response
    parts: dict[Coefficients, float] = {}
    for inner, weight in response.items():
        for sign in (1, -1):
            # V of the opposite motion is V(-x) times the parity of K: the odd part changes its sign
            turned = sign * inner.parity[0] if distance < 0 else 1
            parts[RetardedCoefficients(inner, abs(distance), sign)] = turned * weight
    return parts


def _open_axis(kernel: Kernel, x: Array, step: float, length: float, parity: int) -> tuple[Array, Array]:
    """Return V (n, m) ahead, at `x`, and behind, at ``-x``, of a `kernel` that is not periodic.

    `x` (n,) are multiples of `step`, at least 0.

    V is that of :class:`RetardedCoefficients` with this `length`; the kernel is even or odd, by its `parity`.
    """
    index = np.round(x / step).astype(int)
    last = max(int(index.max()), 1)
    onward, backward = _panels(kernel, last, step, length)
    beyond = _beyond(kernel, last * step, step, length)[None]
    ahead = _decaying_sums(np.concatenate([beyond, onward[::-1]]), step / length)[::-1]
    behind = _decaying_sums(np.concatenate([ahead[:1], parity * backward]), step / length)
    return ahead[index], behind[index]


def _periodic_axis(
    kernel: Kernel, x: Array, step: float, period: float, length: float, parity: int
) -> tuple[Array, Array]:
    """Return V at `x` and at ``-x`` as :func:`_open_axis`, of a `kernel` that repeats after a `period`."""
    count = round(period / step)
    half = (count + 1) // 2
    onward, backward = _panels(kernel, half, step, length)
    panels = np.concatenate([onward, parity * backward[: count - half][::-1]])[::-1]
    # V at 0 is the integral over one period, and over all others, each exp(-period / length) times the one before
    first = _decaying_sums(panels, step / length)[-1:] / -np.expm1(-period / length)
    around = _decaying_sums(np.concatenate([first, panels]), step / length)[:0:-1]
    index = np.round(x / step).astype(int) % count
    return around[index], around[-index % count]


def _decaying_sums(terms: Array, steps: float) -> Array:
    """Return the sums (k, m) ``y_0 = terms_0, y_k = terms_k + exp(-steps) y_(k - 1)`` of `terms` (k, m)."""
    from scipy.signal import lfilter  # imported late, since it is slow

    return np.asarray(lfilter([1.0], [1.0, -exp(-steps)], terms, axis=0))


def _panels(kernel: Kernel, count: int, step: float, length: float) -> tuple[Array, Array]:
    """Return the integrals (count, m) of the `kernel` over each of `count` panels of size `step` from 0 on, twice.

    The first ones are weighted with ``exp(-t / length) / length`` for the distance t from the near end of the panel,
    the second ones for the distance from its far end.
    """
    halves = np.concatenate([[0.0], np.sort(0.5 - 0.5 ** np.arange(2.0, HALVINGS + 2)), [0.5]])
    edges = step * np.concatenate([halves, 1 - halves[-2::-1]])
    first = [_integral(kernel, 0.0, edges, length, sign) for sign in (1, -1)]
    nodes, weights = _rule(step, length)
    starts = step * np.arange(1, count)
    places = (starts[:, None] + step * nodes).ravel()
    values = kernel(places) if count > 1 else np.zeros((0, *first[0].shape))
    values = values.reshape(count - 1, POINTS, *values.shape[1:])
    onward = np.tensordot(weights, values, (0, 1))
    # Gauss points are symmetric: read backwards, only the weights change
    backward = np.tensordot(weights[::-1], values, (0, 1))
    return (np.concatenate([first[0][None], onward]), np.concatenate([first[1][None], backward]))


def _integral(kernel: Kernel, start: float, edges: Array, length: float, sign: int) -> Array:
    """Return the integral (m,) of the `kernel` over panels between `edges`, distances from `start`.

    It is weighted as by :func:`_panels`, from the first edge on (`sign` 1) or from the last one backwards (-1).
    """
    total: Array | float = 0.0
    for near, far in pairwise(edges):
        nodes, weights = _rule(far - near, length)
        if sign < 0:
            weights = weights[::-1] * exp(-(edges[-1] - far) / length)
        else:
            weights = weights * exp(-(near - edges[0]) / length)
        total = total + np.tensordot(weights, kernel(start + near + (far - near) * nodes), (0, 0))
    return np.asarray(total)


def _beyond(kernel: Kernel, start: float, step: float, length: float) -> Array:
    """Return V (m,) of :func:`_open_axis` at `start`, by panels that double in size from `step` on."""
    reach = NEGLIGIBLE_AGE * length
    edges = [0.0, step]
    while edges[-1] < reach:
        edges.append(2 * edges[-1])
    return _integral(kernel, start, np.array(edges), length, 1)


def _rule(size: float, length: float) -> tuple[Array, Array]:
    """Return points over the `size` of a panel, and weights for ``int_0^size f(t) exp(-t / length) / length dt``.

    The weights are exact for polynomials f of degree ``POINTS - 1`` at any ratio of the lengths: moments of Legendre's
    polynomials under an exponential are modified spherical Bessel functions (DLMF 10.54.2).
    """
    # at the limits the weights are those of a mean and of the near end; Bessel functions overflow beyond
    half = min(max(size / (2 * length), 1e-12), 1e8)
    orders = np.arange(POINTS)
    moments = (-1.0) ** orders * np.sqrt(np.pi / (2 * half)) * ive(orders + 0.5, half)
    weights = half * WEIGHTS * (((2 * orders + 1) * moments) @ LEGENDRE)
    return (NODES + 1) / 2, weights
