import numpy as np
import pytest

import contactstudy as cs
from contactstudy.analytic import image_error
from studies.reference.hard_case import P_H, A, grid
from studies.reference.line_contact import HERTZ, SCENE


def peak(padding: cs.Padding, period: float) -> float:
    """The pressure beside the axis over Hertz's."""
    posed = SCENE.problem(grid((24, 2), period=period), padding)
    solution = cs.solve(posed, tolerance=1e-11)
    assert solution.status is cs.Status.CONVERGED
    return float(solution.pressure[11:13].mean() / P_H)


@pytest.mark.parametrize(
    ("padding", "period"),
    [
        (cs.Superposition(1), 10.0), (cs.CircularSuperposition(1), 10.0), (cs.Superposition(100), 0.05),
        (cs.CircularSuperposition(100), 0.05),
        (cs.CircularSuperposition(10_000), 1e-3),
    ],
    ids=str,
)  # fmt: skip
def test_any_number_of_images_leaves_what_is_beyond(padding: cs.Padding, period: float) -> None:
    law = image_error(1.0, padding.reach(period))
    found = peak(padding, period) - peak(cs.ExactPeriodicity(), period)
    # leading term; the next is of the order of its square
    assert found == pytest.approx(float(law), rel=0.1)


@pytest.mark.parametrize("aspect", [1e-3, 1e3])
def test_cells_of_any_shape_give_hertz(aspect: float) -> None:
    cells = (48, 8)
    on = grid(cells, 2.4, 2.4 / 48 * 8 * aspect)
    solution = cs.solve(SCENE.problem(on, cs.ExactPeriodicity()))
    error = np.abs(solution.pressure - HERTZ.pressure(on.x)[:, None])[np.abs(on.x) < 0.8 * A].max()
    # of second order in the cell, away from the edge
    assert error < 5 * (on.cell_size[0] / A) ** 2 * P_H
