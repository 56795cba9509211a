"""Preconditioned conjugate gradients for a linear system that is given as a product."""

from collections.abc import Callable

import numpy as np

from contactstudy.domain.devices.arrays import Array


def conjugate_gradients(
    product: Callable[[Array], Array],
    precondition: Callable[[Array], Array],
    inner: Callable[[Array, Array], float],
    wanted: Array,
    share: float,
    most: int,
) -> Array:
    """What ``product`` maps to ``wanted``, in the product ``inner`` in which it is symmetric and not negative.

    The residual falls to a ``share`` of the first, in the norm of the preconditioner, in at ``most`` so many products;
    a direction without curvature ends it before. Source: Hestenes & Stiefel (1952), eq. 3:1.
    """
    found, rest = np.zeros_like(wanted), wanted
    closing = precondition(rest)
    direction, size = closing, inner(rest, closing)
    enough = share**2 * size
    for _ in range(most):
        if not size > enough:
            break
        response = product(direction)
        curvature = inner(direction, response)
        if not curvature > 0:
            break
        length = size / curvature
        found = found + length * direction
        rest = rest - length * response
        closing = precondition(rest)
        last, size = size, inner(rest, closing)
        direction = closing + (size / last) * direction
    return found
