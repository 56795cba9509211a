"""Local stage of the preconditioner of a film: the coefficients of a cell and its neighbours, with little elasticity.

Line Gauss-Seidel downstream, or sparse LU factors where cells touch or are long, or where numba is not installed.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from importlib import import_module

import numpy as np
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import SuperLU, splu

from contactstudy.domain.fields import Array
from contactstudy.lubrication.film_equation import Linearised, Mask, neighbour


@dataclass(frozen=True)
class LocalTuning:
    """Tuning constants of the local stage, chosen by counts of iterations on rough films of 64^2 to 256^2 cells.

    Attributes
    ----------
    elastic_fraction, width_fraction
        Elasticity in the line stage: the coefficient of a change of pressure has ``elastic_fraction`` times that of
        thickness, and on the diagonal ``width_fraction`` times the width of a cell.
    elastic_fraction_long, width_fraction_long, long_cell
        The same in the LU stage, and the ratio of length to width of a cell from which it replaces the line stage: lines
        along the length do not couple such cells.
    """

    elastic_fraction: float = 0.03
    width_fraction: float = 0.03
    elastic_fraction_long: float = 0.05
    width_fraction_long: float = 0.1
    long_cell: float = 2.0


TUNING = LocalTuning()


@dataclass(frozen=True, eq=False)
class LineStage:
    """Line Gauss-Seidel by a compiled ``sweep``.

    ``coefficients`` (x, y) are those of the cell, its neighbours along, and the two cells upstream.
    """

    sweep: Callable[..., Array]
    coefficients: tuple[Array, ...]

    @classmethod
    def of(
        cls, sweep: Callable[..., Array], linear: Linearised, cavitated: Mask, touching: Mask
    ) -> "LineStage":
        """Return the stage for unknown pressures, and void fractions of cavitated cells."""
        offsets = (0, 0), (0, -1), (0, 1), (-1, 0), (-2, 0)
        masks, fractions = (cavitated, touching), (TUNING.elastic_fraction, TUNING.width_fraction)
        coefficients = (_coefficient(linear, *masks, offset, *fractions) for offset in offsets)
        return cls(sweep, tuple(coefficients))

    def solve(self, right: Array) -> Array:
        """Return the solution of one downstream sweep of line Gauss-Seidel."""
        return self.sweep(*self.coefficients, right)


@dataclass(frozen=True, eq=False)
class LUStage:
    """Sparse LU factors of the coefficients of cells and their neighbours.

    ``diagonal`` (x, y) are the coefficients of the cells themselves in the factors. The solution is times ``scale``
    (x, y), by which the factors serve for later coefficients too.
    """

    factors: SuperLU
    diagonal: Array
    scale: Array | float = 1.0

    @classmethod
    def of(cls, linear: Linearised, cavitated: Mask, touching: Mask) -> "LUStage":
        """Return the factors for unknown pressures, and void fractions of cavitated cells."""
        index = np.arange(cavitated.size).reshape(cavitated.shape)
        rows, columns, values = [], [], []
        fractions = TUNING.elastic_fraction_long, TUNING.width_fraction_long
        for offset in ((0, 0), (0, -1), (0, 1), (1, 0), (-1, 0), (-2, 0)):
            coefficient = _coefficient(linear, cavitated, touching, offset, *fractions)
            inside = neighbour(np.ones_like(cavitated), offset)
            rows.append(index[inside])
            columns.append(neighbour(index, offset)[inside])
            values.append(coefficient[inside])
        indices = np.concatenate(rows), np.concatenate(columns)
        size = cavitated.size
        factors = splu(csc_matrix((np.concatenate(values), indices), shape=(size, size)))
        return cls(factors, values[0].reshape(cavitated.shape))

    def scaled_to(self, linear: Linearised, cavitated: Mask, touching: Mask) -> "LUStage":
        """Return the same factors, with the solution scaled by the change of the diagonal to these coefficients."""
        fractions = TUNING.elastic_fraction_long, TUNING.width_fraction_long
        diagonal = _coefficient(linear, cavitated, touching, (0, 0), *fractions)
        scale = np.divide(self.diagonal, diagonal, out=np.ones_like(diagonal), where=diagonal != 0)
        return replace(self, scale=scale)

    def solve(self, right: Array) -> Array:
        """Return the solution (x, y)."""
        return np.asarray(self.factors.solve(right.ravel()).reshape(right.shape) * self.scale)


def local_stage(
    linear: Linearised, cavitated: Mask, touching: Mask, last: LUStage | LineStage | None
) -> LineStage | LUStage:
    """Return line Gauss-Seidel, or LU factors where cells touch or are too long for lines to couple them.

    Lubricant in touching cells flows by its pressure alone, also from downstream, which a sweep leaves out. Where none
    touch, the factors of the ``last`` stage serve again: factors of 800 x 128 cells cost as much as 35 iterations. On
    square cells factors take three times as long as the compiled sweep, and two thirds of one by scipy's banded solver.
    """
    dx, dy = linear.equation.cell
    if isinstance(last, LUStage) and not touching.any():
        return last.scaled_to(linear, cavitated, touching)
    if touching.any() or dy > TUNING.long_cell * dx or (sweep := compiled_sweep()) is None:
        return LUStage.of(linear, cavitated, touching)
    return LineStage.of(sweep, linear, cavitated, touching)


def _coefficient(
    linear: Linearised,
    cavitated: Mask,
    touching: Mask,
    offset: tuple[int, int],
    elastic_fraction: float,
    width_fraction: float,
) -> Array:
    """Return the coefficient (x, y) of the neighbour at ``offset``, of its void fraction where it is cavitated.

    That of a pressure has a fraction of the elasticity. Cells without an unknown have a row of the identity.
    """
    fixed = linear.equation.fixed
    zero = np.zeros(fixed.shape)
    film_can_change = neighbour(~touching, offset)
    pressure = linear.pressure.get(offset, zero)
    pressure = pressure + elastic_fraction * film_can_change * linear.thickness.get(offset, zero)
    if offset == (0, 0):
        pressure = pressure + width_fraction * linear.equation.cell[0] * film_can_change
    unknown = np.where(neighbour(cavitated, offset), linear.void.get(offset, zero), pressure)
    return np.where(fixed | neighbour(fixed, offset), offset == (0, 0), unknown)


@cache
def compiled_sweep() -> Callable[..., Array] | None:
    """Return the compiled sweep; None where numba is not installed."""
    try:
        module = import_module("contactstudy.lubrication.newton.compiled_sweep")
    except ModuleNotFoundError:
        return None
    sweep: Callable[..., Array] = module.sweep
    return sweep
