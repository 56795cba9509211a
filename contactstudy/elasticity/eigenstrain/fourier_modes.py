"""Stress and displacement by plastic strain and pressure that are constant in cells, by their Fourier modes.

A field that is constant in cells has waves of all lengths. Waves longer than two cells are resolved. Short waves, those
shorter than two cells, represent the edges of cells: each has the values of one resolved wave, its alias, at the
middles of the cells.

Stress of one wave along the surface of a half-space: under pressure, and by plastic strain constant in layers.

A wave ``exp(i q n.x)`` has the wave number q and the direction ``n = (c, s, 0)``, where c and s are the cosine and the
sine of its angle to x; ``t = (-s, c, 0)`` lies along its crests and z points into the body. Fields depend on n and z
alone, so that plane strain in (n, z) and antiplane shear along t do not couple. Tensors are given by nn, tt, zz,
nz / i, nt, tz / i, with the imaginary unit i: all coefficients between strain, traction and stress are then real.

Plane strain has Airy's stress function ``phi``, of the components ``nn = d2 phi / dz2``, ``zz = -q^2 phi``,
``nz / i = -q d phi / dz`` and ``tt = nu (nn + zz)``. Where the modes of :class:`Sources` stand for ``q^2 phi`` and -nt,
all stresses below follow by differentiation and from equilibrium.

Plastic strain lives in the box of cells of :class:`Volume`.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from enum import Enum
from functools import cache, cached_property
from itertools import pairwise, product
from math import pi
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammainc

from contactstudy.domain.grid import Array, Grid


@dataclass(frozen=True)
class Moduli:
    """Elastic constants of an isotropic half-space: `youngs_modulus` [Pa] and `poisson_ratio`."""

    youngs_modulus: float
    poisson_ratio: float

    @property
    def shear(self) -> float:
        """Shear modulus ``G = E / (2 (1 + nu))`` [Pa]."""
        return self.youngs_modulus / (2 * (1 + self.poisson_ratio))

    @property
    def plane_strain(self) -> float:
        """Plane-strain modulus ``E / (1 - nu^2)`` [Pa]."""
        return self.youngs_modulus / (1 - self.poisson_ratio**2)


@dataclass(frozen=True)
class Volume:
    """Box of cells below the surface that may yield, in layers.

    It has the cells `first` to `last`, exclusive, of `grid` across and all of its cells along. `edges` [m] are the
    depths between layers, at least 0, one more than layers.
    """

    grid: Grid
    first: int
    last: int
    edges: tuple[float, ...]

    @property
    def rows(self) -> slice:
        """Cells of the grid across that the volume covers, as a slice."""
        return slice(self.first, self.last)

    @property
    def shape(self) -> tuple[int, int, int]:
        """Number of cells (layers, x, y)."""
        return len(self.edges) - 1, self.last - self.first, self.grid.cells[1]

    @property
    def thicknesses(self) -> Array:
        """Thickness of each layer (layers,) [m]."""
        return np.diff(np.array(self.edges))

    @property
    def depths(self) -> Array:
        """Depth of the middle of each layer (layers,) [m]."""
        edges = np.array(self.edges)
        return np.asarray((edges[1:] + edges[:-1]) / 2)

    @property
    def cell_volumes(self) -> Array:
        """Volume of a cell in each layer (layers, 1, 1) [m^3], which broadcasts to cells."""
        return self.thicknesses[:, None, None] * self.grid.cell_area


class EigenstrainOperator(Protocol):
    """Linear maps on plastic strain e (component, layers, x, y), constant in each cell of a volume, to cell means.

    Components are deviatoric, in an orthonormal (Mandel) basis of C tensors: 3 in plane strain, 5 otherwise. x points
    across, y along, z into the body. Stress is positive in tension, pressure in compression; plastic strain has no
    unit.

    Methods speak of three maps. S gives the stress under a pressure, its transpose the displacement by a strain. B
    gives minus the residual stress by a strain: in the inner product
    of cell volumes it is symmetric, with eigenvalues above 0 and below 2 G, twice the shear modulus.
    """

    @property
    def volume(self) -> Volume:
        """Box of cells that carry plastic strain."""

    @property
    def moduli(self) -> Moduli:
        """Elastic constants of the body."""

    @property
    def basis(self) -> Array:
        """Basis of the components (C, 6) in terms of xx, yy, zz, yz, xz, xy.

        The squares of a tensor's entries, shear counted twice, add up to 1.
        """

    @property
    def diagonal_blocks(self) -> Array:
        """Minus the residual stress of a cell by its own unit strain, (layers, C, C) [Pa].

        These are the blocks on the diagonal of the map B of :meth:`negative_residual_stress`.
        """

    def stress_of_pressure(self, pressure: Array) -> Array:
        """Return the deviatoric stress S p (C, layers, x, y) [Pa] under `pressure` p (x, y) [Pa] on the whole grid."""

    def stress_of_shear(self, shear: Array) -> Array:
        """Return the deviatoric stress (C, layers, x, y) [Pa] under `shear` along x (x, y) [Pa] on the whole grid."""

    def negative_residual_stress(self, strain: Array) -> Array:
        """Return B e, minus the deviatoric residual stress (C, layers, x, y) [Pa] of plastic `strain` e."""

    def residual_displacement(self, strain: Array) -> Array:
        """Return the surface displacement ``S^T e`` (x, y) [m] by plastic `strain` e, into the body, on the whole grid.

        ``sum(u * p) * cell area = sum(cell volume * e : S p)`` for any pressure p, with the displacement u returned.
        """

    def residual_stress_tensor(self, strain: Array) -> Array:
        """Return the residual stress xx, yy, zz, yz, xz, xy of plastic `strain` e, (6, layers, x, y) [Pa].

        It is the stress without pressure; its deviator is -B e.
        """


# q times a depth at which a mode has decayed: exp(-700) is 1e-304, just above the smallest normal double.
MAX_DECAY = 700.0
# The six fields nn, tt, zz, nz / i, nt, tz / i of a symmetric tensor.
Tensor = tuple[Array, Array, Array, Array, Array, Array]


def means(ratio: Array) -> tuple[Array, Array]:
    """Return the means of ``exp(-s)`` and ``s exp(-s)`` for s from 0 to `ratio`, without cancellation."""
    small = np.maximum(ratio, 1e-300)
    return -np.expm1(-small) / small, gammainc(2.0, small) / small


@dataclass(frozen=True, eq=False)
class Sources:
    """Amplitudes of the Fourier modes of plastic strain in layers, each field (layers, ..., waves).

    Where strain jumps from a layer to the one below, modes ``(a + b q z) exp(-q z)`` of Airy's stress function times
    q^2 and ``c exp(-q z)`` of the antiplane stress -nt decay downwards from there, and others upwards: these are linear
    in the jump. `down` and `up` are their amplitudes (a, b, c) for each layer's own strain. `zz`, `tt` and `tz` are the
    stress of a layer whose displacement does not change with depth; its other components are zero.
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
        """Return the layer with this `ratio` of its thickness to 1 / q, (waves,)."""
        return cls(ratio, np.exp(-ratio), means(ratio))

    def attenuated(self, amplitudes: Array) -> Array:
        """Return the `amplitudes` (a, b, c) of modes at the far side of the layer."""
        after = amplitudes * self.decay
        after[0] += self.ratio * after[1]
        return after


def surface_correction(up: Array) -> Array:
    """Return the amplitudes (a, b, c) of modes that decay downwards and free the surface of traction.

    `up` are the amplitudes at the surface of modes that decay upwards. The stresses zz, nz and tz of both together are
    zero at z = 0.
    """
    return np.stack((-up[0], up[1] - 2 * up[0], up[2]))


def layer_stresses(sources: Sources, layers: Sequence[CellLayer], nu: float) -> Tensor:
    """Return the means of the stress over each of the `layers` (layers, ..., waves) by plastic strain in all of them.

    The layers are in order from the surface on. One sweep up and one down: the work grows with the number of layers,
    not with its square.
    """
    count = len(layers)
    # at each interface the sources are those of the strain below less those of the strain above, which is zero outside
    up, down = np.empty_like(sources.up), np.empty_like(sources.down)
    state = -sources.up[:, -1]
    for number in range(count - 1, -1, -1):
        up[:, number] = state
        state = layers[number].attenuated(state)
        state += sources.up[:, number]
        if number:
            state -= sources.up[:, number - 1]
    state = surface_correction(state) + sources.down[:, 0]
    for number in range(count):
        down[:, number] = state
        if number < count - 1:
            state = layers[number].attenuated(state)
            state += sources.down[:, number + 1]
            state -= sources.down[:, number]
    return _layer_stress(sources, down, up, layers, nu)


def self_stress(sources: Sources, top: Array, layer: CellLayer, nu: float) -> Tensor:
    """Return the means of the stress over a `layer` by its own plastic strain alone, each (any, waves).

    `top` is q times the depth of its upper side.
    """
    down = sources.down + _surface_part(sources, layer, top, top)
    return _layer_stress(sources, down, -sources.up, [layer], nu)


def stress_of_other_layer(
    sources: Sources, layers: tuple[CellLayer, CellLayer], tops: tuple[Array, Array], nu: float
) -> Tensor:
    """Return the means of the stress over the second of two `layers` by plastic strain in the first, above or below it.

    `tops` are q times the depths of their upper sides. For deep layers both may be moved down together, until the
    surface correction vanishes.
    """
    (source, layer), (begin, end) = layers, tops
    down, up = _surface_part(sources, source, begin, end), np.zeros_like(sources.up)
    if np.all(begin < end):
        # one side has the sources of the strain, the other one minus those
        from_both_sides = source.attenuated(sources.down) - sources.down
        down += _attenuated(from_both_sides, end - begin - source.ratio)
    else:
        up += _attenuated(sources.up - source.attenuated(sources.up), begin - end - layer.ratio)
    return _wave_stress(down, up, layer.means, nu)


def _surface_part(sources: Sources, source: CellLayer, begin: Array, end: Array) -> Array:
    """Return the amplitudes at a depth `end` of the surface correction of the modes of a layer.

    `source` is that layer, and `begin` the depth of its upper side. Both depths are times q.
    """
    up = _attenuated(sources.up - source.attenuated(sources.up), begin)
    return _attenuated(surface_correction(up), end)


def _attenuated(amplitudes: Array, ratio: Array) -> Array:
    """Return the `amplitudes` of modes after a distance of `ratio` / q."""
    after = amplitudes * np.exp(-np.minimum(ratio, MAX_DECAY))
    after[0] += ratio * after[1]
    return after


def _means_below(top: Array, layer: CellLayer) -> tuple[Array, Array]:
    """Return the means of ``exp(-s)`` and ``s exp(-s)`` over a `layer` whose upper side is at s = `top`."""
    decay = np.exp(-np.minimum(top, MAX_DECAY))
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
    across = -s * m0
    return c * (2 * m0 - m1), (2 * nu) * c * m0, c * m1, c * (m0 - m1), across, across


def _layer_stress(sources: Sources, down: Array, up: Array, layers: Sequence[CellLayer], nu: float) -> Tensor:
    """Return the means of the stress over each layer, by waves and by the layer's own strain.

    The waves have the amplitudes `down` at the upper side of each layer and `up` at its lower side.
    """
    m0, m1 = layers[0].means
    if any(layer is not layers[0] for layer in layers):
        m0, m1 = (np.stack([layer.means[order] for layer in layers])[:, None] for order in (0, 1))
    nn, tt, zz, nz, nt, tz = _wave_stress(down, up, (m0, m1), nu)
    tt += sources.tt
    zz += sources.zz
    tz += sources.tz
    return nn, tt, zz, nz, nt, tz


def _wave_stress(down: Array, up: Array, layer_means: tuple[Array, Array], nu: float) -> Tensor:
    """Return the means of the stress over a layer by modes, without that of its own uniform strain.

    `down` are the amplitudes (a, b, c) of those that decay downwards, at its upper side; `up` are those of the modes
    that decay upwards, at its lower side. `layer_means` are those of ``exp(-s)`` and ``s exp(-s)`` over the layer.
    """
    m0, m1 = layer_means
    sums, differences = down + up, down - up
    # nn, tt, zz and nt do not depend on the direction of decay; nz and tz, with one index z, change their signs with it
    b, zz = m0 * sums[1], m0 * sums[0] + m1 * sums[1]
    nz = m0 * (differences[0] - differences[1]) + m1 * differences[1]
    return zz - 2 * b, (-2 * nu) * b, -zz, nz, -m0 * sums[2], -m0 * differences[2]


class Components(Enum):
    """Set of stress components to compute.

    Its value has one sign for each component: -1 for one with a single index z, which is odd in depth.
    """

    #: (xx - zz) / sqrt(2), (2 yy - xx - zz) / sqrt(6), sqrt(2) xz, sqrt(2) xy, sqrt(2) yz: the basis of the deviator.
    DEVIATOR = (1, 1, -1, 1, -1)
    #: xx, yy, zz, yz, xz, xy.
    TENSOR = (1, 1, 1, -1, -1, 1)

    @property
    def signs(self) -> Array:
        """Parity of each component in depth (components,)."""
        return np.array(self.value)


@dataclass(frozen=True, eq=False)
class WaveDirection:
    """Wave number `q` [1/m] and direction (`c`, `s`) of waves, each (waves,).

    `weight` is the fraction of a wave that the mean over a cell leaves, for strain and for stress together.
    """

    q: Array
    c: Array
    s: Array
    weight: Array

    def strain(self, e: Array) -> Tensor:
        """Return the strain nn, tt, zz, nz / i, nt, tz / i of waves.

        `e` (5, ..., waves) are its components in the basis of ``Components.DEVIATOR``.
        """
        c, s = self.c, self.s
        xx, yy = e[0] / 2**0.5 - e[1] / 6**0.5, (2 / 6**0.5) * e[1]
        zz = -xx - yy
        xz, xy, yz = (e[number] / 2**0.5 for number in (2, 3, 4))
        twisted = (2 * c * s) * xy
        nn = c * c * xx + s * s * yy + twisted
        tt = -zz - nn
        nt = (c * s) * (yy - xx) + (c * c - s * s) * xy
        return nn, tt, zz, c * xz + s * yz, nt, c * yz - s * xz

    def stress(self, tensor: Tensor, components: Components) -> Array:
        """Return the chosen `components` (components, ..., waves) of a stress `tensor`."""
        c, s = self.c, self.s
        nn, tt, zz, nz, nt, tz = tensor
        xx = (c * c) * (nn - tt) + tt - (2 * c * s) * nt
        xy = (c * s) * (nn - tt) + (c * c - s * s) * nt
        xz, yz = c * nz - s * tz, s * nz + c * tz
        if components is Components.TENSOR:
            return np.stack(np.broadcast_arrays(xx, nn + tt - xx, zz, yz, xz, xy))
        lateral = 2 * (nn + tt) - 3 * xx - zz
        shears = (2**0.5 * shear for shear in (xz, xy, yz))
        return np.stack(np.broadcast_arrays((xx - zz) / 2**0.5, lateral / 6**0.5, *shears))


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
