"""From the displacement of a contact to a pressure on it: what to precondition with."""

from collections.abc import Callable

import numpy as np
from numpy.typing import DTypeLike

from contactstudy.domain.devices.arrays import Array
from contactstudy.domain.devices.device import arrays, device, fused
from contactstudy.domain.devices.rows import compiled, in_blocks
from contactstudy.elasticity.extension import Extension
from contactstudy.elasticity.transforms import Waves, transforms

# Single precision has noise in all waves: in the shortest, times this, it may be as large as the longest are.
WIDEST = 1e4


class ApproximateInverse:
    """Division by a ``spectrum`` on the unpadded grid of so many ``cells``, as if it were periodic.

    The displacement of the contact is extended to all cells first, and the pressure found on all
    cells is gathered to the contact by the transposed map, or a fragmented contact would seem far too
    stiff: by more with every halving of the cells. The mean over the grid is mapped to zero. ``room`` gives
    the work array of a transform. It works in ``real`` numbers of this type, if their digits span the range of the
    spectrum: a preconditioner needs few.

    Source: Vollebregt (2014), eq. 20, there on the padded grid and with zeros outside the contact.
    """

    def __init__(
        self,
        spectrum: Array,
        cells: tuple[int, int],
        room: Callable[[tuple[int, int], DTypeLike], Waves | None],
        real: DTypeLike,
    ) -> None:
        xp = arrays()
        inverse = 1 / spectrum
        inverse[0, 0] = 0.0
        if float(xp.max(inverse)) * float(xp.max(spectrum)) > WIDEST:
            real = spectrum.dtype
        self._inverse, self.real = xp.astype(inverse, real, copy=False), real
        self._cells, self._room = cells, room
        # displacements fall like wave numbers grow, so that the shortest waves tell the cell's sides
        self._elongation = float(spectrum[0, -1]) / float(spectrum[cells[0] // 2, 0])

    @property
    def work(self) -> float:
        """Cells transformed in one application."""
        return float(self._cells[0] * self._cells[1])

    def extension(self, contact: Array) -> Extension:
        """From the displacement of a ``contact`` (x, y), which is 1 there and 0 elsewhere, to that of all cells."""
        return Extension(contact, self._elongation)

    def waves(self, displacement: Array) -> Waves:
        """Waves of the pressure on all cells that makes a ``displacement`` (x, y) of all cells."""
        room = self._room(self._cells, self.real)
        waves = transforms().forward(displacement, self._cells, room)
        scale(waves, self._inverse)
        return waves

    def pressure(self, waves: Waves) -> Array:
        """The pressure (x, y) with these ``waves``, which are lost."""
        return transforms().backward(waves, self._cells, self._cells)

    def __call__(self, displacement: Array, contact: Array) -> Array:
        """The pressure on a ``contact`` with this ``displacement`` (x, y), which is zero elsewhere."""
        extension = self.extension(contact)
        return extension.transposed(self.pressure(self.waves(extension(displacement))))


def sampled(spectrum: Array, cells: tuple[int, int], padded: tuple[int, int]) -> Array:
    """The spectrum of a padded grid at the waves of the unpadded one, above zero."""
    xp, put = arrays(), device().put
    (nx, ny), (px, py) = cells, padded
    across = np.round(np.arange(nx) * (px / nx)).astype(int) % px
    along = np.minimum(np.round(np.arange(ny // 2 + 1) * (py / ny)).astype(int), py // 2)
    found = xp.take(xp.take(spectrum, put(across), axis=0), put(along), axis=1)
    # a window of images may make a coefficient zero or negative; that of the half-space is positive
    sizes = xp.abs(found)
    smallest = float(xp.min(sizes[1:, :])) if nx > 1 else float(xp.max(sizes))
    return xp.maximum(found, 1e-3 * smallest)


def scale(waves: Waves, factors: Array) -> None:
    """Multiply ``waves`` in place."""
    kernels = fused()
    if kernels is not None and np.isrealobj(factors):
        compiled(kernels.scale, waves.view(factors.dtype), factors)
        return

    def some(rows: slice) -> None:
        own = waves[rows, :]
        own *= factors[rows, :]

    in_blocks(some, waves.shape)
