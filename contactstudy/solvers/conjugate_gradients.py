"""Conjugate gradients for a symmetric positive linear map in any inner product."""

from collections.abc import Callable

import numpy as np

from contactstudy.domain.fields import Array


def conjugate_gradients(
    product: Callable[[Array], Array],
    precondition: Callable[[Array], Array],
    inner: Callable[[Array, Array], float],
    right_side: Array,
    fraction: float,
    max_products: int,
) -> Array:
    """Return an approximate x with ``product(x) = right_side``.

    Conjugate gradients for a map that is symmetric and not negative in the inner product `inner`. They stop when the
    residual has fallen to a `fraction` of the first, in the norm of the preconditioner, after `max_products`, or at a
    direction without curvature. Source: Hestenes & Stiefel (1952), eq. 3:1.
    """
    solution, residual = np.zeros_like(right_side), right_side
    preconditioned = precondition(residual)
    direction, size = preconditioned, inner(residual, preconditioned)
    target = fraction**2 * size
    for _ in range(max_products):
        if not size > target:
            break
        response = product(direction)
        curvature = inner(direction, response)
        if not curvature > 0:
            break
        length = size / curvature
        solution = solution + length * direction
        residual = residual - length * response
        preconditioned = precondition(residual)
        last, size = size, inner(residual, preconditioned)
        direction = preconditioned + (size / last) * direction
    return solution
