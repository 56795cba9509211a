"""The verdict on a scene: what it promises of a scene file, and its choice among measurements made by hand."""

from collections.abc import Iterator
from dataclasses import replace
from math import inf, pi
from pathlib import Path

import pytest
import xarray as xr

import contactstudy as cs
from studies.advice import stored
from studies.advice.trials import verdict_on
from studies.advice.verdict import (
    EVERY_NUMBER,
    PRESSURE,
    Measured,
    SceneToJudge,
    Setting,
    Verdict,
    is_tie,
    paper_scene,
    scene_in,
)
from studies.reference.line_contact import HERTZ, SCENE
from studies.report.wording import claim, explanation, lines
from tests.studies.conftest import quiet

EXAMPLES = Path(__file__).parents[3] / "examples"
EXACT, COPIED = cs.ExactPeriodicity(), cs.DuplicatedPadding()


def pasted(scene: str, verdict: Verdict, folder: Path) -> cs.SceneFile:
    """A scene file with the tables of the verdict in the place of its own."""
    best = verdict.best()
    assert best is not None
    names = ("grid", "padding", "padding_across", "solve", "plan")
    kept = [table for table in f"\n{scene}".split("\n[") if table.partition("]")[0] not in names]
    (folder / "chosen.toml").write_text("\n[".join(kept) + "\n" + verdict.toml(best), encoding="utf-8")
    return cs.read_scene(folder / "chosen.toml")


@pytest.fixture(scope="module", autouse=True)
def two_rounds() -> Iterator[None]:
    """Times of two rounds, however quick they are: none is judged here."""
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr("studies.advice.trials.ROUND_SECONDS", 0.0)
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
    text = (EXAMPLES / f"{name}.toml").read_text(encoding="utf-8")
    verdict = verdict_on(scene_in(EXAMPLES / f"{name}.toml"), error)
    answer = pasted(text, verdict, tmp_path).solve()
    assert answer.met, answer.accuracy
    best = verdict.best()
    assert best is not None
    assert is_tie(best, verdict.meeting()[0])
    if name == "rough-roller":  # which ends along its length
        free = cs.ZeroPadding(), cs.ZeroPadding()
        assert {measured.setting.padding for measured in verdict.settings} == {free}


def test_a_verdict_keeps_the_errors_of_the_numbers_that_are_named(tmp_path: Path) -> None:
    path = tmp_path / "ball.toml"
    path.write_text(scene_text("ball"), encoding="utf-8")
    request = {"peak_pressure": 0.02, "approach": 0.1}
    verdict = stored.verdict_of(scene_in(path), request, tmp_path, quiet)
    best = verdict.best()
    assert best is not None
    answer = pasted(path.read_text(encoding="utf-8"), verdict, tmp_path).solve()
    assert answer.requested == request
    assert answer.met, answer.accuracy
    # a number counts in proportion to its own request
    ratios = [number.ratio for number in answer.judged.values()]
    assert 0.02 * max(ratios) <= best.error <= 0.02 == verdict.error
    assert "is kept by every number that is named" in claim(verdict)
    again = stored.verdict_of(scene_in(path), request, tmp_path, quiet)
    assert again.toml(best) == verdict.toml(best)


def test_the_pressure_keeps_the_error_under_a_somewhat_lower_load(cylinder: Verdict) -> None:
    best = cylinder.best()
    assert best is not None
    grid = cs.Grid(best.setting.cells, cylinder.extent)
    for factor in (1.0, 0.985, 0.97, 0.955, 0.94, 0.92):
        scene = replace(SCENE, load=cs.LineLoad(factor * HERTZ.load_per_length))
        answer = cs.solve(
            scene, grid, best.setting.padding, error={"pressure": 0.01}, tolerance=best.setting.tolerance
        )  # fmt: skip
        assert answer.met


BODIES = '[[solids]]\nmaterial = "steel"\n' * 2
SCENES = {
    "ball": '[load]\ntotal = "40 N"\n[[shapes]]\nkind = "Sphere"\nradius = "4 mm"\n',
    "reaches the edge of its plan": '[load]\nper_length = "40 N/mm"\n[[shapes]]\nkind = "Cylinder"\nradius = "10 mm"\n'
    '[[shapes]]\nkind = "Roughness"\nrms = "0.3 um"\nhurst = 0.7\nroll_off = "50 um"\ncut_off = "16 um"\n'
    'peklenik = 0.5\nseed = 3\n[plan]\nperiod = "0.2 mm"\n',
    "own window": 'padding = { kind = "Superposition", images = 4 }\n[load]\nper_length = "70 N/mm"\n'
    '[[shapes]]\nkind = "Cylinder"\nradius = "10 mm"\n[plan]\nperiod = "0.3 mm"\n',
}


def scene_text(name: str) -> str:
    head, _, rest = SCENES[name].rpartition("[load]")
    return f"{head}{BODIES}[load]{rest}"


@pytest.mark.cases(1)
@pytest.mark.parametrize("name", SCENES)
def test_every_number_is_kept_where_a_solve_keeps_it(name: str, tmp_path: Path) -> None:
    (tmp_path / "scene.toml").write_text(scene_text(name), encoding="utf-8")
    verdict = verdict_on(scene_in(tmp_path / "scene.toml"), 0.05 if name == "ball" else 0.2)
    assert verdict.measure == EVERY_NUMBER
    assert verdict.best() is not None
    if name == "own window":
        assert verdict.own == "superposed, n = 4"
        assert verdict.own in {one.setting.label for one in verdict.settings}


def test_a_window_that_is_too_short_keeps_the_error_on_no_grid(cylinder: Verdict) -> None:
    assert cylinder.own == "exact"
    assert not {"zero", "duplicated"} & {one.setting.label for one in cylinder.meeting()}
    assert any("duplicated padding" in text for text in explanation(cylinder))


def test_a_measured_difference_above_the_error_is_not_met_whatever_the_bound() -> None:
    assert not of(one(difference=0.04)).meeting()


def one(
    padding: cs.Padding = EXACT,
    cells: int = 32,
    bound: float = 0.02,
    seconds: float = 1.0,
    difference: float = 0.01,
) -> Measured:
    label = {EXACT: "exact", COPIED: "duplicated"}[padding]
    setting = Setting(label, padding, (cells, cells), 1e-4)
    return Measured(setting, bound, 2 * bound, "in the contact area", difference, seconds)


def of(*settings: Measured, error: float = 0.03, measure: str = PRESSURE) -> Verdict:
    return Verdict(
        "hand", "", error, measure, (1e-3, 1e-3), "exact", "a finer solution", settings, ("A note.",)
    )  # fmt: skip


def test_a_tie_goes_to_the_padding_of_the_scene_and_to_more_cells() -> None:
    best = of(
        one(COPIED, seconds=0.95),
        one(cells=48, seconds=1.0),
        one(cells=64, seconds=1.04),
    ).best()
    assert best is not None
    assert (best.setting.label, best.setting.cells) == ("exact", (64, 64))
    # on one grid a copy differs in its set-up alone; on another the faster one is chosen
    for cells, chosen in ((32, "exact"), (24, "duplicated")):
        faster = of(one(COPIED, cells, seconds=0.8), one(seconds=1.0)).best()
        assert faster is not None
        assert faster.setting.label == chosen


@pytest.mark.parametrize(("measure", "met"), [(PRESSURE, True), (EVERY_NUMBER, False)])
def test_the_bound_that_counts_is_that_of_the_measure(measure: str, met: bool) -> None:  # noqa: FBT001 (parametrised)
    verdict = of(one(), measure=measure)
    assert bool(verdict.meeting()) is met
    assert claim(verdict).startswith("Use exact" if met else "No setting that was tried")


def test_without_a_bound_the_nearest_setting_is_named_and_nothing_claimed() -> None:
    verdict = of(one(bound=inf), one(cells=64, bound=inf))
    assert claim(verdict).startswith("No setting that was tried is shown to keep 3.0")
    assert "64 x 64 cells" in claim(verdict)
    assert "an error without a bound" in " ".join(lines(verdict))


def test_a_verdict_is_read_again_for_its_scene_and_error_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[float] = []

    def by_hand(described: SceneToJudge, error: float, *_: object) -> Verdict:
        made.append(error)
        return of(one(), error=error)

    monkeypatch.setattr(stored, "verdict_on", by_hand)
    scene = paper_scene()
    other = replace(scene, file=replace(scene.file, options=cs.SolveOptions(tolerance=1e-9)))
    for described, error, count in (
        (scene, 0.1, 1),
        (scene, 0.1, 1),
        (scene, 0.2, 2),
        (other, 0.2, 3),
    ):
        found = stored.verdict_of(described, error, tmp_path, quiet)
        assert (found.error, len(made)) == (error, count)
    xr.Dataset({"case_status": 1}).to_netcdf(stored.path_in(tmp_path))
    with pytest.raises(cs.InvalidInput, match="holds a study, which the comparison would replace"):
        stored.verdict_of(scene, 0.1, tmp_path, quiet)


@pytest.mark.parametrize("padding", [EXACT, cs.Superposition(4), (cs.ZeroPadding(), cs.ZeroPadding())])
def test_a_padding_survives_in_a_file(padding: cs.Padding | cs.Paddings) -> None:
    measured = replace(one(), setting=replace(one().setting, padding=padding))
    assert stored.from_dataset(stored.to_dataset(of(measured))) == of(measured)


def test_a_copy_has_cells_enough_along_to_cover_both_sides_alike(cylinder: Verdict) -> None:
    copied = [one for one in cylinder.settings if one.setting.label == "duplicated"]
    assert {one.setting.cells[1] for one in cylinder.settings} == {1, 8}
    # by the law of its reach, and not half as much again
    for one in copied[-2:]:
        assert one.difference == pytest.approx(1 / (2 * pi * 2.4**2), rel=0.2)
