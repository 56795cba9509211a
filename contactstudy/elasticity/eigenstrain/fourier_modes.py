"""Stress and displacement by plastic strain and pressure that are constant in cells, by their Fourier modes.

A field that is constant in cells has waves of all lengths. Waves longer than two cells are resolved. Short waves, those
shorter than two cells, represent the edges of cells: each has the values of one resolved wave, its alias, at the
middles of the cells.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache, cached_property
from itertools import pairwise, product
from math import pi

import numpy as np
from numpy.typing import NDArray

from contactstudy.domain.grid import Array
from contactstudy.elasticity.eigenstrain.half_space_wave import (
    CellLayer,
    Components,
    Moduli,
    Sources,
    Tensor,
    Volume,
    WaveDirection,
    layer_stresses,
    self_stress,
    stress_of_other_layer,
    stress_under_pressure,
)

# The order of a short wave along an axis is the whole number of periods in a cell that it has more than its alias. Waves
# up to this order either way are summed one by one, shorter waves together.
SUMMED_ORDERS = 2
# Depth, in lengths of the longer side of a cell, at which the stress by short waves of pressure has decayed. The surface
# correction of short waves of strain decays on the way up and down, and has decayed at half that depth.
DEEP = 3.0
# Layers below that half depth are treated as if they were at this multiple of it, so that all such layers of one
# thickness share their coefficients.
REMOTE_DEPTHS = 1e3
# Largest distance between layers that act on one another by short waves, in lengths of the shorter side of a cell. On
# five layers of 0.7 to 1.4 cells with a smooth strain, the stress differs from the closed forms of plane strain and
# antiplane shear by at most 1.3e-3 of 2 G (the shear modulus G) times the largest component of strain.
NEAR = 0.6


# Means of the stress over a layer under a unit wave of traction on the surface, from the wave number q times the depth
# of its upper side, the layer, Poisson's ratio and the direction of the wave (c, s).
TractionWave = Callable[[Array, CellLayer, float, tuple[Array, Array]], Tensor]


@dataclass(frozen=True, eq=False)
class LayerCoupling:
    """Stress in `layers` by strain in as many layers `sources`: in the first by the first, in the second by the second.

    `blocks` (components, 5, waves) [Pa] are the stress by unit strain, the same for each pair.
    """

    layers: slice
    sources: slice
    blocks: Array

    def add(self, total: Array, strain: Array) -> None:
        """Add to the stress `total` (components, layers, ..., waves) the stress by `strain` (5, layers, ..., waves)."""
        for i, j in self._coupled:
            total[i, self.layers] += self.blocks[i, j] * strain[j, self.sources]

    @cached_property
    def _coupled(self) -> list[tuple[int, int]]:
        """Pairs of stress and strain components with a block that is not zero."""
        return [(i, j) for i, j in np.ndindex(self.blocks.shape[:2]) if self.blocks[i, j].any()]


@dataclass(frozen=True, eq=False)
class ShortWaves:
    """Short waves, with the values of resolved waves, their aliases, at the middles of cells.

    `x` and `y` (waves,) [1/m] are the wave numbers of the resolved waves, across and along.
    """

    volume: Volume
    moduli: Moduli
    x: Array
    y: Array

    def shifted(self, across: int, along: int) -> WaveDirection:
        """Return the waves that have `across` and `along` more periods in a cell than the resolved ones.

        Those of (0, 0) are the resolved waves themselves. Their weight is the square of the mean of a wave over a cell,
        ``sinc^2`` along each axis.
        """
        dx, dy = self.volume.grid.cell_size
        x, y = self.x + 2 * pi * across / dx, self.y + 2 * pi * along / dy
        q = np.hypot(x, y)
        weight = (np.sinc(x * dx / (2 * pi)) * np.sinc(y * dy / (2 * pi))) ** 2
        return WaveDirection(q, x / q, y / q, weight)

    def couplings(self, components: Components) -> Iterator[LayerCoupling]:
        """Yield the stress in each layer by strain in itself and in layers near to it, by short waves."""
        edges = self.volume.edges
        thicknesses = rounded(self.volume.thicknesses)
        surface_depth = DEEP / 2 * max(self.volume.grid.cell_size)
        near = NEAR * min(self.volume.grid.cell_size)
        single: dict[tuple[float, float], list[int]] = {}
        pairs: dict[tuple[int, float, float, float, float], list[int]] = {}
        for number, thickness in enumerate(thicknesses):
            top = edges[number] if edges[number] < surface_depth else REMOTE_DEPTHS * surface_depth
            single.setdefault((thickness, top), []).append(number)
            for steps, below in enumerate(thicknesses[number + 1 :], start=1):
                gap = float(sum(thicknesses[number + 1 : number + steps]))
                if gap > near:
                    break
                pairs.setdefault((steps, top, thickness, gap, below), []).append(number)
        for key, numbers in single.items():
            blocks = self._self_stress(*key, components)
            for begin, end in _runs(numbers):
                group = slice(begin, end)
                yield LayerCoupling(group, group, blocks)
        for (steps, top, upper, gap, lower), numbers in pairs.items():
            lower_top = top + upper + gap
            down = self._stress_of_other_layer((upper, lower), (top, lower_top), components)
            up = self._stress_of_other_layer((lower, upper), (lower_top, top), components)
            for begin, end in _runs(numbers):
                above, beneath = slice(begin, end), slice(begin + steps, end + steps)
                yield LayerCoupling(beneath, above, down)
                yield LayerCoupling(above, beneath, up)

    def _self_stress(self, thickness: float, top: float, components: Components) -> Array:
        """Return the stress (components, 5, waves) in a layer by its own unit strains."""
        total = np.zeros((len(components.value), 5, len(self.x)))
        for direction in self.directions():
            layer = CellLayer.from_ratio(direction.q * thickness)
            total += direction.weight * own_stress(direction, layer, top, self.moduli, components)
        return total

    def _stress_of_other_layer(
        self, thicknesses: tuple[float, float], tops: tuple[float, float], components: Components
    ) -> Array:
        """Return the stress (components, 5, waves) in the second of two layers by unit strains in the first."""
        total = np.zeros((len(components.value), 5, len(self.x)))
        nu = self.moduli.poisson_ratio
        for direction in self.directions():
            source, layer = (CellLayer.from_ratio(direction.q * thickness) for thickness in thicknesses)
            begin, end = (direction.q * top for top in tops)
            sources = _unit_strains(direction, self.moduli)
            tensor = stress_of_other_layer(sources, (source, layer), (begin, end), nu)
            total += direction.weight * direction.stress(tensor, components)
        return total

    def directions(self) -> Iterator[WaveDirection]:
        """Yield the short waves of the first `SUMMED_ORDERS`, then waves that represent all shorter ones together.

        The weights ``sinc^2`` of all waves of one alias along an axis, the resolved one among them, add up to 1. What
        the first orders leave of 1 is the weight of the shorter ones, which point along the axis either way. Waves that
        are shorter than the first orders along both axes count as waves across.
        """
        (dx, dy), orders = self.volume.grid.cell_size, range(-SUMMED_ORDERS, SUMMED_ORDERS + 1)
        for shift in product(orders, repeat=2):
            if any(shift):
                yield self.shifted(*shift)
        across, along = (
            sum(np.sinc(number * step / (2 * pi) + shift) ** 2 for shift in orders)
            for number, step in ((self.x, dx), (self.y, dy))
        )
        unit = np.ones(1)
        for step, weight, c in ((dx, 1 - across, 1.0), (dy, across * (1 - along), 0.0)):
            q = 2 * pi * (2 * SUMMED_ORDERS + 1) / step
            for side in (1, -1):
                yield WaveDirection(q * unit, side * c * unit, side * (1 - c) * unit, weight / 2)


def own_stress(direction: WaveDirection, layer: CellLayer, top: float, moduli: Moduli, components: Components) -> Array:
    """Return the stress (components, 5, waves) in a `layer` by each of its own unit strains.

    `top` [m] is the depth of its upper side.
    """
    sources = _unit_strains(direction, moduli)
    tensor = self_stress(sources, direction.q * top, layer, moduli.poisson_ratio)
    return direction.stress(tensor, components)


def _unit_strains(direction: WaveDirection, moduli: Moduli) -> Sources:
    """Return the sources of five unit strains, one after another."""
    return Sources.from_strain(direction.strain(np.eye(5)[..., None] * np.ones(len(direction.q))), moduli)


def rounded(thicknesses: Array) -> list[float]:
    """Return the `thicknesses` with values that differ only by rounding made equal."""
    finest = 1e-12 * float(thicknesses.min())
    return [round(thickness / finest) * finest for thickness in thicknesses.tolist()]


def _runs(numbers: list[int]) -> Iterator[tuple[int, int]]:
    """Yield the first and last number, the last exclusive, of each run of consecutive `numbers`."""
    breaks = [0, *(k + 1 for k, (a, b) in enumerate(pairwise(numbers)) if b != a + 1), len(numbers)]
    for begin, end in pairwise(breaks):
        yield numbers[begin], numbers[end - 1] + 1


Complex = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class Waves:
    """Waves with some orders along the length, each with every wave number across a period: fields (period, orders).

    `across` (period,) and `along` (orders,) are wave numbers [1/m].
    """

    volume: Volume
    moduli: Moduli
    across: Array
    along: Array

    @classmethod
    def from_orders(cls, volume: Volume, moduli: Moduli, orders: Array, period: int) -> "Waves":
        """Return the waves with these `orders` above 0, the numbers of their periods in the length of the grid.

        The `period` across is an odd number of cells.
        """
        across = 2 * np.pi * np.fft.fftfreq(period, volume.grid.cell_size[0])
        return cls(volume, moduli, across, 2 * np.pi * orders / volume.grid.length)

    def stress(self, strain: Complex, components: Components) -> Complex:
        """Return the mean stress of cells (components, layers, period, orders) by `strain` (5, layers, ...)."""
        e = _real(strain)
        direction = self._direction
        sources = Sources.from_strain(direction.strain(e), self.moduli)
        tensor = layer_stresses(sources, self._layers, self.moduli.poisson_ratio)
        total = direction.stress(tensor, components)
        total *= direction.weight
        for coupling in self._couplings(components):
            coupling.add(total, e)
        return _complex(total, components, strain.shape[2:])

    def stress_of_traction(self, waves: Complex, traction: TractionWave) -> Complex:
        """Return the deviatoric stress of cells (5, layers, period, orders) by `waves` (period, orders) of a traction.

        Stress is in the unit of the traction.
        """
        unit, shape = self._by_unit(traction), waves.shape
        parts = np.stack((waves.real.ravel(), waves.imag.ravel()))
        return _complex(unit[:, :, None] * parts, Components.DEVIATOR, shape)

    def residual_displacement(self, strain: Complex) -> Complex:
        """Return the surface displacement (period, orders) [m], into the body, by `strain` (5, layers, period, orders).

        By reciprocity it is the stress under unit pressure on the strain times the thickness of each layer. The factors
        are real, so that no conjugate is needed, see :func:`_real`.
        """
        e = _real(strain)
        parts, unit = np.zeros((2, e.shape[3])), self._by_unit(stress_under_pressure)
        for number, thickness in enumerate(self.volume.thicknesses):
            parts += thickness * np.einsum("iw,irw->rw", unit[:, number], e[:, number])
        return np.asarray((parts[0] + 1j * parts[1]).reshape(strain.shape[2:]))

    def diagonal_blocks(self, fractions: Array) -> Array:
        """Return minus the residual stress of a cell by its own unit strain, by these waves alone, (layers, 5, 5) [Pa].

        `fractions` (orders,) are the fractions of the waves in the strain of one cell.
        """
        fraction = np.broadcast_to(fractions, (len(self.across), len(fractions))).ravel()
        direction = self._direction
        blocks = np.empty((self.volume.shape[0], 5, 5))
        for number, layer in enumerate(self._layers):
            top = self.volume.edges[number]
            stress = own_stress(direction, layer, top, self.moduli, Components.DEVIATOR)
            blocks[number] = -(stress @ (fraction * direction.weight))
        signs = Components.DEVIATOR.signs
        # waves to either side cancel in odd blocks
        is_even = np.outer(signs, signs) > 0
        blocks *= is_even
        for coupling in self._couplings(Components.DEVIATOR):
            if coupling.sources == coupling.layers:
                blocks[coupling.layers] -= is_even * (coupling.blocks @ fraction)
        return blocks

    @cached_property
    def _short(self) -> ShortWaves:
        """Short waves that have the same values at the middles of cells as these."""
        x, y = np.repeat(self.across, len(self.along)), np.tile(self.along, len(self.across))
        return ShortWaves(self.volume, self.moduli, x, y)

    @cached_property
    def _direction(self) -> WaveDirection:
        """Wave numbers and directions of these waves, with their weights."""
        return self._short.shifted(0, 0)

    @cached_property
    def _layers(self) -> tuple[CellLayer, ...]:
        """Layers of the volume; layers of equal thickness are one object."""
        thicknesses, q = rounded(self.volume.thicknesses), self._direction.q
        layers = {thickness: CellLayer.from_ratio(q * thickness) for thickness in set(thicknesses)}
        return tuple(layers[thickness] for thickness in thicknesses)

    @cached_property
    def _couplings(self) -> Callable[[Components], tuple[LayerCoupling, ...]]:
        """Function that returns the couplings of layers by short waves, by components, each found once."""
        return cache(lambda components: tuple(self._short.couplings(components)))

    @cached_property
    def _by_unit(self) -> Callable[[TractionWave], Array]:
        """:meth:`_stress_of_unit`, computed once for each traction."""
        return cache(self._stress_of_unit)

    def _stress_of_unit(self, traction: TractionWave) -> Array:
        """Return the deviatoric stress (5, layers, waves) by a unit of a traction."""
        volume = self.volume
        total = np.zeros((5, volume.shape[0], len(self._direction.q)))
        for number, (top, thickness) in enumerate(zip(volume.edges[:-1], volume.thicknesses, strict=True)):
            is_near = top < DEEP * max(volume.grid.cell_size)
            for direction in (*(self._short.directions() if is_near else ()), self._direction):
                layer = CellLayer.from_ratio(direction.q * thickness)
                ratio, unit_vector = direction.q * top, (direction.c, direction.s)
                tensor = traction(ratio, layer, self.moduli.poisson_ratio, unit_vector)
                total[:, number] += direction.weight * direction.stress(tensor, Components.DEVIATOR)
        return total


def _real(strain: Complex) -> Array:
    """Return complex waves (5, layers, period, orders) as real and imaginary parts (5, layers, 2, waves).

    Components that are odd in depth are divided by i: they are a quarter of a wave out of phase, so that maps of the
    parts are real.
    """
    waves = strain.reshape(*strain.shape[:2], -1).copy()
    waves[Components.DEVIATOR.signs < 0] *= -1j
    return np.stack((waves.real, waves.imag), axis=2)


def _complex(parts: Array, components: Components, shape: tuple[int, ...]) -> Complex:
    """Return complex waves (components, layers, *shape) from their `parts` (components, layers, 2, waves).

    The parts are real and imaginary. This is the inverse of :func:`_real`: components that are odd in depth are
    multiplied by i.
    """
    waves = parts[:, :, 0] + 1j * parts[:, :, 1]
    waves[components.signs < 0] *= 1j
    return np.asarray(waves.reshape(*waves.shape[:2], *shape))
