from dataclasses import replace

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.solvers import coulomb
from contactstudy.solvers.solve import solve_with_mixing
from tests.conftest import LineContact

UNLIKE = cs.Scene(
    cs.LineLoad(1e5),
    (cs.HalfSpace(210e9, 0.3), cs.HalfSpace(70e9, 0.33)),
    (cs.Cylinder(0.01),),
    friction=cs.Sliding(0.5),
)


def test_outer_iterations_over_the_shear_of_dissimilar_bodies_end_in_equilibrium() -> None:
    """The gap in the contact is that of the pressure and of its own shear."""
    posed = UNLIKE.problem(cs.Grid((96, 1), (4e-4, 1e-3)), cs.ExactPeriodicity())
    solution = cs.solve(posed, tolerance=1e-9)
    assert solution.status is cs.Status.CONVERGED
    displacement = posed.operator(solution.pressure) + 0.5 * posed.friction.coupling(solution.pressure)
    gap = posed.undeformed_gap + displacement
    touching = solution.pressure > 0
    assert np.ptp(gap[touching]) <= 1e-8 * posed.scales.gap
    assert gap[~touching].min() > gap[touching].mean()
    assert "outer iterations over the coupled displacement" in solution.note


@pytest.mark.parametrize("width", [4e-4, 1e-4], ids=["whole contact", "cut off at the edge"])
def test_outer_iterations_that_do_not_converge_have_a_status(monkeypatch: pytest.MonkeyPatch, width: float) -> None:
    monkeypatch.setattr(coulomb, "MAX_SLIDING_ITERATIONS", 2)
    posed = UNLIKE.problem(cs.Grid((96, 1), (width, 1e-3)), cs.ZeroPadding())
    solution = cs.solve(posed, tolerance=1e-9)
    assert solution.status is cs.Status.NOT_CONVERGED
    assert solution.residual > 1e-9


def test_mixing_ends_where_the_lagged_displacement_is_that_of_its_own_pressure(line_contact: LineContact) -> None:
    """A gap that tilts by a fraction of the displacement."""
    problem = line_contact.scene.problem(line_contact.grid((24, 1), 1.0), cs.ExactPeriodicity())
    options = cs.SolveOptions(1e-9)

    def lagged(pressure: np.ndarray) -> np.ndarray:
        return 0.02 * problem.operator(pressure) * np.linspace(-1, 1, 24)[:, None]

    mixed = solve_with_mixing(problem, lagged, options)
    pressure = mixed.solution.pressure
    again = cs.solve(replace(problem, undeformed_gap=problem.undeformed_gap + lagged(pressure)), tolerance=1e-10)
    np.testing.assert_allclose(again.pressure, pressure, atol=1e-6 * pressure.max())
    assert mixed.solution.status is cs.Status.CONVERGED
    assert 2 < mixed.outer_iterations < 12
    few = solve_with_mixing(problem, lagged, options, max_outer=2)
    assert few.solution.status is cs.Status.NOT_CONVERGED
    assert few.solution.residual > 1e-9
    assert few.change > mixed.change
