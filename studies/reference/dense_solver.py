"""The discrete answer without transforms or iterations: a dense matrix, and sets of cells by pivoting."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

import contactstudy as cs
from contactstudy.domain.fields import Array
from contactstudy.elasticity.kernels.displacement import (
    boussinesq_cell,
    boussinesq_cell_doubly_periodic,
    boussinesq_cell_periodic,
)
from contactstudy.problem.constraint import violation

# Of influence coefficients and of one transform pair, over the largest displacement.
ROUNDING = 1e-13
PIVOTS = 100


@dataclass(frozen=True, eq=False)
class DenseAnswer:
    """``pressure`` (width, length) and ``approach``, dimensionless; ``softest`` of the operator's waves.

    ``softest`` is the smallest eigenvalue of the operator on the free cells of the answer and of the
    solution it was found beside, for pressures that carry no load: where gaps are wrong, pressures are
    wrong by no more than that over this, in the mean square. ``rounding`` is what it leaves of a gap.
    """

    pressure: Array
    approach: float
    softest: float
    rounding: float


def answer(
    scene: cs.Scene, grid: cs.Grid, paddings: cs.Paddings, solution: cs.Solution
) -> DenseAnswer:
    """Return the pressure that meets all conditions of contact to rounding, pivoting from ``solution``'s sets.

    Raises ``ArithmeticError`` where pivoting comes to no end. Source: Hintermüller, Ito & Kunisch (2003),
    Algorithm 2.1, for two limits.
    """
    scales = scene.scales(grid)
    factor = scales.pressure / (np.pi * scene.contact_modulus * scales.gap)
    matrix = factor * influence_matrix(grid, paddings, scales.length)
    gap = (solution.problem.undeformed_gap.ravel() - solution.problem.datum) / scales.gap
    total = scene.load.largest * grid.period / grid.cell_area / scales.pressure
    most = scene.hardness / scales.pressure
    before = solution.pressure.ravel() / scales.pressure
    diagonal = matrix[0, 0] - matrix.mean()  # a rigid shift may make the first negative
    yielding = before >= most
    free = (before > 0) & ~yielding
    started = free.copy()
    for _ in range(PIVOTS):
        pressure = np.where(yielding, most, 0.0)
        displacement = matrix @ pressure if yielding.any() else np.zeros_like(gap)
        free_load = total - pressure.sum()
        pressure[free], approach = _on(matrix, free, -(gap + displacement)[free], free_load)
        deformed_gap = gap + matrix @ pressure
        if not free.any():
            approach = float(deformed_gap[yielding].max())
        deformed_gap -= approach
        deformed_gap[free] = 0.0
        predicted = pressure - deformed_gap / diagonal
        sets = predicted >= most, (predicted > 0) & (predicted < most)
        if (sets[0] == yielding).all() and (sets[1] == free).all():
            sizes = gap[pressure > 0].max(), (np.abs(matrix) @ pressure).max()
            return DenseAnswer(
                pressure.reshape(solution.pressure.shape),
                approach,
                _softest(matrix, free | started),
                ROUNDING * sum(sizes),
            )
        yielding, free = sets
    raise ArithmeticError(f"no end of pivoting after {PIVOTS} sets of cells")


def _on(matrix: Array, free: np.ndarray, displacement: Array, load: float) -> tuple[Array, float]:
    """Return the pressure on ``free`` cells that gives ``displacement`` plus an approach, under ``load``."""
    count = int(free.sum())
    if not count:
        return np.zeros(0), 0.0
    system = np.ones((count + 1, count + 1))
    system[:-1, :-1] = matrix[np.ix_(free, free)]
    system[:-1, -1], system[-1, -1] = -1.0, 0.0
    unknowns = np.linalg.solve(system, np.append(displacement, load))
    return unknowns[:-1], float(unknowns[-1])


def _softest(matrix: Array, free: np.ndarray) -> float:
    count = int(free.sum())
    if count < 2:  # none moves alone; its own stands for how the load's equation rounds
        return float(matrix[0, 0] - matrix.mean())
    part = matrix[np.ix_(free, free)]
    part = part - part.mean(axis=0)
    part -= part.mean(axis=1)[:, None]
    # the mean itself is out of the way, beyond every other
    return float(np.linalg.eigvalsh(part + np.abs(part).sum() / count)[0])


def stated_error(solution: cs.Solution, found: DenseAnswer) -> float:
    """Return a bound of the pressure's distance from the discrete answer, in the problem's unit of pressure.

    From what the conditions of contact leave open, found again from the pressure, and from rounding, by the
    softest wave; and from the load.
    """
    bare, unit = solution.problem.bare(), solution.problem.scales.pressure
    pressure = solution.pressure / unit
    gap = bare.gap(pressure, bare.operator(pressure))
    free = bare.constraint.free(pressure)
    residual_gap = gap.height * free + violation(pressure, gap.height, free)
    unsure = (
        float(np.linalg.norm(residual_gap)) + found.rounding * np.count_nonzero(pressure) ** 0.5
    )
    unbalanced = bare.resultant.error(float(pressure.sum()))
    return float(unsure / found.softest + pressure.max() * (unbalanced + ROUNDING))


@lru_cache(maxsize=64)
def influence_matrix(grid: cs.Grid, paddings: cs.Paddings, datum: float) -> Array:
    """Return the influence coefficients [m] of every cell on every other, pair by pair, all images summed."""
    (nx, ny), (dx, dy) = grid.cells, grid.cell
    x, y = np.arange(1 - nx, nx) * dx, np.arange(1 - ny, ny) * dy
    offsets = _coefficients(x[:, None], y[None, :], grid, paddings, datum)
    i, j = np.divmod(np.arange(nx * ny), ny)
    return np.asarray(offsets[i[:, None] - i + nx - 1, j[:, None] - j + ny - 1])


def _coefficients(x: Array, y: Array, grid: cs.Grid, paddings: cs.Paddings, datum: float) -> Array:
    (dx, dy), (width, period) = grid.cell, grid.extent
    across, along = paddings
    if across.window is None and along.window is None:
        return boussinesq_cell_doubly_periodic(x, y, dx, dy, width, period)
    assert across.window is not None
    if along.window is None:
        shift = 2 * dx * dy / period * np.log(datum)
        return _images(
            lambda a: shift + boussinesq_cell_periodic(a, y, dx, dy, period), across, x, width
        )
    return _images(
        lambda a: _images(lambda b: boussinesq_cell(a, b, dx, dy), along, y, period),
        across,
        x,
        width,
    )


def _images(at: Callable[[Array], Array], padding: cs.Padding, d: Array, period: float) -> Array:
    """Return the sum over a window; a window that wraps is even about its middle."""
    assert padding.window is not None
    if padding.wraps:
        d = np.minimum(np.abs(d), period - np.abs(d))
    return np.asarray(sum(at(d + m * period) for m in padding.window))
