"""Local stage of the preconditioner of a film: the coefficients of a cell and its neighbours, with little elasticity.

Lines in turn along the shorter sides of the cells, or sparse LU factors where cells touch.
"""

from collections.abc import Callable
from functools import cache
from importlib import import_module

import numpy as np
from scipy.linalg.lapack import dgbtrf, dgbtrs
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import splu

from contactstudy.domain.fields import Array
from contactstudy.lubrication.film_equation import Linearised, Mask, neighbour

# Elasticity in the local stage: the coefficient of a change of pressure has the first times that of thickness, and on
# the diagonal the second times the width of a cell. These, of lines ALONG the length and of others, and the PASSES over
# every second line, were chosen by counts of iterations on 50 rough, crowned and mixed films of 64 x 16 to 864 x 128
# cells, M = 20 and 100, L = 0 to 10.
ELASTICITY, ELASTICITY_ALONG, PASSES = (0.05, 0.1), (0.03, 0.03), 3

# Function that solves for a right-hand side (x, y), approximately.
LocalStage = Callable[[Array], Array]


def local_stage(linear: Linearised, cavitated: Mask, touching: Mask) -> LocalStage:
    """Return the stage for unknown pressures, and void fractions of cavitated cells.

    It is Gauss-Seidel by lines, across the contact, or along its length where cells are shorter along than across, if
    numba is installed: by the others it took twice as long with ratios of two to six. Factors of 800 x 128 cells cost
    as much as 35 iterations, and solve in six times the time of the lines. Where cells touch, lubricant flows around
    them: lines took up to a hundred times the iterations there.

    Raises ``RuntimeError`` for a singular system.
    """
    dx, dy = linear.equation.cell
    sweep = None if touching.any() or dy >= dx else compiled_sweep()
    elasticity = ELASTICITY if sweep is None else ELASTICITY_ALONG

    def coefficient(across: int, along: int) -> Array:
        return _coefficient(linear, cavitated, touching, (across, along), elasticity)

    if sweep is None:
        stage = _by_factors if touching.any() else _by_lines
        return stage(coefficient, cavitated.shape)
    offsets = (0, 0), (0, -1), (0, 1), (-1, 0), (-2, 0)
    coefficients = [coefficient(*offset) for offset in offsets]
    return lambda right: sweep(*coefficients, right)


def _by_lines(coefficient: Callable[[int, int], Array], shape: tuple[int, ...]) -> LocalStage:
    """Return the stage by lines across, with the factors of every second line as those of one banded matrix."""
    rows, columns = shape
    downstream, diagonal, upstream, second, previous, following = (
        np.ascontiguousarray(coefficient(*offset).T) for offset in ((1, 0), (0, 0), (-1, 0), (-2, 0), (0, -1), (0, 1))
    )
    halves = []
    for start in (0, 1):
        lines = np.arange(start, columns, 2)
        bands = np.zeros((6, len(lines) * rows))  # two rows are for the factors
        # the first two cells of a line and the last are fixed, so that lines do not act on each other
        bands[2, 1:] = downstream[lines].ravel()[:-1]
        bands[3] = diagonal[lines].ravel()
        bands[4, :-1] = upstream[lines].ravel()[1:]
        bands[5, :-2] = second[lines].ravel()[2:]
        factors, pivots, failed = dgbtrf(bands, 2, 1, overwrite_ab=True)
        if failed:
            raise RuntimeError("singular")
        halves.append((lines, factors, pivots, previous[lines], following[lines]))

    def solve(right: Array) -> Array:
        given = np.ascontiguousarray(right.T)
        solution = np.zeros_like(given)
        for number in range(PASSES):
            lines, factors, pivots, before, behind = halves[number % 2]
            left = given[lines]
            if number:
                left -= before * solution[lines - 1]
                left -= behind * solution[(lines + 1) % columns]
            solved = dgbtrs(factors, 2, 1, left.ravel(), pivots, overwrite_b=True)[0]
            solution[lines] = solved.reshape(left.shape)
        return solution.T

    return solve


def _by_factors(coefficient: Callable[[int, int], Array], shape: tuple[int, ...]) -> LocalStage:
    """Return the stage by sparse LU factors."""
    index = np.arange(np.prod(shape)).reshape(shape)
    rows, columns, values = [], [], []
    for offset in ((0, 0), (0, -1), (0, 1), (1, 0), (-1, 0), (-2, 0)):
        inside = neighbour(np.ones(shape, dtype=bool), offset)
        rows.append(index[inside])
        columns.append(neighbour(index, offset)[inside])
        values.append(coefficient(*offset)[inside])
    indices = np.concatenate(rows), np.concatenate(columns)
    factors = splu(csc_matrix((np.concatenate(values), indices), shape=(index.size, index.size)))
    return lambda right: np.asarray(factors.solve(right.ravel()).reshape(shape))


def _coefficient(
    linear: Linearised,
    cavitated: Mask,
    touching: Mask,
    offset: tuple[int, int],
    elasticity: tuple[float, float],
) -> Array:
    """Return the coefficient (x, y) of the neighbour at ``offset``, of its void fraction where it is cavitated.

    That of a pressure has a part of the `elasticity`. Cells without an unknown have a row of the identity.
    """
    fixed = linear.equation.fixed
    zero = np.zeros(fixed.shape)
    film_can_change = neighbour(~touching, offset)
    pressure = linear.pressure.get(offset, zero)
    pressure = pressure + elasticity[0] * film_can_change * linear.thickness.get(offset, zero)
    if offset == (0, 0):
        pressure = pressure + elasticity[1] * linear.equation.cell[0] * film_can_change
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
