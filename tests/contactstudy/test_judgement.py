"""A requested error is kept by every number, and the headline says by which it is not."""

from dataclasses import replace
from math import inf

import pytest

import contactstudy as cs
from contactstudy.answers.answer import judged_numbers
from contactstudy.io.quantities.quantity import Quantity
from tests.conftest import LineContact

EXACT = cs.ExactPeriodicity()


def test_a_requested_error_is_kept_by_every_number(line_contact: LineContact) -> None:
    hertz, answer = line_contact.hertz, cs.solve(line_contact.scene, error="1 %")
    assert answer.met
    assert "met by every number" in answer.accuracy
    assert max(number.relative_bound for number in answer.quantities.values()) <= 1e-2
    for name, true in (("half_width", hertz.half_width), ("peak_pressure", hertz.peak_pressure)):
        assert answer.quantities[name].value == pytest.approx(true, rel=1e-2)


def test_the_headline_names_the_worst_number_and_the_cells_that_would_keep_the_error(line_contact: LineContact) -> None:
    answer = cs.solve(line_contact.scene, line_contact.grid((40, 1), 1.0), EXACT, error="1 %")
    worst = max(answer.quantities.values(), key=lambda number: number.relative_bound)
    assert answer.error.l1.total <= 1e-2
    assert not answer.met
    assert f"{100 * worst.relative_bound:.2g} % in the {worst.label.split(' (')[0]}" in answer.accuracy
    cells = int(answer.accuracy.split("about ")[1].split(" x 1")[0])
    finer = cs.solve(line_contact.scene, line_contact.grid((cells, 1), 1.0), EXACT, error="1 %")
    assert finer.met


def test_errors_of_named_numbers_refine_no_further_than_these_need(line_contact: LineContact) -> None:
    scene = replace(line_contact.scene, outputs=(cs.SubsurfaceStress(),))
    some = cs.solve(scene, error={"peak_pressure": "2 %", "von_mises": "5 %"})
    every = cs.solve(scene, error="2 %")
    assert some.met
    assert some.quantities["peak_pressure"].relative_bound <= 2e-2
    assert some.quantities["largest_von_mises"].relative_bound <= 5e-2
    assert some.grid.cells[0] < every.grid.cells[0]
    assert list(some.judged) == ["peak_pressure", "largest_von_mises"]


def test_a_named_number_without_a_bound_is_not_met_and_says_why(line_contact: LineContact) -> None:
    problem = line_contact.scene.problem(line_contact.grid((32, 1), 1.0), EXACT)
    answer = cs.solve(replace(problem, source=None), error={"peak_pressure": 0.5})
    assert answer.quantities["peak_pressure"].reason.startswith("No bound for the discretisation error")
    assert answer.met is False
    assert "no bound in the peak pressure" in answer.accuracy


def test_a_request_that_cannot_be_judged_is_refused(line_contact: LineContact) -> None:
    for error, sentence in (
        ({"peak": "2 %"}, "error names 'peak', which this answer does not have: give some of pressure, peak_p"),
        ({"peak_pressure": 2}, r"solve.error\['peak_pressure'\] is 2: give a relative error"),
        ({}, "solve.error is empty"),
    ):
        with pytest.raises(cs.InvalidInput, match=sentence):
            repr(cs.solve(line_contact.scene, error=error))  # type: ignore[call-overload]


def test_components_count_over_the_whole_and_fractions_over_one() -> None:
    numbers = {
        "traction_coefficient": Quantity(0.2, "1", "tangential force over load", 1e-3, ""),
        "lateral_traction_coefficient": Quantity(1e-6, "1", "lateral force", 1e-3, ""),
        "stick_fraction": Quantity(1e-3, "1", "fraction that sticks", 2e-3, "", is_fraction=True),
        "pressure_shift": Quantity(0.0, "m", "centroid", 1e-9, ""),
    }
    judged = judged_numbers(numbers, 1e-2)
    assert judged["lateral_traction_coefficient"].ratio == pytest.approx(0.5)
    assert judged["stick_fraction"].ratio == pytest.approx(0.2)
    assert str(judged["stick_fraction"]) == "0.2 % in the fraction that sticks (absolute)"
    assert "pressure_shift" not in judged  # zero, of which no error is a part


def test_numbers_without_a_law_are_bounded_by_their_changes_from_larger_cells() -> None:
    """The centroid of a rolling contact has no law of its own: a finer grid shows its true error."""
    rubber = cs.ViscoelasticHalfSpace(1e6, 0.49, relaxation=((1.5e6, 1.0),))
    rigid = cs.HalfSpace(inf, 0.3)
    scene = cs.Scene(cs.LineLoad(500.0), (rubber, rigid), (cs.Cylinder(0.01),), rolling=cs.Rolling(0.1))
    found, fine = (
        cs.solve(scene, cs.Grid((cells, 1), (8e-3, 1e-2)), EXACT).quantities["pressure_shift"] for cells in (48, 768)
    )
    assert abs(found.value - fine.value) <= found.bound < 0.5 * abs(found.value)
    assert fine.bound < found.bound / 10


def test_no_cells_are_said_to_keep_the_error_of_a_depth_between_given_depths(line_contact: LineContact) -> None:
    depths = tuple(ratio * line_contact.hertz.half_width for ratio in (0.3, 0.8, 1.6))
    scene = replace(line_contact.scene, outputs=(cs.SubsurfaceStress(depths=depths),))
    answer = cs.solve(scene, line_contact.grid((40, 1), 1.0), EXACT, error="1 %")
    assert "give closer depths" in answer.accuracy
    assert "cells would meet it" not in answer.accuracy


def test_the_error_of_a_stress_at_a_given_depth_is_bounded_as_closely_as_the_cells_allow(
    line_contact: LineContact,
) -> None:
    scene = replace(line_contact.scene, outputs=(cs.SubsurfaceStress(depths=(0.3 * line_contact.hertz.half_width,)),))
    found, fine = (
        cs.solve(scene, line_contact.grid((cells, 1), 1.0), EXACT).quantities["largest_von_mises"]
        for cells in (400, 4000)
    )
    assert abs(found.value - fine.value) <= found.bound < 3e-4 * found.value
    assert fine.bound < 0.1 * found.bound


def test_no_cells_are_said_to_keep_the_error_of_a_largest_stress_that_may_lie_between_depths(
    line_contact: LineContact,
) -> None:
    scene = replace(line_contact.scene, outputs=(cs.SubsurfaceStress(),))
    answer = cs.solve(scene, line_contact.grid((400, 1), 1.0), EXACT, error={"von_mises": 1e-4})
    assert "may lie between depths" in answer.accuracy
    assert "cells would meet it" not in answer.accuracy
