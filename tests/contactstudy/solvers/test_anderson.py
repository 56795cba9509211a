from dataclasses import replace

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.problem.constraint import PrescribedApproach
from contactstudy.solvers.fixed_point import solve_with_mixing
from tests.conftest import LineContact


@pytest.fixture
def problem(line_contact: LineContact) -> cs.Problem:
    return line_contact.scene.problem(line_contact.grid((24, 1), 1.0), cs.ExactPeriodicity())


def test_mixing_ends_where_the_lagged_displacement_is_that_of_its_own_pressure(
    problem: cs.Problem,
) -> None:
    """A gap that tilts by a fraction of the pressure of the mirrored cells."""

    def lagged(pressure: np.ndarray) -> np.ndarray:
        tilt = np.linspace(-1, 1, 24)[:, None]
        return 0.02 * problem.operator(pressure) * tilt

    found = solve_with_mixing(problem, lagged, cs.SolveOptions(1e-10), change=1e-8)
    pressure = found.solution.pressure
    again = cs.solve(replace(problem, undeformed_gap=problem.undeformed_gap + lagged(pressure)), tolerance=1e-10)
    np.testing.assert_allclose(again.pressure, pressure, atol=1e-6 * pressure.max())
    assert found.solution.status is cs.Status.CONVERGED
    assert found.change <= 1e-8
    assert 2 < found.outer_iterations < 12
    assert found.iterations > found.solution.iterations
    assert found.convolutions > found.solution.convolutions
    few = solve_with_mixing(problem, lagged, cs.SolveOptions(1e-10), change=1e-8, max_outer=2)
    assert (few.outer_iterations, few.solution.status) == (2, cs.Status.NOT_CONVERGED)
    assert few.solution.residual >= few.change > 1e-8


def test_mixing_of_bodies_that_do_not_touch_ends_at_once(problem: cs.Problem) -> None:
    apart = replace(problem, control=PrescribedApproach(float(problem.undeformed_gap.min()) - 1))
    found = solve_with_mixing(apart, problem.operator)
    assert (found.outer_iterations, found.change) == (1, 0.0)
    assert not found.solution.pressure.any()
