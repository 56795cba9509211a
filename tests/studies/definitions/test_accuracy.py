"""What the study of estimates stores of a small contact with a known truth."""

from dataclasses import replace

import contactstudy as cs
from studies.definitions.accuracy import KINDS, scene_at
from studies.reference.accuracy.case import errors
from studies.reference.accuracy.matrix import matrix
from studies.registry import load

NAME = "smooth cylinder 0"


def test_errors_stand_beside_their_bounds_and_a_truth_that_is_not_known_is_below_zero() -> None:
    case = scene_at({"case": NAME})
    solution = case.run(case.prepare())
    found = {name: float(one) for name, one in load("accuracy").measures(case, solution).items()}
    true, estimate = errors(solution, matrix()[NAME].truth()), cs.error_estimate(solution)
    for metric in ("l1", "peak_pressure", "contact_area"):
        assert found[f"{metric}_error"] == getattr(true, metric) > 0
        assert found[f"{metric}_bound"] == getattr(estimate, metric).total
    # a closed form says nothing of the mean gap; the drawing takes what is below zero for not known
    assert found["mean_gap_error"] == -1.0
    assert found["mean_gap_bound"] > 0
    assert found["silent"] == 0
    assert found["kind"] == KINDS.index("smooth cylinder") == 0


def test_a_bound_that_is_missing_without_a_reason_is_counted() -> None:
    case = scene_at({"case": NAME})
    solution = case.run(case.prepare())
    cut = replace(solution, status=cs.Status.CONTACT_AT_EDGE)
    found = load("accuracy").measures(case, cut)
    # it says that the contact is cut off
    assert float(found["l1_bound"]) == float("inf")
    assert float(found["silent"]) == 0
