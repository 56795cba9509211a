"""The comparison of a scene's settings, on scenes whose answer is known."""

from math import pi
from pathlib import Path

import numpy as np
import pytest

import contactstudy as cs
from studies.advice.comparison import LINE, Comparison
from studies.advice.measuring import Budget, compared
from studies.advice.stored import store, stored
from studies.advice.subject import (
    bounds_of,
    described_in,
    paper_described,
    subject_of,
)
from studies.reference.line_contact import HERTZ, SCENE, hertz_means

EXAMPLES = Path(__file__).parents[3] / "examples"


@pytest.fixture(scope="module")
def cylinder() -> Comparison:
    return compared(paper_described().subject(), 1e-2, Budget(1.5))


def test_means_of_hertzs_pressure_carry_his_load_on_any_cells() -> None:
    for cells in ((7, 3), (64, 1)):
        grid = cs.Grid(cells, (2.4 * HERTZ.half_width, 1e-4))
        load = hertz_means(HERTZ, grid).sum() * grid.cell_area / grid.period
        assert load == pytest.approx(HERTZ.load_per_length, rel=1e-12)


def test_the_error_of_a_window_follows_its_law_on_the_papers_cylinder(cylinder: Comparison) -> None:
    # a^2 / (2 pi D^2): next order (a / D)^2, which is 1/36 at D = 6 a
    alone = {repr(one.padding): one.l1 for one in cylinder.paddings}
    for images in (2, 4, 6, 10):
        reach = 2.4 * (images + 0.5)
        law = 1 / (2 * pi * reach**2)
        assert alone[f"CircularSuperposition(images={images})"] == pytest.approx(law, rel=0.1)


def test_a_cylinder_is_judged_by_hertz_and_solved_with_one_cell_along(cylinder: Comparison) -> None:
    assert cylinder.reference is None
    assert cylinder.floor == 0
    verdict = cylinder.verdict()
    assert verdict is not None
    assert verdict.meets
    assert verdict.best.label in (LINE, "exact")
    solution = cs.solve(
        SCENE.problem(
            cs.Grid(verdict.best.setting.cells, cylinder.extent), verdict.best.setting.padding
        ),
        tolerance=verdict.best.setting.tolerance,
    )
    true = hertz_means(HERTZ, solution.problem.grid)
    assert np.abs(solution.pressure - true).sum() <= 1e-2 * true.sum()


def test_a_window_that_leaves_too_much_out_meets_the_request_on_no_grid(
    cylinder: Comparison,
) -> None:
    # duplicated padding alone is 2.4 % wrong at a period of 2.4 half-widths
    alone = {repr(one.padding): one.l1 for one in cylinder.paddings}
    assert 0.02 < alone["DuplicatedPadding()"] < 0.03
    verdict = cylinder.verdict()
    assert verdict is not None
    assert "duplicated" not in {rival.measured.label for rival in verdict.rivals}


def test_errors_on_a_ladder_of_a_rough_roller_keep_to_its_own_estimates() -> None:
    subject = described_in(EXAMPLES / "rough-roller.toml").subject(0.2)
    measured = compared(subject, 0.2, Budget(1.5))
    assert measured.own_label == "free"
    assert measured.reference is not None
    # every image belongs to another contact
    assert min(one.l1 for one in measured.paddings) > 0.1
    finest = measured.of("free")[-1]
    answer = subject.solve(finest.setting)
    assert finest.error <= bounds_of(answer)["pressure_l1"] + measured.floor


def test_a_stored_comparison_is_that_of_its_scene_alone(
    tmp_path: Path, cylinder: Comparison
) -> None:
    store(cylinder, paper_described().key, tmp_path)
    assert stored(paper_described().key, tmp_path) == cylinder
    assert stored(paper_described(period=0.6).key, tmp_path) is None


def test_a_load_that_is_sought_is_answered_with_a_remedy() -> None:
    with pytest.raises(cs.InvalidInput, match="give it a load per length"):
        described_in(EXAMPLES / "gripper.toml").subject()


def test_a_scene_without_a_width_of_its_own_needs_a_grid() -> None:
    flat = cs.Scene(SCENE.load, SCENE.solids, (cs.Waviness(1e-6, along=1e-4),))
    with pytest.raises(cs.InvalidInput, match="grid"):
        subject_of(cs.SceneFile(flat), "flat")


@pytest.mark.parametrize(
    ("error", "seconds"), [(0.0, 1.0), (-1.0, 1.0), (0.1, 0.0), (float("nan"), 1.0)]
)
def test_a_request_must_be_above_zero(error: float, seconds: float) -> None:
    with pytest.raises(cs.InvalidInput, match="above 0"):
        compared(paper_described().subject(), error, Budget(seconds))
