"""Chapters of the report: their studies, the values of the axes, the figures shown; and the sections of their pages."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import chain

from contactstudy import InvalidInput
from contactstudy.domain.validation import suggestion
from studies.advice.verdict import SETTINGS
from studies.model.drawing import CaptionedFigure, Finding, Table
from studies.model.study import Study
from studies.registry import BUILT_IN, SCENES, load, outline


@dataclass(frozen=True)
class Part:
    """A study in a chapter, with other values of its `axes`, and the `figures` shown (None for all).

    Each case is timed at most ``repeats`` times: twice where a front of error against time is shown. The `title` is
    that of the study if it is empty.
    """

    name: str
    axes: Mapping[str, str] = field(default_factory=dict)
    figures: tuple[str, ...] | None = None
    repeats: int = 1
    title: str = ""

    def study(self) -> Study:
        """Return the study over the axes of this chapter."""
        return load(self.name).override(self.axes)


@dataclass(frozen=True)
class Chapter:
    """A page of the report: a title, the studies it shows in their order, and a paragraph that begins it."""

    name: str
    title: str
    parts: Sequence[Part]
    introduction: str = ""

    @property
    def page(self) -> str:
        """File name of the page."""
        return f"{self.name}.html"

    @property
    def command(self) -> str:
        """Command that makes the page."""
        return "contactstudy report" + f" {self.name}" * (self.name != MAIN.name)


@dataclass(frozen=True, eq=False)
class Section:
    """The part of a page that shows a study or answers a question.

    `name` is its anchor on the page, and `axes_text` names the axes that vary with their values. `file` is the netCDF
    file beside the page, without its ending, and the folder of the figures.
    """

    name: str
    title: str
    findings: Sequence[Finding]
    figures: Sequence[CaptionedFigure]
    tables: Sequence[Table]
    file: str
    axes_text: str = ""

    @property
    def answers(self) -> Sequence[Finding]:
        """Findings that answer a question of the reader."""
        return [item for item in self.findings if item.question]


MAIN = Chapter(
    "report",
    "Line contacts, periodic along their length: padding, accuracy and cost",
    (
        Part(SETTINGS),
        Part(
            "pareto",
            {"padding": "exact", "images": "6", "period": "2.4", "grid": "96", "solver_tolerance": "1e-8"},
            (),
            repeats=10,
            title="How many cells along?",
        ),
        Part("images", figures=("reach",), repeats=0, title="Which n, for which period?"),
        Part("grid", figures=("over_grid",), repeats=0, title="Which grid?"),
        Part("paper", figures=("pressure",), title="What the paper claims"),
        Part("rough-paddings", figures=("paddings",), repeats=0, title="Does roughness change the error of a padding?"),
        Part("stability", figures=(), title="Is it stable?"),
    ),
)
CHAPTERS = {
    chapter.name: chapter
    for chapter in (
        MAIN,
        Chapter(
            "effects",
            "Effects: coating, friction, creep, wear, yielding, films and roughness",
            tuple(Part(name) for name in SCENES if name != "rough-paddings"),
        ),
    )
}


def chapters(names: Sequence[str]) -> Sequence[Chapter]:
    """Return the chapters of some names, which may also be "all" or studies; the main chapter for no name.

    Raises :class:`~contactstudy.InvalidInput` for a name that is neither.
    """
    chosen = dict.fromkeys(chain.from_iterable(CHAPTERS if name == "all" else (name,) for name in names))
    for name in chosen:
        if name not in (*CHAPTERS, *BUILT_IN):
            choices = ["all", *CHAPTERS, *BUILT_IN]
            raise InvalidInput(f"Chapter {name!r} is not known: {suggestion(name, choices)}.")
    return [CHAPTERS.get(name) or chapter_of_study(name) for name in chosen or (MAIN.name,)]


def chapter_of_study(name: str) -> Chapter:
    """Return a study as a chapter of its own."""
    return Chapter(name, outline(name)[0].rstrip("."), (Part(name, repeats=2),))
