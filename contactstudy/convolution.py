"""From pressure to displacement by one pruned, real transform pair."""

from dataclasses import dataclass

import numpy as np
from scipy import fft

from contactstudy.arrays import Array
from contactstudy.grid import Grid
from contactstudy.kernel import kernel
from contactstudy.padding import Padding, Paddings, across_and_along


@dataclass(frozen=True, eq=False)
class Convolution:
    """The linear operator ``displacement = K * pressure`` on one grid.

    Call it with a pressure of shape (width, length) [Pa] to get the displacement [m] of the same
    shape. It is symmetric and positive definite. Only the rows that hold pressure are transformed
    along the length, and only the rows asked for are transformed back.
    """

    spectrum: Array
    cells: tuple[int, int]
    padded: tuple[int, int]

    def __call__(self, pressure: Array) -> Array:
        """Displacement [m] under ``pressure`` [Pa], both (width, length)."""
        (nx, ny), (px, py) = self.cells, self.padded
        waves = fft.fft(fft.rfft(pressure, py, axis=1), px, axis=0, overwrite_x=True)
        waves *= self.spectrum
        rows = fft.ifft(waves, axis=0, overwrite_x=True)[:nx]
        return np.asarray(fft.irfft(rows, py, axis=1)[:, :ny])


def convolution(
    contact_modulus: float, grid: Grid, padding: Padding | Paddings, datum: float
) -> Convolution:
    """The operator of two half-spaces on ``grid``.

    ``contact_modulus`` E* [Pa]; ``padding`` along the length, or (across, along); ``datum`` [m] is where
    displacement is counted from in a padding that leaves it open. An axis that wraps is circular, one
    that does not is padded to twice its cells, which makes it linear (Liu, Wang & Liu 2000).
    """
    paddings = across_and_along(padding)
    sizes = zip(grid.cells, paddings, (False, True), strict=True)
    px, py = (
        n if padding.wraps else fft.next_fast_len(2 * n - 1, real=real)
        for n, padding, real in sizes
    )
    coefficients = kernel(grid, paddings, datum) / (np.pi * contact_modulus)
    around = coefficients[np.ix_(*map(_around, coefficients.shape, (px, py)))]
    # even about zero along both axes, so the transform is real
    spectrum = fft.fft(fft.rfft(around, axis=1), axis=0).real
    return Convolution(np.ascontiguousarray(spectrum), grid.cells, (px, py))


def _around(known: int, padded: int) -> np.ndarray[tuple[int], np.dtype[np.intp]]:
    """Offset of each point of a padded axis from zero; the last known stands where no pair looks."""
    index = np.arange(padded)
    return np.minimum(np.minimum(index, padded - index), known - 1)
