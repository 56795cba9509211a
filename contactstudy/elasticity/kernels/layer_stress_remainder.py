"""Short-ranged remainder of the stress in a coated half-space under a loaded cell: alone, in a row, in a lattice."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from contactstudy.domain.fields import Array
from contactstudy.elasticity.kernels.layer_response import Numbers, composite
from contactstudy.elasticity.kernels.layer_stress import LayerStress
from contactstudy.elasticity.kernels.stress_cell import COMPONENTS, Component
from contactstudy.elasticity.kernels.traction import CERRUTI_ACROSS, CERRUTI_ALONG

# Components of stress by what presses or drags the surface: pressure, shear across, shear along.
FAMILIES: Mapping[str, Mapping[str, Component]] = {
    "pressure": COMPONENTS,
    "across": CERRUTI_ACROSS,
    "along": CERRUTI_ALONG,
}
TURNED = {"pressure": "pressure", "across": "along", "along": "across"}
Places = NDArray[np.intp]
# exp(-NEGLIGIBLE_EXPONENT) is below rounding.
NEGLIGIBLE_EXPONENT = 34.0
# Phase of a wave, in radians, that the Gauss points of one piece resolve.
PHASE = 12.0
# A row's waves along it die within so many periods; a cell alone is one of a lattice so many times as wide as asked.
DEAD, APART = 6.0, 4


@dataclass(frozen=True)
class LayerStressRemainder:
    """Influence coefficients of what :meth:`~contactstudy.elasticity.kernels.layer_stress.LayerStress.remainder` is.

    It falls as the inverse cube of the distance. Of a cell alone it is that of a lattice four times as wide.

    Parameters
    ----------
    stress
        Stress under one wave at a depth.
    thickness
        Thickness of the layer; all lengths are in one unit.
    load, name
        What acts on the cell, of ``FAMILIES``, and the component of stress.
    """

    stress: LayerStress
    thickness: float
    load: str
    name: str

    @property
    def parity(self) -> tuple[int, int]:
        """Parity of the component in x and y."""
        return FAMILIES[self.load][self.name].parity

    def turned(self) -> "LayerStressRemainder":
        """Return the component that takes this one's place when the axes are exchanged."""
        name = COMPONENTS[self.name].turned
        return LayerStressRemainder(self.stress, self.thickness, TURNED[self.load], name)

    def cell(self, x: Array, y: Array, dx: float, dy: float) -> Array:
        """Return the response to one cell; x and y broadcast and are whole numbers of cells."""
        cells = [
            fft.next_fast_len(APART * (round(float(np.abs(offsets).max()) / step) + 1))
            for offsets, step in ((x, dx), (y, dy))
        ]
        field = self._lattice(dx, dy, cells[0], cells[1])
        return np.asarray(field[_places(x, dx, cells[0]), _places(y, dy, cells[1])])

    def row(self, x: Array, y: Array, dx: float, dy: float, period: float) -> Array:
        """Return the response to an infinite row of images along y; x is a column, y a row."""
        distances, places = np.unique(np.abs(x.ravel()), return_inverse=True)
        mean = np.where(x.ravel() < 0, self.parity[0], 1) * self._line(distances, dx)[places]
        result = np.tile(mean[:, None] * (dy / period), (1, y.size))
        along = round(period / dy)
        if along > 1:
            reach = 2 * float(distances[-1]) + DEAD * period
            across = fft.next_fast_len(int(np.ceil(reach / dx)) + 1)
            field = self._lattice(dx, dy, across, along)
            chosen = field[_places(x.ravel(), dx, across)]
            chosen = chosen - chosen.mean(axis=1, keepdims=True)
            result += chosen[:, _places(y.ravel(), dy, along)]
        return result

    def lattice(
        self, x: Array, y: Array, dx: float, dy: float, width: float, period: float
    ) -> Array:
        """Return the response to an infinite lattice of images along both axes; x is a column, y a row."""
        cells = round(width / dx), round(period / dy)
        field = self._lattice(dx, dy, *cells)
        return np.asarray(
            field[np.ix_(_places(x.ravel(), dx, cells[0]), _places(y.ravel(), dy, cells[1]))]
        )

    def _lattice(self, dx: float, dy: float, across: int, along: int) -> Array:
        """Return the response (across, along) to a cell of a lattice at all its points, by the sum of its waves."""
        return _lattice(self.stress, self.thickness, self.load, dx, dy, across, along)[self.name]

    def _line(self, x: Array, dx: float) -> Array:
        """Return the response to a strip, endless along y, at distances `x` at least 0, in order."""
        scaled, width = x / self.thickness, dx / self.thickness
        far = max(NEGLIGIBLE_EXPONENT / self.stress.materials.first_pole, 2 * width)
        result = np.empty(x.size)
        ends = np.array([0.0, *(2.0 ** np.arange(0, 60)), np.inf])
        for start, end in pairwise(ends):
            chosen = (scaled >= start) & (scaled < end)
            if chosen.any():
                decays = scaled[chosen].min() > far
                integral = self._far if decays else self._near
                result[chosen] = integral(scaled[chosen], width)
        return result

    def _near(self, x: Array, width: float) -> Array:
        """Return the response to a strip near it, by quadrature over real waves; all in thicknesses."""
        longest = min(0.5, PHASE / max(float(x[-1]) + width / 2, 1e-3))
        ends = [0.0, min(self.stress.materials.nearest_pole / 4, longest)]
        while ends[-1] < NEGLIGIBLE_EXPONENT / self.stress.reach:
            ends.append(ends[-1] + min(ends[-1], longest))
        k, weight = composite(np.array(ends))
        waves = self._plane_amplitude(k) * weight * width * np.sinc(k * width / 2 / np.pi) / np.pi
        phase = np.multiply.outer(x, k)
        even = self.parity[0] > 0
        return np.asarray(np.cos(phase) @ waves.real if even else -np.sin(phase) @ waves.imag)

    def _far(self, x: Array, width: float) -> Array:
        """Return the response to a strip far from it, by quadrature over waves that decay; all in thicknesses."""
        end = min(self.stress.materials.first_pole, NEGLIGIBLE_EXPONENT / (float(x[0]) - width / 2))
        start = 1e-3 * min(self.stress.materials.nearest_pole, end)
        count = int(np.ceil(np.log2(end / start)))
        tau, weight = composite(np.concatenate([[0.0], np.geomspace(start, end, count + 1)]))
        waves = 1j * self._plane_amplitude(1j * tau) * weight / np.pi
        decay = np.exp(-np.multiply.outer(x - width / 2, tau)) * -np.expm1(-tau * width) / tau
        return np.asarray((decay @ waves).real)

    def _plane_amplitude(self, k: Numbers) -> Numbers:
        """Return the stress over the load under waves across with wave numbers `k`, real or imaginary."""
        rest = self.stress.remainder(k)[0 if self.load == "pressure" else 1]
        normal, shear, across = rest
        if self.load == "along":
            s_tz, s_lt = self.stress.antiplane(k)
            parts: dict[str, Numbers] = {"yz": s_tz, "xy": 1j * s_lt}
            return np.asarray(parts.get(self.name, np.zeros(k.size)) + 0j)
        parts = {"zz": normal, "xx": across, "xz": -1j * shear}
        parts["yy"] = self.stress.poisson_ratio * (normal + across)
        factor = 1 if self.load == "pressure" else 1j
        return np.asarray(factor * parts.get(self.name, np.zeros(k.size)) + 0j)


def amplitudes(stress: LayerStress, load: str, across: Array, along: Array) -> dict[str, Array]:
    """Return all components of the remainder over the load, by name, under waves (across, along).

    Wave numbers are those times the thickness; the products of a component's parities are even for a real amplitude.
    """
    size = np.hypot(across, along)
    with np.errstate(invalid="ignore"):
        c = np.where(size > 0, across / size, 1.0)
        s = np.where(size > 0, along / size, 0.0)
    pressed, sheared = stress.interpolated(size)
    s_tz: Numbers
    s_lt: Numbers
    if load == "pressure":
        normal, shear, s_ll = pressed[0], -1j * pressed[1], pressed[2]
        s_tz = s_lt = np.zeros_like(size)
    else:
        part, other = (c, -s) if load == "across" else (s, c)
        normal, shear, s_ll = (
            1j * part * sheared[0],
            part * sheared[1],
            1j * part * sheared[2],
        )
        down, around = stress.antiplane(size)
        s_tz, s_lt = other * down, 1j * other * around
    s_tt = stress.poisson_ratio * (s_ll + normal)
    return {
        "xx": c * c * s_ll + s * s * s_tt - 2 * c * s * s_lt,
        "yy": s * s * s_ll + c * c * s_tt + 2 * c * s * s_lt,
        "zz": normal,
        "yz": s * shear + c * s_tz,
        "xz": c * shear - s * s_tz,
        "xy": c * s * (s_ll - s_tt) + (c * c - s * s) * s_lt,
    }


@lru_cache(maxsize=4)
def _lattice(
    stress: LayerStress,
    thickness: float,
    load: str,
    dx: float,
    dy: float,
    across: int,
    along: int,
) -> dict[str, Array]:
    """Return the response (across, along) to one cell of a lattice at all its points, for each component.

    Waves shorter than two cells are aliased to the longer ones.
    """
    waves = {name: np.zeros((across, along // 2 + 1), dtype=complex) for name in COMPONENTS}
    last = NEGLIGIBLE_EXPONENT / (stress.reach * thickness)
    first_x = 2 * np.pi * fft.fftfreq(across, dx)
    first_y = 2 * np.pi * fft.rfftfreq(along, dy)
    for kx, rows in _aliased(first_x, dx, last):
        for ky, columns in _aliased(first_y, dy, last):
            if np.hypot(np.abs(kx).min(), np.abs(ky).min()) > last:
                continue
            mean = np.sinc(kx * dx / (2 * np.pi))[:, None] * np.sinc(ky * dy / (2 * np.pi))
            found = amplitudes(stress, load, kx[:, None] * thickness, ky * thickness)
            for name, amplitude in found.items():
                waves[name][np.ix_(rows, columns)] += amplitude * mean
    return {name: fft.irfft2(sums, (across, along)) for name, sums in waves.items()}


def _aliased(first: Array, step: float, last: float) -> list[tuple[Array, Places]]:
    """Return wave numbers up to `last`, with their places among the `first` ones whose aliases they are."""
    turns = int(np.ceil(last * step / (2 * np.pi) + 0.5))
    found = []
    for turn in range(-turns, turns + 1):
        waves = first + 2 * np.pi * turn / step
        places = np.flatnonzero(np.abs(waves) <= last)
        if places.size:
            found.append((waves[places], places))
    return found


def _places(offsets: Array, step: float, cells: int) -> Places:
    """Return the places of `offsets` on a circle of `cells`."""
    return np.asarray(np.round(np.asarray(offsets) / step).astype(np.intp) % cells)
