"""Stress of one wave along the surface of a half-space: under pressure, and by plastic strain constant in layers.

A wave ``exp(i q n.x)`` has the wave number q and the direction ``n = (c, s, 0)``, where c and s are the cosine and the
sine of its angle to x; ``t = (-s, c, 0)`` lies along its crests and z points into the body. Fields depend on n and z
alone, so that plane strain in (n, z) and antiplane shear along t do not couple. Tensors are given by nn, tt, zz,
nz / i, nt, tz / i, with the imaginary unit i: all coefficients between strain, traction and stress are then real.

Plane strain has Airy's stress function ``phi``, of the components ``nn = d2 phi / dz2``, ``zz = -q^2 phi``,
``nz / i = -q d phi / dz`` and ``tt = nu (nn + zz)``. Where the modes of :class:`Sources` stand for ``q^2 phi`` and -nt,
all stresses below follow by differentiation and from equilibrium.

Plastic strain lives in the box of cells of :class:`Volume`.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Protocol

import numpy as np
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
