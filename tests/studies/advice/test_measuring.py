"""The comparison of a scene's settings, on scenes whose answer is known."""

from dataclasses import replace
from functools import partial
from math import inf, nan, prod
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

import contactstudy as cs
from studies.advice.compared_scene import (
    ComparedScene,
    Setting,
    bounds_of,
    compared_scene,
    paper_scene,
    scene_in,
)
from studies.advice.comparison import (
    LINE,
    Comparison,
    MeasuredPadding,
    MeasuredSetting,
    label_of,
    with_envelope,
)
from studies.advice.front import pareto_front
from studies.advice.measuring import compare_settings
from studies.advice.nested_answers import Budget, NestedAnswers
from studies.advice.rounds import median_ratio_and_p, times_in_rounds
from studies.advice.stored import as_text, comparison_of, from_text, path_in, store, stored
from studies.reference.line_contact import HERTZ, SCENE, hertz_means, relative_l1
from studies.store.netcdf import check_kind

EXAMPLES = Path(__file__).parents[3] / "examples"


@pytest.fixture(scope="module")
def cylinder() -> Comparison:
    return compare_settings(paper_scene().subject(), 1e-2, Budget(6.0))


def test_means_of_hertzs_pressure_carry_his_load_on_any_cells() -> None:
    for cells in ((7, 3), (64, 1)):
        grid = cs.Grid(cells, (2.4 * HERTZ.half_width, 1e-4))
        load = hertz_means(HERTZ, grid).sum() * grid.cell_area / grid.length
        assert load == pytest.approx(HERTZ.load_per_length, rel=1e-12)


def test_a_cylinder_is_judged_by_hertz_and_solved_with_one_cell_along(cylinder: Comparison) -> None:
    assert cylinder.reference is None
    assert cylinder.reference_bound == 0
    verdict = cylinder.verdict()
    assert verdict.meets
    assert verdict.best.label in (LINE, "exact")
    setting = verdict.best.setting
    grid = cs.Grid(setting.cells, cylinder.extent)
    solution = cs.solve(SCENE.problem(grid, setting.padding), tolerance=setting.tolerance)
    true = hertz_means(HERTZ, grid)
    assert np.abs(solution.pressure - true).sum() <= 1e-2 * true.sum()


def test_a_padding_that_does_not_converge_has_no_error_of_its_own(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    solve = ComparedScene.solve

    def cut_short(subject: ComparedScene, setting: Setting) -> Any:
        answer = solve(subject, setting)
        is_copied = setting.padding == cs.DuplicatedPadding()
        return replace(answer, status=cs.Status.STALLED) if is_copied else answer

    monkeypatch.setattr(ComparedScene, "solve", cut_short)
    measured = compare_settings(paper_scene().subject(), 0.1, Budget(2.0))
    assert "duplicated" not in {label_of(item.padding) for item in measured.paddings}
    assert f"Left out: duplicated. For the first: {cs.Status.STALLED}" in " ".join(measured.notes)


def test_a_window_too_short_meets_the_request_on_no_grid(cylinder: Comparison) -> None:
    # duplicated padding alone is 2.4 % wrong at a period of 2.4 half-widths
    alone = {repr(one.padding): one.l1 for one in cylinder.paddings}
    assert 0.02 < alone["DuplicatedPadding()"] < 0.03
    verdict = cylinder.verdict()
    assert "duplicated" not in {alternative.measured.label for alternative in verdict.alternatives}


@pytest.mark.whole
def test_errors_on_a_ladder_of_a_rough_roller_keep_to_its_own_estimates() -> None:
    subject = scene_in(EXAMPLES / "rough-roller.toml").subject(0.2)
    measured = compare_settings(subject, 0.2, Budget(6.0))
    assert measured.boundary_label == "free"
    assert measured.reference is not None
    # every image belongs to another contact
    assert min(one.l1 for one in measured.paddings) > 0.1
    finest = measured.settings_of("free")[-1]
    answer = subject.solve(finest.setting)
    assert finest.error <= bounds_of(answer)["pressure_l1"] + measured.reference_bound


def test_work_is_expected_to_take_as_much_longer_by_the_clock_as_that_before() -> None:
    now = perf_counter(), process_time()
    for slowdown, fits in ((1.0, True), (20.0, False)):
        budget = Budget(10.0, began=(now[0] - slowdown, now[1] - 1.0))
        assert budget.allows(1.0) is fits
    # of ten seconds nine are kept for what follows
    assert not Budget(10.0).allows(1.0, kept=0.9)


@pytest.mark.whole
def test_one_slow_solve_does_not_end_the_refinement(monkeypatch: pytest.MonkeyPatch) -> None:
    """By the processor too, as a first compilation is."""
    slow = iter([2.0])
    solve = ComparedScene.solve

    def slowed(subject: ComparedScene, setting: Setting) -> object:
        end = process_time() + (next(slow, 0.0) if setting.cells == (48, 24) else 0.0)
        while process_time() < end:
            pass
        return solve(subject, setting)

    monkeypatch.setattr(ComparedScene, "solve", slowed)
    nested = NestedAnswers(scene_in(EXAMPLES / "rough.toml").subject(), 0.1, Budget(600.0))
    nested.refine(lambda multiple: prod(nested.cells(multiple)) <= 144 * 72)
    assert nested.cells(max(nested.answers)) == (144, 72)


def test_errors_are_over_the_norm_of_a_pressure_that_also_pulls() -> None:
    pulls = np.array([[3.0], [-1.0]])
    assert relative_l1(pulls + 0.4, pulls) == pytest.approx(0.2)


def test_a_stored_comparison_is_of_its_scene_and_program_alone(
    tmp_path: Path, cylinder: Comparison, monkeypatch: pytest.MonkeyPatch
) -> None:
    store(cylinder, paper_scene().key, tmp_path)
    assert stored(paper_scene().key, tmp_path) == cylinder
    assert stored(paper_scene(period=0.6).key, tmp_path) is None
    with monkeypatch.context() as edited:  # in a checkout whose revision stays
        edited.setattr("studies.advice.stored.source_hash", lambda *folder: "edited")
        assert stored(paper_scene().key, tmp_path) is None
    # a study settings.py would write a file of the same name
    with pytest.raises(cs.InvalidInput, match="holds a comparison, which the study would replace"):
        check_kind(path_in(tmp_path), "study")
    xr.Dataset({"case_status": 1}).to_netcdf(path_in(tmp_path))
    with pytest.raises(cs.InvalidInput, match="holds a study, which the comparison would replace"):
        stored(paper_scene().key, tmp_path)


@pytest.mark.parametrize(
    ("scene", "padding", "remedy"),
    [
        (cs.read_scene(EXAMPLES / "gripper.toml").scene, None, "give it a load per length"),
        (replace(SCENE, adhesion=cs.Adhesion(0.05)), None, r"give \[adhesion\] a range to compare"),
        (replace(SCENE, shapes=(cs.Waviness(1e-6, along=1e-4),)), None, r"give it a \[grid\]"),
        (SCENE, (cs.ExactPeriodicity(), cs.ExactPeriodicity()), "leave out padding_across"),
    ],
    ids=[
        "load that is sought",
        "attraction of short range",
        "no width of its own",
        "neighbours across",
    ],
)
def test_a_scene_without_settings_to_compare_is_refused(
    scene: cs.Scene, padding: cs.Paddings | None, remedy: str
) -> None:
    with pytest.raises(cs.InvalidInput, match=remedy):
        compared_scene(cs.SceneFile(scene, padding=padding), "refused")


def test_a_stored_comparison_that_had_too_few_seconds_is_measured_again(tmp_path: Path) -> None:
    for seconds, measured in ((1e-6, True), (1e-6, False), (1e-5, True)):
        said = list[str]()
        found = comparison_of(paper_scene(), 1e-3, Budget(seconds), tmp_path, said.append)
        assert found.budget == seconds
        assert (not any("stored" in text for text in said)) is measured


@pytest.mark.parametrize(
    "changed",
    [{"adhesion": cs.Adhesion(5.0, range=1e-7)}, {"load": cs.Approach(7.5e-7, datum=1.25e-4)}],
    ids=["adhesion", "a given approach"],
)
def test_hertz_is_the_reference_of_no_contact_under_other_forces(changed: dict[str, Any]) -> None:
    grid = cs.Grid((32, 1), (2.5e-4, 1e-4))
    file = cs.SceneFile(replace(SCENE, **changed), grid=grid)
    assert compared_scene(file, "other forces").exact is None


@pytest.mark.parametrize(
    ("error", "seconds"), [(0.0, 1.0), (-1.0, 1.0), (0.1, 0.0), (float("nan"), 1.0)]
)
def test_a_request_must_be_above_zero(error: float, seconds: float) -> None:
    with pytest.raises(cs.InvalidInput, match="above 0"):
        compare_settings(paper_scene().subject(), error, Budget(seconds))


PAIRS = st.lists(st.tuples(st.floats(0, 10), st.floats(0, 10)), max_size=30)


@given(PAIRS)
def test_nothing_on_the_front_is_beaten_and_all_else_is(pairs: list[tuple[float, float]]) -> None:
    cost, error = np.array(pairs).reshape(-1, 2).T
    front = pareto_front(cost, error)
    assert (np.diff(cost[front]) > 0).all()
    assert (np.diff(error[front]) < 0).all()
    for c, e in pairs:
        assert ((cost[front] <= c) & (error[front] <= e)).any()


def test_paired_times_are_compared_within_their_round() -> None:
    # a slow third round slows both: the ratio stays 2
    found, chance = median_ratio_and_p([2.0, 4.0, 200.0, nan], [1.0, 2.0, 100.0, 1.0])
    assert found == pytest.approx(2)
    assert chance == 0.25  # three of three alike: two of 8 outcomes
    assert median_ratio_and_p([1.0, 1.0], [1.0, 1.0]) == (1, 1)


def test_each_round_of_times_has_every_setting_once_and_none_begins_without_time() -> None:
    made: list[int] = []
    has_time = iter([True, True, False])
    rounds = times_in_rounds(
        [partial(made.append, k) for k in range(3)], 15, lambda: next(has_time)
    )
    assert [len(times) for times in rounds] == [3, 3]
    assert sorted(made[:3]) == sorted(made[3:]) == [0, 1, 2]


EXACT, COPIED, ZERO = cs.ExactPeriodicity(), cs.DuplicatedPadding(), cs.ZeroPadding()


def one(
    padding: cs.Padding = EXACT,
    cells: int = 32,
    error: float = 0.02,
    seconds: float = 1.0,
    *,
    rounds: int = 15,
    bounded: bool = True,
) -> MeasuredSetting:
    """A setting that takes as long in every round."""
    setting, times = Setting(padding, (cells, cells), 1e-4), (seconds,) * rounds
    return MeasuredSetting(setting, label_of(padding), error, bounded, times[:1], times)


def of(*settings: MeasuredSetting, reference_bound: float = 0.0) -> Comparison:
    return Comparison(
        name="hand", text="", extent=(1e-3, 1e-3), boundary=EXACT, error=0.03,
        reference_bound=reference_bound, reference=(96, 96),
        bounds={"pressure_l1": reference_bound, "peak_pressure": inf},
        paddings=(MeasuredPadding(COPIED, 0.02, {"mean_gap": 0.1}),),
        paddings_on=(48, 48), tolerances={1e-2: 1e-3}, settings=settings, notes=("A note.",), seconds=3.0,
    )  # fmt: skip


def test_a_tie_goes_to_the_boundary_of_the_scene_itself() -> None:
    # always 5 % quicker, which is clear and not worth it
    verdict = of(one(), one(COPIED, seconds=0.95)).verdict()
    assert verdict.best.label == "exact"
    (alternative,) = verdict.alternatives
    assert alternative.is_as_fast
    assert alternative.ratio == pytest.approx(0.95)


def test_another_padding_is_chosen_if_it_is_a_fifth_quicker_in_enough_rounds() -> None:
    # the same median ratio from three rounds decides nothing
    for rounds, label in ((15, "duplicated"), (3, "exact")):
        verdict = of(one(rounds=rounds), one(COPIED, seconds=0.8, rounds=rounds)).verdict()
        assert verdict.best.label == label


def test_the_bound_on_the_reference_is_added_to_every_error() -> None:
    fine, coarse = one(cells=48, error=0.015, seconds=2.0), one(error=0.025)
    for reference_bound, cells in ((0.004, 32), (0.006, 48)):
        verdict = of(coarse, fine, reference_bound=reference_bound).verdict()
        assert verdict.meets
        assert verdict.best.setting.cells == (cells, cells)
    assert verdict.coarser == coarse


def test_a_grid_that_nothing_bounds_is_never_recommended() -> None:
    verdict = of(one(cells=16, error=0.01, seconds=0.5, bounded=False), one()).verdict()
    assert verdict.best.setting.cells == (32, 32)


def test_errors_below_the_bound_on_the_reference_are_equal_where_none_meets_the_request() -> None:
    quick = one(COPIED, 48, error=0.01, seconds=0.5)
    for error, label in ((0.02, "exact"), (0.09, "duplicated")):
        verdict = of(one(error=error), quick, reference_bound=0.025).verdict()
        assert not verdict.meets
        assert verdict.best.label == label


def test_without_a_bound_on_the_reference_nothing_is_said_to_meet_a_request() -> None:
    assert not of(one(error=0.001), reference_bound=inf).verdict().meets


def test_the_error_of_a_grid_is_the_largest_of_it_and_of_all_finer_ones() -> None:
    assert with_envelope([0.08, 0.14, 0.06]) == [0.14, 0.14, 0.06]


@pytest.mark.parametrize(
    "padding", [EXACT, (ZERO, ZERO), cs.CircularSuperposition(6), (EXACT, EXACT)]
)
def test_a_padding_survives_as_text(padding: cs.Padding | cs.Paddings) -> None:
    assert from_text(as_text(padding)) == padding
