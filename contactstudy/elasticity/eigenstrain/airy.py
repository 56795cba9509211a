"""Stress by a cell of plastic strain or by a pressed cell, in plane strain on an infinite axis x: closed forms.

Means over cells of the Airy stress function of a half-space free of traction,
``G = [r^2 ln(r / R) + 2 z z'] / (8 pi)``, which solves ``nabla^4 G = delta`` with G = dG/dz = 0 at z = 0; r is the
distance from the source and R that from its image. Every mean is a difference over edges of an integral of G.
"""

from collections.abc import Mapping

import numpy as np

from contactstudy.domain.devices.arrays import Array

# Derivatives of G by depth of the stress (m) and of the source (n); by x there are 4 - m - n.
ORDERS = tuple((m, n) for m in range(3) for n in range(3))


def influence(count: int, edges: Array, layer: int) -> Mapping[tuple[int, int], Array]:
    """Means of ``d_z^m d_z'^n d_x^(4-m-n) G`` over a cell of ``layer``, by sources in all layers, for each (m, n).

    Arrays (layers, x) for ``count`` offsets 0, 1, 2 ... in cells; ``edges`` of the layers in cells too. Errors from
    cancellation grow like the offset squared, to 1e-9 of the largest at 1000 cells.
    """
    x = np.arange(-1.0, count + 1)
    below, above = (_integrals(x, edges[layer + side], edges) for side in (1, 0))
    thickness = edges[layer + 1] - edges[layer]
    means = {}
    for orders in ORDERS:
        change = np.diff(below[orders] - above[orders], axis=0)
        means[orders] = (change[:, 2:] - 2 * change[:, 1:-1] + change[:, :-2]) / thickness
    return means


def _integrals(x: Array, z: float, source: Array) -> dict[tuple[int, int], Array]:
    """``d_z^(m-1) d_z'^(n-1) d_x^(2-m-n) G`` at x, z by each depth of ``source``, (source, x), for each (m, n)."""
    z_source = source[:, None]
    direct = _powers(x, z - z_source)
    image = _powers(x, z + z_source)
    rest = _products(x, z, z_source)
    return {
        (m, n): (-((-1) ** n) * direct[m + n] - image[m + n] + 4 * rest[m, n]) / (8 * np.pi)
        for m, n in ORDERS
    }


def _powers(x: Array, z: Array) -> tuple[Array, ...]:
    """``d_z^(k-2) d_x^(2-k) (r^2 ln r)`` for k = 0 ... 4, but for what differences remove."""
    squared = x * x + z * z
    log = np.log(np.where(squared > 0, squared, 1.0)) / 2
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
    """``d_z^(m-1) d_z'^(n-1) d_x^(2-m-n) (z z' ln R)``, but for what differences remove."""
    w = (z + source) + 1j * x
    log = np.log(np.where(w == 0, 1.0, w))
    # integrals of ln w, none to two times
    of_log = log, w * (log - 1), w * w / 2 * (log - 1.5)
    found = {}
    for m, n in ORDERS:
        s, t = m - 1, n - 1
        turn = 1j ** ((2 - m - n) % 4)
        zero, one, two = ((turn * term).real for term in of_log)
        found[m, n] = z * source * zero + (s * source + t * z) * one + s * t * two
    return found


def pressed(offsets: Array, edges: Array) -> tuple[Array, Array, Array]:
    """Means of the stresses xx, zz and xz over cells under a cell of unit pressure, each (layers, x).

    ``offsets`` of the stress from the pressure and ``edges`` of the layers in cells. Source: the integrals of
    Johnson (1985), eqs. 2.23, over the cells.
    """
    x = offsets + np.array([-1.0, 0.0, 1.0])[:, None]
    x, z = x[:, None, :], edges[:, None]
    squared = x * x + z * z
    log = np.log(np.where(squared > 0, squared, 1.0)) / 2
    angle = np.arctan2(x, z)
    integrals = (
        (z * z * log - x * z * angle) / np.pi,
        -x * (z * angle + x * log) / np.pi,
        (squared * angle - x * z) / (2 * np.pi),
    )
    thickness = np.diff(edges)[:, None]
    found = []
    for one in integrals:
        change = np.diff(one, axis=1)
        found.append((change[2] - 2 * change[1] + change[0]) / thickness)
    xx, zz, xz = found
    return xx, zz, xz
