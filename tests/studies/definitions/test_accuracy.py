from dataclasses import replace

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.accuracy.estimate import error_estimate
from studies.definitions.accuracy import KINDS, USES, case_at, use_of
from studies.reference.accuracy.case import errors
from studies.reference.accuracy.matrix import matrix
from studies.reference.accuracy.random_scenes import RANDOM
from studies.registry import load

NAME = "smooth cylinder 0"


def test_errors_stand_beside_their_bounds_and_one_that_is_not_known_is_left_out() -> None:
    case = case_at({"case": NAME, "seed": 1})
    solution = case.run(case.prepare())
    found = {name: float(one) for name, one in load("accuracy").measures(case, solution).items()}
    true, estimate = errors(solution, matrix()[NAME].truth()), error_estimate(solution)
    for metric in ("l1", "peak_pressure", "contact_area"):
        assert found[f"{metric}_error"] == getattr(true, metric) > 0
        assert found[f"{metric}_bound"] == getattr(estimate, metric).total
    # a closed form says nothing of the mean gap
    assert "mean_gap_error" not in found
    assert found["mean_gap_bound"] > 0
    assert found["missing_without_reason"] == 0
    assert found["kind"] == KINDS.index("smooth cylinder") == 0
    assert found["use"] == USES.index("calibration")
    uses = [use_of(name) for name in ("rollers 3", "rollers 4", "random rollers 3")]
    assert uses == ["validation", "calibration", "random"]


def test_a_bound_that_is_missing_without_a_reason_is_counted() -> None:
    case = case_at({"case": NAME, "seed": 1})
    solution = case.run(case.prepare())
    touching = int(solution.pressure.any(axis=1).argmax())
    cut = replace(solution, problem=replace(solution.problem, open_edges=(touching,)))
    found = load("accuracy").measures(case, cut)
    # it says that the contact is cut off
    assert float(found["l1_bound"]) == float("inf")
    assert float(found["missing_without_reason"]) == 0


def test_a_seed_chooses_other_random_contacts_and_the_same_matrix() -> None:
    first, other = (case_at({"case": "random waves 0", "seed": seed}).case for seed in (1, 2))
    assert first.scene != other.scene
    assert case_at({"case": "random waves 0", "seed": 1}).case.scene == first.scene
    # which is solved once
    assert case_at({"case": NAME, "seed": 1}) == case_at({"case": NAME, "seed": 2})


@pytest.mark.cases(len(RANDOM))
@pytest.mark.parametrize("kind", RANDOM)
def test_every_random_contact_has_a_problem(kind: str) -> None:
    for seed in range(3):
        run = case_at({"case": f"{kind} 0", "seed": seed})
        assert np.isfinite(run.prepare().undeformed_gap).all()
        dx, dy = run.case.grid.cell_size
        for shape in run.case.scene.shapes:
            if isinstance(shape, cs.Roughness):
                assert dy == pytest.approx(dx, rel=0.05)
            if isinstance(shape, cs.Waviness) and shape.along < np.inf:
                waves = run.case.grid.length / shape.along
                assert waves == pytest.approx(max(round(waves), 1))
