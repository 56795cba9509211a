"""Displacement and stress by a uniform tangential traction on a rectangular cell of a half-space.

The same kind of :class:`~contactstudy.elasticity.kernels.stress_cell.CellKernel` as the stress under pressure, so
that rows and lattices of cells are summed by the same functions. x runs across, y along, z into the body.
"""

import numpy as np

from contactstudy.domain.fields import Array
from contactstudy.elasticity.kernels.stress_cell import COMPONENTS, CellKernel, KernelFunction, Strip


def _swapped(field: KernelFunction) -> KernelFunction:
    """Return `field` with x and y exchanged."""
    return lambda x, y, z, r, nu: field(y, x, z, r, nu)


def _asinh(y: Array, x: Array, z: float) -> Array:
    """Return the integral of 1/r along y."""
    return np.asarray(np.arcsinh(y / np.sqrt(x * x + z * z)))


def _harmonic_point(x: Array, y: Array, z: float, r: Array) -> Array:
    """Return ``-(d/dx)(d/dy)^2 (z ln(r + z) - r)``."""
    s = r + z
    return np.asarray((-1 + y * y / (r * r) + 2 * y * y / (r * s)) * x / (r * s * s))


def _xx_point(x: Array, y: Array, z: float, r: Array, nu: float) -> Array:
    """Return 2 pi times the stress xx under a unit force along x at the origin."""
    s = r + z
    third = (-3 + x * x / (r * r) + 2 * x * x / (r * s)) * x / (r * s * s)
    return np.asarray((1 - 2 * nu) * (x / r**3 + third) - 3 * x**3 / r**5)


def _xx_corner(x: Array, y: Array, z: float, r: Array, nu: float) -> Array:
    """Return the integral over x and y of 2 pi times the stress xx under a unit force along x."""
    compliant = x * x * y / ((x * x + z * z) * r) + 2 * _asinh(y, x, z)
    return np.asarray(compliant - (1 - 2 * nu) * y / (r + z))


def _yy_point(x: Array, y: Array, z: float, r: Array, nu: float) -> Array:
    """Return 2 pi times the stress yy under a unit force along x at the origin."""
    lateral = x / r**3 + _harmonic_point(x, y, z, r)
    return np.asarray((1 - 2 * nu) * lateral - 3 * x * y * y / r**5)


def _yy_corner(x: Array, y: Array, z: float, r: Array, nu: float) -> Array:
    """Return the integral over x and y of 2 pi times the stress yy under a unit force along x."""
    line = _asinh(y, x, z)
    return np.asarray(line - y / r - (1 - 2 * nu) * (line - y / (r + z)))


def _xy_point(x: Array, y: Array, z: float, r: Array, nu: float) -> Array:
    """Return 2 pi times the stress xy under a unit force along x at the origin."""
    lateral = _harmonic_point(y, x, z, r)
    return np.asarray((1 - 2 * nu) * lateral - 3 * x * x * y / r**5)


def _xy_corner(x: Array, y: Array, z: float, r: Array, nu: float) -> Array:
    """Return the integral over x and y of 2 pi times the stress xy under a unit force along x."""
    return np.asarray(_asinh(x, y, z) - x / r + (1 - 2 * nu) * x / (r + z))


def _zero(strip: Strip, nu: float) -> float:
    """Return zero: the stress that is not there in plane strain."""
    return 0.0


_NORMAL = COMPONENTS


def _incompressible(name: str) -> tuple[KernelFunction, KernelFunction]:
    """Return point and corner of a normal stress for a Poisson's ratio of a half: traction makes them at any ratio."""
    kernel = _NORMAL[name]
    return (lambda x, y, z, r, nu: kernel.point(x, y, z, r, 0.5), lambda x, y, z, r, nu: kernel.corner(x, y, z, r, 0.5))


# Stress under unit traction along x, and along y. Source: Cerruti, by way of Johnson (1985), eqs. 3.76, sect. 2.5(b)
CERRUTI_ACROSS: dict[str, CellKernel] = {}
CERRUTI_ALONG: dict[str, CellKernel] = {}
for _name, _parity, _point, _corner, _plane, _other in (
    ("xx", (-1, 1), _xx_point, _xx_corner, lambda s, nu: s.edge_terms.imag - 2 * s.logarithm, _zero),
    ("yy", (-1, 1), _yy_point, _yy_corner, lambda s, nu: -2 * nu * s.logarithm, _zero),
    ("zz", (-1, 1), _NORMAL["xz"].point, _NORMAL["xz"].corner, _NORMAL["xz"].plane, _zero),
    ("yz", (-1, -1), *_incompressible("xy"), _zero, _zero),
    # by traction along the strip: antiplane
    ("xz", (1, 1), *_incompressible("xx"), _NORMAL["xx"].plane, lambda s, nu: -s.angle),
    ("xy", (1, -1), _xy_point, _xy_corner, _zero, lambda s, nu: -s.logarithm),
):
    _swapped_name = _NORMAL[_name].swapped
    CERRUTI_ACROSS[_name] = CellKernel(
        f"{_name} by shear across", _parity, _point, _corner, _plane, _swapped_name, CERRUTI_ALONG
    )
    CERRUTI_ALONG[_swapped_name] = CellKernel(
        f"{_swapped_name} by shear along",
        (_parity[1], _parity[0]),
        _swapped(_point),
        _swapped(_corner),
        _other,
        _name,
        CERRUTI_ACROSS,
    )


def _half_log(x: Array, y: Array, z: float, r: Array, nu: float) -> Array:
    """Return the integral of ``x / r^2`` over x and y, up to terms whose differences over corners vanish."""
    return np.asarray(y * np.log(r) + np.abs(x) * np.arctan2(y, np.abs(x)))


def _moment(x: Array, y: Array, z: float, r: Array, nu: float) -> Array:
    """Return the integral of ``x^2 / r^3`` over x and y."""
    return np.asarray(y * np.arcsinh(x / np.where(y == 0, 1.0, np.abs(y))))


# 2 pi times these are integrals over the cell of fields on the surface, z = 0: x / r^2 and y / r^2, the normal
# displacement under traction (Johnson 1985, eq. 3.75c), x^2 / r^3 and x y / r^3, what Poisson's ratio adds to the
# displacement along the surface (eqs. 3.75a, b). y^2 / r^3 is 1 / r less x^2 / r^3.
SURFACE: dict[str, CellKernel] = {}
# Names of the fields with the axes exchanged.
SWAPPED = {"xx": "yy", "yy": "xx", "xy": "xy", "x": "y", "y": "x"}
for _name, _parity, _point, _corner, _plane in (
    ("x", (-1, 1), lambda x, y, z, r, nu: x / (r * r), _half_log, lambda s, nu: np.pi / 2 * s.sides),
    ("y", (1, -1), lambda x, y, z, r, nu: y / (r * r), _swapped(_half_log), _zero),
    ("xx", (1, 1), lambda x, y, z, r, nu: x * x / r**3, _moment, lambda s, nu: s.mean_width),
    ("xy", (-1, -1), lambda x, y, z, r, nu: x * y / r**3, lambda x, y, z, r, nu: -r, _zero),
):
    SURFACE[_name] = CellKernel(f"{_name} on the surface", _parity, _point, _corner, _plane, SWAPPED[_name], SURFACE)
