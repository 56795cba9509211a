"""Response of a layered half-space to a wave of pressure or tangential traction, and its short-ranged remainder.

In space the remainder is two functions of one distance, tabulated once for each pair of materials.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray
from scipy.special import j1, k1

from contactstudy.domain.fields import Array
from contactstudy.elasticity.kernels.displacement_cell import mean_gauss_rule

RealOrComplex = NDArray[np.inexact[Any]]

# Below this the difference sinh(k)^2 - k^2 is summed as a series.
SERIES_END = 1.0


@dataclass(frozen=True)
class LayerResponse:
    """Displacement of a layer on a half-space under a wave of pressure, over that of the layer's own half-space.

    With k the wave number times the thickness, the quotient is ``1 + D(k)`` with ``D = d0 exp(-2 k) + R(k)``; d0 is
    `contrast`, and R is the `remainder`, which is zero at k = 0 and decays like ``k^2 exp(-2 k)``.

    Source: plane strain of a bonded layer (Burmister 1945; Johnson 1985, sect. 5.8). It holds for every direction of the
    wave.

    Parameters
    ----------
    shear_ratio
        Shear modulus of the layer over that of the substrate, from 0 (a rigid substrate) on.
    coating_poisson_ratio, substrate_poisson_ratio
        Poisson's ratios.
    """

    shear_ratio: float
    coating_poisson_ratio: float
    substrate_poisson_ratio: float

    @cached_property
    def _mismatch(self) -> tuple[float, float, float, float, float]:
        """Mismatch of the materials (Burmister 1945): lambda, kappa, ``1 - lambda``, ``1 - kappa`` and a cross term.

        The cross term is ``lambda (1 - kappa) + kappa (1 - lambda)``.
        """
        m, nu1, nu2 = (self.shear_ratio, self.coating_poisson_ratio, self.substrate_poisson_ratio)
        below, above = 1 + m * (3 - 4 * nu2), m + 3 - 4 * nu1
        lam = (m * (3 - 4 * nu2) - (3 - 4 * nu1)) / below
        kap, one_lam, one_kap = (m - 1) / above, 4 * (1 - nu1) / below, 4 * (1 - nu1) / above
        return lam, kap, one_lam, one_kap, lam * one_kap + kap * one_lam

    @property
    def contrast(self) -> float:
        """Plane-strain modulus of the layer over that of the substrate, less one, d0."""
        ratio = (1 - self.substrate_poisson_ratio) / (1 - self.coating_poisson_ratio)
        return self.shear_ratio * ratio - 1

    @property
    def coupling_contrast(self) -> float:
        """``1 - 2 nu`` of the substrate times the ratio of the shear moduli, less that of the layer: h0."""
        soft = 1 - 2 * self.substrate_poisson_ratio
        return self.shear_ratio * soft - (1 - 2 * self.coating_poisson_ratio)

    @property
    def slope(self) -> float:
        """Derivative of `remainder` at k = 0."""
        lam, kap, one_lam, one_kap, cross = self._mismatch
        return (4 * kap + 2 * (2 * lam * kap - self.contrast * cross)) / (one_lam * one_kap)

    @property
    def pole_distance_from_zero(self) -> float:
        """Lower bound of the distance of singularities of `remainder` from k = 0.

        The nearest one tends to ``k = -(1 - nu1) / (2 m (1 - nu2))`` for a stiff layer, with the ratio m of the shear
        moduli; the bound takes nu1 = 1/2.
        """
        return min(0.2, 0.25 / (1 - self.substrate_poisson_ratio)) / max(self.shear_ratio, 1.0)

    @property
    def pole_distance_from_real_axis(self) -> float:
        """Lower bound of the distance of poles of `remainder` in the right half-plane from the real axis.

        On the imaginary axis itself an incompressible layer on a rigid substrate has one at 0.74, where what is
        integrated along that axis has decayed.
        """
        return float(0.85 * max(self.shear_ratio, 1.0) ** (-1 / 3))

    def remainder(self, k: RealOrComplex) -> RealOrComplex:
        """Return R(k), the short-ranged response, without cancellation for small k or very unlike materials."""
        return self._remainder(k, 1)

    def shear_remainders(
        self, k: RealOrComplex
    ) -> tuple[RealOrComplex, RealOrComplex, RealOrComplex]:
        """Return what R(k) is under tangential traction: along the wave, across it, and of the displacements' coupling.

        Displacement by traction along the wave is ``2 (1 - nu1^2) / (E1 q) (1 + d0 exp(-2 k) + R)``. By traction across
        the wave it is ``1 / (G1 q) (1 + (m - 1) exp(-2 k) + R)``, with m the ratio of the shear moduli. Normal
        displacement by traction along the wave is ``1 / (2 G1 q) (1 - 2 nu1 + h0 exp(-2 k) + R)``, a quarter of a wave
        behind, with h0 the `coupling_contrast`. The wave number q [1/m] times the thickness is k, and E1, G1 and nu1
        are the layer's. Source: that of the class; antiplane strain of the layer across the wave.
        """
        _, kap, one_lam, one_kap, cross = self._mismatch
        ratio = (self.shear_ratio - 1) / (self.shear_ratio + 1)
        t, u = np.exp(-2 * k), -np.expm1(-2 * k)
        antiplane = -2 * ratio**2 * t * u / ((1 - ratio) * (1 - ratio + ratio * u))
        h0, remainder = self.coupling_contrast, u * cross + kap * self._higher_order(k)
        above = 8 * kap * k * k * (1 - self.coating_poisson_ratio) - h0 * remainder
        coupling = t * above / (one_lam * one_kap + remainder)
        return self._remainder(k, -1), antiplane, np.asarray(coupling)

    def _remainder(self, k: RealOrComplex, sign: int) -> RealOrComplex:
        """Return the remainder under pressure (`sign` 1) or shear along the wave (-1)."""
        lam, kap, one_lam, one_kap, cross = self._mismatch
        t, u = np.exp(-2 * k), -np.expm1(-2 * k)
        higher_order, d0 = self._higher_order(k), self.contrast
        above = (
            4 * kap * k * (sign + k) + u * (2 * lam * kap - d0 * cross) - d0 * kap * higher_order
        )
        return np.asarray(t * above / (one_lam * one_kap + u * cross + kap * higher_order))

    def _higher_order(self, k: RealOrComplex) -> RealOrComplex:
        """Return the part of the denominator over kappa that is of order k^2."""
        lam, _, one_lam, *_ = self._mismatch
        t, u = np.exp(-2 * k), -np.expm1(-2 * k)
        # (1 - t)^2 - 4 k^2 t, of order k^4
        fourth = u * u - 4 * k * k * t
        small = np.abs(k) < SERIES_END
        if small.any():
            fourth[small] = 4 * t[small] * _sinh_square_less_square(k[small])
        return np.asarray(lam * fourth - 4 * k * k * t * one_lam)

    @cached_property
    def taylor(self) -> tuple[float, float, float]:
        """Coefficients of k^2, k^4 and k^6 in `remainder`, which give its far field in space."""
        second, fourth, sixth = self.taylor_coefficients(self.remainder)[2::2]
        return second, fourth, sixth

    def taylor_coefficients(
        self, function: Callable[[RealOrComplex], RealOrComplex]
    ) -> list[float]:
        """Return the Taylor coefficients up to k^6 of a `function` that is as regular at k = 0 as the response."""
        around = 0.5 * self.pole_distance_from_zero
        turn = np.exp(2j * np.pi * np.arange(64) / 64)
        terms = np.real(np.fft.fft(function(around * turn))) / 64
        return [float(term / around**n) for n, term in enumerate(terms[:7])]


def _sinh_square_less_square(k: RealOrComplex) -> RealOrComplex:
    """Return ``sinh(k)^2 - k^2`` for small k: ``sum (2 k)^(2 n) / (2 (2 n)!)`` from n = 2 on."""
    square = 4 * k * k
    term = square * square / 48
    total = term.copy()
    for n in range(3, 14):
        term = term * square / ((2 * n - 1) * (2 * n))
        total = total + term
    return np.asarray(total)


# The tables' pieces are [0, 1], [1, 2], [2, 4] ... thicknesses: singularities at two thicknesses and, of
# the far form, at zero lie outside a Bernstein ellipse of rho = 5.8.
CHEBYSHEV_POINTS = 22
# R is below 2e-14 of its largest beyond this k.
LAST_WAVE = 20.0
# Gauss points on each piece of k, at most two oscillations long.
GAUSS_POINTS = 18
# exp(-x) is neglected beyond this x
NEGLIGIBLE_EXPONENT = 42.0


class RemainderTables:
    """Tables in space of R(k), the short-ranged part of a :class:`LayerResponse`: `edge` and `strip`.

    Distances are in thicknesses. The tables are filled as they are used.
    """

    def __init__(self, response: LayerResponse) -> None:
        self.response = response
        self._edge: dict[int, Array] = {}
        self._strip: dict[int, Array] = {}

    def edge(self, s: Array) -> Array:
        """Return ``(1 / s) int R(k) J1(k s) / k dk``.

        Times s it is the radial field with the divergence ``int R(k) J0(k s) dk``.
        """
        return self._interpolated(s, self._edge, self._edge_at)

    def strip(self, s: Array) -> Array:
        """Return ``int R(k) sin(k s) / k^2 dk``, which is odd in s.

        It is the integral from 0 to s of ``int R(k) cos(k s) / k dk``.
        """
        return np.asarray(s * self._interpolated(np.abs(s), self._strip, self._strip_at))

    def _interpolated(
        self, s: Array, pieces: dict[int, Array], exact: Callable[[Array], Array]
    ) -> Array:
        """Return a tabulated function at `s`, after adding to `pieces` those that `s` needs from `exact` values."""
        # frexp: s in [2^(e-1), 2^e)
        piece = np.maximum(np.frexp(s)[1], 0)
        result = np.empty(s.shape)
        for number in np.unique(piece).tolist():
            start, end = (0.0, 1.0) if number == 0 else (2.0 ** (number - 1), 2.0**number)
            if number not in pieces:
                nodes = chebyshev.chebpts1(CHEBYSHEV_POINTS)
                values = exact((start + end) / 2 + (end - start) / 2 * nodes)
                pieces[number] = chebyshev.chebfit(nodes, values, CHEBYSHEV_POINTS - 1)
            chosen = piece == number
            local = (2 * s[chosen] - start - end) / (end - start)
            result[chosen] = chebyshev.chebval(local, pieces[number])
        return result

    def _edge_at(self, s: Array) -> Array:
        """Return `edge` at distances `s` in order, by quadrature over k."""
        response = self.response
        if s[0] >= NEGLIGIBLE_EXPONENT / response.pole_distance_from_real_axis:
            # along the imaginary axis, where J1 decays as K1; the neglected part is below rounding
            tau, weight = self._imaginary(float(s[0]))
            even = np.real(response.remainder(1j * tau)) / tau
            far = k1(np.multiply.outer(s, tau)) @ (even * weight)
            return np.asarray((response.slope / s - 2 / np.pi * far) / s)
        k, weight = self._real(float(s[-1]))
        integrand = np.real(response.remainder(k)) / k * weight
        return np.asarray(j1(np.multiply.outer(s, k)) @ integrand / s)

    def _strip_at(self, s: Array) -> Array:
        """Return `strip` over `s` at distances `s` in order, by quadrature over k."""
        response = self.response
        if s[0] >= NEGLIGIBLE_EXPONENT / response.pole_distance_from_real_axis:
            tau, weight = self._imaginary(float(s[0]))
            even = np.real(response.remainder(1j * tau)) / tau**2
            far = np.exp(-np.multiply.outer(s, tau)) @ (even * weight)
            return np.asarray((np.pi / 2 * response.slope - far) / s)
        k, weight = self._real(float(s[-1]))
        integrand = np.real(response.remainder(k)) / k * weight
        return np.asarray(np.sinc(np.multiply.outer(s, k) / np.pi) @ integrand)

    def _real(self, s: float) -> tuple[Array, Array]:
        """Return Gauss points and weights for integrals over k of a field that oscillates with ``k s``."""
        longest = min(0.5, 4 * np.pi / max(s, 1.0))
        ends = [0.0, min(self.response.pole_distance_from_zero, longest)]
        while ends[-1] < LAST_WAVE:
            ends.append(ends[-1] + min(ends[-1], longest))
        return composite(np.array(ends))

    def _imaginary(self, s: float) -> tuple[Array, Array]:
        """Return Gauss points and weights for integrals over tau of a field that decays like ``exp(-s tau)``."""
        end = min(self.response.pole_distance_from_real_axis, NEGLIGIBLE_EXPONENT / s)
        start = 1e-3 * min(self.response.pole_distance_from_zero, 1 / s)
        count = int(np.ceil(np.log2(end / start)))
        return composite(np.concatenate([[0.0], np.geomspace(start, end, count + 1)]))


@lru_cache(maxsize=32)
def remainder_tables(response: LayerResponse) -> RemainderTables:
    """Return the tables of one pair of materials."""
    return RemainderTables(response)


def composite(ends: Array) -> tuple[Array, Array]:
    """Return Gauss points and weights on pieces between `ends`."""
    nodes, weights = np.array(mean_gauss_rule(GAUSS_POINTS)).T
    middle, width = (ends[1:] + ends[:-1]) / 2, np.diff(ends)
    points = middle[:, None] + width[:, None] / 2 * nodes
    return points.ravel(), (width[:, None] * weights).ravel()
