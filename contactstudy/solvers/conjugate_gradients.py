"""Conjugate gradients for a self-adjoint positive semidefinite operator in any inner product."""

from collections.abc import Callable

import numpy as np

from contactstudy.domain.fields import Array


def conjugate_gradients(
    product: Callable[[Array], Array],
    precondition: Callable[[Array], Array],
    inner: Callable[[Array, Array], float],
    rhs: Array,
    rtol: float,
    maxiter: int,
) -> Array:
    """Return an approximate solution x of ``product(x) = rhs``.

    The operator `product` and the preconditioner `precondition` are self-adjoint and positive semidefinite in the inner
    product `inner`. The iteration begins with zero, and ends where the norm of the residual, ``sqrt(inner(r, M r))``
    with the preconditioner M, has fallen to `rtol` times the first one, after `maxiter` applications of the operator, or
    at a direction without curvature. Source: Hestenes & Stiefel (1952), eq. 3:1.
    """
    solution, residual = np.zeros_like(rhs), rhs
    preconditioned = precondition(residual)
    direction, size = preconditioned, inner(residual, preconditioned)
    target = rtol**2 * size
    for _ in range(maxiter):
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
