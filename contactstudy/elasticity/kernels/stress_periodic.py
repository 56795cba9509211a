"""Stress below a cell repeated along one axis or both, summed over all images."""

from collections.abc import Callable
from functools import cache

import numpy as np
from numpy.polynomial.chebyshev import chebpts1, chebvander
from numpy.typing import ArrayLike
from scipy.linalg import eigh_tridiagonal

from contactstudy.domain.fields import Array
from contactstudy.elasticity.kernels.displacement_cell import mean_gauss_rule
from contactstudy.elasticity.kernels.displacement_periodic import column_and_row
from contactstudy.elasticity.kernels.stress_cell import CellKernel, Strip, sign, stress_cell, strip

# Distance from the axis, in periods, beyond which the stress does not vary along it: exp(-2 pi 6) ~ 1e-17.
PLANE_STRAIN_PERIODS = 6.0
# Nodes of the rule for images at more than twice the distance from the axis: each gains a factor of rho^2 = 8^2.
TAIL_POINTS = 10
# Points across and along that all of these are interpolated from: Bernstein ellipses of rho >= 6 and 13.
INTERPOLATED = 22, 14
# Points along either axis that all rows of a lattice but three are interpolated from: rho >= 9.
LATTICE_INTERPOLATED = 18
# Images that the tail's rule is made from.
TAIL_IMAGES = 20_000


def stress_cell_periodic(
    component: CellKernel,
    x: ArrayLike,
    y: ArrayLike,
    z: float,
    dx: float,
    dy: float,
    period: float,
    poisson_ratio: float,
) -> Array:
    """Return a component of stress over pressure (x, y) below a cell repeated infinitely along y.

    The error is below 1e-12 of the largest component, of one cell or of the row, whichever is larger. The nearest images
    are summed one by one. The others are 1/m^2 times a smooth function of 1/m, and summed by Gauss's rule for such sums
    (Monien 2010, Math. Comp. 79), whose nodes are positions between the images. Far from the axis, the row is a strip in
    plane strain.

    Parameters
    ----------
    component
        Component to compute.
    x, y
        Offsets from the centre of a cell: every x with every y.
    z
        Depth at least 0, not 0 on the edge of a cell.
    dx, dy
        Sides of the cell, ``dy <= period``; all lengths in one unit.
    period
        Distance between images along y.
    poisson_ratio
        Poisson's ratio of the half-space.
    """
    x, y = column_and_row(x, y)
    y = y - period * np.round(y / period)
    outer, inner = (np.maximum(np.abs(x.ravel()) + side * dx / 2, 0) for side in (1, -1))
    far = (np.hypot(inner, z) >= PLANE_STRAIN_PERIODS * period) | (dy == period)
    result = np.empty(np.broadcast_shapes(x.shape, y.shape))
    if far.any():
        plane = plane_strain(component, strip(x[far], z, dx), poisson_ratio)
        result[far] = plane * (dy / period)
    reach = np.exp2(np.ceil(np.log2(np.maximum(np.hypot(outer, z) / period, 1)))).astype(int)
    for periods in np.unique(reach[~far]).tolist():
        rows = ~far & (reach == periods)
        near = sorted(range(1 - 2 * periods, 2 * periods), key=abs, reverse=True)

        def far_images(u: Array, v: Array, periods: int = periods) -> Array:
            positions, weights = _tail(2 * periods)
            images = np.outer(positions, (1, -1)).reshape(-1, 1, 1) * period + v
            stress = stress_cell(component, u, images, z, dx, dy, poisson_ratio)
            return np.asarray(np.einsum("i,ixy->xy", np.repeat(weights, 2), stress))

        # small terms add up before they meet the large ones
        ends = periods * period, period / 2
        total = _smooth(far_images, x[rows], y, ends, INTERPOLATED, component.parity)
        for m in near:
            total += stress_cell(component, x[rows], y + m * period, z, dx, dy, poisson_ratio)
        result[rows] = total
    return result


def plane_strain(component: CellKernel, loaded_strip: Strip, poisson_ratio: float) -> Array:
    """Return a component of stress under unit pressure on a strip."""
    return np.asarray(component.plane(loaded_strip, poisson_ratio) / np.pi + 0 * loaded_strip.angle)


def _smooth(
    field: Callable[[Array, Array], Array],
    x: Array,
    y: Array,
    ends: tuple[float, float],
    counts: tuple[int, int],
    parity: tuple[int, int],
) -> Array:
    """Return a smooth `field` at a column of `x` and a row of `y`, interpolated from Chebyshev points.

    Parameters
    ----------
    field
        Returns the values (x, y) at a column and a row of offsets.
    x, y
        Offsets.
    ends
        Largest offset along each axis.
    counts
        Number of Chebyshev points along each axis.
    parity
        1 for an axis along which the field is even, -1 where it is odd.
    """
    (u, from_x), (v, from_y) = (
        ((1 + chebpts1(count)) / 2 * end, chebyshev_interpolation(count, 2 * np.abs(a.ravel()) / end - 1))
        for a, end, count in zip((x, y), ends, counts, strict=True)
    )
    along = np.einsum("uv,jv->uj", field(u[:, None], v[None, :]), from_y)
    smooth = np.einsum("iu,uj->ij", from_x, along)
    return np.asarray(smooth * sign(x, parity[0]) * sign(y, parity[1]))


def chebyshev_interpolation(count: int, points: Array) -> Array:
    """Return the matrix from values at first-kind Chebyshev points to values at `points`, shape (points, count)."""
    nodes = chebvander(chebpts1(count), count - 1)
    # the polynomials are orthogonal over their points
    weights = nodes.T * (np.where(np.arange(count) == 0, 1, 2)[:, None] / count)
    # not through BLAS, which would start threads for it
    return np.asarray(np.einsum("ik,kj->ij", chebvander(points, count - 1), weights))


@cache
def _tail(start: int) -> tuple[Array, Array]:
    """Return positions and weights with ``sum over m >= start of f(m)`` for f(m) = m^-2 polynomial(1/m)."""
    end = start + TAIL_IMAGES
    m = np.arange(start, end, dtype=np.float64)
    # the sum from there on is an integral but for 1 / (12 end^3)
    nodes, tail_weights = np.array(mean_gauss_rule(TAIL_POINTS)).T
    remainder = 1 / (end - 0.5)
    t = np.append(1 / m, (1 + nodes) / 2 * remainder)
    weights = np.append(m**-2, tail_weights * remainder)
    # Lanczos: the three-term recurrence of the polynomials orthogonal over this sum
    vectors = [np.sqrt(weights / weights.sum())]
    diagonal, off = [], []
    for _ in range(TAIL_POINTS):
        following = t * vectors[-1]
        diagonal.append(float((following * vectors[-1]).sum()))
        for _again in range(2):
            for vector in vectors:
                following = following - (following * vector).sum() * vector
        off.append(float(np.sqrt((following**2).sum())))
        vectors.append(following / off[-1])
    nodes, eigenvectors = eigh_tridiagonal(np.array(diagonal), np.array(off[:-1]))
    return 1 / nodes, weights.sum() * (eigenvectors[0] / nodes) ** 2


def stress_cell_doubly_periodic(
    component: CellKernel,
    x: ArrayLike,
    y: ArrayLike,
    z: float,
    dx: float,
    dy: float,
    width: float,
    period: float,
    poisson_ratio: float,
) -> Array:
    """Return a component of stress over pressure (x, y) below a cell repeated along x and y.

    The displacement is periodic along both axes: the mean strain along the surface is zero, and so the mean of xx and yy
    is ``-nu / (1 - nu)`` of the mean pressure. Without this condition the sum would depend on its order. The error is
    below 1e-12 of the largest component. Each row of :func:`stress_cell_periodic` less its strip vanishes within a few
    periods; all strips together have a closed form.

    Parameters
    ----------
    component
        Component to compute.
    x, y
        Offsets from the centre of a cell: every x with every y.
    z
        Depth at least 0, not 0 on the edge of a cell.
    dx, dy
        Sides of the cell, all lengths in one unit.
    width, period
        Distances between images along x and y.
    poisson_ratio
        Poisson's ratio of the half-space.
    """
    x, y = column_and_row(x, y)
    if period > width:  # the harmonics of the shorter period vanish sooner
        swapped = component.swap_axes()
        arguments = y.T, x.T, z, dy, dx, period, width, poisson_ratio
        return stress_cell_doubly_periodic(swapped, *arguments).T
    x = x - width * np.round(x / width)
    y = y - period * np.round(y / period)

    def rows(u: Array, v: Array, numbers: list[int]) -> Array:
        images = np.add.outer(np.array(numbers) * width, u.ravel())
        each = images.ravel()
        stress = stress_cell_periodic(component, each, v, z, dx, dy, period, poisson_ratio)
        plane = plane_strain(component, strip(each, z, dx), poisson_ratio)
        stress -= plane[:, None] * (dy / period)
        return np.asarray(stress.reshape(*images.shape, -1).sum(axis=0))

    # smooth from the second row on
    last = int(np.ceil(PLANE_STRAIN_PERIODS * period / width)) + 1
    far = [side * m for m in range(last, 1, -1) for side in (1, -1)]
    points = LATTICE_INTERPOLATED, LATTICE_INTERPOLATED
    total = _smooth(lambda u, v: rows(u, v, far), x, y, (width / 2, period / 2), points, component.parity)
    total += rows(x, y, [1, -1, 0])
    strips = plane_strain(component, _strips(x, z, dx, width), poisson_ratio)
    confined = (1 - 2 * poisson_ratio) / (1 - poisson_ratio) * dx / width
    confinement = {"xx": confined, "yy": poisson_ratio * confined}.get(component.name, 0.0)
    return np.asarray(total + (strips + confinement) * (dy / period))


def _strips(x: Array, z: float, dx: float, width: float) -> Strip:
    """Return strips repeated with `width`: 1/x becomes (pi/W) cot(pi x/W) (Johnson 1985, sect. 13.2)."""
    # beyond this the harmonics have long underflowed, and cosh would not hold them
    depth = min(2 * np.pi * z / width, 100.0)
    twice, cell = 2 * np.pi * x / width, np.pi * dx / width
    edges = 2 * np.sin((twice + cell) / 2) * np.sin((twice - cell) / 2)
    fading = 2 * np.sinh(depth / 2) ** 2 * np.cos(twice)
    # cosh(depth) (cos(cell) - cos(twice)) + ..., by products where the difference would cancel
    angle = np.arctan2(np.sin(cell) * np.sinh(depth), edges * np.cosh(depth) + fading)
    denominator = edges - fading + 1j * np.sin(twice) * np.sinh(depth)
    return Strip(angle, -2 * np.pi * z / width * np.sin(cell) / denominator, x, z, dx, width)
