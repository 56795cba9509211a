"""Pages of the report: figures from stored studies, in one self-contained page for each chapter."""

import base64
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from time import monotonic

import xarray as xr
from jinja2 import Environment, PackageLoader, StrictUndefined, select_autoescape

from contactstudy import InvalidInput
from contactstudy.domain.files import replacing
from contactstudy.domain.validation import display_unit_of
from studies.advice.trials import path_in, verdict_of
from studies.advice.verdict import PRESSURE, SETTINGS, Verdict, from_dataset, paper_scene
from studies.engine.options import RunOptions
from studies.engine.run import run
from studies.model.drawing import CaptionedFigure, Drawing, Finding, write_figure
from studies.model.outcome import CaseStatus
from studies.model.plain_text import Log, one_line
from studies.model.study import Study
from studies.reference.paddings import padding_text
from studies.registry import BUILT_IN, load_drawing
from studies.report.chapters import CHAPTERS, MAIN, Chapter, Part, Section, chapter_of_study
from studies.report.drawings import comparison as settings
from studies.store.netcdf import read

MAX_LISTED = 10  # values of an axis that a page lists
# Requested error of the pressure of the paper's cylinder.
PAPER_ERROR = 1e-2
SCENE_INTRODUCTION = (
    "The scene was solved with every padding that it may have. Neighbouring periods can be ignored (zero), copied once "
    "(duplicated), summed over n periods on each side in a window fixed to the domain (superposed) or moving with the "
    "point (circular), or summed to infinity in closed form (exact). The error is the bound that a solve states."
)

NOTHING_TO_DRAW = Drawing(
    lambda dataset: (), lambda dataset: (Finding("No case gave numbers.", "See the variable `error` of the file."),)
)


def draw_figures(study: Study, drawing: Drawing, out: Path) -> Sequence[CaptionedFigure]:
    """Draw the figures of ``study`` into ``<out>/<study>/``, from its netCDF file alone."""
    figures = drawing.figure(stored(study, out))
    for figure in figures:
        write_figure(figure.figure, out / study.name / figure.name, ["png"])
    return figures


def stored(study: Study, out: Path) -> xr.Dataset:
    """Return the stored Dataset of a study.

    Raises :class:`~contactstudy.InvalidInput` for a file with other axes, such as one of an earlier version.
    """
    path = out / f"{study.name}.nc"
    dataset = read(path)
    dims = dataset["case_status"].dims if "case_status" in dataset else ()
    axes = [axis.name for axis in study.axes]
    if set(dims) != set(axes):
        kind = f"has the axes {', '.join(map(str, dims))}" if dims else "is not a study file"
        raise InvalidInput(f"File {str(path)!r} {kind}, and the study has {', '.join(axes)}: run the study again.")
    return dataset


def section(part: Part, dataset: xr.Dataset) -> Section:
    """Return the figures of a study that a chapter shows, with findings and tables; of what it lacks a finding."""
    study, drawing = part.study(), load_drawing(part.name)
    if not (dataset["case_status"] == CaseStatus.OK).any():
        drawing = NOTHING_TO_DRAW
    try:
        figures = drawing.figure(dataset) if part.figures != () else ()
        findings, tables = drawing.findings(dataset), drawing.tables(dataset)
    except KeyError as missing:
        lacks = f"The file lacks what is drawn of it: {one_line(str(missing.args[0]), 100)}."
        findings, tables, figures = [Finding(lacks, "Run the study again.")], (), ()
    shown = [item for item in figures if part.figures is None or item.name in part.figures]
    return Section(
        name=part.name,
        title=part.title or study.title.rstrip("."),
        findings=findings,
        figures=shown,
        tables=tables,
        file=part.name,
        axes_text=axes_text(dataset),
    )


def run_and_write(chapter: Chapter, out: Path, *, options: RunOptions, log: Log) -> Path:
    """Run the studies of a chapter, write its page, and return its path."""
    for number, part in enumerate(chapter.parts, 1):
        start, messages = monotonic(), list[str]()
        if part.name == SETTINGS:
            verdict = verdict_of(paper_scene(), PAPER_ERROR, out, log, PRESSURE)
            extent = f"{len(verdict.settings)} settings"
        else:
            study = part.study()
            timed = replace(options, repeats=part.repeats if options.repeats else 0)
            dataset = run(study, out, options=timed, log=messages.append)
            failed = ~dataset["case_status"].isin([CaseStatus.OK, CaseStatus.NOT_RUN])
            for message in messages if failed.any() else ():
                log(message)
            extent = f"{study.size} points"
        log(f"{chapter.name}: {number} of {len(chapter.parts)}, {part.name}: {extent} in {monotonic() - start:.0f} s")
    return draw_and_write(chapter, out)


def write_scene(verdict: Verdict, out: Path) -> Path:
    """Write the page about the settings of one scene, whose verdict is stored; return its path."""
    title = f"{verdict.name}: which padding and which grid"
    chapter = Chapter(MAIN.name, title, (), SCENE_INTRODUCTION)
    return write_page(chapter, settings.sections(verdict), {SETTINGS: read(path_in(out))}, out)


def draw_and_write(chapter: Chapter, out: Path) -> Path:
    """Draw a chapter from the netCDF files of its studies and write its page; return its path."""
    datasets, sections = {}, list[Section]()
    for part in chapter.parts:
        if part.name == SETTINGS:
            if not path_in(out).is_file():
                raise InvalidInput(f"Comparison {str(path_in(out))!r} does not exist: run contactstudy report first.")
            datasets[SETTINGS] = read(path_in(out))
            sections += settings.sections(from_dataset(datasets[SETTINGS]))[:1]
            continue
        datasets[part.name] = stored(part.study(), out)
        sections.append(section(part, datasets[part.name]))
    return write_page(chapter, sections, datasets, out)


def write_page(chapter: Chapter, sections: Sequence[Section], datasets: Mapping[str, xr.Dataset], out: Path) -> Path:
    """Save the figures of a chapter, write its page with the provenance of their files, and return its path."""
    environment = Environment(
        loader=PackageLoader("studies.report", "."),
        autoescape=select_autoescape(),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    page = environment.get_template("page.html").render(
        chapter=chapter,
        main=MAIN,
        main_is_there=(out / MAIN.page).is_file(),
        explored={path.name for path in out.glob("*-explore.html")},
        sections=sections,
        figures={part.name: [_embedded(figure, part.file, out) for figure in part.figures] for part in sections},
        made=_made(datasets),
        others=_others(chapter, out) if chapter.parts else (),
    )
    path = out / chapter.page
    with replacing(path) as partial:
        partial.write_text(page, encoding="utf-8")
    return path


def _embedded(drawn: CaptionedFigure, folder: str, out: Path) -> Mapping[str, str]:
    """Save a figure into ``<out>/<folder>``, and return what a page shows of it as texts.

    They are ``png`` in base64, the path of its ``file``, ``caption``, and ``width`` and ``height`` in pixels.
    """
    [path] = write_figure(drawn.figure, out / folder / drawn.name, ["png"])
    return {
        "png": base64.b64encode(path.read_bytes()).decode(),
        "file": f"{folder}/{drawn.name}.png",
        "caption": drawn.caption,
        "width": f"{100 * drawn.figure.get_figwidth():.0f}",
        "height": f"{100 * drawn.figure.get_figheight():.0f}",
    }


def _made(datasets: Mapping[str, xr.Dataset]) -> Mapping[str, str]:
    """Return what the files of a page were made with, by name; several different texts side by side."""
    made = {"files": ", ".join(f"{name}.nc" for name in datasets)}
    names = (
        "command", "git_revision", "source", "transforms", "python", "platform", "cpu", "cpu_count", "timing",
    )  # fmt: skip
    for name in names:
        key = "history" if name == "command" else name
        texts = [str(saved.attrs[key]) for saved in datasets.values() if key in saved.attrs]
        if name == "command":  # it follows the time
            texts = [text.partition(" ")[2] for text in texts]
        if texts:
            made[name.replace("_", " ")] = ", ".join(dict.fromkeys(texts))
    return made


def axes_text(dataset: xr.Dataset) -> str:
    """Return the axes with several values, in usual units, or the ends of more than ten; paddings are left out."""
    texts = []
    for name in dataset["case_status"].dims:
        coordinate = dataset[name]
        if coordinate.size < 2 or name == "padding":  # the figures name all paddings
            continue
        size, unit = 1.0, ""
        if coordinate.dtype.kind in "iuf":
            size, unit = display_unit_of(coordinate, str(coordinate.attrs.get("units", "1")))
        values = [
            padding_text(value) if isinstance(value, str) else f"{value / size:.6g}"
            for value in coordinate.values.tolist()
        ]
        text = ", ".join(values)
        if len(values) > MAX_LISTED:
            text = f"{len(values)} values"
            text += f" from {values[0]} to {values[-1]}" * (coordinate.dtype.kind in "iuf")
        long_name = str(coordinate.attrs.get("long_name", name)).partition(" (")[0]
        texts.append(f"{long_name}: {text} {unit}".rstrip())
    return "; ".join(texts)


def _others(chapter: Chapter, out: Path) -> Sequence[tuple[Chapter, bool]]:
    """Return all other chapters and the studies in no chapter, each with whether its page is there."""
    shown = {part.name for entry in CHAPTERS.values() for part in entry.parts}
    chapters = [entry for entry in CHAPTERS.values() if entry != chapter]
    chapters += [chapter_of_study(name) for name in BUILT_IN if name not in shown]
    return [(entry, (out / entry.page).is_file()) for entry in chapters]
