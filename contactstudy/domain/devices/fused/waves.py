"""A pass over waves."""

from contactstudy.domain.devices.fused.jit import exact
from contactstudy.domain.devices.namespace import Array


@exact
def scale(parts: Array, factors: Array) -> None:
    """Real and imaginary ``parts`` of waves, one after the other, times real factors, in place."""
    for i in range(factors.shape[0]):
        for j in range(factors.shape[1]):
            parts[i, 2 * j] *= factors[i, j]
            parts[i, 2 * j + 1] *= factors[i, j]
