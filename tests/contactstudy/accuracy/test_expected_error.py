"""The error expected before a solve, against the error of the solve."""

import numpy as np

import contactstudy as cs
from contactstudy.accuracy.expected_error import smooth_l1
from tests.conftest import LineContact


def test_wherever_the_edge_falls_the_error_is_below_the_expected(line_contact: LineContact) -> None:
    worst, hertz = 0.0, line_contact.hertz
    for cells in (33, 56, 80, 96, 131):
        for width in np.linspace(2.23, 2.59, 12):
            grid = line_contact.grid((cells, 1), 1.0, width)
            solution = cs.solve(line_contact.scene.problem(grid, cs.ExactPeriodicity()))
            true = hertz.pressure(grid.x)[:, None]
            error = np.abs(solution.pressure - true).sum() / solution.pressure.sum()
            worst = max(worst, float(error) / smooth_l1(grid.cell[0] / hertz.half_width))
    # a bound, and no larger than the edge at its worst place calls for
    assert 0.5 < worst <= 1
