from dataclasses import replace

import numpy as np
import pytest

import contactstudy as cs
from studies.definitions.hard_cases import grid
from studies.reference.line_contact import P_H, SCENE
from tests.hard_cases.cases import CASES
from tests.hard_cases.hard_case import EXACT
from tests.hard_cases.judged import ends_well


@pytest.mark.parametrize("solver", [cs.PreconditionedCG(), cs.PolonskyKeer()], ids=str)
def test_a_hardness_binds_from_the_elastic_peak_down(solver: cs.Solver) -> None:
    posed = SCENE.problem(grid(), EXACT)
    peak = cs.solve(posed, tolerance=1e-12, solver=solver).pressure.max()
    for fraction, yields in ((1 + 1e-6, False), (1 - 1e-6, True)):
        hard = replace(SCENE, hardness=fraction * peak)
        solution = cs.solve(hard.problem(grid(), EXACT), tolerance=1e-12, solver=solver)
        assert solution.status is cs.Status.CONVERGED
        assert (solution.pressure == fraction * peak).any() == yields
        # what the cap takes off stands beside it: no more than a cell's fraction moves
        assert np.abs(solution.pressure.max() / peak - 1) < 2e-6


def test_a_hardness_that_just_carries_the_load_bears_evenly() -> None:
    on = grid(width=4.8)
    least = SCENE.load.per_length / on.extent[0]
    hard = replace(SCENE, hardness=least * (1 + 1e-12))
    for solver in (cs.PreconditionedCG(), cs.PolonskyKeer()):
        solution = cs.solve(hard.problem(on, EXACT), solver=solver)
        assert solution.status is cs.Status.CONTACT_AT_EDGE
        np.testing.assert_allclose(solution.pressure, least, rtol=1e-9)
    sentence = str(ends_well("hardness below the mean pressure", "exact", "Polonsky-Keer").status)
    assert "larger hardness" in sentence
    assert CASES["hardness below the mean pressure"].scene.hardness < least < 0.33 * P_H
