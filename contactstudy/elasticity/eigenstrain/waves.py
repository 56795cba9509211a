"""A block of waves: stress and displacement by plastic strain and pressure that are constant in cells.

Waves shorter than two cells are what the edges of cells are made of; a grid of cells sees them as longer waves.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise, product
from math import pi
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from contactstudy.domain.fields import Array
from contactstudy.elasticity.eigenstrain.volume import Moduli, Volume
from contactstudy.elasticity.eigenstrain.wave import (
    Components,
    Direction,
    Layer,
    Sources,
    by_another,
    by_itself,
    by_layers,
    pressed,
)

# Waves of 2, 1 ... cells that are taken one by one, so many times; those beyond stand together.
ORDERS = 2
# Depth in cells from which on short waves of pressure have died out; those of strain come back from half of it.
DEEP = 3.0
# In place of the depth of a layer that short waves reach the surface from no more, so many times as deep as that.
DEEPEST = 1e3
# Distance in cells between layers that act on one another by short waves.
NEAR = 0.6


@dataclass(frozen=True, eq=False)
class Coupling:
    """Stress in ``layers`` by strain in as many ``sources``: ``blocks`` (components, 5, waves)."""

    layers: slice
    sources: slice
    blocks: Array

    def add(self, total: Array, strain: Array) -> None:
        """To stress (components, layers, waves) that by ``strain`` (5, layers, waves)."""
        for i, j in self._coupled:
            total[i, self.layers] += self.blocks[i, j] * strain[j, self.sources]

    @cached_property
    def _coupled(self) -> list[tuple[int, int]]:
        """Components that are."""
        return [(i, j) for i, j in np.ndindex(self.blocks.shape[:2]) if self.blocks[i, j].any()]


@dataclass(frozen=True, eq=False)
class ShortWaves:
    """All waves that cells at their middles do not tell from those with the numbers ``x``, ``y`` [1/m], (waves,)."""

    volume: Volume
    moduli: Moduli
    x: Array
    y: Array

    def shifted(self, across: int, along: int) -> Direction:
        """Those with so many more waves to a cell, across and along."""
        dx, dy = self.volume.grid.cell
        x, y = self.x + 2 * pi * across / dx, self.y + 2 * pi * along / dy
        q = np.hypot(x, y)
        weight = (np.sinc(x * dx / (2 * pi)) * np.sinc(y * dy / (2 * pi))) ** 2
        return Direction(q, x / q, y / q, weight)

    def stress_of_pressure(self, components: Components) -> Array:
        """Stress (components, layers, waves) by unit pressure."""
        volume = self.volume
        total = np.zeros((len(components.value), volume.shape[0], len(self.x)))
        for number, top in enumerate(volume.edges[:-1]):
            if top >= DEEP * max(volume.grid.cell):
                break
            for direction in self._all():
                layer = Layer.of(direction.q * volume.thicknesses[number])
                tensor = pressed(direction.q * top, layer, self.moduli.poisson_ratio)
                total[:, number] += direction.weight * direction.stress(tensor, components)
        return total

    def couplings(self, components: Components) -> Iterator[Coupling]:
        """How layers act on themselves, and on those near to them, by strain."""
        edges = self.volume.edges
        thicknesses = alike(self.volume.thicknesses)
        felt, near = DEEP / 2 * max(self.volume.grid.cell), NEAR * min(self.volume.grid.cell)
        single: dict[tuple[float, float], list[int]] = {}
        pairs: dict[tuple[int, float, float, float, float], list[int]] = {}
        for number, thickness in enumerate(thicknesses):
            top = edges[number] if edges[number] < felt else DEEPEST * felt
            single.setdefault((thickness, top), []).append(number)
            for steps, below in enumerate(thicknesses[number + 1 :], start=1):
                gap = float(sum(thicknesses[number + 1 : number + steps]))
                if gap > near:
                    break
                pairs.setdefault((steps, top, thickness, gap, below), []).append(number)
        for key, numbers in single.items():
            blocks = self._by_itself(*key, components)
            for begin, end in _runs(numbers):
                here = slice(begin, end)
                yield Coupling(here, here, blocks)
        for (steps, top, upper, gap, lower), numbers in pairs.items():
            there = top + upper + gap
            down = self._by_another((upper, lower), (top, there), components)
            up = self._by_another((lower, upper), (there, top), components)
            for begin, end in _runs(numbers):
                above, beneath = slice(begin, end), slice(begin + steps, end + steps)
                yield Coupling(beneath, above, down)
                yield Coupling(above, beneath, up)

    def _by_itself(self, thickness: float, top: float, components: Components) -> Array:
        total = np.zeros((len(components.value), 5, len(self.x)))
        for direction in self._all():
            layer = Layer.of(direction.q * thickness)
            total += direction.weight * own_stress(direction, layer, top, self.moduli, components)
        return total

    def _by_another(
        self,
        thicknesses: tuple[float, float],
        tops: tuple[float, float],
        components: Components,
    ) -> Array:
        total = np.zeros((len(components.value), 5, len(self.x)))
        nu = self.moduli.poisson_ratio
        for direction in self._all():
            source, layer = (Layer.of(direction.q * one) for one in thicknesses)
            begin, end = (direction.q * top for top in tops)
            sources = _units(direction, self.moduli)
            tensor = by_another(sources, (source, layer), (begin, end), nu)
            total += direction.weight * direction.stress(tensor, components)
        return total

    def _all(self) -> Iterator[Direction]:
        """Those taken one by one, then those that stand for the rest across, and along."""
        (dx, dy), orders = self.volume.grid.cell, range(-ORDERS, ORDERS + 1)
        for shift in product(orders, repeat=2):
            if any(shift):
                yield self.shifted(*shift)
        across, along = (
            sum(np.sinc(number * step / (2 * pi) + shift) ** 2 for shift in orders)
            for number, step in ((self.x, dx), (self.y, dy))
        )
        one = np.ones(1)
        for step, weight, c in ((dx, 1 - across, 1.0), (dy, across * (1 - along), 0.0)):
            q = 2 * pi * (2 * ORDERS + 1) / step
            for side in (1, -1):
                yield Direction(q * one, side * c * one, side * (1 - c) * one, weight / 2)


def own_stress(
    direction: Direction, layer: Layer, top: float, moduli: Moduli, components: Components
) -> Array:
    """Stress (components, 5, waves) in a ``layer`` whose ``top`` [m] is so deep, by each of its own strains."""
    sources = _units(direction, moduli)
    tensor = by_itself(sources, direction.q * top, layer, moduli.poisson_ratio)
    return direction.stress(tensor, components)


def _units(direction: Direction, moduli: Moduli) -> Sources:
    """Those of unit strains, one after another."""
    return Sources.of(direction.strain(np.eye(5)[..., None] * np.ones(len(direction.q))), moduli)


def alike(thicknesses: Array) -> list[float]:
    """With those that differ by rounding made the same."""
    finest = 1e-12 * float(thicknesses.min())
    return [round(thickness / finest) * finest for thickness in thicknesses.tolist()]


def _runs(numbers: list[int]) -> Iterator[tuple[int, int]]:
    """First and last, exclusive, of runs of consecutive ones."""
    breaks = [0, *(k + 1 for k, (a, b) in enumerate(pairwise(numbers)) if b != a + 1), len(numbers)]
    for begin, end in pairwise(breaks):
        yield numbers[begin], numbers[end - 1] + 1


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
