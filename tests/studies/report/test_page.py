import re
from collections.abc import Iterable, Mapping
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import pytest
import xarray as xr

from contactstudy import InvalidInput
from studies.advice.trials import verdict_of
from studies.advice.verdict import PRESSURE, paper_scene
from studies.engine.options import RunOptions
from studies.engine.run import run
from studies.model.drawing import Finding, Table
from studies.model.outcome import CaseStatus, summary_messages
from studies.model.study import Study
from studies.registry import BUILT_IN, load, load_drawing
from studies.report import page as report
from studies.report.chapters import (
    CHAPTERS,
    MAIN,
    SETTINGS,
    Chapter,
    Part,
    chapter_of_study,
    chapters,
)
from tests.studies.conftest import quiet

FEW = {"grid": "16,24", "period": "0.6,2.4", "solver_tolerance": "1e-6"}


HARD = {"case": "load of 1e-30 N/m,a step,one iteration,hardness below the mean pressure"}

OWN: Mapping[str, Mapping[str, str]] = {
    "stability": HARD,
    "grid": {"grid": "16,24,32"},
    "paper": {},
    "pareto": {"grid": "16,24", "images": "1", "solver_tolerance": "1e-6"},
    "images": {"grid": "24", "images": "0,1,6"},
}


def few(name: str) -> Study:
    study = load(name)
    axes = {axis.name: FEW[axis.name] for axis in study.axes if axis.name in FEW}
    return study.override(OWN.get(name, axes))


def run_few(names: Iterable[str], folder: Path) -> None:
    for name in names:
        run(few(name), folder, workers=1, repeats=1, log=quiet)


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The main chapter of few cases."""
    folder = tmp_path_factory.mktemp("report")
    run_few([part.name for part in MAIN.parts if part.name != SETTINGS], folder)
    verdict_of(paper_scene(), 1e-2, folder, quiet, PRESSURE)
    report.draw_and_write(MAIN, folder)
    return folder


@pytest.fixture(scope="module")
def text(out: Path) -> str:
    return (out / "report.html").read_text(encoding="utf-8")


class Page(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.sources: list[str] = []
        self.links: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        self.sources += [given["src"] or ""] if "src" in given else []
        self.links += [given["href"] or ""] if "href" in given else []
        if tag not in ("meta", "br", "img", "link"):
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


def examine(text: str, folder: Path, figures: int) -> None:
    """A page stands alone, and its links introduction somewhere."""
    page = Page()
    page.feed(text)
    assert page.open == []
    assert len(page.sources) == figures
    assert all(source.startswith("data:image/png;base64,") for source in page.sources)
    for link in page.links:
        there = f'id="{link[1:]}"' in text if link.startswith("#") else (folder / link).is_file()
        assert there, link
    assert not re.search(r"https?://|\bnan\b|\bNone\b", re.sub(r"base64,[^\"]*", "", text))


@pytest.mark.whole
def test_the_report_stands_alone_and_its_links_lead_somewhere(out: Path, text: str) -> None:
    examine(text, out, len(list(out.rglob("*.png"))))
    assert not list(out.rglob("*.partial*"))


@pytest.mark.whole
def test_the_claims_of_the_paper_stand_with_measured_numbers(text: str) -> None:
    for claim in ("n ≥ 6 gives very similar results", "Independent of the domain extent"):
        assert claim in text
    # beside the axis, near a^2 / (8 D^2) at D = L = 3 a and (6 + 1/2) L; the variation along the length with n = 1
    for shown in ("1.3\xa0%", "0.038\xa0%", "28\xa0%"):
        assert shown in text


@pytest.mark.parametrize(
    ("names", "pages"),
    [
        ((), ["report"]),
        (("grid", "coating", "grid"), ["grid", "coating"]),
        (("all",), ["report", "effects"]),
    ],
)
def test_chapters_are_named_and_any_study_is_one(names: tuple[str, ...], pages: list[str]) -> None:
    assert [chapter.name for chapter in chapters(names)] == pages


def test_a_chapter_that_is_not_there_is_refused_with_a_remedy() -> None:
    with pytest.raises(InvalidInput, match=r"^Chapter 'efects' is not known: did you mean 'effects'"):
        chapters(("efects",))


def test_a_chapter_is_run_with_a_line_a_study_and_later_drawn_by_itself(tmp_path: Path) -> None:
    axes = {"padding": "exact,duplicated", "period": "0.6,2.4", "images": "1", "grid": "16"}
    chapter = Chapter("two", "Two studies", (Part("period", axes), Part("images", axes)))
    lines: list[str] = []
    options = RunOptions(workers=0, repeats=0)
    path = report.run_and_write(chapter, tmp_path, options=options, log=lines.append)
    assert [line.partition(" points")[0] for line in lines] == [
        "two: 1 of 2, period: 4",
        "two: 2 of 2, images: 4",
    ]
    text = path.read_text(encoding="utf-8")
    examine(text, tmp_path, 3)
    assert {file.name for file in tmp_path.rglob("*.png")} == {"reach.png", "over_period.png"}
    page = report.draw_and_write(chapter_of_study("period"), tmp_path)
    assert "A chapter of" in page.read_text(encoding="utf-8")


def test_a_failed_case_is_told_in_the_log(tmp_path: Path) -> None:
    lines: list[str] = []
    chapter = chapter_of_study("stability")
    part = replace(chapter.parts[0], axes={"case": "load of 1e-30 N/m"})
    chapter = replace(chapter, parts=(part,))
    options = RunOptions(workers=1, time_limit=1e-6, repeats=1)
    page = report.run_and_write(chapter, tmp_path, options=options, log=lines.append)
    assert len(lines) > 1
    assert any("not done after" in line for line in lines)
    assert "No case gave numbers." in page.read_text(encoding="utf-8")


@pytest.mark.whole
def test_a_study_slots_in_with_what_it_says(out: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    drawing = replace(
        load_drawing("images"),
        findings=lambda dataset: (Finding("C", "c"), Finding("A < B", "by 2.4 a", "Which is it?")),
        tables=lambda dataset: (Table("cases", ("case", "error"), (("hard", "1 %"),)),),
    )
    monkeypatch.setattr(report, "load_drawing", lambda name: drawing)
    (out / "images-explore.html").write_text("", encoding="utf-8")
    text = report.draw_and_write(chapter_of_study("images"), out).read_text(encoding="utf-8")
    for page in ("images.html", "images-explore.html"):
        (out / page).unlink()
    assert '<a href="images-explore.html">Look into images</a>' in text
    assert text.count("A &lt; B") == 2  # in the summary, and in its section
    assert re.findall(r'<dt class="question">(.*?)</dt>', text) == ["Which is it?"]
    assert '<td class="number" data-value="1 %">1 %</td>' in text


@pytest.fixture(scope="module")
def stored(out: Path, tmp_path_factory: pytest.TempPathFactory) -> Mapping[str, xr.Dataset]:
    """Datasets of few cases of each study, made when they are first asked for."""

    class Stored(dict[str, xr.Dataset]):
        def __missing__(self, name: str) -> xr.Dataset:
            if not (out / f"{name}.nc").is_file():
                run_few([name], out)
            self[name] = report.stored(load(name), out)
            return self[name]

    return Stored()


@pytest.mark.whole
@pytest.mark.parametrize("name", BUILT_IN)
def test_a_study_of_one_point_and_axes_of_one_value_are_drawn(name: str, stored: Mapping[str, xr.Dataset]) -> None:
    dataset, drawing = stored[name], load_drawing(name)
    # the last padding is the reference of the others
    axes = dataset["case_status"].dims
    part = dataset.isel({axis: [1 if axis == "padding" else -1] for axis in axes})
    assert [*drawing.figure(part), *drawing.tables(part)]
    drawing.findings(part)


@pytest.mark.whole
@pytest.mark.parametrize("name", [name for name in CHAPTERS if name != MAIN.name])
def test_every_chapter_is_drawn_from_what_is_stored(name: str, out: Path, stored: Mapping[str, xr.Dataset]) -> None:
    for part in CHAPTERS[name].parts:
        dataset = stored[part.name]
        assert (dataset["case_status"] == CaseStatus.OK).all(), [*summary_messages(dataset)]
    text = report.draw_and_write(CHAPTERS[name], out).read_text(encoding="utf-8")
    examine(text, out, text.count("<figure "))
    for part in CHAPTERS[name].parts:
        assert f'<h2 id="{part.name}">' in text
