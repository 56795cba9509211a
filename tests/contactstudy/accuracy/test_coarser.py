"""How a solution differs from that on cells of twice the size, by hand."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.accuracy.coarser import change, coarser_problem
from tests.conftest import LineContact


def test_heights_added_to_a_problem_are_averaged_over_the_larger_cells(
    line_contact: LineContact,
) -> None:
    problem = line_contact.scene.problem(line_contact.grid((16, 8), 1.2), cs.ExactPeriodicity())
    added = np.random.default_rng(0).normal(scale=1e-7, size=(16, 8))
    rough = replace(problem, undeformed_gap=problem.undeformed_gap + added)
    smooth, coarse = coarser_problem(problem), coarser_problem(rough)
    assert smooth is not None
    assert coarse is not None
    means = added.reshape(8, 2, 4, 2).mean(axis=(1, 3))
    assert coarse.undeformed_gap - smooth.undeformed_gap == pytest.approx(means, rel=1e-6)


def test_a_change_is_of_the_load_the_peak_the_area_and_the_gap() -> None:
    fine = SimpleNamespace(
        pressure=np.array([[4.0], [2.0], [2.0], [0.0]]),
        mean_gap=2.0,
    )
    coarse = SimpleNamespace(pressure=np.array([[3.0], [0.0]]), mean_gap=3.0)
    seen = change(fine, coarse)  # type: ignore[arg-type]
    # means of 3 and 1 for 3 and 0, of a load of 4; a peak of 4 for 3
    assert seen.l1 == pytest.approx(1 / 4)
    assert seen.peak_pressure == pytest.approx(1 / 3)
    # half in contact for three quarters, a gap of 3 for 2 in the mean
    assert seen.contact_area == pytest.approx(1 / 3)
    assert seen.mean_gap == pytest.approx(1 / 2)
