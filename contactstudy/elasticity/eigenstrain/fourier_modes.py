"""Stress and displacement by plastic strain and traction that are constant in cells, wave by wave along the surface.

A wave ``exp(i q n.x)`` has the wave number q and the direction ``n = (c, s, 0)``, where c and s are the cosine and the
sine of its angle to x; ``t = (-s, c, 0)`` lies along its crests and z points into the body. Fields depend on n and z
alone, so that plane strain in (n, z) and antiplane shear along t do not couple. A tensor is given by its fields nn, tt,
zz, nz / i, nt, tz / i, with the imaginary unit i: all coefficients between strain, traction and stress are then real.

Plane strain has Airy's stress function ``phi``, of the components ``nn = d2 phi / dz2``, ``zz = -q^2 phi``,
``nz / i = -q d phi / dz`` and ``tt = nu (nn + zz)``. Where the modes of :class:`Sources` stand for ``q^2 phi`` and -nt,
all stresses below follow by differentiation and from equilibrium.

A field that is constant in cells has waves of all lengths. :class:`Waves` longer than two cells are resolved. Short
waves, those shorter than two cells, represent the edges of cells: each has the values of one resolved wave, its alias,
at the middles of the cells. Short waves act on the layer of their own strain and on its neighbours alone: further away
they have decayed, where layers are about as thick as cells are wide, or thicker. What is left out is small where strain
is smooth, and larger where it is noise from cell to cell. On five layers of 0.7 to 1.4 cells, the stress by a strain
that decays over three cells is right to 1.5e-4, by noise to 1e-2 of 2 G (the shear modulus G) times the largest strain.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from enum import Enum
from functools import cache, cached_property
from itertools import product
from math import pi

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammainc

from contactstudy.domain.grid import Array
from contactstudy.elasticity.eigenstrain.plane_strain_operator import PLANE_STRAIN_BASIS, Moduli, Volume

Complex = NDArray[np.complex128]
# The six fields nn, tt, zz, nz / i, nt, tz / i of a symmetric tensor, each (layers, ..., waves).
Tensor = tuple[Array, ...]
# The tensors of plane strain, then sqrt(2) xy and sqrt(2) yz, in terms of xx, yy, zz, yz, xz, xy.
BASIS = np.vstack((PLANE_STRAIN_BASIS, np.eye(6)[[5, 3]] / 2**0.5))
# The order of a short wave along an axis is the whole number of periods in a cell that it has more than its alias. Waves
# up to this order either way are summed one by one, shorter waves together. With 1, 2 and 4 the stress of a cell by its
# own strain is right to 4e-4, 6e-5 and 7e-6 of 2 G times the strain; 1 halves the time of the set-up, 4 triples it.
SUMMED_ORDERS = 2
# Depth, in lengths of the longer side of a cell, at which the stress by short waves of pressure has decayed, to
# exp(-3 pi) = 8e-5 times a few. The surface correction of short waves of strain decays on the way up and down, and has
# decayed at half that depth.
DEEP = 3.0


def means(ratio: Array) -> tuple[Array, Array]:
    """Return the means of ``exp(-s)`` and ``s exp(-s)`` for s from 0 to `ratio`, without cancellation; 1 and 0 at 0."""
    positive = np.maximum(ratio, 1e-300)
    return -np.expm1(-positive) / positive, gammainc(2.0, positive) / positive


@dataclass(frozen=True, eq=False)
class Sources:
    """Amplitudes [Pa] of the Fourier modes of plastic strain in layers.

    Where strain jumps from a layer to the one below, modes decay downwards from there, and others upwards, all linear
    in the jump. They are ``(a + b q z) exp(-q z)`` of Airy's stress function times q^2, and ``c exp(-q z)`` of the
    antiplane stress -nt. `down` and `up` are their amplitudes a, b and c for each layer's own strain, (3, layers, ...,
    waves). `zz`, `tt` and `tz` (layers, ..., waves) are the stress of a layer whose displacement does not change with
    depth; its other components are zero.
    """

    down: Array
    up: Array
    zz: Array
    tt: Array
    tz: Array

    @classmethod
    def from_strain(cls, strain: Tensor, moduli: Moduli) -> "Sources":
        """Return the sources of a plastic `strain`.

        At the sides of a layer the modes make traction and displacement in n and z continuous. Of their amplitudes, `f`
        balances half of the stress s_zz that the layer would have without displacement along z, and `g` and `h` make up
        for its strains nn - zz and nz. Of `down`, a and b are h + f and h + g; of `up`, they are h - f and h - g.
        """
        nn, tt, zz, nz, nt, tz = strain
        nu, shear, half = moduli.poisson_ratio, moduli.shear, moduli.plane_strain / 2
        f = -half * (zz + nu * tt)
        g = (half / 2) * (nn - zz)
        h = -half * nz
        down, up = np.stack((h + f, h + g, shear * (nt - tz))), np.stack((h - f, h - g, -shear * (nt + tz)))
        return cls(down, up, 2 * f, (2 * nu) * f - moduli.youngs_modulus * tt, (-2 * shear) * tz)


@dataclass(frozen=True, eq=False)
class CellLayer:
    """Attenuation of Fourier modes over a layer.

    `ratio` (waves,) is the wave number q times the thickness. `decay` is ``exp(-ratio)``. `means` are those of
    ``exp(-s)`` and ``s exp(-s)`` over the layer, see the function :func:`means`.
    """

    ratio: Array
    decay: Array
    means: tuple[Array, Array]

    @classmethod
    def from_ratio(cls, ratio: Array) -> "CellLayer":
        """Return the layer with a `ratio` of its thickness to 1 / q, (waves,)."""
        return cls(ratio, np.exp(-ratio), means(ratio))

    def attenuated(self, amplitudes: Array) -> Array:
        """Return the amplitudes a, b, c (3, ...) at the far side of the layer of modes with `amplitudes`."""
        after = amplitudes * self.decay
        after[0] += self.ratio * after[1]
        return after


def surface_correction(up: Array) -> Array:
    """Return the amplitudes a, b, c (3, ...) of modes that decay downwards and free the surface of traction.

    `up` (3, ...) are the amplitudes at the surface of modes that decay upwards. The stresses zz, nz and tz of both
    together are zero at z = 0.
    """
    return np.stack((-up[0], up[1] - 2 * up[0], up[2]))


def layer_stresses(sources: Sources, top: Array, layers: Sequence[CellLayer], nu: float) -> Tensor:
    """Return the means of the stress over each of the `layers` by plastic strain in all of them, given by its `sources`.

    The layers are in order downwards, from the depth of `top` / q on. One sweep up and one down: the work grows with the
    number of layers, not with its square.
    """
    count = len(layers)
    # `up` are the amplitudes at the lower side of each layer, `down` those at its upper side; at each side the sources
    # are those of the strain below less those of the strain above, and the strain is zero outside the layers
    up, down = np.empty_like(sources.up), np.empty_like(sources.down)
    state = -sources.up[:, -1]
    for number in range(count - 1, -1, -1):
        up[:, number] = state
        state = layers[number].attenuated(state)
        state += sources.up[:, number]
        if number:
            state -= sources.up[:, number - 1]
    above = CellLayer.from_ratio(top)
    state = above.attenuated(surface_correction(above.attenuated(state))) + sources.down[:, 0]
    for number in range(count):
        down[:, number] = state
        if number < count - 1:
            state = layers[number].attenuated(state)
            state += sources.down[:, number + 1]
            state -= sources.down[:, number]
    m0, m1 = layers[0].means
    if any(layer is not layers[0] for layer in layers):
        m0, m1 = (np.stack([layer.means[order] for layer in layers])[:, None] for order in (0, 1))
    # nn, tt, zz and nt do not depend on the direction of decay; nz and tz, with one index z, change their signs with it
    sums, differences = down + up, down - up
    b, zz = m0 * sums[1], m0 * sums[0] + m1 * sums[1]
    nz = m0 * (differences[0] - differences[1]) + m1 * differences[1]
    tt, tz = (-2 * nu) * b + sources.tt, -m0 * differences[2] + sources.tz
    return zz - 2 * b, tt, sources.zz - zz, nz, -m0 * sums[2], tz


# Function that returns the means of the stress over a layer under a unit wave of traction. Its arguments are the wave
# number q times the depth of the layer's upper side, the layer, Poisson's ratio and the direction of the wave (c, s).
TractionWave = Callable[[Array, CellLayer, float, tuple[Array, Array]], Tensor]


def _means_below(top: Array, layer: CellLayer) -> tuple[Array, Array]:
    """Return the means of ``exp(-s)`` and ``s exp(-s)`` over a `layer` whose upper side is at s = `top`."""
    decay = np.exp(-top)
    m0 = decay * layer.means[0]
    return m0, decay * layer.means[1] + top * m0


def stress_under_pressure(top: Array, layer: CellLayer, nu: float, _direction: tuple[Array, Array]) -> Tensor:
    """Return the means of the stress over a `layer` under a wave of unit pressure (waves,).

    `top` is q times the depth of its upper side. Source: Johnson (1985), sect. 2.2, the stress under a line load,
    summed to a wave.
    """
    m0, m1 = _means_below(top, layer)
    zeros = np.zeros_like(m0)
    return m1 - m0, -2 * nu * m0, -(m0 + m1), m1, zeros, zeros


def stress_under_shear(top: Array, layer: CellLayer, nu: float, direction: tuple[Array, Array]) -> Tensor:
    """Return the means of the stress over a `layer` under a wave of unit traction along x (waves,), divided by i.

    `top` is q times the depth of its upper side, and `direction` is that of n, (c, s). Source: Johnson (1985), sect.
    2.3, the stress under a tangential line load, summed to a wave, and antiplane shear along t.
    """
    m0, m1 = _means_below(top, layer)
    c, s = direction
    antiplane = -s * m0
    return c * (2 * m0 - m1), (2 * nu) * c * m0, c * m1, c * (m0 - m1), antiplane, antiplane


class Components(Enum):
    """Set of components of stress to compute; its value is a row for each, in terms of xx, yy, zz, yz, xz, xy."""

    #: The components of a deviator in `BASIS`: inner products, in which a shear stands for two entries of a tensor.
    DEVIATOR = tuple(map(tuple, BASIS * (1, 1, 1, 2, 2, 2)))
    TENSOR = tuple(map(tuple, np.eye(6)))

    @property
    def matrix(self) -> Array:
        """Matrix (components, 6) from a tensor to the components."""
        return np.array(self.value)

    @property
    def is_odd(self) -> NDArray[np.bool_]:
        """True for each component (components,) that is odd in depth, yz and xz, which have one index z."""
        return np.asarray(self.matrix[:, 3:5].any(axis=1))


@dataclass(frozen=True, eq=False)
class WaveDirection:
    """Wave number `q` [1/m] and direction (`c`, `s`) of waves, each (waves,), or (1,) where all have the same.

    `weight` is the fraction of a wave that the mean over a cell leaves, for strain and for stress together.
    """

    q: Array
    c: Array
    s: Array
    weight: Array

    def strain(self, e: Array) -> Tensor:
        """Return the fields of a strain with the components `e` (5, ..., waves), those odd in depth over i."""
        c, s = self.c, self.s
        xx, yy, zz, yz, xz, xy = np.tensordot(BASIS.T, e, 1)
        nn = c * c * xx + s * s * yy + (2 * c * s) * xy
        nt = (c * s) * (yy - xx) + (c * c - s * s) * xy
        return nn, -zz - nn, zz, c * xz + s * yz, nt, c * yz - s * xz

    def stress(self, tensor: Tensor) -> Array:
        """Return xx, yy, zz, yz / i, xz / i, xy (6, ..., waves) of the fields of a stress, times the weight."""
        c, s = self.c, self.s
        nn, tt, zz, nz, nt, tz = tensor
        xx = (c * c) * (nn - tt) + tt - (2 * c * s) * nt
        xy = (c * s) * (nn - tt) + (c * c - s * s) * nt
        fields = np.broadcast_arrays(xx, nn + tt - xx, zz, s * nz + c * tz, c * nz - s * tz, xy)
        return np.asarray(self.weight * np.stack(fields))


@dataclass(frozen=True, eq=False)
class Waves:
    """Waves with some orders along the length, each with every wave number across a period: fields (period, orders).

    Attributes
    ----------
    volume
        Cells that carry plastic strain.
    moduli
        Elastic constants of the body.
    orders
        Numbers of periods of the waves in the length of the grid (orders,), above 0.
    period
        Period across, an odd number of cells: an even one has a wave whose direction across is undefined.
    """

    volume: Volume
    moduli: Moduli
    orders: Array
    period: int

    def stress(self, strain: Complex, components: Components) -> Complex:
        """Return the mean stress [Pa] of cells (components, layers, period, orders) by a `strain`.

        The `strain` is (5, layers, period, orders).
        """
        e = _real(strain)
        direction, edges = self._resolved, self.volume.edges
        sources = Sources.from_strain(direction.strain(e), self.moduli)
        tensor = layer_stresses(sources, direction.q * edges[0], self._layers, self.moduli.poisson_ratio)
        total = np.tensordot(components.matrix, direction.stress(tensor), 1)
        for layer, source, blocks in self._short_blocks(components):
            total[:, layer] += np.einsum("ijw,jrw->irw", blocks, e[:, source])
        return _complex(total, components, strain.shape[2:])

    def stress_of_traction(self, waves: Complex, traction: TractionWave) -> Complex:
        """Return the deviatoric stress of cells (5, layers, period, orders) by `waves` (period, orders) of a traction.

        Stress is in the unit of the traction.
        """
        parts = np.stack((waves.real.ravel(), waves.imag.ravel()))
        return _complex(self._by_unit(traction)[:, :, None] * parts, Components.DEVIATOR, waves.shape)

    def residual_displacement(self, strain: Complex) -> Complex:
        """Return the surface displacement (period, orders) [m], into the body, by `strain` (5, layers, period, orders).

        By reciprocity it is the stress under unit pressure on the strain times the thickness of each layer. The factors
        are real, so that no conjugate is needed, see :func:`_real`.
        """
        moments = self.volume.thicknesses[:, None, None] * _real(strain)
        real, imaginary = np.einsum("ilw,ilrw->rw", self._by_unit(stress_under_pressure), moments)
        return np.asarray((real + 1j * imaginary).reshape(strain.shape[2:]))

    def diagonal_blocks(self, fractions: Array) -> Array:
        """Return minus the residual stress of a cell by its own unit strain, by these waves alone, (layers, 5, 5) [Pa].

        `fractions` (orders,) are the amplitudes of these waves in the strain of one cell; those of all waves sum to 1.
        """
        fraction = np.tile(fractions, self.period)
        blocks = np.empty((self.volume.shape[0], 5, 5))
        for number, (top, thickness) in enumerate(zip(self.volume.edges[:-1], self._thicknesses, strict=True)):
            stress = self._stress_of_unit_strains(self._resolved, top, (thickness,))[:, 0, 0]
            blocks[number] = -np.tensordot(Components.DEVIATOR.matrix, stress @ fraction, 1)
        for layer, source, short in self._short_blocks(Components.DEVIATOR):
            if source == layer:
                blocks[layer] -= short @ fraction
        # waves to either side cancel between even and odd components
        is_odd = Components.DEVIATOR.is_odd
        return np.asarray(blocks * (is_odd == is_odd[:, None]))

    @cached_property
    def _wave_numbers(self) -> tuple[Array, Array]:
        """Wave numbers (waves,) [1/m] of the resolved waves across and along."""
        grid = self.volume.grid
        across = 2 * pi * np.fft.fftfreq(self.period, grid.cell_size[0])
        along = 2 * pi * self.orders / grid.length
        return np.repeat(across, len(along)), np.tile(along, len(across))

    def _shifted(self, across: int, along: int) -> WaveDirection:
        """Return the waves that have `across` and `along` more periods in a cell than the resolved ones.

        Their weight is the square of the mean of a wave over a cell, ``sinc^2`` along each axis.
        """
        (dx, dy), (x, y) = self.volume.grid.cell_size, self._wave_numbers
        x, y = x + 2 * pi * across / dx, y + 2 * pi * along / dy
        q = np.hypot(x, y)
        weight = (np.sinc(x * dx / (2 * pi)) * np.sinc(y * dy / (2 * pi))) ** 2
        return WaveDirection(q, x / q, y / q, weight)

    @cached_property
    def _resolved(self) -> WaveDirection:
        """The resolved waves."""
        return self._shifted(0, 0)

    @cached_property
    def _short(self) -> tuple[WaveDirection, ...]:
        """The short waves of the first `SUMMED_ORDERS`, then waves that represent all shorter ones together.

        The weights ``sinc^2`` of all waves of one alias along an axis, the resolved one among them, add up to 1. What
        the first orders leave of 1 is the weight of the shorter ones, which point along the axis either way. Weighted
        like ``1 / q^2``, their mean length is half of the longest. Waves that are shorter than the first orders along
        both axes count as waves across.
        """
        orders = range(-SUMMED_ORDERS, SUMMED_ORDERS + 1)
        directions = [self._shifted(*shift) for shift in product(orders, repeat=2) if any(shift)]
        (dx, dy), wave_numbers = self.volume.grid.cell_size, self._wave_numbers
        across, along = (
            sum(np.sinc(number * step / (2 * pi) + shift) ** 2 for shift in orders)
            for number, step in zip(wave_numbers, (dx, dy), strict=True)
        )
        unit = np.ones(1)
        for step, weight, c in ((dx, 1 - across, 1.0), (dy, across * (1 - along), 0.0)):
            q = 2 * pi * (2 * SUMMED_ORDERS + 1) / step
            directions += [
                WaveDirection(q * unit, side * c * unit, side * (1 - c) * unit, weight / 2) for side in (1, -1)
            ]
        return tuple(directions)

    @cached_property
    def _thicknesses(self) -> list[float]:
        """Thicknesses of the layers [m]; values that differ only by rounding are made equal."""
        thicknesses = self.volume.thicknesses
        finest = 1e-12 * float(thicknesses.min())
        return [round(thickness / finest) * finest for thickness in thicknesses.tolist()]

    @cached_property
    def _layers(self) -> tuple[CellLayer, ...]:
        """Layers of the volume under the resolved waves; layers of equal thickness are one object."""
        layers = {thickness: CellLayer.from_ratio(self._resolved.q * thickness) for thickness in set(self._thicknesses)}
        return tuple(layers[thickness] for thickness in self._thicknesses)

    @cached_property
    def _short_blocks(self) -> Callable[[Components], tuple[tuple[int, int, Array], ...]]:
        """Function that returns the stress by short waves as (layer, layer of the strain, its block), found once.

        A block (components, 5, waves) [Pa] is the stress by unit strain. The layers are the same or neighbours.
        """
        return cache(lambda components: tuple(self._neighbours(components)))

    def _neighbours(self, components: Components) -> Iterator[tuple[int, int, Array]]:
        """Yield what the function :attr:`_short_blocks` returns."""

        @cache
        def blocks(top: float, thicknesses: tuple[float, ...]) -> Array:
            """Return the stress (components, layers, layers, 5, waves) [Pa] in adjacent layers by unit strains."""
            total = sum(self._stress_of_unit_strains(direction, top, thicknesses) for direction in self._short)
            return np.tensordot(components.matrix, total, 1)

        decayed = DEEP / 2 * max(self.volume.grid.cell_size)
        for layer, top in enumerate(self.volume.edges[:-1]):
            pair = tuple(self._thicknesses[layer : layer + 2])
            # all layers without surface correction count as equally deep, to share their blocks
            found = blocks(top if top < decayed else 2 * decayed, pair)
            for below, source in ((0, 0), (0, 1), (1, 0))[: 2 * len(pair) - 1]:
                yield layer + below, layer + source, found[:, below, source]

    def _stress_of_unit_strains(self, direction: WaveDirection, top: float, thicknesses: tuple[float, ...]) -> Array:
        """Return the stress (6, layers, layers, 5, waves) [Pa] in adjacent layers by unit strains in each of them.

        The uppermost begins at the depth `top` [m]. The axes are xx, yy, zz, yz / i, xz / i, xy of the stress, the
        layers of stress and of strain, and the components of the strain in `BASIS`.
        """
        count = len(thicknesses)
        strain = np.einsum("ik,ls->ilsk", np.eye(5), np.eye(count)).reshape(5, count, 5 * count, 1)
        sources = Sources.from_strain(direction.strain(strain), self.moduli)
        layers = [CellLayer.from_ratio(direction.q * thickness) for thickness in thicknesses]
        tensor = layer_stresses(sources, direction.q * top, layers, self.moduli.poisson_ratio)
        return direction.stress(tensor).reshape(6, count, count, 5, -1)

    @cached_property
    def _by_unit(self) -> Callable[[TractionWave], Array]:
        """Function that returns :meth:`_stress_of_unit` of a traction, found once for each."""
        return cache(self._stress_of_unit)

    def _stress_of_unit(self, traction: TractionWave) -> Array:
        """Return the deviatoric stress (5, layers, waves) by a unit of a traction."""
        volume, nu = self.volume, self.moduli.poisson_ratio
        total = np.zeros((6, volume.shape[0], len(self._resolved.q)))
        for number, (top, thickness) in enumerate(zip(volume.edges[:-1], volume.thicknesses, strict=True)):
            is_near = top < DEEP * max(volume.grid.cell_size)
            for direction in (*(self._short if is_near else ()), self._resolved):
                layer = CellLayer.from_ratio(direction.q * thickness)
                tensor = traction(direction.q * top, layer, nu, (direction.c, direction.s))
                total[:, number] += direction.stress(tensor)
        return np.tensordot(Components.DEVIATOR.matrix, total, 1)


def _real(strain: Complex) -> Array:
    """Return complex waves (5, layers, period, orders) as real and imaginary parts (5, layers, 2, waves).

    Components that are odd in depth are divided by i: they are a quarter of a wave out of phase, so that maps of the
    parts are real.
    """
    waves = strain.reshape(*strain.shape[:2], -1).copy()
    waves[Components.DEVIATOR.is_odd] *= -1j
    return np.stack((waves.real, waves.imag), axis=2)


def _complex(parts: Array, components: Components, shape: tuple[int, ...]) -> Complex:
    """Return complex waves (components, layers, *shape) from their `parts` (components, layers, 2, waves).

    The parts are real and imaginary. This is the inverse of :func:`_real`: components that are odd in depth are
    multiplied by i.
    """
    waves = parts[:, :, 0] + 1j * parts[:, :, 1]
    waves[components.is_odd] *= 1j
    return np.asarray(waves.reshape(*waves.shape[:2], *shape))
