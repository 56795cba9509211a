"""The accuracy cases are what they say, and bounds hold on every seventh of the matrix."""

from dataclasses import fields
from math import inf, isnan, nan

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.accuracy.estimate import error_estimate
from tests.accuracy.__main__ import Judged, judged, summary
from tests.accuracy.case import AccuracyCase, ClosedForm, Errors, errors
from tests.accuracy.matrix import matrix
from tests.accuracy.random_scenes import RANDOM, random_case

EVERY = 7  # a prime, so that no kind's own order is followed
THINNED = tuple(matrix())[::EVERY]
METRICS = tuple(one.name for one in fields(Errors))


@pytest.fixture(scope="module")
def found() -> list[tuple[cs.ErrorEstimate, Errors]]:
    pairs = []
    for name in THINNED:
        case = matrix()[name]
        solution = cs.solve(case.problem())
        pairs.append((error_estimate(solution), errors(solution, case.truth())))
    return pairs


@pytest.mark.parametrize("metric", METRICS)
def test_bounds_hold_in_nearly_all_cases_and_are_not_far_too_large(
    metric: str, found: list[tuple[cs.ErrorEstimate, Errors]]
) -> None:
    """95 of 100 are promised: of these twenty, one may be missed."""
    pairs = [(getattr(estimate, metric).total, getattr(true, metric)) for estimate, true in found]
    known = [(bound, true) for bound, true in pairs if not isnan(true) and true < inf]
    assert sum(bound < true for bound, true in known) <= 1
    if metric != "mean_gap":  # whose own error is far below what its edges may do
        looseness = [bound / true for bound, true in known if bound < inf and true > 1e-12]
        # edges inside their cells leave an area with an error far below a cell's, which the bound cannot know
        assert np.median(looseness) < (15 if metric == "contact_area" else 5)


def test_no_infinite_pressure_is_given_a_bound_and_every_missing_bound_has_a_reason(
    found: list[tuple[cs.ErrorEstimate, Errors]],
) -> None:
    assert any(true.peak_pressure == inf for _, true in found)
    for estimate, true in found:
        if true.peak_pressure == inf:
            assert estimate.peak_pressure.total == inf
        if inf in {getattr(estimate, metric).discretisation for metric in METRICS[:2]}:
            assert estimate.warnings


CLOSED = [name for name, case in matrix().items() if isinstance(case.find_truth, ClosedForm)]


@pytest.mark.cases(100)
@pytest.mark.parametrize("name", CLOSED)
def test_a_closed_form_carries_its_load_on_its_area_up_to_its_peak_pressure(name: str) -> None:
    """Sampled at points that fall anywhere: the load to the fraction of them at an edge or beside a pole."""
    case: AccuracyCase = matrix()[name]
    truth = case.find_truth
    count = (1008, 1012 if case.grid.cells[1] > 1 else 1)
    places = [(np.arange(n) + 0.5) / n - 0.5 for n in count]
    x, y = (fraction * side for fraction, side in zip(places, case.grid.extent, strict=True))
    pressure = np.broadcast_to(truth.pressure(x[:, None], y), count)
    load = case.scene.largest_load
    # of a pole's load beside an edge the root of a step is lost, and its width over that of the contact
    step = 1 / (count[0] * truth.area)
    sharp = truth.highest == np.inf
    assert pressure.mean() * case.grid.extent[0] == pytest.approx(load, rel=2 * step**0.5 if sharp else 4 * step)
    assert (pressure > 1e-9 * pressure.max()).mean() == pytest.approx(truth.area, rel=4 * step)
    if not sharp:  # a parabola's top, half a step away
        assert pressure.max() == pytest.approx(truth.highest, rel=10 * step)
    assert truth(case).pressure.sum() * case.grid.cell_area / case.grid.length == pytest.approx(load)


def test_errors_stand_beside_their_bounds_and_one_that_is_not_known_does_not_count() -> None:
    name = "smooth cylinder 0"
    found = {row.metric: row for row in judged(name)}
    solution = cs.solve(matrix()[name].problem())
    true = errors(solution, matrix()[name].truth())
    for metric in ("l1", "peak_pressure", "contact_area"):
        assert found[metric].error == getattr(true, metric) > 0
        assert found[metric].bound == getattr(solution.error, metric).total
    # a closed form says nothing of the mean gap
    assert isnan(found["mean_gap"].error)
    pairs = ((0.01, 0.02), (0.01, 0.04), (0.02, 0.01), (0.03, inf), (nan, 1.0))
    rows = [Judged("a", "random", "l1", error, bound, has_reason=True) for error, bound in pairs]
    assert summary(rows) == " 66.7 % hold,     2 times the error,   1 missing"


@pytest.mark.cases(len(RANDOM))
@pytest.mark.parametrize("kind", RANDOM)
def test_a_seed_chooses_the_random_contacts_of_each_kind(kind: str) -> None:
    first, again, other = (random_case(f"{kind} 0", seed) for seed in (1, 1, 2))
    assert (first.scene, first.grid) == (again.scene, again.grid) != (other.scene, other.grid)
    assert np.isfinite(first.problem().undeformed_gap).all()
