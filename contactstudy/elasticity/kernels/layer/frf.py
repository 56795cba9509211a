"""How a layered half-space answers one wave of pressure."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

Numbers = NDArray[np.inexact[Any]]

# Below this the difference sinh k - k is summed as a series.
SERIES_END = 1.0


@dataclass(frozen=True)
class LayerResponse:
    """Displacement of a layer on a half-space under a wave of pressure, over that of the layer's own half-space.

    With k the wave number times the thickness, the quotient is ``1 + D(k)`` with
    ``D = d0 exp(-2 k) + R(k)``; ``d0`` is ``contrast``, and ``R`` is ``rest``, which is zero at k = 0 and
    decays like ``k^2 exp(-2 k)``. ``shear_ratio`` is the layer's shear modulus over the substrate's,
    from 0 (a rigid substrate) on.

    Source: plane strain of a bonded layer under normal pressure, without shear on its surface
    (Burmister 1945; Johnson 1985, sect. 5.8), which holds for every direction of the wave.
    """

    shear_ratio: float
    coating_poisson_ratio: float
    substrate_poisson_ratio: float

    @cached_property
    def _mismatch(self) -> tuple[float, float, float, float]:
        """lambda and kappa, and what each leaves of one."""
        m, nu1, nu2 = (
            self.shear_ratio,
            self.coating_poisson_ratio,
            self.substrate_poisson_ratio,
        )
        below, above = 1 + m * (3 - 4 * nu2), m + 3 - 4 * nu1
        lam = (m * (3 - 4 * nu2) - (3 - 4 * nu1)) / below
        return lam, (m - 1) / above, 4 * (1 - nu1) / below, 4 * (1 - nu1) / above

    @property
    def contrast(self) -> float:
        """d0: the layer's plane-strain modulus over the substrate's, less one."""
        ratio = (1 - self.substrate_poisson_ratio) / (1 - self.coating_poisson_ratio)
        return self.shear_ratio * ratio - 1

    @property
    def slope(self) -> float:
        """R'(0)."""
        lam, kap, one_lam, one_kap = self._mismatch
        cross = lam * one_kap + kap * one_lam
        return (4 * kap + 2 * (2 * lam * kap - self.contrast * cross)) / (one_lam * one_kap)

    @property
    def nearest_pole(self) -> float:
        """R has no singularity nearer to k = 0 than this."""
        return 0.2 / max(self.shear_ratio, 1.0)

    @property
    def first_pole(self) -> float:
        """R has no pole in the right half-plane nearer to the real axis than this."""
        return 0.85 * min(1.0, self.shear_ratio ** (-1 / 3) if self.shear_ratio else 1.0)

    def rest(self, k: Numbers) -> Numbers:
        """R(k), written so that nothing cancels for small k or for very unlike materials."""
        lam, kap, one_lam, one_kap = self._mismatch
        cross = lam * one_kap + kap * one_lam
        t, u = np.exp(-2 * k), -np.expm1(-2 * k)
        # (1 - t)^2 - 4 k^2 t, of order k^4
        fourth = u * u - 4 * k * k * t
        small = np.abs(k) < SERIES_END
        if small.any():
            fourth[small] = 4 * t[small] * _sinh_square_less_square(k[small])
        bent = lam * fourth - 4 * k * k * t * one_lam
        d0 = self.contrast
        above = 4 * kap * k * (1 + k) + u * (2 * lam * kap - d0 * cross) - d0 * kap * bent
        return np.asarray(t * above / (one_lam * one_kap + u * cross + kap * bent))

    def taylor(self) -> tuple[float, float, float]:
        """Coefficients of k^2, k^4 and k^6 in R, which its far field decays by."""
        around = 0.5 * self.nearest_pole
        turn = np.exp(2j * np.pi * np.arange(64) / 64)
        series = np.real(np.fft.fft(self.rest(around * turn))) / 64
        second, fourth, sixth = (float(series[n] / around**n) for n in (2, 4, 6))
        return second, fourth, sixth


def _sinh_square_less_square(k: Numbers) -> Numbers:
    """``sinh(k)^2 - k^2`` for small k: ``sum (2 k)^(2 n) / (2 (2 n)!)`` from n = 2 on."""
    square = 4 * k * k
    term = square * square / 48
    total = term.copy()
    for n in range(3, 14):
        term = term * square / ((2 * n - 1) * (2 * n))
        total = total + term
    return np.asarray(total)
