"""The tangent of a contact beside the dense operator and beside another contact."""

from dataclasses import replace

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.solvers.plasticity.contact_tangent import ContactTangent
from tests.conftest import LineContact


@pytest.fixture
def solution(line_contact: LineContact) -> cs.Solution:
    problem = line_contact.scene.problem(line_contact.grid((24, 2), 0.3), cs.ExactPeriodicity())
    return cs.solve(problem, tolerance=1e-12)


def test_it_is_the_inverse_of_the_dense_operator_under_a_fixed_load(solution: cs.Solution) -> None:
    """``K^-1 - K^-1 1 1^T K^-1 / (1^T K^-1 1)`` on the cells that bear, to a hundredth in its own norm."""
    problem = solution.problem
    bears = (solution.pressure > 0).ravel()
    columns = []
    for one in np.eye(bears.size)[bears]:
        columns.append(problem.operator(one.reshape(24, 2)).ravel()[bears])
    inverse = np.linalg.inv(np.transpose(columns))
    ones = np.ones(bears.sum())
    dense = inverse - np.outer(inverse @ ones, ones @ inverse) / (ones @ inverse @ ones)
    gap = 1e-8 * np.random.default_rng(0).standard_normal((24, 2))
    found = ContactTangent.of(solution, cs.Precision.DOUBLE)(gap)
    wanted = dense @ gap.ravel()[bears]
    assert not found.ravel()[~bears].any()
    assert found.sum() == pytest.approx(0, abs=1e-9 * np.abs(found).sum())
    # the residual falls to a hundredth in the norm of the preconditioner, which is near that of the operator
    assert np.linalg.norm(found.ravel()[bears] - wanted) < 0.05 * np.linalg.norm(wanted)


def test_a_gap_that_opens_takes_pressure_away(solution: cs.Solution) -> None:
    """Beside the contact over a little more gap, whose cells are the same."""
    x = solution.problem.grid.x
    opened = 1e-11 * np.cos(np.pi * x / x[-1] / 2)[:, None] * np.ones((24, 2))
    problem = solution.problem
    other = replace(problem, undeformed_gap=problem.undeformed_gap + opened)
    change = cs.solve(other, tolerance=1e-13).pressure - solution.pressure
    found = ContactTangent.of(solution, cs.Precision.DOUBLE)(opened)
    assert np.linalg.norm(change + found) < 0.05 * np.linalg.norm(found)


def test_one_cell_cannot_change(solution: cs.Solution) -> None:
    alone = replace(solution, pressure=np.eye(24, 2) * np.eye(1, 2))
    assert (alone.pressure > 0).sum() == 1
    assert not ContactTangent.of(alone, cs.Precision.DOUBLE)(np.ones((24, 2))).any()
