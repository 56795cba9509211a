import re
import shutil
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import pytest
import xarray as xr
from matplotlib.layout_engine import ConstrainedLayoutEngine

from studies.engine.run import run
from studies.model.drawing import CaptionedFigure, Drawing, Finding, Table
from studies.model.outcome import CaseStatus
from studies.model.study import Study
from studies.reference.accuracy.matrix import matrix
from studies.registry import BUILT_IN, load, load_drawing
from studies.report import page as report
from studies.report.style import marked, panels, percent, plain, power
from tests.studies.conftest import quiet

FEW = {"grid": "16,24", "period": "0.6,2.4", "solver_tolerance": "1e-6"}
# a rough surface has a length of its own, and waves that a grid must show
ROUGH = {"rms": "0,0.1", "peklenik": "1", "hurst": "0.8", "seed": "1", "grid": "80"}
# of the accuracy cases every fortieth
SOME = {"case": ",".join(list(matrix())[::40])}
# these have axes of their own
OWN = {
    "roughness": ROUGH,
    "accuracy": SOME,
    "coating": {"ratio": "0.25,2,4", "thickness": "0.1,1,10", "grid": "64"},
    # one grid: of two, wear would want two marches with short steps to compare with
    "wear": {"grid": "16"},
    "effect_cost": {"grid": "24"},
    "plastic": {"pressure": "2,3", "steps": "2,4", "grid": "24"},
    "friction": {"poisson_ratio": "0,0.3", "grid": "65", "rough_grid": "24"},
}


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("report")
    for name in BUILT_IN:
        study = load(name)
        axes = {axis.name: FEW[axis.name] for axis in study.points if axis.name in FEW}
        few = study.override(OWN.get(name, axes))
        run(few, folder, workers=0, repeats=1, log=quiet)
    report.write(folder)
    return folder


def test_every_case_of_the_report_has_its_numbers(out: Path) -> None:
    for name in BUILT_IN:
        with xr.open_dataset(out / f"{name}.nc", decode_times=False) as dataset:
            assert (dataset["case_status"] == CaseStatus.OK).all(), name


class Page(HTMLParser):
    """Pictures, links, and that every tag is closed."""

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


def test_report_stands_alone_and_its_links_lead_somewhere(out: Path) -> None:
    text = (out / "report.html").read_text(encoding="utf-8")
    page = Page()
    page.feed(text)
    assert page.open == []
    assert len(page.sources) == len(list(out.rglob("*.png")))
    assert all(source.startswith("data:image/png;base64,") for source in page.sources)
    for link in page.links:
        assert (f'id="{link[1:]}"' in text) if link.startswith("#") else (out / link).is_file(), (
            link
        )
    assert not re.search(r"https?://|\bnan\b|\bNone\b", re.sub(r"base64,[^\"]*", "", text))


def test_every_study_leaves_netcdf_png_and_pdf(out: Path) -> None:
    for name in BUILT_IN:
        assert (out / f"{name}.nc").is_file()
        pictures = {path.stem for path in (out / name).glob("*.png")}
        assert pictures
        assert pictures == {path.stem for path in (out / name).glob("*.pdf")}
    assert not list(out.rglob("*.partial*"))


def test_report_examines_the_two_claims_with_measured_numbers(out: Path) -> None:
    text = (out / "report.html").read_text(encoding="utf-8")
    assert "n ≥ 6 gives very similar results" in text
    assert "Independent of the domain extent" in text
    assert "On a rough surface a padding has the same error as on a smooth one" in text
    # at 128 cells, from the paper's own setting
    for shown in ("1.9\xa0%", "17\xa0%", "0.050\xa0%", "31\xa0%", "527\xa0%"):
        assert shown in text


def test_report_has_a_summary_then_every_study_in_order(out: Path) -> None:
    text = (out / "report.html").read_text(encoding="utf-8")
    summary, contents, *sections = re.split(r"<nav |<section ", text)
    assert [
        re.search('aria-labelledby="(.*?)"', section)[1]  # type: ignore[index]
        for section in sections
    ] == [*BUILT_IN, "estimate_validation"]
    questions = re.findall(r'class="question">(.*?)<', summary)
    assert questions[:4] == ["Which padding?", "What does it cost?", "Which n?", "Which period?"]
    first = questions.index("The paper&#39;s first claim")
    assert questions[first + 1] == "The paper&#39;s second claim"
    for name in BUILT_IN:
        assert f'href="#{name}"' in contents
        assert f'href="{name}.nc"' in text


def test_a_study_slots_in_with_what_it_says(
    out: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shutil.copytree(out, tmp_path, dirs_exist_ok=True)
    new = replace(load("speed"), title="Something new.")
    drawing = replace(
        load_drawing("speed"),
        findings=lambda dataset: (Finding("C", "c"), Finding("A < B", "by 2.4 a", "Which is it?")),
        tables=lambda dataset: (Table("cases", ("case", "error"), (("hard", "1 %"),)),),
    )
    monkeypatch.setattr(report, "BUILT_IN", ("speed",))
    monkeypatch.setattr(report, "load", lambda name: new)
    monkeypatch.setattr(report, "load_drawing", lambda name: drawing)
    text = report.write(tmp_path).read_text(encoding="utf-8")
    assert '<h2 id="speed">Something new</h2>' in text
    assert text.count("A &lt; B") == 2  # in the summary, and in its section
    assert re.findall(r'<dt class="question">(.*?)</dt>', text) == ["Which is it?", "Speed"]
    assert '<td class="number" data-value="1 %">1 %</td>' in text
    assert 'id="estimate_validation"' not in text  # nothing stored has an estimate


@pytest.mark.parametrize("name", ["padding", "images", "period", "grid", "pareto"])
@pytest.mark.parametrize("padding", ["exact", "zero", "superposed"])
def test_figures_can_be_drawn_of_one_mode_at_one_point(
    name: str, padding: str, tmp_path: Path
) -> None:
    study: Study = load(name).override(
        {"padding": padding, "images": "1", "period": "1.2", "grid": "16"}
    )
    run(study, tmp_path, workers=0, repeats=1, log=quiet)
    report.draw(study, load_drawing(name), tmp_path)
    assert list((tmp_path / name).glob("*.png"))


@pytest.mark.parametrize(
    ("share", "text"),
    [
        (0.0, "0\xa0%"),
        (-0.0192, "1.9\xa0%"),
        (0.167, "17\xa0%"),
        (8.5e-6, "0.00085\xa0%"),
        (5.27, "527\xa0%"),
        (1e-12, "1.0e-10\xa0%"),
        (float("nan"), "not known"),
    ],
)
def test_shares_are_written_with_two_digits(share: float, text: str) -> None:
    assert percent(share) == text


@pytest.mark.parametrize(
    ("text", "html", "unmarked"),
    [
        ("2 of p_{H}", "2 of p<sub>H</sub>", "2 of p_H"),
        ("N^{−3/2} & N^{1.7}", "N<sup>−3/2</sup> &amp; N<sup>1.7</sup>", "N^−3/2 & N^1.7"),
        ("solver_tolerance, p_H, N^2", "solver_tolerance, p_H, N^2", "solver_tolerance, p_H, N^2"),
    ],
)
def test_marks_are_set_as_indices_and_powers_and_nothing_else_is(
    text: str, html: str, unmarked: str
) -> None:
    assert marked(text) == html
    assert plain(text) == unmarked


def test_a_power_is_marked() -> None:
    assert power("N", -1.5, 1) == "N^{−1.5}"


def test_a_figure_is_laid_out_once_for_both_files(out: Path, tmp_path: Path) -> None:
    laid_out = []

    class Counted(ConstrainedLayoutEngine):
        def execute(self, fig: object) -> object:
            laid_out.append(fig)
            return super().execute(fig)

    figure, (ax,) = panels(1)
    figure.set_layout_engine(Counted())
    ax.set_ylabel("two lines\nwant room")
    before = ax.get_position().x0
    shutil.copy(out / "period.nc", tmp_path)
    drawing = Drawing(lambda _: (CaptionedFigure("one", figure, "words"),))
    report.draw(load("period"), drawing, tmp_path)
    assert laid_out == [figure]
    assert ax.get_position().x0 > before
    assert {path.name for path in (tmp_path / "period").iterdir()} == {"one.png", "one.pdf"}
