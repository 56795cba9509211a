"""A problem in its own scales, by hand."""

from dataclasses import replace

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.problem.problem import Scales
from tests.conftest import LineContact


def test_a_bare_problem_counts_heights_and_pressures_in_its_scales(
    line_contact: LineContact,
) -> None:
    problem = line_contact.scene.problem(line_contact.grid((8, 2), 1.0), cs.ExactPeriodicity())
    scales = Scales(length=1.0, pressure=4e8, gap=2e-6)
    raised = replace(problem, undeformed_gap=problem.undeformed_gap + 7.0, scales=scales)
    assert raised.datum == pytest.approx(problem.undeformed_gap.min() + 7.0)
    bare = raised.bare()
    heights = (problem.undeformed_gap - problem.undeformed_gap.min()) / 2e-6
    # heights of a millionth beside seven metres
    np.testing.assert_allclose(bare.undeformed_gap, heights, atol=1e-9)
    pressure = np.random.default_rng(0).random((8, 2))
    moved = problem.operator(4e8 * pressure) / 2e-6
    np.testing.assert_allclose(bare.operator(pressure), moved, rtol=1e-9)
    assert bare.resultant.uniform(16) == pytest.approx(problem.resultant.uniform(16) / 4e8)
    assert raised.bare(cs.Precision.SINGLE).undeformed_gap.dtype == np.float32


def test_a_hardness_is_counted_in_the_scale_of_pressure(line_contact: LineContact) -> None:
    scene = replace(line_contact.scene, hardness=1e9)
    problem = scene.problem(line_contact.grid((8, 2), 1.0), cs.ExactPeriodicity())
    bare = replace(problem, scales=Scales(1.0, 4e8, 2e-6)).bare()
    assert bare.constraint == cs.HardnessLimited(2.5)
