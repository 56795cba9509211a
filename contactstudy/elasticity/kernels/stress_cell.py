"""Stress below a rectangular cell under uniform pressure on an elastic half-space.

Coefficients are stress over pressure, for one component at a time, tension positive. x runs across, y along, z into the
body, whose surface is free of tangential traction.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from contactstudy.domain.fields import Array
from contactstudy.elasticity.kernels.displacement_cell import mean_gauss_rule

# Distances in units of the longer side of a cell. Up to CORNER_DISTANCE the difference of corners loses a factor of
# CORNER_DISTANCE^2 and the cell's aspect; from there on a point's field is analytic in a Bernstein ellipse of
# rho >= 16, 36, 80, 320 or 4000, so that 7, 5, 4, 3 or 2 Gauss points leave at most 1e-13.
CORNER_DISTANCE = 4.0
GAUSS_ZONES = ((CORNER_DISTANCE, 7), (9.0, 5), (20.0, 4), (80.0, 3), (1000.0, 2))

# Field at offsets x, y and depth z, with the distance from the origin and Poisson's ratio.
KernelFunction = Callable[[Array, Array, float, Array, float], Array]


@dataclass(frozen=True)
class CellKernel:
    """Kernel of a field of a loaded cell, such as one component of the stress tensor.

    Parameters
    ----------
    name
        Name of the field, such as the component "xx".
    parity
        1 for a field that is even across and along, -1 for one that is odd.
    point
        2 pi times the field, such as the stress, under a unit force at the origin: from offsets x and y, depth z,
        distance r and Poisson's ratio.
    corner
        Integral of `point` over x and y, of the same arguments.
    plane
        pi times the field in plane strain under unit load on a :class:`Strip`, from it and Poisson's ratio.
    swapped
        Name of the field with the axes exchanged.
    family
        Kernels among which `swapped` is looked up, by default ``COMPONENTS``.
    """

    name: str
    parity: tuple[int, int]
    point: KernelFunction
    corner: KernelFunction
    plane: "Callable[[Strip, float], Array | float]"
    swapped: str
    family: "Mapping[str, CellKernel] | None" = field(default=None, compare=False, repr=False)

    def swap_axes(self) -> "CellKernel":
        """Return the kernel with the axes exchanged."""
        return (COMPONENTS if self.family is None else self.family)[self.swapped]


@dataclass(frozen=True, eq=False)
class Strip:
    """Loaded strip, infinite along y, as seen from a point (Johnson 1985, sect. 2.5(a)).

    Parameters
    ----------
    angle
        Angle that it subtends.
    edge_terms
        Terms ``z / (a + i z) - z / (b + i z)`` of its edges at offsets a and b.
    middle
        Offset of its middle.
    depth
        Depth z of the point.
    width
        Width of the strip.
    period
        Period W across, None for a strip by itself.
    """

    angle: Array
    edge_terms: NDArray[np.complex128]
    middle: Array
    depth: float
    width: float
    period: float | None = None

    @property
    def logarithm(self) -> Array:
        """``ln |a + i z| - ln |b + i z|``; with a period, that of ``2 sin(pi (a + i z) / W)``."""
        x, z, dx, period = self.middle, self.depth, self.width, self.period
        if period is None:
            return np.asarray(np.log1p(2 * x * dx / ((x - dx / 2) ** 2 + z * z)) / 2)
        # |2 sin(u + i v)|^2 = 4 (sin(u)^2 + sinh(v)^2); at depth both edges are lost in rounding alike
        deep = np.sinh(min(np.pi * z / period, 300.0)) ** 2
        ends = (np.sin(np.pi * (x + side * dx / 2) / period) ** 2 + deep for side in (1, -1))
        return np.asarray(np.log(np.divide(*ends)) / 2)

    @property
    def sides(self) -> Array:
        """Integral of the sign of the offset, ``|a| - |b|``; with a period, of a sawtooth without mean."""
        ends, period = [self.middle + side * self.width / 2 for side in (1, -1)], self.period
        if period is None:
            return np.asarray(np.abs(ends[0]) - np.abs(ends[1]))
        from_middle = [end - period * np.round(end / period) for end in ends]
        tops = [np.abs(end) - end**2 / period for end in from_middle]
        return np.asarray(tops[0] - tops[1])

    @property
    def mean_width(self) -> float:
        """Width of the strip; 0 with a period, where the mean is omitted."""
        return self.width if self.period is None else 0.0


def _angle(x: Array, y: Array, z: float, r: Array) -> Array:
    """Return the integral of ``-z / r^3``: minus the solid angle of a quadrant."""
    return np.asarray(-np.arctan2(x * y, z * r))


def _second_derivative_inverse(x: Array, y: Array, z: float, r: Array) -> Array:
    """Return the integral of ``-z (d/dx)^2 (1/r)``."""
    return np.asarray(z * x * y / ((x * x + z * z) * r))


def second_derivative_log(x: Array, y: Array, z: float, r: Array) -> Array:
    """Return the integral of ``(d/dx)^2 ln(r + z)``, its two arctangents as one that does not cancel."""
    return np.arctan2(x * y * (x * x + y * y) / (r + z), x * x * r + z * y * y)


def second_derivative_log_point(x: Array, y: Array, z: float, r: Array) -> Array:
    """Return ``(d/dx)^2 ln(r + z)``."""
    return np.asarray((1 - x * x * (2 * r + z) / (r * r * (r + z))) / (r * (r + z)))


def _xx_point(x: Array, y: Array, z: float, r: Array, nu: float) -> Array:
    """Return 2 pi times the stress xx under a unit force at the origin."""
    s = r * r
    lateral = z / (s * r) - second_derivative_log_point(x, y, z, r)
    return np.asarray((1 - 2 * nu) * lateral - 3 * z * (x * x) / (s * s * r))


def _xx_corner(x: Array, y: Array, z: float, r: Array, nu: float) -> Array:
    """Return the integral over x and y of 2 pi times the stress xx under a unit force."""
    lateral = (1 - 2 * nu) * second_derivative_log(x, y, z, r)
    return np.asarray(2 * nu * _angle(x, y, z, r) + _second_derivative_inverse(x, y, z, r) - lateral)


def _xy_point(x: Array, y: Array, z: float, r: Array, nu: float) -> Array:
    """Return 2 pi times the stress xy under a unit force at the origin."""
    s = r * r
    lateral = (1 - 2 * nu) * (2 * r + z) / (r + z) ** 2
    return np.asarray(x * y / (s * r) * (lateral - 3 * z / s))


def _xz_corner(x: Array, y: Array, z: float, r: Array, _: float) -> Array:
    """Return the integral over x and y of 2 pi times the stress xz under a unit force."""
    return np.asarray(z * z * y / ((x * x + z * z) * r))


# Name, parity, point, corner, plane and swapped name. Source: Love (1929), by way of Johnson (1985), eqs. 3.19 and 3.25
COMPONENTS = {
    component.name: component
    for component in (
        CellKernel(
            "xx", (1, 1), _xx_point, _xx_corner, lambda strip, nu: strip.edge_terms.real - strip.angle, "yy"
        ),
        CellKernel(
            "yy", (1, 1),
            lambda x, y, z, r, nu: _xx_point(y, x, z, r, nu),
            lambda x, y, z, r, nu: _xx_corner(y, x, z, r, nu),
            lambda strip, nu: -2 * nu * strip.angle, "xx",
        ),
        CellKernel(
            "zz", (1, 1),
            lambda x, y, z, r, nu: -3 * z**3 / ((r * r) * (r * r) * r),
            lambda x, y, z, r, nu: (
                _angle(x, y, z, r)
                - _second_derivative_inverse(x, y, z, r)
                - _second_derivative_inverse(y, x, z, r)
            ),
            lambda strip, nu: -strip.edge_terms.real - strip.angle, "zz",
        ),
        CellKernel(
            "yz", (1, -1),
            lambda x, y, z, r, nu: -3 * z * z * y / ((r * r) * (r * r) * r),
            lambda x, y, z, r, nu: _xz_corner(y, x, z, r, nu), lambda strip, nu: 0.0, "xz",
        ),
        CellKernel(
            "xz", (-1, 1),
            lambda x, y, z, r, nu: -3 * z * z * x / ((r * r) * (r * r) * r),
            _xz_corner, lambda strip, nu: -strip.edge_terms.imag, "yz",
        ),
        CellKernel(
            "xy", (-1, -1), _xy_point,
            lambda x, y, z, r, nu: -z / r - (1 - 2 * nu) * np.log(r + z), lambda strip, nu: 0.0, "xy",
        ),
    )
}  # fmt: skip


def stress_cell(
    component: CellKernel, x: ArrayLike, y: ArrayLike, z: float, dx: float, dy: float, poisson_ratio: float
) -> Array:
    """Return a component of stress over pressure below a rectangular cell.

    The error is below 1e-12 of the largest component at that distance for ``dx / dy`` from 0.1 to 10, and beyond
    in proportion to the larger of this ratio and its inverse. The result is even or odd in x and y to the last bit.

    Parameters
    ----------
    component
        Component to compute.
    x, y
        Offsets from the centre of the cell, which broadcast.
    z
        Depth at least 0, not 0 on the edge of the cell.
    dx, dy
        Sides of the cell, all lengths in one unit.
    poisson_ratio
        Poisson's ratio of the half-space.
    """
    offsets = (np.asarray(a, dtype=np.float64) for a in (x, y))
    across, along = np.broadcast_arrays(*offsets)
    even_x, even_y = component.parity
    signs = sign(across, even_x) * sign(along, even_y)
    u, v = np.abs(across), np.abs(along)
    distance = np.sqrt(u * u + v * v + z * z) / max(dx, dy)
    result = np.empty(u.shape)
    near = distance < CORNER_DISTANCE
    result[near] = _corners(component.corner, u[near], v[near], z, dx, dy, poisson_ratio)
    ends = (*(start for start, _ in GAUSS_ZONES[1:]), np.inf)
    for (start, points), end in zip(GAUSS_ZONES, ends, strict=True):
        zone = (distance >= start) & (distance < end)
        result[zone] = _points(component.point, u[zone], v[zone], z, dx, dy, poisson_ratio, points)
    return np.asarray(signs * result / (2 * np.pi))


def sign(offset: Array, parity: int) -> Array | float:
    """Return the sign of a field with this `parity` on the side of `offset`."""
    return np.sign(offset) if parity < 0 else 1.0


def _corners(field: KernelFunction, x: Array, y: Array, z: float, dx: float, dy: float, poisson_ratio: float) -> Array:
    """Return the integral of a field over a cell, as the difference of its `corner` field at the four corners."""
    total = np.zeros(x.shape)
    for side in (1, -1):
        for end in (1, -1):
            u, v = x + side * dx / 2, y + end * dy / 2
            total += side * end * field(u, v, z, np.sqrt(u * u + v * v + z * z), poisson_ratio)
    return total


def _points(field: KernelFunction, x: Array, y: Array, z: float, dx: float, dy: float, nu: float, points: int) -> Array:
    """Return the integral of a field over a cell, by Gauss `points` along either side."""
    total = np.zeros(x.shape)
    if not x.size:
        return total
    for node, across in mean_gauss_rule(points):
        u = x + node * dx / 2
        for node_along, along in mean_gauss_rule(points):
            v = y + node_along * dy / 2
            total += across * along * field(u, v, z, np.sqrt(u * u + v * v + z * z), nu)
    return dx * dy * total


def strip(x: Array, z: float, dx: float) -> Strip:
    """Return a strip of width `dx` whose middle is `x` away, at depth `z`."""
    # by the product of both distances, where their difference would cancel
    product = (x - dx / 2) * (x + dx / 2) - z * z + 2j * z * x
    angle = np.arctan2(z * dx, np.real(product) + 2 * z * z)
    edge_terms = np.asarray(-z * dx / product, dtype=np.complex128)
    return Strip(angle, edge_terms, x, z, dx)
