"""Convolution across of fields in layers, by real matrices that take every layer to every layer, wave by wave.

Components are even in x but one, which is odd: the waves of that one times -i make the matrices real. Transforms are
padded to twice the cells, without error.
"""

import numpy as np
from scipy import fft

from contactstudy.domain.devices.arrays import Array


def padded_cells(across: int) -> int:
    """How many cells the transforms of so many have."""
    return int(fft.next_fast_len(2 * across, real=True))


def real_spectrum(means: Array, *, is_odd: tuple[bool, bool]) -> Array:
    """The factors (..., waves) of a component by another, from ``means`` (..., x) at offsets 0, 1, 2 ... in cells.

    ``is_odd`` says which of the two, that of the result and that of the source, is the odd one.
    """
    across = means.shape[-1]
    around = np.zeros((*means.shape[:-1], padded_cells(across)))
    around[..., :across] = means
    sign = -1 if is_odd[0] != is_odd[1] else 1
    around[..., around.shape[-1] - across + 1 :] = sign * means[..., :0:-1]
    waves = fft.rfft(around, axis=-1)
    if sign > 0:
        return np.asarray(waves.real)
    # what is odd has waves of -i times its sine transform
    return np.asarray(waves.imag if is_odd[0] else -waves.imag)


def convolved(matrices: Array, fields: Array, odd: int) -> Array:
    """``fields`` (components, layers, x) by ``matrices`` (waves, components layers, components layers)."""
    components, layers, across = fields.shape
    padded = padded_cells(across)
    waves = fft.rfft(fields, padded, axis=-1)
    waves[odd] *= -1j
    columns = np.ascontiguousarray(np.moveaxis(waves, -1, 0)).reshape(-1, components * layers, 1)
    found = np.matmul(matrices, columns.view(np.float64))
    result = np.moveaxis(found.view(np.complex128).reshape(-1, components, layers), 0, -1)
    result[odd] *= 1j
    return np.asarray(fft.irfft(result, padded, axis=-1)[..., :across])
