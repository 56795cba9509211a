from dataclasses import replace
from math import inf, nan

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.accuracy.estimate import error_estimate
from tests.accuracy.__main__ import METRICS, Judged, judged, summary
from tests.accuracy.case import errors
from tests.accuracy.matrix import matrix
from tests.accuracy.random_scenes import RANDOM, random_case

NAME = "smooth cylinder 0"


def test_errors_stand_beside_their_bounds_and_one_that_is_not_known_does_not_count() -> None:
    found = {row.metric: row for row in judged(NAME)}
    assert tuple(found) == METRICS
    solution = cs.solve(matrix()[NAME].problem())
    true = errors(solution, matrix()[NAME].truth())
    for metric in ("l1", "peak_pressure", "contact_area"):
        assert found[metric].error == getattr(true, metric) > 0
        assert found[metric].bound == getattr(solution.error, metric).total
    assert {row.use for row in found.values()} == {"calibration"}
    # a closed form says nothing of the mean gap
    assert np.isnan(found["mean_gap"].error)
    assert summary([found["mean_gap"]]).startswith("  nan")


def test_a_summary_counts_bounds_that_hold_their_median_and_what_is_missing() -> None:
    pairs = ((0.01, 0.02), (0.01, 0.04), (0.02, 0.01), (0.03, inf), (nan, 1.0))
    rows = [Judged("a", "random", "l1", error, bound, has_reason=True) for error, bound in pairs]
    assert summary(rows) == " 66.7 % hold,     2 times the error,   1 missing"


def test_a_contact_that_is_cut_off_says_so() -> None:
    solution = cs.solve(matrix()[NAME].problem())
    touching = int(solution.pressure.any(axis=1).argmax())
    cut = replace(solution, problem=replace(solution.problem, open_edges=(touching,)))
    estimate = error_estimate(cut)
    assert estimate.l1.total == inf
    assert estimate.warnings


def test_a_seed_chooses_other_random_contacts() -> None:
    first, again, other = (random_case("random waves 0", seed).scene for seed in (1, 1, 2))
    assert first == again != other


@pytest.mark.cases(len(RANDOM))
@pytest.mark.parametrize("kind", RANDOM)
def test_every_random_contact_has_a_problem(kind: str) -> None:
    for seed in range(3):
        case = random_case(f"{kind} 0", seed)
        assert np.isfinite(case.problem().undeformed_gap).all()
        dx, dy = case.grid.cell_size
        for shape in case.scene.shapes:
            if isinstance(shape, cs.Roughness):
                assert dy == pytest.approx(dx, rel=0.05)
            if isinstance(shape, cs.Waviness) and shape.along < np.inf:
                waves = case.grid.length / shape.along
                assert waves == pytest.approx(max(round(waves), 1))
