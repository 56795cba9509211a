"""Elastic part of the slip of the first against the second body: a linear, monotone map of the tangential traction."""

from typing import Protocol

import numpy as np

from contactstudy.domain.fields import Array
from contactstudy.elasticity.approximate_inverse import at_unpadded_wave_numbers
from contactstudy.elasticity.convolution import GeneralConvolution
from contactstudy.elasticity.tangential import ShearResponse
from contactstudy.elasticity.transforms import TRANSFORMS


class SlipOperator(Protocol):
    """Linear map D from traction to elastic slip, both (component, x, y), whose symmetric part is positive definite."""

    @property
    def self_compliance(self) -> float:
        """Slip of a cell under a unit traction along x on it alone, less the mean slip of all cells; above zero."""

    def __call__(self, shear: Array) -> Array:
        """Return the slip under `shear`."""

    def approximate_inverse(self, slip: Array) -> Array:
        """Return an approximation to the traction (component, x, y) of a `slip` of some cells, which is zero elsewhere.

        The given array may be overwritten.
        """


class QuasiStaticSlip:
    """Elastic slip of a contact at rest: the displacement A q itself, from a state without tangential traction.

    `response` is the displacement under traction, A.
    """

    def __init__(self, response: ShearResponse) -> None:
        self._response = response
        direct = _coefficients(response.xx)
        self.self_compliance = float(direct[0, 0] - direct.mean())
        self._inverse = _inverses(response)

    def __call__(self, shear: Array) -> Array:
        """Return the slip under `shear`, both (component, x, y)."""
        return self._response(shear)

    def approximate_inverse(self, slip: Array) -> Array:
        """Return `slip` divided by the spectra of A on the unpadded, periodic grid: a circulant preconditioner."""
        return _filtered(slip, self._inverse)


class RollingSlip:
    """Elastic slip of steady rolling per distance rolled: ``(D q)(x) = [(A q)(x) - (A q)(x + step)] / |step|``.

    Parameters
    ----------
    response
        Displacement under tangential traction, A.
    step
        Width of a cell [m], negative where the contact moves to smaller x.
    """

    def __init__(self, response: ShearResponse, step: float) -> None:
        self._length = abs(step)
        self._ahead = 1 if step > 0 else -1
        rows = response.xx.padded[0]
        # phase factors of a shift by one cell
        shift = np.exp(2j * np.pi * self._ahead / rows * np.arange(rows))
        self._slip = response.scaled((1 - shift)[:, None] / abs(step))
        self.self_compliance = float(_coefficients(self._slip.xx)[0, 0])
        self._inverse = _inverses(response)

    def __call__(self, shear: Array) -> Array:
        """Return the slip under `shear`, both (component, x, y)."""
        return self._slip(shear)

    def approximate_inverse(self, slip: Array) -> Array:
        """Return `slip` summed from the leading edge, which undoes the difference, and divided by the spectra of A."""
        summed = np.cumsum(slip[:, :: -self._ahead], axis=1)[:, :: -self._ahead]
        return self._length * _filtered(summed, self._inverse)


def _coefficients(part: GeneralConvolution) -> Array:
    """Return the convolution (x, y) of a unit in the first cell."""
    return TRANSFORMS.backward(part.spectrum.copy(), part.cells, part.padded)


def _inverses(response: ShearResponse) -> list[Array]:
    """Return the inverse spectra of both components, the zero wave number with the largest compliance of the others."""
    inverses = []
    for part in (response.xx, response.yy):
        sizes = at_unpadded_wave_numbers(np.abs(part.spectrum.real), part.cells, part.padded)
        sizes[0, 0] = 0
        sizes[0, 0] = largest = sizes.max()
        inverses.append(1 / np.maximum(sizes, 1e-9 * largest))
    return inverses


def _filtered(field: Array, factors: list[Array]) -> Array:
    """Return a `field` (component, x, y) with its Fourier coefficients on the unpadded grid times the `factors`."""
    pairs = zip(field, factors, strict=True)
    return np.stack([TRANSFORMS.filtered(component, factor, None) for component, factor in pairs])
