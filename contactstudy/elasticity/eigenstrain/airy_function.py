"""Closed forms of the stress in a half-space in plane strain, by a cell of plastic strain or a cell under traction.

They are means over cells of the Airy stress function of a half-space free of traction,
``G = [r^2 ln(r / R) + 2 z z'] / (8 pi)``, which solves ``nabla^4 G = delta`` with G = dG/dz = 0 at z = 0; r is the
distance from the source and R that from its mirror source. Every mean is a difference over edges of an integral of G.
"""

from collections.abc import Callable, Mapping

import numpy as np

from contactstudy.domain.fields import Array

# Means of the stresses xx, zz and xz by a traction on one cell, from offsets and edges.
TractionKernel = Callable[[Array, Array], tuple[Array, Array, Array]]
# Derivatives of G by depth of the stress (m) and of the source (n); by x there are 4 - m - n.
DERIVATIVE_ORDERS = tuple((m, n) for m in range(3) for n in range(3))


def airy_means(count: int, edges: Array, layer: int) -> Mapping[tuple[int, int], Array]:
    """Return means of derivatives of Airy's stress function G over a cell of one `layer`, by sources in all layers.

    For each (m, n) of `DERIVATIVE_ORDERS` it is ``d_z^m d_z'^n d_x^(4-m-n) G`` with depths z of the stress and z' of
    the source; G is that of a half-space free of traction. The arrays (layers, x) are at `count` offsets 0, 1, 2 ...
    across; offsets and the `edges` of the layers are in cells. Errors from cancellation grow like the offset squared,
    to some 3e-9 of the largest mean at 1000 cells.
    """
    x = np.arange(-1.0, count + 1)
    below, above = (_integrals(x, edges[layer + side], edges) for side in (1, 0))
    thickness = edges[layer + 1] - edges[layer]
    means = {}
    for orders in DERIVATIVE_ORDERS:
        change = np.diff(below[orders] - above[orders], axis=0)
        means[orders] = (change[:, 2:] - 2 * change[:, 1:-1] + change[:, :-2]) / thickness
    return means


def _integrals(x: Array, z: float, source: Array) -> dict[tuple[int, int], Array]:
    """Return ``d_z^(m-1) d_z'^(n-1) d_x^(2-m-n) G`` (source, x) for each (m, n), at offsets `x` and depth `z`.

    G is Airy's stress function, and `source` the depths of its sources. Polynomials that the differences over cells
    remove are left out.
    """
    z_source = source[:, None]
    direct = _powers(x, z - z_source)
    image = _powers(x, z + z_source)
    products = _products(x, z, z_source)
    return {
        (m, n): (-((-1) ** n) * direct[m + n] - image[m + n] + 4 * products[m, n]) / (8 * np.pi)
        for m, n in DERIVATIVE_ORDERS
    }


def log_distance(squared: Array) -> Array:
    """Return ``ln r`` from ``r^2``, and 0 at r = 0: what it is multiplied by is zero there."""
    return np.asarray(np.log(squared + (squared == 0)) / 2)


def _powers(x: Array, z: Array) -> tuple[Array, ...]:
    """Return ``d_z^(k-2) d_x^(2-k) (r^2 ln r)`` for k = 0 ... 4, with r the distance from the origin to (x, z).

    Polynomials that the differences over cells remove are left out.
    """
    squared = x * x + z * z
    log = log_distance(squared)
    # angles from the z axis and from the x axis, of the same sign as x z
    by_z = np.sign(z) * np.arctan2(x, np.abs(z))
    by_x = np.sign(x) * np.arctan2(z, np.abs(x))
    return (
        (z * z - 3 * x * x) * log + 4 * x * z * by_x,
        2 * x * (z * log + x * by_x),
        squared * log,
        2 * z * (x * log + z * by_z),
        (x * x - 3 * z * z) * log + 4 * x * z * by_z,
    )


def _products(x: Array, z: float, source: Array) -> dict[tuple[int, int], Array]:
    """Return ``d_z^(m-1) d_z'^(n-1) d_x^(2-m-n) (z z' ln R)`` for each (m, n), with z' the depths of the `source`.

    R is the distance from the mirror source. Polynomials that the differences over cells remove are left out.
    """
    w = (z + source) + 1j * x
    log = np.log(np.where(w == 0, 1.0, w))
    # ln w, integrated zero, one and two times
    log_integrals = log, w * (log - 1), w * w / 2 * (log - 1.5)
    derivatives = {}
    for m, n in DERIVATIVE_ORDERS:
        s, t = m - 1, n - 1
        rotation = 1j ** ((2 - m - n) % 4)
        plain, once, twice = ((rotation * term).real for term in log_integrals)
        derivatives[m, n] = z * source * plain + (s * source + t * z) * once + s * t * twice
    return derivatives


def stress_means_under_pressure(offsets: Array, edges: Array) -> tuple[Array, Array, Array]:
    """Return means of the stresses xx, zz and xz over cells under one cell of unit pressure, each (layers, x).

    `offsets` of the stress from the pressure and `edges` of the layers are in cells. Source: the integrals of Johnson
    (1985), eqs. 2.23, over the cells.
    """
    x, z, squared, log, angle = _from_one_cell(offsets, edges)
    return _means(
        edges,
        (z * z * log - x * z * angle) / np.pi,
        -x * (z * angle + x * log) / np.pi,
        (squared * angle - x * z) / (2 * np.pi),
    )


def stress_means_under_shear(offsets: Array, edges: Array) -> tuple[Array, Array, Array]:
    """Return means of the stresses xx, zz and xz over cells by unit tangential traction on one cell, each (layers, x).

    Arguments are those of :func:`stress_means_under_pressure`. Source: the integrals of Johnson (1985), eqs. 2.23, over
    the cells: zz and xz are xz and xx of a pressed cell, and ``xx + zz = -2 x / (pi r^2)`` below a line of force.
    """
    x, z, squared, log, angle = _from_one_cell(offsets, edges)
    by_x = np.sign(x) * np.arctan2(z, np.abs(x))
    zz = (squared * angle - x * z) / (2 * np.pi)
    trace = -2 / np.pi * (x * z * log + (z * z * angle + x * x * by_x) / 2)
    return _means(edges, trace - zz, zz, (z * z * log - x * z * angle) / np.pi)


def _from_one_cell(offsets: Array, edges: Array) -> tuple[Array, Array, Array, Array, Array]:
    """Return x, z, r^2, ln r and the angle from the z axis at the edges of cells, (edge across, edge, x)."""
    x = (offsets + np.array([-1.0, 0.0, 1.0])[:, None])[:, None, :]
    z = edges[:, None]
    squared = x * x + z * z
    return x, z, squared, log_distance(squared), np.arctan2(x, z)


def _means(edges: Array, *integrals: Array) -> tuple[Array, Array, Array]:
    """Return the means (layers, x) over cells of three stresses, integrated twice over x and once over z."""
    thickness = np.diff(edges)[:, None]
    changes = [np.diff(integral, axis=1) for integral in integrals]
    xx, zz, xz = ((change[2] - 2 * change[1] + change[0]) / thickness for change in changes)
    return xx, zz, xz
