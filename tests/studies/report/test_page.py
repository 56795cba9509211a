import re
from collections.abc import Mapping
from pathlib import Path

import pytest
import xarray as xr

from contactstudy import InvalidInput
from studies.advice.trials import verdict_of
from studies.advice.verdict import PRESSURE, paper_scene
from studies.engine.options import RunOptions
from studies.engine.run import run
from studies.model.outcome import CaseStatus
from studies.registry import BUILT_IN, load, load_drawing
from studies.report import page as report
from studies.report.chapters import CHAPTERS, MAIN, SETTINGS, Chapter, Part, chapter_of_study, chapters
from tests.studies.conftest import quiet

# Few cases of each study; of one that is not named those of any, and of a scene those of its file.
FEW = {"grid": "16,24", "period": "0.6,2.4", "solver_tolerance": "1e-6"}
OWN: Mapping[str, Mapping[str, str]] = {
    "stability": {"case": "load of 1e-30 N/m,a step,one iteration,hardness below the mean pressure"},
    "grid": {"grid": "16,24,32"},
    "paper": {},
    "pareto": {"grid": "16,24", "images": "1", "solver_tolerance": "1e-6"},
    "images": {"grid": "24", "images": "0,1,6"},
}


def run_few(name: str, folder: Path) -> None:
    study = load(name)
    axes = {axis.name: FEW[axis.name] for axis in study.axes if axis.name in FEW}
    run(study.override(OWN.get(name, axes)), folder, workers=1, repeats=1, log=quiet)


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The main chapter of few cases."""
    folder = tmp_path_factory.mktemp("report")
    for part in MAIN.parts:
        if part.name != SETTINGS:
            run_few(part.name, folder)
    verdict_of(paper_scene(), 1e-2, folder, quiet, PRESSURE)
    report.draw_and_write(MAIN, folder)
    return folder


def examine(text: str, folder: Path) -> None:
    """A page has its figures in itself, its links lead somewhere, and it has no text of a missing number."""
    sources, links = (re.findall(rf'\b{name}="([^"]*)"', text) for name in ("src", "href"))
    assert len(sources) == text.count("<figure ") > 0
    assert all(source.startswith("data:image/png;base64,") for source in sources)
    for link in links:
        there = f'id="{link[1:]}"' in text if link.startswith("#") else (folder / link).is_file()
        assert there, link
    assert not re.search(r"https?://|\bnan\b|\bNone\b", re.sub(r"base64,[^\"]*", "", text))


@pytest.mark.whole
def test_the_report_stands_alone_with_the_measured_numbers_of_the_paper_s_claims(out: Path) -> None:
    text = (out / "report.html").read_text(encoding="utf-8")
    examine(text, out)
    for claim in ("n ≥ 6 gives very similar results", "Independent of the domain extent"):
        assert claim in text
    # beside the axis, near a^2 / (8 D^2) at D = L = 3 a and (6 + 1/2) L; the variation along the length with n = 1
    for shown in ("1.3\xa0%", "0.038\xa0%", "28\xa0%"):
        assert shown in text


def test_chapters_are_named_any_study_is_one_and_others_are_refused() -> None:
    for names, pages in (((), ["report"]), (("grid", "grid"), ["grid"]), (("all",), ["report", "effects"])):
        assert [chapter.name for chapter in chapters(names)] == pages
    with pytest.raises(InvalidInput, match=r"^Chapter 'efects' is not known: did you mean 'effects'"):
        chapters(("efects",))


def test_a_chapter_is_run_with_a_line_a_study_and_later_drawn_by_itself(tmp_path: Path) -> None:
    axes = {"padding": "exact,duplicated", "period": "0.6,2.4", "images": "1", "grid": "16"}
    chapter = Chapter("two", "Two studies", (Part("period", axes), Part("images", axes)))
    lines: list[str] = []
    options = RunOptions(workers=0, repeats=0)
    path = report.run_and_write(chapter, tmp_path, options=options, log=lines.append)
    assert [line.partition(" points")[0] for line in lines] == ["two: 1 of 2, period: 4", "two: 2 of 2, images: 4"]
    examine(path.read_text(encoding="utf-8"), tmp_path)
    page = report.draw_and_write(chapter_of_study("period"), tmp_path)
    assert "A chapter of" in page.read_text(encoding="utf-8")


def test_a_failed_case_is_told_in_the_log_and_on_the_page(tmp_path: Path) -> None:
    lines: list[str] = []
    chapter = Chapter("hard", "Hard", (Part("stability", {"case": "load of 1e-30 N/m"}),))
    options = RunOptions(workers=1, time_limit=1e-6, repeats=1)
    page = report.run_and_write(chapter, tmp_path, options=options, log=lines.append)
    assert any("not done after" in line for line in lines)
    assert "No case gave numbers." in page.read_text(encoding="utf-8")


def test_a_figure_whose_variable_is_not_stored_is_told_on_the_page(tmp_path: Path) -> None:
    run_few("stability", tmp_path)
    dataset = report.stored(load("stability"), tmp_path).drop_vars("pressure_difference_l1")
    (said,) = report.section(Part("stability"), dataset).findings
    assert "pressure_difference_l1" in said.claim


@pytest.fixture(scope="module")
def stored(out: Path) -> Mapping[str, xr.Dataset]:
    """Datasets of few cases of each study, made when they are first asked for."""

    class Stored(dict[str, xr.Dataset]):
        def __missing__(self, name: str) -> xr.Dataset:
            if not (out / f"{name}.nc").is_file():
                run_few(name, out)
            self[name] = report.stored(load(name), out)
            return self[name]

    return Stored()


@pytest.mark.whole
@pytest.mark.parametrize("name", BUILT_IN)
def test_a_study_of_one_point_and_axes_of_one_value_are_drawn(name: str, stored: Mapping[str, xr.Dataset]) -> None:
    dataset, drawing = stored[name], load_drawing(name)
    assert (dataset["case_status"] == CaseStatus.OK).all()
    # the last padding is the reference of the others
    axes = dataset["case_status"].dims
    part = dataset.isel({axis: [1 if axis == "padding" else -1] for axis in axes})
    assert [*drawing.figure(part), *drawing.tables(part)]
    drawing.findings(part)


@pytest.mark.whole
def test_the_chapter_of_effects_is_drawn_from_what_is_stored(out: Path, stored: Mapping[str, xr.Dataset]) -> None:
    effects = CHAPTERS["effects"]
    assert all(stored[part.name] is not None for part in effects.parts)
    text = report.draw_and_write(effects, out).read_text(encoding="utf-8")
    examine(text, out)
    for part in effects.parts:
        assert f'<h2 id="{part.name}">' in text
