import numpy as np

import contactstudy as cs
from contactstudy.accuracy.bounded_solution import cell_errors
from tests.conftest import LineContact


def test_the_law_of_the_cells_holds_in_the_mean_over_places_of_the_edge(
    line_contact: LineContact,
) -> None:
    a = line_contact.hertz.half_width
    found, expected = [], []
    for width in np.linspace(2.4, 2.47, 20):
        grid = cs.Grid((60, 1), (width * a, width * a))
        solution = cs.solve(line_contact.scene.problem(grid, cs.ExactPeriodicity()))
        border = np.clip(np.linspace(-width / 2, width / 2, 61), -1, 1)
        carried = (border * np.sqrt(1 - border**2) + np.arcsin(border)) / 2
        means = np.diff(carried) / (width / 60) * line_contact.hertz.peak_pressure
        found.append(np.abs(solution.pressure[:, 0] - means).sum() / means.sum())
        expected.append(sum(cell_errors(solution)))
    # second differences beside the edges have their error too
    assert np.mean(expected) / 2 < np.mean(found) < np.mean(expected)
