"""Stress below a rectangular cell under uniform pressure or traction on a half-space: alone, in a row, in a lattice.

Coefficients are stress over pressure or traction, for one component at a time, tension positive. x runs across, y
along, z into the body. The surface under pressure is free of tangential traction. A :class:`CellKernel` has the
formulas of one component, a family of them those of all components by one load: ``FAMILIES``.
:class:`StressCoefficients` sums a kernel over the cell and its images. The fields of ``SURFACE``, displacement along
the surface and along the normal by traction, are kernels too.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from typing import ClassVar

import numpy as np
from numpy.polynomial.chebyshev import chebpts1, chebvander
from numpy.typing import ArrayLike, NDArray

from contactstudy.domain.grid import Array
from contactstudy.elasticity.kernels.displacement import column_and_row, mean_gauss_rule

# Distance from a cell, in units of its longer side, up to which its field is the difference of the values of a
# primitive at the four corners. By cancellation this has an error of up to the square of the distance times the aspect
# ratio of the cell, in units of rounding.
CORNER_DISTANCE = 4.0
# First distance and number of Gauss points of each zone beyond. From 4, 9, 20, 80 and 1000 sides on the field of a
# point is analytic in a Bernstein ellipse of rho >= 16, 36, 80, 320 or 4000 about the cell, so that so many points
# leave 1e-13.
GAUSS_ZONES = ((CORNER_DISTANCE, 7), (9.0, 5), (20.0, 4), (80.0, 3), (1000.0, 2))

# Field (...) at offsets x and y (...) and a depth z, from the distance r (...) from the origin and Poisson's ratio nu.
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
        A primitive of `point` over x and y, of the same arguments: over a cell their integral is its difference over
        the corners.
    plane
        pi times the field in plane strain under unit load on a :class:`Strip`, from the strip and Poisson's ratio.
    swapped
        Key in `family` of the field with the axes exchanged.
    family
        Kernels by key, among them that of the field with the axes exchanged; None for ``BOUSSINESQ``.
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
        return (BOUSSINESQ if self.family is None else self.family)[self.swapped]

    def exchanged(self, name: str, plane: "Callable[[Strip, float], Array | float]") -> "CellKernel":
        """Return the kernel of the field `name`: this one with the axes exchanged, and with `plane` in plane strain."""
        even_x, even_y = self.parity
        point, corner = _swapped(self.point), _swapped(self.corner)
        return CellKernel(name, (even_y, even_x), point, corner, plane, self.name, self.family)


@dataclass(frozen=True, eq=False)
class Strip:
    """Loaded strip, infinite along y, as seen from a point (Johnson 1985, sect. 2.5(a)).

    Parameters
    ----------
    angle
        Angle that the strip subtends at the point.
    edge_terms
        Terms ``z / (a + i z) - z / (b + i z)`` of the edges, where a = middle + width / 2 and b = middle - width / 2
        are the offsets of the point from them.
    middle
        Offset of the point from the middle of the strip.
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
        """``ln |a + i z| - ln |b + i z|``; with a period W, ``ln |2 sin(pi (a + i z) / W)|`` less the same of b."""
        x, z, dx, period = self.middle, self.depth, self.width, self.period
        if period is None:
            return np.asarray(np.log1p(2 * x * dx / ((x - dx / 2) ** 2 + z * z)) / 2)
        # |2 sin(u + i v)|^2 = 4 (sin(u)^2 + sinh(v)^2); at depth both edges are lost in rounding alike
        deep = np.sinh(min(np.pi * z / period, 300.0)) ** 2
        ends = (np.sin(np.pi * (x + side * dx / 2) / period) ** 2 + deep for side in (1, -1))
        return np.asarray(np.log(np.divide(*ends)) / 2)

    @property
    def sides(self) -> Array:
        """``|a| - |b|``, the integral of the offset's sign; with a period, the integral of a sawtooth of zero mean."""
        ends, period = [self.middle + side * self.width / 2 for side in (1, -1)], self.period
        if period is None:
            return np.asarray(np.abs(ends[0]) - np.abs(ends[1]))
        from_middle = [end - period * np.round(end / period) for end in ends]
        tops = [np.abs(end) - end**2 / period for end in from_middle]
        return np.asarray(tops[0] - tops[1])


def _angle(x: Array, y: Array, z: float, r: Array) -> Array:
    """Return the primitive of ``-z / r^3`` over x and y: minus the solid angle of a quadrant."""
    return np.asarray(-np.arctan2(x * y, z * r))


def _second_derivative_inverse(x: Array, y: Array, z: float, r: Array) -> Array:
    """Return the primitive of ``-z (d/dx)^2 (1/r)`` over x and y; ``-3 z x^2 / r^5`` is this field less ``z / r^3``."""
    return np.asarray(z * x * y / ((x * x + z * z) * r))


def second_derivative_log(x: Array, y: Array, z: float, r: Array) -> Array:
    """Return the primitive of ``(d/dx)^2 ln(r + z)`` over x and y, its two arctangents as one that does not cancel."""
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
    """Return the primitive over x and y of 2 pi times the stress xx under a unit force."""
    lateral = (1 - 2 * nu) * second_derivative_log(x, y, z, r)
    return np.asarray(2 * nu * _angle(x, y, z, r) + _second_derivative_inverse(x, y, z, r) - lateral)


def _xy_point(x: Array, y: Array, z: float, r: Array, nu: float) -> Array:
    """Return 2 pi times the stress xy under a unit force at the origin."""
    s = r * r
    lateral = (1 - 2 * nu) * (2 * r + z) / (r + z) ** 2
    return np.asarray(x * y / (s * r) * (lateral - 3 * z / s))


def _xz_corner(x: Array, y: Array, z: float, r: Array, _: float) -> Array:
    """Return the primitive over x and y of 2 pi times the stress xz under a unit force."""
    return np.asarray(z * z * y / ((x * x + z * z) * r))


def _swapped(field: KernelFunction) -> KernelFunction:
    """Return `field` with x and y exchanged."""
    return lambda x, y, z, r, nu: field(y, x, z, r, nu)


def _zero(strip: Strip, nu: float) -> float:
    """Return zero, for a stress that vanishes in plane strain."""
    return 0.0


_XX = CellKernel("xx", (1, 1), _xx_point, _xx_corner, lambda strip, nu: strip.edge_terms.real - strip.angle, "yy")
_XZ = CellKernel(
    "xz", (-1, 1),
    lambda x, y, z, r, nu: -3 * z * z * x / ((r * r) * (r * r) * r),
    _xz_corner, lambda strip, nu: -strip.edge_terms.imag, "yz",
)  # fmt: skip
# Stress under unit pressure, by component. The stresses of a point load are those of Johnson (1985), eqs. 3.18, written
# with ``x^2 + y^2 = (r - z) (r + z)`` so that nothing cancels on the axis; those of a cell are Love's (1929, eqs.
# 3.25).
BOUSSINESQ = {
    component.name: component
    for component in (
        _XX,
        _XX.exchanged("yy", lambda strip, nu: -2 * nu * strip.angle),
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
        _XZ.exchanged("yz", _zero),
        _XZ,
        CellKernel(
            "xy", (-1, -1), _xy_point, lambda x, y, z, r, nu: -z / r - (1 - 2 * nu) * np.log(r + z), _zero, "xy",
        ),
    )
}  # fmt: skip
# Names of the components of stress, in the order of arrays.
COMPONENTS = tuple(BOUSSINESQ)


def sign(offset: Array, parity: int) -> Array | float:
    """Return the sign of a field with this `parity` on the side of `offset`."""
    return np.sign(offset) if parity < 0 else 1.0


def _corners(field: KernelFunction, x: Array, y: Array, z: float, dx: float, dy: float, poisson_ratio: float) -> Array:
    """Return the integral of a field over a cell, as the difference of its primitive `field` over the four corners.

    `x` and `y` (n,) are offsets from the centre of the cell, `z` the depth, `dx` and `dy` the sides.
    """
    total = np.zeros(x.shape)
    for side in (1, -1):
        for end in (1, -1):
            u, v = x + side * dx / 2, y + end * dy / 2
            total += side * end * field(u, v, z, np.sqrt(u * u + v * v + z * z), poisson_ratio)
    return total


def _points(field: KernelFunction, x: Array, y: Array, z: float, dx: float, dy: float, nu: float, points: int) -> Array:
    """Return the integral of the `field` of a point over a cell, by so many Gauss `points` along either side.

    The other arguments are those of :func:`_corners`.
    """
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
    """Return a strip of width `dx` as seen from points at the offsets `x` (n,) from its middle and at the depth `z`."""
    # by the product of both distances, where their difference would cancel
    product = (x - dx / 2) * (x + dx / 2) - z * z + 2j * z * x
    angle = np.arctan2(z * dx, np.real(product) + 2 * z * z)
    edge_terms = np.asarray(-z * dx / product, dtype=np.complex128)
    return Strip(angle, edge_terms, x, z, dx)


# Distance from the axis, in periods, beyond which the stress of a row does not vary along it: exp(-2 pi 6) ~ 1e-17.
PLANE_STRAIN_PERIODS = 6.0
# Number of nodes of the rule that sums the images at more than twice the distance from the axis: each node gains a
# factor of rho^2 = 8^2 in error, ten 1e-18.
TAIL_POINTS = 10
# Numbers of Chebyshev points across and along from which these images are interpolated. Their sum is analytic in
# Bernstein ellipses of rho >= 6 and 13: 6^-22 and 13^-14 are below 1e-15.
INTERPOLATED = 22, 14
# Number of Chebyshev points along either axis from which the rows of a lattice beyond the nearest three are
# interpolated: with rho >= 9, 9^-18 ~ 7e-18 is left.
LATTICE_INTERPOLATED = 18
# Number of images that the rule for the tail is made from. The integral over those beyond is exact to
# 1 / (12 TAIL_IMAGES^3) ~ 1e-14.
TAIL_IMAGES = 20_000


def plane_strain(component: CellKernel, loaded_strip: Strip, poisson_ratio: float) -> Array:
    """Return a component of stress (n,) under unit load on a strip, in plane strain."""
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
    """Return positions (TAIL_POINTS,) and weights for sums over m >= `start` of m^-2 times a polynomial of 1/m."""
    end = start + TAIL_IMAGES
    m = np.arange(start, end, dtype=np.float64)
    # from there on the sum is an integral
    nodes, tail_weights = np.array(mean_gauss_rule(TAIL_POINTS)).T
    remainder = 1 / (end - 0.5)
    t = np.append(1 / m, (1 + nodes) / 2 * remainder)
    weights = np.append(m**-2, tail_weights * remainder)
    # Golub & Welsch: the product with t, in an orthonormal basis of the polynomials over this sum
    root = np.sqrt(weights)
    basis = np.linalg.qr(root[:, None] * chebvander(2 * start * t - 1, TAIL_POINTS - 1)).Q
    nodes, vectors = np.linalg.eigh(basis.T @ (t[:, None] * basis))
    # Gauss's weights are those of m^2 f(m)
    return 1 / nodes, (vectors.T @ (basis.T @ root) / nodes) ** 2


def _strips(x: Array, z: float, dx: float, period: float) -> Strip:
    """Return strips of width `dx` repeated with `period`, as :func:`strip` returns one.

    In the fields of one strip, 1/x becomes (pi/W) cot(pi x/W) with the period W (Johnson 1985, sect. 13.2).
    """
    # beyond this the harmonics have long underflowed, and cosh would not hold them
    depth = min(2 * np.pi * z / period, 100.0)
    twice, cell = 2 * np.pi * x / period, np.pi * dx / period
    edges = 2 * np.sin((twice + cell) / 2) * np.sin((twice - cell) / 2)
    fading = 2 * np.sinh(depth / 2) ** 2 * np.cos(twice)
    # cosh(depth) (cos(cell) - cos(twice)) + ..., by products where the difference would cancel
    angle = np.arctan2(np.sin(cell) * np.sinh(depth), edges * np.cosh(depth) + fading)
    denominator = edges - fading + 1j * np.sin(twice) * np.sinh(depth)
    return Strip(angle, -2 * np.pi * z / period * np.sin(cell) / denominator, x, z, dx, period)


def _inverse_distance_along(y: Array, x: Array, z: float) -> Array:
    """Return the primitive of 1/r over y."""
    return np.asarray(np.arcsinh(y / np.sqrt(x * x + z * z)))


def _harmonic_point(x: Array, y: Array, z: float, r: Array) -> Array:
    """Return ``-(d/dx)(d/dy)^2 (z ln(r + z) - r)``."""
    s = r + z
    return np.asarray((-1 + y * y / (r * r) + 2 * y * y / (r * s)) * x / (r * s * s))


def _traction_xx_point(x: Array, y: Array, z: float, r: Array, nu: float) -> Array:
    """Return 2 pi times the stress xx under a unit force along x at the origin."""
    s = r + z
    # (d/dx)^3 (r - z ln(r + z))
    third = (-3 + x * x / (r * r) + 2 * x * x / (r * s)) * x / (r * s * s)
    return np.asarray((1 - 2 * nu) * (x / r**3 + third) - 3 * x**3 / r**5)


def _traction_xx_corner(x: Array, y: Array, z: float, r: Array, nu: float) -> Array:
    """Return the primitive over x and y of 2 pi times the stress xx under a unit force along x."""
    incompressible = x * x * y / ((x * x + z * z) * r) + 2 * _inverse_distance_along(y, x, z)
    return np.asarray(incompressible - (1 - 2 * nu) * y / (r + z))


def _traction_yy_point(x: Array, y: Array, z: float, r: Array, nu: float) -> Array:
    """Return 2 pi times the stress yy under a unit force along x at the origin."""
    lateral = x / r**3 + _harmonic_point(x, y, z, r)
    return np.asarray((1 - 2 * nu) * lateral - 3 * x * y * y / r**5)


def _traction_yy_corner(x: Array, y: Array, z: float, r: Array, nu: float) -> Array:
    """Return the primitive over x and y of 2 pi times the stress yy under a unit force along x."""
    line = _inverse_distance_along(y, x, z)
    return np.asarray(line - y / r - (1 - 2 * nu) * (line - y / (r + z)))


def _traction_xy_point(x: Array, y: Array, z: float, r: Array, nu: float) -> Array:
    """Return 2 pi times the stress xy under a unit force along x at the origin."""
    lateral = _harmonic_point(y, x, z, r)
    return np.asarray((1 - 2 * nu) * lateral - 3 * x * x * y / r**5)


def _traction_xy_corner(x: Array, y: Array, z: float, r: Array, nu: float) -> Array:
    """Return the primitive over x and y of 2 pi times the stress xy under a unit force along x."""
    return np.asarray(_inverse_distance_along(x, y, z) - x / r + (1 - 2 * nu) * x / (r + z))


def _incompressible(name: str) -> tuple[KernelFunction, KernelFunction]:
    """Return point and corner of the stress `name` by pressure at a Poisson's ratio of 1/2.

    At this ratio xx and xy by pressure are xz and yz by traction along x, at any ratio.
    """
    kernel = BOUSSINESQ[name]
    return (lambda x, y, z, r, nu: kernel.point(x, y, z, r, 0.5), lambda x, y, z, r, nu: kernel.corner(x, y, z, r, 0.5))


# Stress under unit traction along x, and along y. Each is the family in which kernels of the other are found with the
# axes exchanged. Source: Cerruti, by way of Johnson (1985), eqs. 3.76 for a point load and sect. 2.5(b) for a strip.
CERRUTI_ACROSS: dict[str, CellKernel] = {}
CERRUTI_ALONG: dict[str, CellKernel] = {}
for _name, _parity, _point, _corner, _plane, _plane_along in (
    ("xx", (-1, 1), _traction_xx_point, _traction_xx_corner, lambda s, nu: s.edge_terms.imag - 2 * s.logarithm, _zero),
    ("yy", (-1, 1), _traction_yy_point, _traction_yy_corner, lambda s, nu: -2 * nu * s.logarithm, _zero),
    ("zz", (-1, 1), BOUSSINESQ["xz"].point, BOUSSINESQ["xz"].corner, BOUSSINESQ["xz"].plane, _zero),
    ("yz", (-1, -1), *_incompressible("xy"), _zero, _zero),
    # by traction along the strip: antiplane
    ("xz", (1, 1), *_incompressible("xx"), BOUSSINESQ["xx"].plane, lambda s, nu: -s.angle),
    ("xy", (1, -1), _traction_xy_point, _traction_xy_corner, _zero, lambda s, nu: -s.logarithm),
):
    _swapped_name = BOUSSINESQ[_name].swapped
    _across = CellKernel(f"{_name} by shear across", _parity, _point, _corner, _plane, _swapped_name, CERRUTI_ALONG)
    _along = _across.exchanged(f"{_swapped_name} by shear along", _plane_along)
    CERRUTI_ACROSS[_name] = _across
    CERRUTI_ALONG[_swapped_name] = replace(_along, swapped=_name, family=CERRUTI_ACROSS)


def _half_log(x: Array, y: Array, z: float, r: Array, nu: float) -> Array:
    """Return the primitive of ``x / r^2`` over x and y on the surface, without terms that cancel over corners."""
    return np.asarray(y * np.log(r) + np.abs(x) * np.arctan2(y, np.abs(x)))


def _moment(x: Array, y: Array, z: float, r: Array, nu: float) -> Array:
    """Return the primitive of ``x^2 / r^3`` over x and y on the surface."""
    return np.asarray(y * np.arcsinh(x / np.where(y == 0, 1.0, np.abs(y))))


# Fields on the surface, z = 0, by traction, times 2 pi. "x" and "y" are x / r^2 and y / r^2, the displacement along the
# normal (Johnson 1985, eq. 3.75c); "xx" and "xy" are x^2 / r^3 and x y / r^3, what Poisson's ratio adds to the
# displacement along the surface (eqs. 3.75a, b). There is no "yy": y^2 / r^3 is 1 / r less x^2 / r^3. Repeated strips
# leave out a uniform "xx".
SURFACE: dict[str, CellKernel] = {}
# Name of each field with the axes exchanged.
SWAPPED = {"xx": "yy", "yy": "xx", "xy": "xy", "x": "y", "y": "x"}
for _name, _parity, _point, _corner, _plane in (
    ("x", (-1, 1), lambda x, y, z, r, nu: x / (r * r), _half_log, lambda s, nu: np.pi / 2 * s.sides),
    ("y", (1, -1), lambda x, y, z, r, nu: y / (r * r), _swapped(_half_log), _zero),
    ("xx", (1, 1), lambda x, y, z, r, nu: x * x / r**3, _moment, lambda s, nu: 0.0 if s.period else s.width),
    ("xy", (-1, -1), lambda x, y, z, r, nu: x * y / r**3, lambda x, y, z, r, nu: -r, _zero),
):
    SURFACE[_name] = CellKernel(f"{_name} on the surface", _parity, _point, _corner, _plane, SWAPPED[_name], SURFACE)


# Components of stress by the load on the surface: pressure, shear across (along x), shear along (along y).
FAMILIES: Mapping[str, Mapping[str, CellKernel]] = {
    "pressure": BOUSSINESQ,
    "across": CERRUTI_ACROSS,
    "along": CERRUTI_ALONG,
}


@dataclass(frozen=True)
class StressCoefficients:
    """Influence coefficients of a stress component, or of another field, at one depth: response over the load on a cell.

    They are :class:`~contactstudy.elasticity.convolution.Coefficients`, even or odd in x and y to the last bit. The
    response of one cell has an error of 1e-12 of the largest component at that distance, for ``dx / dy`` from 0.1 to
    10. Beyond, the error grows in proportion to this ratio or its inverse. For a row or a lattice it is 1e-12 of the
    largest component, of one cell or of all together, whichever is larger.

    Parameters
    ----------
    component
        Component, with the load on the surface that causes it.
    depth
        Depth below the surface [m] at least 0; at 0 offsets should not be on the edge of a cell.
    poisson_ratio
        Poisson's ratio of the half-space.
    """

    component: CellKernel
    depth: float
    poisson_ratio: float

    @property
    def parity(self) -> tuple[int, int]:
        """Parity of the component in x and y."""
        return self.component.parity

    def swap_axes(self) -> "StressCoefficients":
        """Return the component that takes this one's place when the axes are exchanged."""
        return replace(self, component=self.component.swap_axes())

    def cell(self, x: ArrayLike, y: ArrayLike, dx: float, dy: float) -> Array:
        """Return the response to one cell; x and y broadcast.

        Near the cell it is the difference of the component's `corner` at the four corners, beyond `CORNER_DISTANCE` an
        integral by Gauss points.
        """
        z = self.depth
        offsets = (np.asarray(a, dtype=np.float64) for a in (x, y))
        across, along = np.broadcast_arrays(*offsets)
        even_x, even_y = self.component.parity
        signs = sign(across, even_x) * sign(along, even_y)
        u, v = np.abs(across), np.abs(along)
        distance = np.sqrt(u * u + v * v + z * z) / max(dx, dy)
        result = np.empty(u.shape)
        near = distance < CORNER_DISTANCE
        result[near] = _corners(self.component.corner, u[near], v[near], z, dx, dy, self.poisson_ratio)
        ends = (*(start for start, _ in GAUSS_ZONES[1:]), np.inf)
        for (start, points), end in zip(GAUSS_ZONES, ends, strict=True):
            zone = (distance >= start) & (distance < end)
            result[zone] = _points(self.component.point, u[zone], v[zone], z, dx, dy, self.poisson_ratio, points)
        return np.asarray(signs * result / (2 * np.pi))

    def row(self, x: ArrayLike, y: ArrayLike, dx: float, dy: float, period: float) -> Array:
        """Return the response (x, y) to an infinite row of images along y, at every x with every y.

        The nearest images are summed one by one. The others are 1/m^2 times a smooth function of 1/m, and summed by
        Gauss's rule for such sums (Monien 2010, Math. Comp. 79), whose nodes are positions between the images. Far from
        the axis, the row is a strip in plane strain.
        """
        (x, y), z = column_and_row(x, y), self.depth
        y = y - period * np.round(y / period)
        outer, inner = (np.maximum(np.abs(x.ravel()) + side * dx / 2, 0) for side in (1, -1))
        far = (np.hypot(inner, z) >= PLANE_STRAIN_PERIODS * period) | (dy == period)
        result = np.empty(np.broadcast_shapes(x.shape, y.shape))
        if far.any():
            plane = plane_strain(self.component, strip(x[far], z, dx), self.poisson_ratio)
            result[far] = plane * (dy / period)
        # in powers of two, each of which takes a rule for its tail
        reach = np.exp2(np.ceil(np.log2(np.maximum(np.hypot(outer, z) / period, 1)))).astype(int)
        for periods in np.unique(reach[~far]).tolist():
            rows = ~far & (reach == periods)
            near = sorted(range(1 - 2 * periods, 2 * periods), key=abs, reverse=True)

            def far_images(u: Array, v: Array, periods: int = periods) -> Array:
                """Return the sum over images that are at least 2 `periods` away, at a column `u` and a row `v`."""
                positions, weights = _tail(2 * periods)
                images = np.outer(positions, (1, -1)).reshape(-1, 1, 1) * period + v
                stress = self.cell(u, images, dx, dy)
                return np.asarray(np.einsum("i,ixy->xy", np.repeat(weights, 2), stress))

            # small terms add up before they meet the large ones
            ends = periods * period, period / 2
            total = _smooth(far_images, x[rows], y, ends, INTERPOLATED, self.parity)
            for m in near:
                total += self.cell(x[rows], y + m * period, dx, dy)
            result[rows] = total
        return result

    def lattice(self, x: ArrayLike, y: ArrayLike, dx: float, dy: float, width: float, period: float) -> Array:
        """Return the response (x, y) to an infinite lattice of images along both axes, at every x with every y.

        The displacement is periodic along both axes: the mean strain along the surface is zero, and so the mean of xx
        and yy is ``-nu / (1 - nu)`` of the mean pressure. Without this condition the sum would depend on its order.
        Each row less its strip vanishes within a few periods; all strips together have a closed form.
        """
        (x, y), nu = column_and_row(x, y), self.poisson_ratio
        if period > width:  # the harmonics of the shorter period vanish sooner
            return self.swap_axes().lattice(y.T, x.T, dy, dx, period, width).T
        x = x - width * np.round(x / width)
        y = y - period * np.round(y / period)

        def rows(u: Array, v: Array, numbers: list[int]) -> Array:
            """Return the sum of rows by their `numbers` across, each less its strip, at columns `u` and a row `v`."""
            images = np.add.outer(np.array(numbers) * width, u.ravel())
            each = images.ravel()
            stress = self.row(each, v, dx, dy, period)
            plane = plane_strain(self.component, strip(each, self.depth, dx), self.poisson_ratio)
            stress -= plane[:, None] * (dy / period)
            return np.asarray(stress.reshape(*images.shape, -1).sum(axis=0))

        # smooth from the second row on
        last = int(np.ceil(PLANE_STRAIN_PERIODS * period / width)) + 1
        far = [side * m for m in range(last, 1, -1) for side in (1, -1)]
        points = LATTICE_INTERPOLATED, LATTICE_INTERPOLATED
        total = _smooth(lambda u, v: rows(u, v, far), x, y, (width / 2, period / 2), points, self.parity)
        total += rows(x, y, [1, -1, 0])
        strips = plane_strain(self.component, _strips(x, self.depth, dx, width), nu)
        # deep strips have means of xx and yy of -1 and -2 nu; only kernels by pressure have these names and such means
        confined = (1 - 2 * nu) / (1 - nu) * dx / width
        confinement = {"xx": confined, "yy": nu * confined}.get(self.component.name, 0.0)
        return np.asarray(total + (strips + confinement) * (dy / period))


@dataclass(frozen=True)
class HalfSpaceStress:
    """Stress in a homogeneous half-space of this `poisson_ratio`; it has no interface."""

    poisson_ratio: float
    interface_depths: ClassVar[tuple[float, ...]] = ()

    def coefficients(self, traction: str, component: str, depth: float) -> tuple[tuple[StressCoefficients, float], ...]:
        """Return the coefficients of a `component`, such as "xz", by a `traction`, a key of ``FAMILIES``: weight 1."""
        return ((StressCoefficients(FAMILIES[traction][component], depth, self.poisson_ratio), 1.0),)
