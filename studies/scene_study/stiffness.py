"""How much load more brings the bodies nearer."""

import numpy as np

import contactstudy as cs
from contactstudy.domain.fields import Array, inner

# The error of the stiffness is the square of the relative error of the iteration.
RESIDUAL = 3e-2
MOST = 60


def normal_stiffness(solution: cs.Solution) -> float:
    """d load / d approach [N/m per m of length] of the contact as it stands: its cells stay the same.

    The increment of the pressure that carries a unit of load and moves all cells in contact alike, found
    by projected conjugate gradients (Hestenes & Stiefel 1952), which do not see the rigid shift of the
    operator. Cells that yield carry no more. nan where no cell can.
    """
    problem = solution.problem
    free = problem.constraint.free(solution.pressure) > 0
    count = int(free.sum())
    if not count:
        return float("nan")
    cells = free.astype(np.float64)
    operator = problem.operator
    precondition = operator.approximate_inverse()

    def moved(pressure: Array) -> Array:
        return np.asarray(np.where(free, operator(pressure), 0.0))

    def level(field: Array) -> Array:
        return np.asarray(np.where(free, field - field[free].sum() / count, 0.0))

    pressure = np.where(free, 1 / count, 0.0)
    displacement = moved(pressure)
    residual = -level(displacement)
    first = np.abs(displacement - displacement.sum() / count)[free].mean()
    direction: Array | None = None
    size = 0.0
    for _ in range(MOST):
        if count < 2 or np.abs(residual).sum() / count <= RESIDUAL * first:
            break
        closing = level(precondition(residual, cells))
        before, size = size, inner(residual, closing)
        direction = closing if direction is None else closing + direction * (size / before)
        response = moved(direction)
        length = size / inner(direction, response)
        pressure += length * direction
        displacement += length * response
        residual = -level(displacement)
    # the energy of a unit of load [m per unit of summed pressure]
    compliance = inner(pressure, displacement)
    grid = problem.grid
    return float(grid.cell_area / grid.period / compliance)
