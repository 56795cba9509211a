"""The layer's rest in space: two functions of one distance, tabulated once per pair of materials."""

from collections.abc import Callable
from functools import cached_property, lru_cache

import numpy as np
from numpy.polynomial import chebyshev
from numpy.polynomial.legendre import leggauss
from scipy.special import j1, k1

from contactstudy.domain.devices.arrays import Array
from contactstudy.elasticity.kernels.layer.frf import LayerResponse

# The tables' pieces are [0, 1], [1, 2], [2, 4] ... thicknesses: singularities at two thicknesses and, of
# the far form, at zero lie outside a Bernstein ellipse of rho = 5.8.
ORDER = 22
# R is below 1e-16 of its largest beyond this k.
LAST_WAVE = 20.0
# Gauss points on each piece of k, at most two oscillations long.
POINTS = 18
# What decays like exp(-x) ends here.
LOST = 42.0


class RestInSpace:
    """``edge`` and ``strip`` of one :class:`LayerResponse`, distances in thicknesses."""

    def __init__(self, response: LayerResponse) -> None:
        self.response = response
        self._edge: dict[int, Array] = {}
        self._strip: dict[int, Array] = {}

    def edge(self, s: Array) -> Array:
        """``(1 / s) int R(k) J1(k s) / k dk``: the radial field whose divergence is ``int R(k) J0(k s) dk``."""
        return self._interpolated(s, self._edge, self._edge_at)

    def strip(self, s: Array) -> Array:
        """``int R(k) sin(k s) / k^2 dk``: the integral from 0 to s of ``int R(k) cos(k s) / k dk``; odd."""
        return np.asarray(s * self._interpolated(np.abs(s), self._strip, self._strip_at))

    @cached_property
    def taylor(self) -> tuple[float, float, float]:
        """:meth:`LayerResponse.taylor`."""
        return self.response.taylor()

    def _interpolated(
        self, s: Array, pieces: dict[int, Array], exact: Callable[[Array], Array]
    ) -> Array:
        # frexp: s in [2^(e-1), 2^e)
        piece = np.maximum(np.frexp(s)[1], 0)
        result = np.empty(s.shape)
        for number in np.unique(piece).tolist():
            start, end = (0.0, 1.0) if number == 0 else (2.0 ** (number - 1), 2.0**number)
            if number not in pieces:
                nodes = chebyshev.chebpts1(ORDER)
                values = exact((start + end) / 2 + (end - start) / 2 * nodes)
                pieces[number] = chebyshev.chebfit(nodes, values, ORDER - 1)
            chosen = piece == number
            local = (2 * s[chosen] - start - end) / (end - start)
            result[chosen] = chebyshev.chebval(local, pieces[number])
        return result

    def _edge_at(self, s: Array) -> Array:
        response = self.response
        if s[0] >= LOST / response.first_pole:
            # along the imaginary axis, where J1 decays as K1; what is cut off is below rounding
            tau, weight = self._imaginary(float(s[0]))
            even = np.real(response.rest(1j * tau)) / tau
            far = k1(np.multiply.outer(s, tau)) @ (even * weight)
            return np.asarray((response.slope / s - 2 / np.pi * far) / s)
        k, weight = self._real(float(s[-1]))
        share = np.real(response.rest(k)) / k * weight
        return np.asarray(j1(np.multiply.outer(s, k)) @ share / s)

    def _strip_at(self, s: Array) -> Array:
        response = self.response
        if s[0] >= LOST / response.first_pole:
            tau, weight = self._imaginary(float(s[0]))
            even = np.real(response.rest(1j * tau)) / tau**2
            far = np.exp(-np.multiply.outer(s, tau)) @ (even * weight)
            return np.asarray((np.pi / 2 * response.slope - far) / s)
        k, weight = self._real(float(s[-1]))
        share = np.real(response.rest(k)) / k * weight
        return np.asarray(np.sinc(np.multiply.outer(s, k) / np.pi) @ share)

    def _real(self, s: float) -> tuple[Array, Array]:
        """Gauss points for integrals over k of what oscillates with ``k s``."""
        longest = min(0.5, 4 * np.pi / max(s, 1.0))
        ends = [0.0, min(self.response.nearest_pole, longest)]
        while ends[-1] < LAST_WAVE:
            ends.append(ends[-1] + min(ends[-1], longest))
        return _composite(np.array(ends))

    def _imaginary(self, s: float) -> tuple[Array, Array]:
        """Gauss points for integrals over tau of what decays like ``exp(-s tau)``."""
        end = min(self.response.first_pole, LOST / s)
        start = 1e-3 * min(self.response.nearest_pole, 1 / s)
        count = int(np.ceil(np.log2(end / start)))
        return _composite(np.concatenate([[0.0], np.geomspace(start, end, count + 1)]))


@lru_cache(maxsize=32)
def rest_in_space(response: LayerResponse) -> RestInSpace:
    """The tables of one pair of materials, filled as they are used."""
    return RestInSpace(response)


def _composite(ends: Array) -> tuple[Array, Array]:
    nodes, weights = leggauss(POINTS)
    middle, half = (ends[1:] + ends[:-1]) / 2, np.diff(ends) / 2
    return (middle[:, None] + half[:, None] * nodes).ravel(), (half[:, None] * weights).ravel()
