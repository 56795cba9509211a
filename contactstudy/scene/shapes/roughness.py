"""Waviness, machined textures such as dimples and grooves, and self-affine random roughness, the same on every grid."""

from dataclasses import replace
from functools import partial
from math import inf, pi
from typing import Annotated, Literal, Self

import numpy as np
from scipy import fft

from contactstudy.domain import validation
from contactstudy.domain.device import cached_array
from contactstudy.domain.grid import Array, Grid
from contactstudy.domain.validation import InvalidInput, at_least, readable, validated, whole_quotient
from contactstudy.scene.shapes.shape import LengthScales, no_gap

# Wavelength or pitch [m], infinite where nothing repeats.
Wavelength = Annotated[validation.Metres, validation.OR_INFINITE]
# Flank of a feature, by the names that :class:`Dimple` explains.
Profile = Literal["parabolic", "cosine", "flat"]


def flank(profile: Profile, t: Array) -> Array:
    """Return the fraction of the depth of a feature at each fraction `t` of the way from middle (0) to rim (1)."""
    if profile == "flat":
        return np.ones_like(t)
    return np.asarray((1 - t) * (1 + t) if profile == "parabolic" else (1 + np.cos(np.pi * t)) / 2)


@validated
class Dimple:
    """Round dimple of a texture.

    Parameters
    ----------
    depth
        Depth [m], at least zero.
    diameter
        Diameter at the rim [m], above zero.
    profile
        Flank: "parabolic", ``1 - t^2`` on the way t to the rim, as the paraboloid that stands for a sphere in Hertz's
        theory; "cosine", ``(1 + cos(pi t)) / 2``, without a kink at the rim; or "flat", of the full depth up to the rim.
    """

    depth: Annotated[validation.Metres, validation.AT_LEAST_ZERO]
    diameter: validation.Metres
    profile: Profile = "parabolic"


@validated
class Groove:
    """Straight groove of a texture.

    Parameters
    ----------
    depth
        Depth [m], at least zero.
    width
        Width at the rim [m], above zero.
    profile
        Flank, "parabolic", "cosine" or "flat", as of a :class:`~contactstudy.Dimple`.
    """

    depth: Annotated[validation.Metres, validation.AT_LEAST_ZERO]
    width: validation.Metres
    profile: Profile = "cosine"


@validated
class Texture:
    """Dimples on a rectangular lattice, or parallel grooves, one of them centred at the origin.

    Depths are sampled at the cell centres, so that the area of a feature a few cells wide is approximate.

    Parameters
    ----------
    feature
        A :class:`~contactstudy.Dimple` or a :class:`~contactstudy.Groove`.
    pitch
        Distance (across, along) [m] between neighbours. Dimples have two finite pitches, grooves one: ``(p, inf)`` are
        grooves along the length, ``(inf, p)`` across it.

    Raises
    ------
    InvalidInput
        If features overlap, a pitch is missing, or the pitch along does not divide the grid's period.
    """

    feature: Dimple | Groove
    pitch: tuple[Wavelength, Wavelength]

    def check_together(self) -> None:
        """Check that features have the pitches of their kind, and do not overlap."""
        pitch = self.pitch
        finite_pitches = 2 if isinstance(self.feature, Dimple) else 1
        if sum(distance < inf for distance in pitch) != finite_pitches or self.feature_size > min(pitch):
            raise InvalidInput(
                f"Texture.pitch is {pitch!r}: give two pitches for dimples, one and inf for grooves, of at least "
                f"{self.feature_size!r} m, the size of the feature, so that none overlap."
            )

    @property
    def feature_size(self) -> float:
        """Diameter of a dimple, or width of a groove [m]."""
        return self.feature.diameter if isinstance(self.feature, Dimple) else self.feature.width

    @property
    def area_density(self) -> float:
        """Textured fraction of the surface, ``pi d^2 / 4`` over the cell of the lattice, or a width over its pitch."""
        across, along = (self.feature_size / pitch for pitch in self.pitch)
        return pi / 4 * across * along if isinstance(self.feature, Dimple) else max(across, along)

    @property
    def length_scales(self) -> LengthScales:
        """Length scales, since features, and the lands between them, are as fine as they are wide."""
        if self.feature.depth == 0:
            return LengthScales()
        size, (across, along) = self.feature_size, self.pitch
        finest = _narrowest(size, across), _narrowest(size, along)
        return LengthScales(finest, _finite(along), period_across=_finite(across))

    def gap(self, grid: Grid) -> Array:
        """Return depths [m] at the cell centres, of shape (x, y), or (nx, 1) for grooves along the length."""
        across, along = self.pitch
        whole_quotient("Texture.pitch[1]", along, grid.length)
        if self.feature.depth == 0:
            return no_gap(grid)
        y = grid.y if along < inf else np.zeros(1)
        distance = np.hypot(_from_nearest(grid.x, across)[:, None], _from_nearest(y, along))
        t = distance / (self.feature_size / 2)
        depth = self.feature.depth * flank(self.feature.profile, np.minimum(t, 1))
        return np.where(t < 1, depth, 0.0)


def _finite(length: float) -> float:
    """Return a pitch or wavelength [m] as a period; 0, which is no period, for an infinite one."""
    return length if length < inf else 0.0


def _narrowest(size: float, pitch: float) -> float:
    """Return the smaller width [m] of a feature and the land beside it; infinite where nothing repeats."""
    if pitch == inf:
        return inf
    return min(size, pitch - size) if pitch > size else size


def _from_nearest(position: Array, pitch: float) -> Array:
    """Return the offset [m] from the nearest multiple of `pitch`; zero where nothing repeats."""
    if pitch == inf:
        return np.zeros_like(position)
    return np.asarray(position - pitch * np.round(position / pitch))


@validated
class Waviness:
    """Plane wave of height, ``amplitude cos(2 pi (x / across + y / along) + phase)``.

    Heights count out of the body, as those of a :class:`~contactstudy.MeasuredSurface`: with an amplitude above zero and
    no phase a crest, which touches first, lies at the origin.

    Parameters
    ----------
    amplitude
        Amplitude [m].
    across, along
        Wavelengths [m], infinite by default: no waves in that direction.
    phase
        Angle at the origin [rad].

    Raises
    ------
    InvalidInput
        If a period of the grid does not hold a whole number of waves along.
    """

    amplitude: Annotated[validation.Metres, validation.ANY_SIGN]
    across: Wavelength = inf
    along: Wavelength = inf
    phase: Annotated[validation.Radians, validation.FINITE] = 0.0

    @property
    def length_scales(self) -> LengthScales:
        """Length scales of the wave."""
        if self.amplitude == 0:
            return LengthScales()
        across, along = self.across, self.along
        height = abs(self.amplitude)
        return LengthScales((across, along), _finite(along), period_across=_finite(across), height=height)

    def gap(self, grid: Grid) -> Array:
        """Return the depth below the mean at the cell centres [m], of shape (x, y), or (nx, 1) without waves along."""
        whole_quotient("Waviness.along", self.along, grid.length)
        y = grid.y if self.amplitude and self.along < inf else np.zeros(1)
        angle = 2 * np.pi * (grid.x[:, None] / self.across + y / self.along) + self.phase
        return np.asarray(-self.amplitude * np.cos(angle))


# Highest point of a surface over its rms height.
HEIGHT_OVER_RMS = 4.0
# Largest number of waves of a surface; their amplitudes take some tens of gigabytes.
MAX_WAVES = 1e9
# Fraction of the rms height below which a surface says what its extent leaves out. Square extents of 1 to 1.3 roll-offs
# hold it, by Hurst exponents from 0.3 to 1; those of 0.7 to 0.95 roll-offs hold 0.9, those of 1.3 to 1.9 hold 0.975.
MOST_OF_HEIGHT = 0.95
# Relative rounding of wave numbers, so that a wave at the cut-off is always one of the surface.
ROUNDING = 1e-9
# The density of a wave is that in the middle of its cell of wave numbers. Where it falls as k^-n, with n up to 4, this
# differs from its mean over the cell by up to n^2 / (24 NEAR^2), 4 %, beyond NEAR times the lowest wave numbers. Within
# these it is the mean of SUBCELLS points along each axis of the cell, whose error is below 0.3 %.
NEAR, SUBCELLS = 4, 16


@validated
class RmsSlope:
    """Roughness given by its root mean square slope Sdq (ISO 25178-2).

    Parameters
    ----------
    slope
        Root mean square of ``|grad h|``, at least zero.
    """

    slope: Annotated[validation.Number, validation.AT_LEAST_ZERO]

    def __bool__(self) -> bool:
        return self.slope > 0


@validated
class Sa:
    """Roughness given by its arithmetic mean height Sa (ISO 25178-2).

    A Gaussian surface has the rms height ``Sa sqrt(pi / 2)``.

    Parameters
    ----------
    height
        Mean of ``|h|`` [m], at least zero.
    """

    height: Annotated[validation.Metres, validation.AT_LEAST_ZERO]

    def __bool__(self) -> bool:
        return self.height > 0

    @property
    def rms(self) -> float:
        """Root mean square of the height of a Gaussian surface [m]."""
        return float(self.height * np.sqrt(np.pi / 2))


@validated
class Roughness:
    """Gaussian surface with the spectral density ``k^(-2 (1 + H))`` between two wavelengths.

    Each wave that fits the extent has the amplitude of the spectrum and a random phase. A shorter `cut_off` adds detail
    to the same surface, and a finer or, with an `extent`, wider grid shows the same. Source: Persson, Albohr,
    Tartaglino, Volokitin & Tosatti (2005), sect. 3; lay Peklenik (1967).

    Parameters
    ----------
    rms
        Root mean square of the height [m], at least zero, or an :class:`~contactstudy.Sa` or
        :class:`~contactstudy.RmsSlope`; zero is no surface. It is that of the whole spectrum: an extent shorter than
        some roll-offs holds only the part of its own waves.
    hurst
        Exponent H between 0 and 1.
    roll_off
        Wavelength [m] above which the density is constant.
    cut_off
        Shortest wavelength [m].
    seed
        Seed of the random phases, a whole number of at least 0.
    peklenik
        Correlation length across the contact over that along it: below 1 the lay runs along the length, above 1 across
        it. The wavelengths are those across the lay.
    extent
        Period (width, length) [m] of the surface, that of the grid if None; its length must divide the grid's period.

    Raises
    ------
    InvalidInput
        If a number is outside these limits, or no wave fits the extent.
    """

    rms: Annotated[validation.Metres, validation.AT_LEAST_ZERO] | RmsSlope | Sa
    hurst: Annotated[validation.Number, validation.BELOW_ONE]
    roll_off: validation.Metres
    cut_off: validation.Metres
    seed: Annotated[int, at_least(0)] = 0
    peklenik: validation.Number = 1.0
    extent: tuple[validation.Metres, validation.Metres] | None = None

    def check_together(self) -> None:
        """Check that the spectrum begins at a longer wave than it ends."""
        if self.roll_off < self.cut_off:
            raise InvalidInput(f"Roughness.roll_off is {self.roll_off!r}: give a wavelength no shorter than cut_off.")

    @property
    def length_scales(self) -> LengthScales:
        """Length scales; the height is four times the rms, as in any Gaussian surface of some ten thousand waves."""
        if not self.rms:
            return LengthScales()
        across, along = self._stretches
        return LengthScales(
            shortest_wavelengths=(self.cut_off * across, self.cut_off * along),
            period=self.extent[1] if self.extent else 0.0,
            period_across=self.extent[0] if self.extent else 0.0,
            longest_wavelength=self._longest_wavelengths[1],
            longest_across=0.0 if self.extent else self._longest_wavelengths[0],
            height=HEIGHT_OVER_RMS * self.rms_height,
        )

    @property
    def _stretches(self) -> tuple[float, float]:
        """Factors on wavelengths (across, along): 1 across the lay, and more along it."""
        return max(self.peklenik, 1), max(1 / self.peklenik, 1)

    @property
    def _longest_wavelengths(self) -> tuple[float, float]:
        """Wavelengths (across, along) of the roll-off [m]."""
        return self.roll_off * self._stretches[0], self.roll_off * self._stretches[1]

    @property
    def rms_height(self) -> float:
        """Root mean square of the height [m]; from an rms slope, that of the spectrum of an infinite surface."""
        if isinstance(self.rms, Sa):
            return self.rms.rms
        if not isinstance(self.rms, RmsSlope):
            return self.rms
        # the integral of k^3 C over C(0), for the slope what _height_moment is for the height
        low, span, hurst = 2 * np.pi / self.roll_off, self.roll_off / self.cut_off, self.hurst
        slope_moment = low**2 * (1 / 4 + (span ** (2 - 2 * hurst) - 1) / (2 - 2 * hurst))
        # along the lay waves are longer, and slopes less
        stretch = min(self.peklenik, 1 / self.peklenik)
        slope_over_height = float(np.sqrt(slope_moment / self._height_moment * (1 + stretch**2) / 2))
        return float(self.rms.slope / slope_over_height)

    @property
    def _height_moment(self) -> float:
        """Integral of ``k C(k) / C(0)`` over wave numbers k in units of 1 / `roll_off`, C the spectral density."""
        return float(1 / 2 + (1 - (self.roll_off / self.cut_off) ** (-2 * self.hurst)) / (2 * self.hurst))

    def with_extent_of(self, grid: Grid) -> Self:
        """Return this surface with the extent that it has on `grid`, so that it can be put on others."""
        return self if self.extent else replace(self, extent=grid.extent)

    def left_out(self, grid: Grid) -> str:
        """Return a sentence if the waves that fit the extent hold less than most of the height; else ``""``."""
        extent = self.extent or grid.extent
        waves = (side / wavelength for side, wavelength in zip(extent, self._longest_wavelengths, strict=True))
        if not self.rms or min(waves) >= 2:  # on two of the longest waves, 97 % of the height or more is held
            return ""
        held = float(np.sqrt(self._fractions(extent).sum()))
        if held >= MOST_OF_HEIGHT:
            return ""
        rms, sides = self.rms_height, " x ".join(map(readable, extent))
        return (
            f"Roughness.roll_off is {readable(self.roll_off)}: the waves that fit the surface's extent of {sides} hold "
            f"{held:.2g} of its rms height of {readable(rms)}, give an extent of some roll-offs, or the roll-off and "
            "the rms height of such an extent."
        )

    def gap(self, grid: Grid) -> Array:
        """Return depths [m] with zero mean over the surface's extent, of shape (nx, ny).

        The shape is (nx, 1) if there is no surface.
        """
        if not self.rms:
            return no_gap(grid)
        extent, (nx, ny) = self.extent or grid.extent, grid.cells
        whole_quotient("Roughness.extent[1]", extent[1], grid.length)
        # half the plane of waves (across, along); the other half is conjugate, since heights are real
        waves = cached_array((self, extent), partial(self._amplitudes, extent))
        kx, ky = self._wave_numbers(extent)
        if extent[0] != grid.extent[0]:
            from scipy.signal import czt  # imported late, since it is slow

            # the cells are no fraction of the surface's width: a chirp z-transform across in place of a fast one
            turn = 2j * np.pi / extent[0]
            rows = czt(waves, nx, np.exp(turn * grid.cell_size[0]), np.exp(-turn * grid.x[0]), axis=0)
            rows *= np.exp(2j * np.pi * kx[0] * grid.x)[:, None]
        else:
            # the phase of every wave is that at the first cell's centre
            waves = waves * np.exp(2j * np.pi * kx * grid.x[0])
            rows = fft.ifft(_folded(waves, kx * grid.extent[0], nx), axis=0, norm="forward")
        rows *= np.exp(2j * np.pi * ky * grid.y[0])
        # waves along are summed onto those that the cells tell apart, the upper half of which is conjugate to the lower
        columns = np.round(ky * grid.length).astype(int).ravel() % ny
        upper = columns > ny // 2
        rows[:, upper] = rows[:, upper].conj()
        half = _folded(rows.T, np.where(upper, ny - columns, columns), ny // 2 + 1)
        half[1 : (ny + 1) // 2] /= 2  # to these irfft adds their conjugates
        return np.asarray(fft.irfft(half.T, ny, axis=1, norm="forward"))

    def _wave_numbers(self, extent: tuple[float, float]) -> tuple[Array, Array]:
        """Return the wave numbers [1/m] of half the plane of waves, across (x, 1) and along (1, y)."""
        counts = [int(side / self.cut_off * (1 + ROUNDING)) for side in extent]
        if (2 * counts[0] + 1) * (counts[1] + 1) > MAX_WAVES:
            raise InvalidInput(
                f"Roughness.cut_off is {self.cut_off!r}: give a wavelength nearer to the extent {extent!r} m, "
                f"or there are more than {MAX_WAVES:g} waves."
            )
        kx = np.arange(-counts[0], counts[0] + 1)[:, None] / extent[0]
        return kx, np.arange(counts[1] + 1)[None, :] / extent[1]

    def _fractions(self, extent: tuple[float, float]) -> Array:
        """Return the fraction of the mean square height that each of half the plane of waves has on an `extent` [m].

        It is the integral of the density over the wave's cell of wave numbers, twice, for the wave and its conjugate.
        """
        kx, ky = self._wave_numbers(extent)
        # stretched along the lay, so that no wave is shorter than the cut-off
        kx, ky = kx * self._stretches[0], ky * self._stretches[1]
        k = np.hypot(kx, ky)
        cell = [stretch / side for stretch, side in zip(self._stretches, extent, strict=True)]
        fractions = self._density(k)
        # the density varies within the cells of the longest waves: their mean
        rows, columns = np.nonzero((k > 0) & (k < NEAR * max(cell)))
        offsets = (np.arange(SUBCELLS) + 0.5) / SUBCELLS - 0.5
        x = kx[rows, :, None] + cell[0] * offsets[:, None]
        y = ky.T[columns, :, None] + cell[1] * offsets
        fractions[rows, columns] = self._density(np.hypot(x, y)).mean(axis=(1, 2))
        # keep one of each conjugate pair
        fractions[(k * self.cut_off > 1 + ROUNDING) | ((ky == 0) & (kx <= 0))] = 0
        return np.asarray(fractions * (2 * cell[0] * cell[1]))

    def _density(self, k: Array) -> Array:
        """Return the spectral density at wave numbers `k` [1/m] across the lay; its integral over the plane is 1."""
        density = np.maximum(k * self.roll_off, 1) ** (-2 * (1 + self.hurst))
        density[k * self.cut_off > 1 + ROUNDING] = 0
        return np.asarray(density * (self.roll_off**2 / (2 * np.pi * self._height_moment)))

    def _amplitudes(self, extent: tuple[float, float]) -> np.ndarray:
        """Return complex amplitudes [m] of half the plane of waves on a surface of that `extent` [m].

        The phase of each follows from the seed and its two wave numbers, so that further waves add detail.
        """
        fractions = self._fractions(extent)
        if not fractions.any():
            whose = "surface's" if self.extent else "grid's"
            raise InvalidInput(
                f"Roughness.cut_off is {self.cut_off!r}: give a wavelength below the {whose} extent "
                f"{extent!r} m, or there is no wave to carry the height."
            )
        key = np.random.SeedSequence(self.seed).generate_state(2, np.uint64)
        first = -(fractions.shape[0] // 2)
        waves = np.empty(fractions.shape, complex)
        for number, row in enumerate(waves, first):
            # a stream of its own for each wave number across, in the order of the wave numbers along
            stream = np.random.Philox(key=key, counter=[0, abs(number), number < 0, 0])
            row[:] = np.exp((2j * np.pi / 2**64) * stream.random_raw(row.size))
        waves *= np.sqrt(2 * fractions) * self.rms_height
        return waves


def _folded(waves: np.ndarray, numbers: np.ndarray, count: int) -> np.ndarray:
    """Return the rows of `waves` summed by their wave `numbers` on `count` points: short ones are aliased."""
    folded = np.zeros((count, waves.shape[1]), dtype=complex)
    indices = np.round(numbers).astype(int).ravel() % count
    if np.bincount(indices).max() == 1:  # an assignment takes a fifth of the time
        folded[indices] = waves
    else:
        np.add.at(folded, indices, waves)
    return folded
