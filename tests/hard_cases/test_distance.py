import numpy as np
import pytest

import contactstudy as cs
from studies.definitions.hard_cases import grid
from studies.reference.line_contact import HERTZ, P_H, SCENE, A


@pytest.mark.parametrize("aspect", [1e-3, 1e3])
def test_cells_of_any_shape_give_hertz(aspect: float) -> None:
    cells = (48, 8)
    on = grid(cells, 2.4, 2.4 / 48 * 8 * aspect)
    solution = cs.solve(SCENE.problem(on, cs.ExactPeriodicity()))
    error = np.abs(solution.pressure - HERTZ.pressure(on.x)[:, None])[np.abs(on.x) < 0.8 * A].max()
    # of second order in the cell, away from the edge
    assert error < 5 * (on.cell_size[0] / A) ** 2 * P_H
