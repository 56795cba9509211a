"""Reference solution of the discrete problem by a dense matrix, with active sets found by pivoting.

It is built pair by pair without transforms, windows of a convolution or an iteration, and solved directly. It has the
influence coefficients of a cell in common with the program.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

import contactstudy as cs
from contactstudy.domain.grid import Array
from contactstudy.elasticity.kernels.displacement import (
    boussinesq_cell,
    boussinesq_cell_doubly_periodic,
    boussinesq_cell_periodic,
)

# Of influence coefficients and of one transform pair, over the largest displacement.
ROUNDING = 1e-13
PIVOTS = 100


@dataclass(frozen=True, eq=False)
class DenseAnswer:
    """Reference solution of a contact: dimensionless pressure (x, y), approach, and relative L1 error by rounding.

    The smallest eigenvalue is that of the operator on the free cells of this solution and of the one compared with it,
    for pressures without a load. The error of a pressure is at most the error of the gap over this, in the mean
    square.
    """

    pressure: Array
    approach: float
    smallest_eigenvalue: float
    error: float


def answer(scene: cs.Scene, grid: cs.Grid, paddings: cs.Paddings, solution: cs.Solution) -> DenseAnswer:
    """Return the pressure that meets all conditions of contact to rounding, by pivoting from `solution`.

    Source: Hintermüller, Ito & Kunisch (2003), Algorithm 2.1, for two limits.

    Raises
    ------
    ArithmeticError
        If pivoting does not end.
    """
    scales = scene.scales(grid)
    factor = scales.pressure / (np.pi * scene.contact_modulus * scales.gap)
    matrix = factor * influence_matrix(grid, paddings, scales.length)
    gap = (solution.problem.undeformed_gap.ravel() - solution.problem.reference_height) / scales.gap
    total = scene.mean_load(grid, paddings) * grid.length / grid.cell_area / scales.pressure
    limit = scene.hardness / scales.pressure
    before = solution.pressure.ravel() / scales.pressure
    diagonal = matrix[0, 0] - matrix.mean()  # a rigid shift may make the first negative
    yielding = before >= limit
    free = (before > 0) & ~yielding
    initially_free = free.copy()
    for _ in range(PIVOTS):
        pressure = np.where(yielding, limit, 0.0)
        displacement = matrix @ pressure if yielding.any() else np.zeros_like(gap)
        free_load = total - pressure.sum()
        needed = -(gap + displacement)[free]
        pressure[free], approach = _solve_active_set(matrix, free, needed, free_load)
        deformed_gap = gap + matrix @ pressure
        if not free.any():
            approach = float(deformed_gap[yielding].max())
        deformed_gap -= approach
        deformed_gap[free] = 0.0
        predicted = pressure - deformed_gap / diagonal
        new_sets = predicted >= limit, (predicted > 0) & (predicted < limit)
        if (new_sets[0] == yielding).all() and (new_sets[1] == free).all():
            sizes = gap[pressure > 0].max(), (np.abs(matrix) @ pressure).max()
            smallest = _smallest_eigenvalue(matrix, free | initially_free)
            field = pressure.reshape(solution.pressure.shape)
            # L1 of a pressure is at most the root of the number of cells times L2, and so is the L2 of equal gaps
            by_gap = ROUNDING * sum(sizes) * np.count_nonzero(pressure) / smallest / total
            return DenseAnswer(field, approach, smallest, float(by_gap + ROUNDING))
        yielding, free = new_sets
    raise ArithmeticError(f"pivoting did not end after {PIVOTS} active sets")


def _solve_active_set(matrix: Array, free: np.ndarray, displacement: Array, load: float) -> tuple[Array, float]:
    """Return pressure and approach for the displacement of the free cells under a load."""
    count = int(free.sum())
    if not count:
        return np.zeros(0), 0.0
    system = np.ones((count + 1, count + 1))
    system[:-1, :-1] = matrix[np.ix_(free, free)]
    system[:-1, -1], system[-1, -1] = -1.0, 0.0
    unknowns = np.linalg.solve(system, np.append(displacement, load))
    return unknowns[:-1], float(unknowns[-1])


def _smallest_eigenvalue(matrix: Array, free: np.ndarray) -> float:
    """Return the smallest eigenvalue of the matrix on the free cells, for pressures without a load."""
    count = int(free.sum())
    # a single cell cannot move: its coefficient bounds the rounding of the load equation
    if count < 2:
        return float(matrix[0, 0] - matrix.mean())
    part = matrix[np.ix_(free, free)]
    part = part - part.mean(axis=0)
    part -= part.mean(axis=1)[:, None]
    # the mean is shifted to an eigenvalue beyond all others
    return float(np.linalg.eigvalsh(part + np.abs(part).sum() / count)[0])


@lru_cache(maxsize=64)
def influence_matrix(grid: cs.Grid, paddings: cs.Paddings, datum: float) -> Array:
    """Return the influence coefficients [m] of every cell on every other, pair by pair, all images summed."""
    (nx, ny), (dx, dy) = grid.cells, grid.cell_size
    x, y = np.arange(1 - nx, nx) * dx, np.arange(1 - ny, ny) * dy
    offsets = _coefficients(x[:, None], y[None, :], grid, paddings, datum)
    i, j = np.divmod(np.arange(nx * ny), ny)
    return np.asarray(offsets[i[:, None] - i + nx - 1, j[:, None] - j + ny - 1])


def _coefficients(x: Array, y: Array, grid: cs.Grid, paddings: cs.Paddings, datum: float) -> Array:
    """Return the influence coefficients [m] at all offsets between cells, with all images summed."""
    (dx, dy), (width, period) = grid.cell_size, grid.extent
    across, along = paddings
    if across.window is None and along.window is None:
        return boussinesq_cell_doubly_periodic(x, y, dx, dy, width, period)
    assert across.window is not None
    if along.window is None:
        shift = 2 * dx * dy / period * np.log(datum)
        return _images(lambda a: shift + boussinesq_cell_periodic(a, y, dx, dy, period), across, x, width)
    return _images(lambda a: _images(lambda b: boussinesq_cell(a, b, dx, dy), along, y, period), across, x, width)


def _images(at: Callable[[Array], Array], padding: cs.Padding, d: Array, period: float) -> Array:
    """Return the sum of `at` over the images of a window; offsets of a window that wraps are even about its middle."""
    assert padding.window is not None
    if padding.wraps:
        d = np.minimum(np.abs(d), period - np.abs(d))
    return np.asarray(sum(at(d + m * period) for m in padding.window))
