"""Preconditioner of a contact problem: from the displacement of the active set to an approximate pressure on it.

The active set is the cells in contact, whose gap should be zero. For a displacement ``u`` known on it

1. ``u`` is extended to all cells with nearly the least elastic energy,
2. the extended displacement is divided by the spectrum of the operator on the periodic grid,
3. the pressure is restricted to the set by the transposed extension.

:class:`SpectralInverse` does this; :class:`FreeEndsInverse` does it near the free ends of a grid. Their ``extension``
is made once for an active set, and then maps fields: it holds steps 1 and 3 in one object.

Extending ``u`` by zeros instead makes a fragmented contact far too stiff, by more with every halving of the cells. With
``w`` = 1 in the contact and 0 elsewhere, the extension outside the contact is the weighted mean ``G(u) / G(w)``. In this
normalised convolution the nearest cells of the contact weigh most.

The extension of least energy is the mean of ``u`` over the first hitting point of a Levy flight. Its jumps are
distributed as the inverse ``S`` of the operator couples cells, like ``r^-3`` (Kyprianou, Osojnik & Shardlow 2018). The
kernel of this extension falls like ``r^-3`` beyond the width of the holes in the contact, and more slowly within. So
does the kernel of ``G = (1 + t S)^(-1/2)``: it is positive, a mixture of Poisson's kernels, and falls like ``r^-3/2``
up to a length that ``t`` sets.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable
from functools import cached_property, partial
from math import ceil, log2, prod

import numpy as np
from numpy.typing import DTypeLike

from contactstudy.domain.device import Cpu, arrays, device
from contactstudy.domain.grid import Array, compiled_loops, device_loops, first_cells
from contactstudy.elasticity.transforms import ComplexField, transforms

# Largest ratio of two values of the spectrum in single precision. A transform's rounding, 1e-7 of the largest value, is
# the same in all wave numbers: beyond this ratio the smallest would have fewer than three digits.
SINGLE_RANGE = 1e4
# Length of the smoothing kernel of G over the width of a hole. Of 1, 1.5, 2 and 3 this takes the fewest iterations on
# sparse contacts, and of 1, 2 and 4 the fewest in the sum over 15 contacts.
HOLES = 2.0
# A weight G(w) below this multiple of the machine epsilon and the largest weight is rounding of a transform, and raised
# to that before it divides. Values from 1 to 1e4 take as many iterations for balls and rough rollers.
NOISE = 100.0
# Ratio of the sides of a cell from which on cells are not merged into blocks of 2 x 2. Up to 4, merged cells make solves
# of a rough roller 1.3 to 1.9 times as fast, at 8 at most 1.2 times, at 12 not at all.
ASPECT_RATIO = 4.0
# Number of cells, 2048 x 2048, from which on they are merged on a GPU: fewer do not keep it busy.
MIN_GPU_CELLS = 2**22
# Cells beyond a free end of the grid, over its own. With 1/16, 1/8, 1/4 or 1, spheres, rough spheres and rough flats
# that reach the ends of 64 x 64 to 1024 x 1024 cells take as many iterations.
MARGIN = 1 / 16


class SpectralInverse:
    """Preconditioner: division by the spectrum on the unpadded grid, as if it were periodic.

    The mean over the grid is mapped to zero. Where cells are square enough, extensions are made on blocks of 2 x 2
    cells by the same map on those. Source: Vollebregt (2014), eq. 20, there on the padded grid and with zeros outside
    the set.

    Parameters
    ----------
    spectrum
        Spectrum of the operator at the wave numbers of the unpadded grid (x, y // 2 + 1).
    cells
        Cells of the grid (across, along).
    work_array
        Returns the array (x, y // 2 + 1) that a transform of a field of a shape (x, y) and a type of real numbers may
        overwrite, or None for a new one.
    real
        Type of the numbers to work in, if their digits span the range of the spectrum; else that of the spectrum.
    """

    def __init__(
        self,
        spectrum: Array,
        cells: tuple[int, int],
        work_array: Callable[[tuple[int, int], DTypeLike], ComplexField | None],
        real: DTypeLike,
    ) -> None:
        xp = arrays()
        inverse = 1 / spectrum
        inverse[0, 0] = 0.0
        if float(xp.max(inverse)) * float(xp.max(spectrum)) > SINGLE_RANGE:
            real = spectrum.dtype
        self._inverse, self.real = xp.astype(inverse, real, copy=False), real
        self._cells, self._work_array = cells, work_array
        self._transforms, self._waves = transforms(), work_array(cells, real)
        # 1 / spectrum at the shortest wave along either axis
        self._stiffest = max(float(inverse[cells[0] // 2, 0]), float(inverse[0, -1]))
        # the length of the smoothing kernel of G in cells, and its spectrum, once an active set has holes
        self._smoothing: tuple[float, Array] = 0.0, self._inverse
        self._coarser, self._transformed = self._on_blocks(spectrum), 0

    @property
    def cells_transformed(self) -> float:
        """Number of cells transformed so far, counted once for a transform and its inverse."""
        return self._transformed + (self._coarser.cells_transformed if self._coarser is not None else 0.0)

    def extension(self, active: Array) -> "SpectralExtension":
        """Return the map from the displacement of an `active` set (x, y), which is not empty, to that of all cells."""
        if self._coarser is not None:
            return BlockExtension(active, self._coarser, self.pressure)
        width = hole_width(active)
        if not width:  # the set has a part of every cell: each cell is extended from its own part
            return SmoothedExtension(active, lambda field: arrays().asarray(field, copy=True), self.pressure)
        # a power of two, so that the spectrum is kept while the set changes little
        width = 2.0 ** round(log2(HOLES * width))
        if width != self._smoothing[0]:
            # t S is the wave number [1/cell] times the width, since the shortest wave has the wave number pi
            stretch = width * np.pi / self._stiffest
            self._smoothing = width, 1 / arrays().sqrt(1 + stretch * self._inverse)
        return SmoothedExtension(active, partial(self._filtered, factors=self._smoothing[1]), self.pressure)

    def pressure(self, displacement: Array) -> Array:
        """Return the pressure on all cells that makes a `displacement` (x, y) of all cells, both periodic."""
        return self._filtered(displacement, self._inverse)

    def _on_blocks(self, spectrum: Array) -> "SpectralInverse | None":
        """Return the same map on blocks of 2 x 2 cells with the `spectrum` of their wave numbers, or None.

        There is none where cells are elongated, too few to pay, or along one axis no multiple of 4, and without
        compiled loops. A GPU has loops for blocks and for smoothing; numba, on large grids, for blocks alone.
        """
        xp, (nx, ny) = arrays(), self._cells
        too_few = not isinstance(device(), Cpu) and nx * ny < MIN_GPU_CELLS
        if compiled_loops(self._cells) is None or too_few or nx % 4 or ny % 4:
            return None
        # the shortest waves along an axis displace the surface in proportion to their length, two cells
        aspect_ratio = float(spectrum[0, -1]) / float(spectrum[nx // 2, 0])
        if not 1 / ASPECT_RATIO < aspect_ratio < ASPECT_RATIO:
            return None
        low = xp.concat([spectrum[: nx // 4, :], spectrum[nx - nx // 4 :, :]])
        low = first_cells(low, (nx // 2, ny // 4 + 1))
        return SpectralInverse(low, (nx // 2, ny // 2), self._work_array, self.real)

    def _filtered(self, field: Array, factors: Array) -> Array:
        """Return `field` with its Fourier coefficients multiplied by `factors`."""
        self._transformed += prod(field.shape)
        return self._transforms.filtered(field, factors, self._waves)


class FreeEndsInverse:
    """Preconditioner on a grid with free ends: a spectral inverse, near an end that of a grid with a margin beyond it.

    Without the margin both ends of an axis are coupled, and iterations grow with the grid. The margin is used only
    while the active set reaches into as many cells next to a free end: transforms of the longer grid take longer.

    Parameters
    ----------
    cells
        Cells of the grid (across, along).
    longer
        Cells (across, along) with the margins; the same number along an axis without a free end.
    inverse
        Returns the spectral inverse on a grid of some cells (across, along).
    """

    def __init__(
        self, cells: tuple[int, int], longer: tuple[int, int], inverse: Callable[[tuple[int, int]], SpectralInverse]
    ) -> None:
        self._cells, self._longer, self._make = cells, longer, inverse
        self._within = inverse(cells)
        self.real = self._within.real

    @cached_property
    def _beyond(self) -> SpectralInverse:
        """The inverse on the longer grid."""
        return self._make(self._longer)

    @property
    def cells_transformed(self) -> float:
        """Number of cells transformed so far, counted as by :class:`SpectralInverse`."""
        beyond = self.__dict__.get("_beyond")  # without making it
        return self._within.cells_transformed + (beyond.cells_transformed if beyond else 0.0)

    def extension(self, active: Array) -> "SpectralExtension | LongerExtension":
        """Return the map from the displacement of an `active` set (x, y) to that of all cells."""
        if not self._is_near_an_end(active):
            return self._within.extension(active)
        return LongerExtension(active, self._longer, self._beyond)

    def _is_near_an_end(self, active: Array) -> bool:
        """Return whether any cell of an `active` set (x, y) is within a margin of a free end."""
        (nx, ny), xp = self._cells, arrays()
        across, along = (
            ceil(MARGIN * n) if longer > n else 0 for n, longer in zip(self._cells, self._longer, strict=True)
        )
        ends = (active[:across, :], active[nx - across :, :], active[:, :along], active[:, ny - along :])
        return any(bool(xp.any(end > 0)) for end in ends if prod(end.shape))


class LongerExtension:
    """Extension of an `active` set (x, y) to all cells of a `longer` grid (cells across, along).

    The `inverse` on the longer grid makes it. The grid of the set is the first cells of the longer one along each axis.
    """

    def __init__(self, active: Array, longer: tuple[int, int], inverse: SpectralInverse) -> None:
        self.active, self._longer = active, longer
        self._extension = inverse.extension(self._lengthened(active))

    def __call__(self, displacement: Array) -> Array:
        """Return a `displacement` (x, y), which is zero outside the set, extended to all cells of the longer grid."""
        return self._extension(self._lengthened(displacement))

    def pressure(self, extended: Array) -> Array:
        """Return the pressure (x, y) on the set that makes an `extended` displacement."""
        return first_cells(self._extension.pressure(extended), self.active.shape)

    def _lengthened(self, field: Array) -> Array:
        """Return a `field` (x, y) on the longer grid, zero beyond the ends."""
        longer = arrays().zeros(self._longer, dtype=field.dtype)
        longer[: field.shape[0], : field.shape[1]] = field
        return longer


class SpectralExtension(ABC):
    """Extension from an active set (x, y) to all cells, and restriction from all cells to the set, its transposed map.

    `active` is the fraction of each cell that belongs to the set: 1 or 0, or between them for a block of cells.
    Displacements of the set are given times these fractions. `pressure` maps a displacement of all cells to their
    pressure.
    """

    def __init__(self, active: Array, pressure: Callable[[Array], Array]) -> None:
        self.active, self._pressure = active, pressure

    @abstractmethod
    def __call__(self, displacement: Array) -> Array:
        """Return a `displacement` (x, y), which is zero outside the set, extended to all cells."""

    @abstractmethod
    def transposed(self, pressure: Array) -> Array:
        """Return a `pressure` (x, y) on all cells restricted to those of the set, by the transposed map, in place."""

    def pressure(self, extended: Array) -> Array:
        """Return the pressure (x, y) on the set that approximately makes an `extended` displacement."""
        return self.transposed(self._pressure(extended))


class SmoothedExtension(SpectralExtension):
    """Extension by the weighted mean of the set's displacement, with the weights of a convolution `smoothed`.

    The convolution is symmetric and positive. It returns a new array.
    """

    def __init__(self, active: Array, smoothed: Callable[[Array], Array], pressure: Callable[[Array], Array]) -> None:
        super().__init__(active, pressure)
        xp = arrays()
        self._smoothed = smoothed
        # (1 - w) / G(w): by it G(u) is divided by the weights, and counts in the part of a cell outside the set alone
        self._outside = weights = smoothed(active)
        noise = NOISE * float(xp.finfo(active.dtype).eps)
        if (loops := device_loops()) is not None:
            loops.outside(active, weights, noise)  # in place
            return
        self._outside = (1 - active) / xp.maximum(weights, noise * float(xp.max(weights)))

    def __call__(self, displacement: Array) -> Array:
        """Return a `displacement` (x, y), which is zero outside the set, extended to all cells."""
        extended = self._smoothed(displacement)
        if (loops := device_loops()) is not None:
            loops.combine(extended, self._outside, displacement)
            return extended
        extended *= self._outside
        extended += displacement
        return extended

    def transposed(self, pressure: Array) -> Array:
        """Return a `pressure` (x, y) on all cells restricted to those of the set, by the transposed map, in place."""
        gathered = self._smoothed(pressure * self._outside)
        if (loops := device_loops()) is not None:
            loops.gather(pressure, gathered, self.active)
            return pressure
        pressure += gathered
        pressure *= self.active
        return pressure


class BlockExtension(SpectralExtension):
    """Extension by way of blocks of 2 x 2 cells, whose means are extended and interpolated linearly.

    A block belongs to the set by the fraction of its cells that do. The blocks are periodic.
    """

    def __init__(self, active: Array, coarser: SpectralInverse, pressure: Callable[[Array], Array]) -> None:
        super().__init__(active, pressure)
        self._loops = compiled_loops(active.shape)  # not None, or there would be no `coarser` inverse
        self._block_active = self._means(active)
        self._extension = coarser.extension(self._block_active)

    def __call__(self, displacement: Array) -> Array:
        """Return a `displacement` (x, y), which is zero outside the set, extended to all cells."""
        blocks = self._extension(self._means(displacement))
        extended = arrays().empty_like(displacement)
        self._loops.interpolated_outside(displacement, blocks, self.active, extended)
        return extended

    def transposed(self, pressure: Array) -> Array:
        """Return a `pressure` (x, y) on all cells restricted to those of the set, by the transposed map, in place."""
        blocks = self._blocks(pressure)
        self._loops.interpolated_outside_transposed(pressure, self.active, blocks)
        blocks = self._extension.transposed(blocks)
        # a whole mean is transposed, but `blocks` came back times the fractions: they are divided out
        self._loops.block_means_transposed(pressure, blocks, self._block_active, self.active)
        return pressure

    def _means(self, field: Array) -> Array:
        """Return the means of `field` (x, y) over blocks of 2 x 2 cells."""
        means = self._blocks(field)
        self._loops.block_means(field, means)
        return means

    def _blocks(self, field: Array) -> Array:
        """Return a field of blocks of 2 x 2 cells, whose values are not set."""
        return arrays().empty((field.shape[0] // 2, field.shape[1] // 2), dtype=field.dtype)


def hole_width(active: Array) -> float:
    """Return the mean width in cells of the stripes between cells of an `active` set (x, y); half that of square holes.

    It is twice the number of cells outside the set over the number of sides between a cell outside and one of the set,
    and 0 for a full or an empty set.
    """
    if (loops := device_loops()) is not None:
        inside, sides = loops.sides(active, results=2)[:, 0].tolist()
        return 2 * (prod(active.shape) - inside) / sides if sides else 0.0
    xp, inside = arrays(), active > 0
    sides = int(xp.count_nonzero(inside[1:, :] != inside[:-1, :]))
    sides += int(xp.count_nonzero(inside[:, 1:] != inside[:, :-1]))
    outside = prod(active.shape) - int(xp.count_nonzero(inside))
    return 2 * outside / sides if sides else 0.0


def at_unpadded_wave_numbers(spectrum: Array, cells: tuple[int, int], padded: tuple[int, int]) -> Array:
    """Return the spectrum of a padded grid at the wave numbers nearest to those of the unpadded one, bounded from below.

    `spectrum` is (px, py // 2 + 1) on `padded` points (px, py), the result (x, y // 2 + 1) for the `cells` (x, y). The
    bound is a thousandth of the smallest magnitude among waves that vary across: it changes none of a half-space.
    """
    xp, put = arrays(), device().to_device
    (nx, ny), (px, py) = cells, padded
    across = np.round(np.arange(nx) * (px / nx)).astype(int) % px
    along = np.minimum(np.round(np.arange(ny // 2 + 1) * (py / ny)).astype(int), py // 2)
    values = xp.take(xp.take(spectrum, put(across), axis=0), put(along), axis=1)
    # a window of images may make that of waves uniform across zero or negative; those that vary across, of which the
    # minimum is, were above 0 on all of 700 grids with half-spaces, layers and free faces
    sizes = xp.abs(values)
    smallest = float(xp.min(sizes[1:, :])) if nx > 1 else float(xp.max(sizes))
    return xp.maximum(values, 1e-3 * smallest)
