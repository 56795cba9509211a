"""The verdict on a scene: what it promises of a scene file, and its choice among measurements made by hand."""

from collections.abc import Iterator
from dataclasses import replace
from math import inf, pi
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import contactstudy as cs
from studies.advice import trials
from studies.advice.reference_error import against
from studies.advice.trials import verdict_on
from studies.advice.verdict import (
    EVERY_NUMBER,
    PRESSURE,
    Measured,
    SceneToJudge,
    Setting,
    Verdict,
    from_dataset,
    is_tie,
    paper_scene,
    scene_in,
    to_dataset,
)
from studies.reference.line_contact import HERTZ, SCENE
from studies.report.drawings.comparison import claim, explanation, lines
from studies.scene_study.study_of import study_of
from tests.studies.conftest import quiet
from tests.studies.scene_study.conftest import ROUGH, SMOOTH, STEEL

EXAMPLES = Path(__file__).parents[3] / "examples"
EXACT, COPIED = cs.ExactPeriodicity(), cs.DuplicatedPadding()
BALL = f'{STEEL}{STEEL}[load]\ntotal = "40 N"\n[[shapes]]\nkind = "Sphere"\nradius = "4 mm"\n'
# A contact that reaches the edge of its plan, and a scene with a window of its own.
WIDE = ROUGH.replace("100 N/mm", "40 N/mm").replace("0.48 mm", "0.2 mm").replace('"0.1 um"', '"0.3 um"')
WINDOW = f'padding = {{ kind = "Superposition", images = 4 }}\n{SMOOTH}period = "0.3 mm"\n'


def best_of(verdict: Verdict) -> Measured:
    best = verdict.best()
    assert best is not None
    return best


def pasted(scene: str, verdict: Verdict, folder: Path) -> cs.SceneFile:
    """A scene file with the tables of the verdict in the place of its own."""
    names = ("grid", "padding", "padding_across", "solve", "plan")
    kept = [table for table in f"\n{scene}".split("\n[") if table.partition("]")[0] not in names]
    (folder / "chosen.toml").write_text("\n[".join(kept) + "\n" + verdict.toml(best_of(verdict)), encoding="utf-8")
    return cs.read_scene(folder / "chosen.toml")


@pytest.fixture(scope="module", autouse=True)
def few_trials() -> Iterator[None]:
    """Times of one round, none of which is judged here, and of the grids every other one."""
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(trials, "ROUND_SECONDS", 0.0)
        patched.setattr(trials, "MULTIPLES", (1, 3, 6, 12, 36))
        yield


@pytest.fixture(scope="module")
def cylinder() -> Verdict:
    return verdict_on(paper_scene(), 1e-2, measure=PRESSURE)


@pytest.mark.parametrize(
    ("name", "error"),
    [
        ("rough-roller", 0.3),
        pytest.param("oil", 0.05, marks=pytest.mark.whole),
        pytest.param("rough", 0.2, marks=pytest.mark.whole),
    ],
)
def test_the_tables_of_a_verdict_solve_the_scene_to_met(name: str, error: float, tmp_path: Path) -> None:
    path = EXAMPLES / f"{name}.toml"
    verdict = verdict_on(scene_in(path), error)
    answer = pasted(path.read_text(encoding="utf-8"), verdict, tmp_path).solve()
    assert answer.met, answer.accuracy
    assert is_tie(best_of(verdict), verdict.meeting()[0])
    if name == "rough-roller":  # which ends along its length
        free = cs.ZeroPadding(), cs.ZeroPadding()
        assert {measured.setting.padding for measured in verdict.settings} == {free}


def test_a_verdict_keeps_the_errors_of_the_numbers_that_are_named(tmp_path: Path) -> None:
    path = tmp_path / "ball.toml"
    path.write_text(BALL, encoding="utf-8")
    request = {"peak_pressure": 0.02, "approach": 0.1}
    verdict = trials.verdict_of(scene_in(path), request, tmp_path, quiet)
    answer = pasted(BALL, verdict, tmp_path).solve()
    assert answer.requested == request
    assert answer.met, answer.accuracy
    # a number counts in proportion to its own request
    ratios = [number.ratio for number in answer.judged.values()]
    assert 0.02 * max(ratios) <= best_of(verdict).error <= 0.02 == verdict.error
    assert "is kept by every number that is named" in claim(verdict)
    # no grid is tried beyond the first that meets the error
    assert best_of(verdict).setting.cells == max(one.setting.cells for one in verdict.settings)


def test_the_pressure_keeps_the_error_under_a_somewhat_lower_load(cylinder: Verdict) -> None:
    setting = best_of(cylinder).setting
    grid = cs.Grid(setting.cells, cylinder.extent)
    for factor in (1.0, 0.985, 0.97, 0.955, 0.94, 0.92):
        scene = replace(SCENE, load=cs.LineLoad(factor * HERTZ.load_per_length))
        assert cs.solve(scene, grid, setting.padding, error={"pressure": 0.01}, tolerance=setting.tolerance).met


@pytest.mark.parametrize("text", [WIDE, WINDOW], ids=["reaches the edge", "own window"])
def test_every_number_is_kept_where_a_solve_keeps_it(text: str, tmp_path: Path) -> None:
    (tmp_path / "scene.toml").write_text(text, encoding="utf-8")
    verdict = verdict_on(scene_in(tmp_path / "scene.toml"), 0.2)
    assert verdict.measure == EVERY_NUMBER
    assert verdict.best() is not None
    if text == WINDOW:
        assert verdict.own == "superposed, n = 4"
        assert verdict.own in {one.setting.label for one in verdict.settings}


def test_a_window_that_is_too_short_keeps_the_error_on_no_grid(cylinder: Verdict) -> None:
    assert not {"zero", "duplicated"} & {one.setting.label for one in cylinder.meeting()}
    assert any("duplicated padding" in text for text in explanation(cylinder))
    # a copy has cells enough along to cover both sides alike: its error is by the law of its reach
    copied = [one for one in cylinder.settings if one.setting.label == "duplicated"]
    assert {one.setting.cells[1] for one in cylinder.settings} == {1, 8}
    assert copied[-1].difference == pytest.approx(1 / (2 * pi * 2.4**2), rel=0.2)


def one(
    padding: cs.Padding = EXACT, cells: int = 32, bound: float = 0.02, seconds: float = 1.0, difference: float = 0.01
) -> Measured:
    setting = Setting(padding, (cells, cells), 1e-4)
    return Measured(setting, bound, 2 * bound, "in the contact area", difference, seconds)


def of(*settings: Measured, error: float = 0.03, measure: str = PRESSURE) -> Verdict:
    return Verdict("hand", "", error, measure, (1e-3, 1e-3), "exact", "a finer solution", settings, ("A note.",))


def test_a_tie_goes_to_the_padding_of_the_scene_and_to_more_cells() -> None:
    tied = best_of(of(one(COPIED, seconds=0.95), one(cells=48, seconds=1.0), one(cells=64, seconds=1.04)))
    assert (tied.setting.label, tied.setting.cells) == ("exact", (64, 64))
    # on one grid a copy differs in its set-up alone; on another the faster one is chosen
    for cells, chosen in ((32, "exact"), (24, "duplicated")):
        assert best_of(of(one(COPIED, cells, seconds=0.8), one(seconds=1.0))).setting.label == chosen


def test_what_counts_is_the_bound_of_the_measure_and_no_measured_difference_above_it() -> None:
    assert claim(of(one())).startswith("Use exact")
    for missed in (of(one(), measure=EVERY_NUMBER), of(one(difference=0.04))):
        assert not missed.meeting()
        assert claim(missed).startswith("No setting that was tried")
    unbounded = of(one(bound=inf), one(cells=64, bound=inf))
    assert "64 x 64 cells" in claim(unbounded)
    assert "an error without a bound" in " ".join(lines(unbounded))


def test_a_verdict_is_read_again_for_its_scene_and_error_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[float] = []

    def by_hand(described: SceneToJudge, error: float, *_: object) -> Verdict:
        made.append(error)
        return of(one(), error=error)

    monkeypatch.setattr(trials, "verdict_on", by_hand)
    scene = paper_scene()
    other = replace(scene, file=replace(scene.file, options=cs.SolveOptions(tolerance=1e-9)))
    for described, error, count in ((scene, 0.1, 1), (scene, 0.1, 1), (scene, 0.2, 2), (other, 0.2, 3)):
        found = trials.verdict_of(described, error, tmp_path, quiet)
        assert (found.error, len(made)) == (error, count)
    xr.Dataset({"case_status": 1}).to_netcdf(trials.path_in(tmp_path))
    with pytest.raises(cs.InvalidInput, match="holds a study, which the comparison would replace"):
        trials.verdict_of(scene, 0.1, tmp_path, quiet)


def test_a_padding_survives_in_a_file() -> None:
    for padding in (cs.Superposition(4), (cs.ZeroPadding(), cs.ExactPeriodicity())):
        verdict = of(replace(one(), setting=replace(one().setting, padding=padding)))
        assert from_dataset(to_dataset(verdict)) == verdict


def test_the_error_against_a_reference_is_that_to_its_cell_means_where_cells_nest() -> None:
    wavy = replace(SCENE, shapes=(*SCENE.shapes, cs.Waviness(1e-7, along=1e-4)))
    file = cs.SceneFile(wavy, grid=cs.Grid((16, 16), (4e-4, 1e-4)), padding=EXACT)
    swept = study_of(file, {"grid.cells": [[16, 16], [24, 24], [32, 32]]})
    (axis,) = swept.axes
    coarse, unnested, reference = axis.values
    study = against(swept, axis.name, reference)
    answers, measured = {}, {}
    for value in axis.values:
        case = study.case_at({axis.name: value})
        answers[value] = case.run(None)
        measured[value] = study.measures(case, answers[value])
    means = answers[reference].pressure.reshape(16, 2, 16, 2).mean((1, 3))
    by_hand = np.abs(answers[coarse].pressure - means).sum() / means.sum()
    assert float(measured[coarse]["pressure_error_l1"]) == pytest.approx(by_hand, rel=1e-12)
    assert float(measured[coarse]["reference_error_l1"]) == pytest.approx(answers[reference].error.l1.total, rel=1e-12)
    for value in (unnested, reference):
        assert "pressure_error_l1" not in measured[value]
