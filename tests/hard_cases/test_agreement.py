"""One discrete answer by both solvers, in one and two dimensions."""

from dataclasses import replace

import numpy as np
import pytest

import contactstudy as cs
from studies.definitions.hard_cases import SOLVERS, grid
from studies.reference.line_contact import SCENE
from tests.hard_cases.cases import EXACT, FREE


@pytest.mark.parametrize("solver", SOLVERS)
def test_exact_routes_agree(solver: str) -> None:
    """Plane strain, three dimensions at several periods, and doubly periodic at a growing width."""

    def middle(along: int, period: float, width: float, across: cs.Padding) -> np.ndarray:
        on = grid((round(32 * width / 2.4), along), width, period)
        scene = replace(SCENE, shapes=(cs.Cylinder(0.01),))
        posed = scene.problem(on, (across, EXACT))
        solution = cs.solve(posed, tolerance=1e-12, solver=SOLVERS[solver])
        assert solution.residual <= 1e-12
        first = (on.cells[0] - 32) // 2
        return np.asarray(solution.pressure[first : first + 32] / posed.scales.pressure)

    plane = middle(1, 1.0, 2.4, FREE)
    for along, period in ((1, 1e3), (4, 0.1), (5, 2.4), (4, 30.0)):
        there = middle(along, period, 2.4, FREE)
        np.testing.assert_allclose(there, np.broadcast_to(plane, there.shape), rtol=0, atol=1e-8)
    # neighbours at W change the curvature by the factor 1 + pi^2 a^2 / (6 W^2), and so the peak by half of that
    for width in (9.6, 24.0):
        change = middle(1, 1.0, width, EXACT)[15:17].mean() / plane[15:17].mean() - 1
        assert abs(change) == pytest.approx(np.pi**2 / (12 * width**2), rel=0.1)
