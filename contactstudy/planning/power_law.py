"""The one model of cost: a power law fitted to what was measured, and the spread that was seen."""

from dataclasses import dataclass
from math import log

import numpy as np

from contactstudy.domain.fields import Array

# Prior widths, all of natural logarithms: any scale, exponents and curvatures of ordinary size, and the spread that
# is assumed where too little was measured, which counts as so many measurements.
SCALE, EXPONENT, CURVATURE = 10.0, 0.6, 0.1
SPREAD, MEASUREMENTS = log(1.25), 2
PASSES = 3  # of spread and fit; the spread settles within a percent


@dataclass(frozen=True, eq=False)
class PowerLaw:
    """``log y = c0 + sum_k (p_k u_k + q_k u_k^2)`` with ``u`` the logarithms of what ``y`` depends on.

    Least squares with a weak prior on every coefficient (ridge regression), which decides where the
    measurements do not: an exponent of something that did not vary is zero, give or take 0.6. The curvature
    is small; it follows sums such as ``a + b N``.
    """

    centre: Array
    mean: float
    coefficients: Array
    covariance: Array
    spread: float

    @classmethod
    def fit(cls, logarithms: Array, values: Array) -> "PowerLaw":
        """Of the natural logarithms, shape (measurements, variables), and those of y, (measurements,).

        The spread is that of the errors of each measurement when it is predicted from all others.
        """
        centre, mean = logarithms.mean(axis=0), float(values.mean())
        terms = _terms(logarithms - centre)
        variables = logarithms.shape[1]
        prior = np.diag(
            np.array([SCALE] + [EXPONENT] * variables + [CURVATURE] * variables) ** -2.0
        )
        spread = SPREAD
        for _ in range(PASSES):
            covariance = np.linalg.inv(terms.T @ terms / spread**2 + prior)
            coefficients = covariance @ (terms.T @ (values - mean)) / spread**2
            leverage = np.einsum("ij,jk,ik->i", terms, covariance, terms) / spread**2
            left_out = (values - mean - terms @ coefficients) / np.maximum(1 - leverage, 1e-3)
            total = float((left_out**2).sum()) + MEASUREMENTS * SPREAD**2
            spread = float(np.sqrt(total / (len(values) + MEASUREMENTS)))
        covariance = np.linalg.inv(terms.T @ terms / spread**2 + prior)
        coefficients = covariance @ (terms.T @ (values - mean)) / spread**2
        return cls(centre, mean, coefficients, covariance, spread)

    def predict(self, logarithms: Array) -> tuple[Array, Array]:
        """``log y``, and its standard deviation, which grows away from what was measured."""
        terms = _terms(logarithms - self.centre)
        variance = self.spread**2 + np.einsum("ij,jk,ik->i", terms, self.covariance, terms)
        return self.mean + terms @ self.coefficients, np.sqrt(variance)


def _terms(centred: Array) -> Array:
    return np.column_stack([np.ones(len(centred)), centred, centred**2])
