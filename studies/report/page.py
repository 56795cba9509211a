"""Stored studies -> figures -> one self-contained page."""

import base64
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import xarray as xr
from jinja2 import Environment, PackageLoader, StrictUndefined, select_autoescape

from contactstudy import InvalidInput
from contactstudy.domain.files import replacing
from studies.engine.progress import Progress
from studies.model.drawing import CaptionedFigure, Drawing, Finding, Table
from studies.model.study import Study
from studies.registry import BUILT_IN, load, load_drawing
from studies.report.drawings import trust
from studies.report.style import marked, plain
from studies.store.netcdf import read


def draw(study: Study, drawing: Drawing, out: Path) -> Sequence[CaptionedFigure]:
    """The figures of ``study`` as PNG and PDF in ``<out>/<study>/``, from its netCDF file alone."""
    figures = drawing.figure(_stored(study, out))
    _save(figures, out / study.name)
    return figures


def _stored(study: Study, out: Path) -> xr.Dataset:
    """What was stored of ``study``; raises InvalidInput where that has other axes, as of an earlier version."""
    path = out / f"{study.name}.nc"
    dataset = read(path)
    found = dataset["case_status"].dims if "case_status" in dataset else ()
    axes = [axis.name for axis in study.points]
    if set(found) != set(axes):
        raise InvalidInput(
            f"Study file {str(path)!r} has the axes {', '.join(map(str, found)) or 'of no study'}, and the study has "
            f"{', '.join(axes)}: run the study again."
        )
    return dataset


def _save(figures: Sequence[CaptionedFigure], folder: Path) -> None:
    given: object = figures
    is_row = isinstance(given, list | tuple)
    if not is_row or not all(isinstance(one, CaptionedFigure) for one in figures):
        raise InvalidInput(
            f"figure of {folder.name!r} gives no studies.model.drawing.CaptionedFigure: return a tuple of them, or "
            "() for none."
        )
    progress = Progress(folder.name, "drawing", len(figures), "figure", lambda text: None)
    with progress:
        for one in figures:
            _save_one(one, folder)
            progress.add()


def _save_one(one: CaptionedFigure, folder: Path) -> None:
    # lay the figure out once for both files: each file would do it again
    if engine := one.figure.get_layout_engine():
        engine.execute(one.figure)
        one.figure.set_layout_engine("none")
    for suffix in ("png", "pdf"):
        with replacing(folder / f"{one.name}.{suffix}") as path:
            one.figure.savefig(path)


def write(out: Path) -> Path:
    """Figures and ``<out>/report.html`` from the netCDF files of the built-in studies; returns its path.

    A chapter for each study in the order of ``BUILT_IN``: its title, what it swept, its findings, figures
    and tables. All findings are in the summary as well, those that answer a question before the others.
    """
    studies = {name: load(name) for name in BUILT_IN}
    stored = {name: _stored(study, out) for name, study in studies.items()}
    chapters = [
        _chapter(studies[name], load_drawing(name), dataset, out)
        for name, dataset in stored.items()
    ]
    sweeps = trust.sweeps_with_estimates(stored)
    chapters += [_estimates_chapter(sweeps, out)] if sweeps else []
    environment = Environment(
        loader=PackageLoader("studies.report", "."),
        autoescape=select_autoescape(),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters.update(marked=marked, plain=plain)
    page = environment.get_template("page.html").render(
        chapters=chapters,
        answers=_answers(chapters),
        provenance={name: dataset.attrs for name, dataset in stored.items()},
    )
    path = out / "report.html"
    with replacing(path) as partial:
        partial.write_text(page, encoding="utf-8")
    return path


@dataclass(frozen=True, eq=False)
class Chapter:
    """What the page shows of a study; ``data`` names the netCDF files behind it."""

    name: str
    title: str
    swept: Sequence[tuple[str, Sequence[object]]]
    findings: Sequence[Finding]
    figures: Sequence[Mapping[str, str]]
    tables: Sequence[Table]
    data: Sequence[str]


def _chapter(study: Study, drawing: Drawing, dataset: xr.Dataset, out: Path) -> Chapter:
    figures = drawing.figure(dataset)
    _save(figures, out / study.name)
    return Chapter(
        name=study.name,
        title=study.title.rstrip("."),
        swept=[(axis.long_name, dataset[axis.name].values.tolist()) for axis in study.points],
        findings=drawing.findings(dataset),
        figures=[_embedded(one, study.name, out) for one in figures],
        tables=drawing.tables(dataset),
        data=[study.name],
    )


def _estimates_chapter(sweeps: Mapping[str, xr.Dataset], out: Path) -> Chapter:
    """The chapter that the sweeps share: error estimates beside true errors."""
    name = "estimate_validation"
    figure = trust.estimates_figure(sweeps)
    _save([figure], out / name)
    return Chapter(
        name=name,
        title="Error estimates beside true errors",
        swept=[],
        findings=[trust.estimates_finding(sweeps)],
        figures=[_embedded(figure, name, out)],
        tables=[trust.estimates_table(sweeps)],
        data=list(sweeps),
    )


def _embedded(one: CaptionedFigure, folder: str, out: Path) -> Mapping[str, str]:
    png = base64.b64encode((out / folder / f"{one.name}.png").read_bytes())
    return {
        "file": f"{folder}/{one.name}",
        "caption": one.caption,
        "png": png.decode(),
        "width": f"{100 * one.figure.get_figwidth():.0f}",
        "height": f"{100 * one.figure.get_figheight():.0f}",
    }


def _answers(chapters: Sequence[Chapter]) -> Sequence[tuple[str, Finding]]:
    """All findings, each with its chapter: those that answer a question first."""
    found = [(chapter.name, finding) for chapter in chapters for finding in chapter.findings]
    return sorted(found, key=lambda one: not one[1].question.endswith("?"))
