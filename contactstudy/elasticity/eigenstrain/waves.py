"""A block of waves: stress and displacement by plastic strain and pressure that are constant in cells."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from contactstudy.domain.devices.arrays import Array
from contactstudy.elasticity.eigenstrain.direction import Components, Direction
from contactstudy.elasticity.eigenstrain.short_waves import Coupling, ShortWaves, alike, own_stress
from contactstudy.elasticity.eigenstrain.volume import Moduli, Volume
from contactstudy.elasticity.eigenstrain.wave import Layer, Sources, by_layers, pressed

Complex = NDArray[np.complex128]
T = TypeVar("T")


@dataclass(frozen=True, eq=False)
class Waves:
    """Waves of some orders along the length, each with all that repeat across in a period, as fields (period, orders).

    ``across`` and ``along`` are wave numbers [1/m], (period,) and (orders,).
    """

    volume: Volume
    moduli: Moduli
    across: Array
    along: Array

    @classmethod
    def of(cls, volume: Volume, moduli: Moduli, orders: Array, period: int) -> "Waves":
        """``orders`` counted in the period along; the ``period`` across is an odd number of cells."""
        across = 2 * np.pi * np.fft.fftfreq(period, volume.grid.cell[0])
        return cls(volume, moduli, across, 2 * np.pi * orders / volume.grid.period)

    def stress(self, strain: Complex, components: Components) -> Complex:
        """Means over cells of the stress (components, layers, period, orders) by ``strain`` (5, layers, ...)."""
        e = _real(strain)
        direction = self._direction
        sources = Sources.of(direction.strain(e), self.moduli)
        tensor = by_layers(sources, self._layers, self.moduli.poisson_ratio)
        total = direction.stress(tensor, components)
        total *= direction.weight
        for one in self._couplings[components]:
            one.add(total, e)
        return _complex(total, components, strain.shape[2:])

    def stress_of_pressure(self, pressure: Complex, components: Components) -> Complex:
        """The same by ``pressure`` (period, orders)."""
        unit = self._pressed[components]
        waves = np.stack((pressure.real.ravel(), pressure.imag.ravel()))
        return _complex(unit[:, :, None] * waves, components, pressure.shape)

    def lift(self, strain: Complex) -> Complex:
        """Displacement of the surface (period, orders) [m] by ``strain`` (5, layers, period, orders)."""
        e = _real(strain)
        moved, unit = np.zeros((2, e.shape[3])), self._pressed[Components.DEVIATOR]
        for number, thickness in enumerate(self.volume.thicknesses):
            moved += thickness * np.einsum("iw,irw->rw", unit[:, number], e[:, number])
        return np.asarray((moved[0] + 1j * moved[1]).reshape(strain.shape[2:]))

    def self_blocks(self, shares: Array) -> Array:
        """(layers, 5, 5) [Pa]: B of a cell on itself, by waves that have these ``shares`` (orders,) in it."""
        share = np.broadcast_to(shares, (len(self.across), len(shares))).ravel()
        direction = self._direction
        blocks = np.empty((self.volume.shape[0], 5, 5))
        for number, layer in enumerate(self._layers):
            top = self.volume.edges[number]
            own = own_stress(direction, layer, top, self.moduli, Components.DEVIATOR)
            blocks[number] = -(own @ (share * direction.weight))
        signs = Components.DEVIATOR.signs
        # waves to either side cancel where they are odd
        even = np.outer(signs, signs) > 0
        blocks *= even
        for one in self._couplings[Components.DEVIATOR]:
            if one.sources == one.layers:
                blocks[one.layers] -= even * (one.blocks @ share)
        return blocks

    @property
    def bytes(self) -> int:
        """What they hold."""
        return (
            sum(one.nbytes for one in self._pressed.values())
            + sum(one.blocks.nbytes for many in self._couplings.values() for one in many)
            + 8 * 8 * len(self._direction.q)
        )

    @cached_property
    def _short(self) -> ShortWaves:
        x, y = np.repeat(self.across, len(self.along)), np.tile(self.along, len(self.across))
        return ShortWaves(self.volume, self.moduli, x, y)

    @cached_property
    def _direction(self) -> Direction:
        return self._short.shifted(0, 0)

    @cached_property
    def _layers(self) -> tuple[Layer, ...]:
        """Those of the same thickness are the same."""
        known: dict[float, Layer] = {}
        found = []
        for thickness in alike(self.volume.thicknesses):
            if thickness not in known:
                known[thickness] = Layer.of(self._direction.q * thickness)
            found.append(known[thickness])
        return tuple(found)

    @cached_property
    def _couplings(self) -> "_OnRequest[tuple[Coupling, ...]]":
        return _OnRequest(lambda components: tuple(self._short.couplings(components)))

    @cached_property
    def _pressed(self) -> "_OnRequest[Array]":
        return _OnRequest(self._by_pressure)

    def _by_pressure(self, components: Components) -> Array:
        """Stress (components, layers, waves) by unit pressure."""
        direction = self._direction
        total = self._short.stress_of_pressure(components)
        for number, layer in enumerate(self._layers):
            depth = direction.q * self.volume.edges[number]
            tensor = pressed(depth, layer, self.moduli.poisson_ratio)
            total[:, number] += direction.weight * direction.stress(tensor, components)
        return total


class _OnRequest(dict[Components, T]):
    """What is made for components when they are first asked for."""

    def __init__(self, make: Callable[[Components], T]) -> None:
        super().__init__()
        self._make = make

    def __missing__(self, components: Components) -> T:
        self[components] = self._make(components)
        return self[components]


def _real(strain: Complex) -> Array:
    """Waves (5, layers, period, orders) as real and imaginary parts, (5, layers, 2, waves), over i where odd."""
    waves = strain.reshape(*strain.shape[:2], -1)
    parts = np.empty((*waves.shape[:2], 2, waves.shape[2]))
    for number, sign in enumerate(Components.DEVIATOR.value):
        real, imaginary = waves[number].real, waves[number].imag
        parts[number, :, 0] = real if sign > 0 else imaginary
        parts[number, :, 1] = imaginary if sign > 0 else -real
    return parts


def _complex(parts: Array, components: Components, shape: tuple[int, ...]) -> Complex:
    """Back to waves (components, layers, ...)."""
    waves = np.empty((*parts.shape[:2], parts.shape[3]), dtype=np.complex128)
    for number, sign in enumerate(components.value):
        first, second = parts[number, :, 0], parts[number, :, 1]
        waves[number].real = first if sign > 0 else -second
        waves[number].imag = second if sign > 0 else first
    return waves.reshape(*waves.shape[:2], *shape)
