import numpy as np
import pytest

import contactstudy as cs
from contactstudy.edge import half_widths
from tests.conftest import LineContact


@pytest.mark.parametrize("cells", [64, 101])
def test_edge_of_hertz_pressure_is_found_to_rounding(cells: int) -> None:
    """p^2 of Hertz's pressure is a parabola, which the fit holds exactly."""
    x = cs.Grid(cells=(cells, 1), extent=(2.4, 1.0)).x
    pressure = np.sqrt(np.clip(1 - (x - 0.05) ** 2, 0, None))
    np.testing.assert_allclose(half_widths(np.stack([pressure, 3 * pressure], 1), x), 1, rtol=1e-12)


def test_edge_of_a_solved_contact_lies_within_a_tenth_of_a_cell(line_contact: LineContact) -> None:
    a = line_contact.hertz.half_width
    for cells in (48, 64, 100, 128, 200, 256):
        grid = line_contact.grid((cells, 1), 2.4)
        solution = cs.solve(line_contact.scene.problem(grid, cs.ExactPeriodicity()))
        (half,) = half_widths(solution.pressure, grid.x)
        assert abs(half - a) < 0.1 * grid.cell[0]


def test_few_cells_count_by_their_faces() -> None:
    x = cs.Grid(cells=(8, 1), extent=(8.0, 1.0)).x
    pressure = np.zeros((8, 2))
    pressure[3:5, 0] = 1.0
    np.testing.assert_array_equal(half_widths(pressure, x), [1.0, 0.0])
