"""Self-affine random roughness, the same surface on every grid."""

from dataclasses import dataclass

import numpy as np
from scipy import fft

from contactstudy.arrays import Array
from contactstudy.checks import InvalidInput, finite, keep, positive, whole
from contactstudy.grid import Grid


@dataclass(frozen=True)
class Roughness:
    """A Gaussian surface whose spectral density falls like ``k^(-2 (1 + H))`` between two wavelengths.

    ``rms`` height [m], from zero on; ``hurst`` H in (0, 1); wavelengths [m] ``roll_off``, above which the
    density is constant, and ``cut_off``, below which there is none; ``seed`` names the surface. It is
    periodic over the grid's extent, and depends on that and on its own fields alone: a finer grid
    shows the same surface, so that refinement converges. Zero rms is no surface.

    Source: Persson, Albohr, Tartaglino, Volokitin & Tosatti (2005), sect. 3.
    """

    rms: float
    hurst: float
    roll_off: float
    cut_off: float
    seed: int = 0

    def __post_init__(self) -> None:
        remedy = "give an rms height of 0 m or more"
        rms = finite("Roughness.rms", self.rms, remedy)
        if rms < 0:
            raise InvalidInput(f"Roughness.rms is {self.rms!r}: {remedy}.")
        remedy = "give an exponent between 0 and 1"
        hurst = finite("Roughness.hurst", self.hurst, remedy)
        if not 0 < hurst < 1:
            raise InvalidInput(f"Roughness.hurst is {self.hurst!r}: {remedy}.")
        cut_off = positive("Roughness.cut_off", self.cut_off, "give a wavelength above 0 m")
        roll_off = positive("Roughness.roll_off", self.roll_off, "give a wavelength above 0 m")
        keep(self, rms=rms, hurst=hurst, cut_off=cut_off, roll_off=roll_off)
        if self.roll_off < self.cut_off:
            raise InvalidInput(
                f"Roughness.roll_off is {self.roll_off!r}: give a wavelength no shorter than cut_off."
            )
        keep(self, seed=whole("Roughness.seed", self.seed, 0, "give a whole number from 0 on"))

    @property
    def curvature(self) -> float:
        """None of its own."""
        return 0.0

    def gap(self, grid: Grid) -> Array:
        """Heights [m] with zero mean over the extent, shape (width, length)."""
        waves, (kx, ky) = self._waves(grid)
        if not waves.any():
            return np.zeros(grid.cells)
        # the phase of every wave at the first cell's centre
        waves *= np.exp(2j * np.pi * (kx * grid.x[0] + ky * grid.y[0]))
        nx, ny = grid.cells
        # waves shorter than two cells look like longer ones, as in any sample
        across = np.round(kx * grid.extent[0]).astype(int).ravel() % nx
        along = np.round(ky * grid.extent[1]).astype(int).ravel() % ny
        folded = np.zeros(grid.cells, dtype=complex)
        np.add.at(folded, np.ix_(across, along), waves)
        return np.asarray(fft.ifft2(folded).real * (nx * ny))

    def _waves(self, grid: Grid) -> tuple[np.ndarray, tuple[Array, Array]]:
        """Complex amplitudes [m] of half the plane of waves, and their wave numbers [1/m]."""
        most = [int(extent / self.cut_off) for extent in grid.extent]
        kx = np.arange(-most[0], most[0] + 1)[:, None] / grid.extent[0]
        ky = np.arange(most[1] + 1)[None, :] / grid.extent[1]
        k = np.hypot(kx, ky)
        density = np.maximum(k, 1 / self.roll_off) ** (-2 * (1 + self.hurst))
        # of a wave and its opposite, which carry the same heights, one
        density[(k > 1 / self.cut_off) | ((ky == 0) & (kx <= 0))] = 0
        normal = np.random.default_rng(self.seed).standard_normal((2, *density.shape))
        waves = np.sqrt(density) * (normal[0] + 1j * normal[1])
        power = np.sum(np.abs(waves) ** 2) / 2
        if power == 0 and self.rms > 0:
            raise InvalidInput(
                f"Roughness.cut_off is {self.cut_off!r}: give a wavelength below the grid's extent "
                f"{grid.extent!r} m, or there is no wave to carry the height."
            )
        return waves * (self.rms / np.sqrt(power) if self.rms > 0 else 0.0), (kx, ky)
