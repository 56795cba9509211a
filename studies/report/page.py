"""Stored studies -> figures -> one self-contained page."""

import base64
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import xarray as xr
from jinja2 import Environment, PackageLoader, StrictUndefined, select_autoescape
from markupsafe import Markup, escape

from studies.model.finding import Finding, Table
from studies.model.study import Plate, Study
from studies.registry import BUILT_IN, load
from studies.report.findings import estimates as trust
from studies.store.netcdf import read, replacing


def draw(study: Study, out: Path) -> Sequence[Plate]:
    """The plates of ``study`` as PNG and PDF in ``<out>/<study>/``, from its netCDF alone."""
    return _draw(study, read(out / f"{study.name}.nc"), out)


def _draw(study: Study, dataset: xr.Dataset, out: Path) -> Sequence[Plate]:
    plates = study.figure(dataset)
    _save(plates, out / study.name)
    return plates


def _save(plates: Sequence[Plate], folder: Path) -> None:
    for plate in plates:
        # laid out once for both files: each would draw itself once more to find the same
        if engine := plate.figure.get_layout_engine():
            engine.execute(plate.figure)
            plate.figure.set_layout_engine("none")
        for suffix in ("png", "pdf"):
            with replacing(folder / f"{plate.name}.{suffix}") as path:
                plate.figure.savefig(path)


def write(out: Path) -> Path:
    """Figures and ``<out>/report.html`` from the netCDF files of the built-in studies; returns its path.

    A chapter for each study in the order of ``BUILT_IN``: its title, what it swept, its findings, plates
    and tables. All findings are in the summary as well, those that answer a question before the others.
    """
    stored = {name: read(out / f"{name}.nc") for name in BUILT_IN}
    chapters = [_chapter(load(name), dataset, out) for name, dataset in stored.items()]
    sweeps = trust.compared(stored)
    chapters += [_trusted(sweeps, out)] if sweeps else []
    environment = Environment(
        loader=PackageLoader("studies.report", "."),
        autoescape=select_autoescape(),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["formulas"] = formulas
    page = environment.get_template("page.html").render(
        chapters=chapters,
        answers=_answers(chapters),
        provenance={name: dataset.attrs for name, dataset in stored.items()},
    )
    path = out / "report.html"
    with replacing(path) as partial:
        partial.write_text(page, encoding="utf-8")
    return path


def formulas(text: str) -> Markup:
    """``text`` with its indices and powers, written p_H, N^2, N^(-3/2) and 7.9e-06, set as such."""
    marked = re.sub(r"\b([a-zA-Z])_([a-zA-Z])\b", r"\1<sub>\2</sub>", str(escape(text)))
    marked = re.sub(r"\^(?:\(([^()]*)\)|(-?\d+(?:\.\d+)?))", r"<sup>\1\2</sup>", marked)
    marked = re.sub(r"(?<![\w.])-(?=\d)", "−", marked)
    marked = re.sub(r"(?<![\w.])1e-0?(\d+)\b", r"10<sup>−\1</sup>", marked)
    marked = re.sub(r"(?<=\d)e-0?(\d+)\b", r"·10<sup>−\1</sup>", marked)
    # a number and its unit stay on one line
    return Markup(re.sub(r"(?<=\d) (?=(?:%|a|s)(?!\w))", "\u00a0", marked))


@dataclass(frozen=True, eq=False)
class Chapter:
    """What the page shows of a study; ``data`` names the netCDF files behind it."""

    name: str
    title: str
    swept: Sequence[tuple[str, Sequence[object]]]
    findings: Sequence[Finding]
    plates: Sequence[Mapping[str, str]]
    tables: Sequence[Table]
    data: Sequence[str]


def _chapter(study: Study, dataset: xr.Dataset, out: Path) -> Chapter:
    return Chapter(
        name=study.name,
        title=study.title.rstrip("."),
        swept=[(axis.long_name, dataset[axis.name].values.tolist()) for axis in study.points],
        findings=study.findings(dataset),
        plates=[_plate(plate, study.name, out) for plate in _draw(study, dataset, out)],
        tables=study.tables(dataset),
        data=[study.name],
    )


def _trusted(sweeps: Mapping[str, xr.Dataset], out: Path) -> Chapter:
    """The chapter that the sweeps share: what their error estimates are worth."""
    plate = trust.figure(sweeps)
    _save([plate], out / "trust")
    return Chapter(
        name="trust",
        title="Error estimates beside true errors",
        swept=[],
        findings=[trust.finding(sweeps)],
        plates=[_plate(plate, "trust", out)],
        tables=[trust.table(sweeps)],
        data=list(sweeps),
    )


def _plate(plate: Plate, folder: str, out: Path) -> Mapping[str, str]:
    picture = base64.b64encode((out / folder / f"{plate.name}.png").read_bytes())
    return {
        "file": f"{folder}/{plate.name}",
        "caption": plate.caption,
        "picture": picture.decode(),
        "width": f"{100 * plate.figure.get_figwidth():.0f}",
        "height": f"{100 * plate.figure.get_figheight():.0f}",
    }


def _answers(chapters: Sequence[Chapter]) -> Sequence[tuple[str, Finding]]:
    """All findings, each with its chapter: those that answer a question first."""
    found = [(chapter.name, finding) for chapter in chapters for finding in chapter.findings]
    return sorted(found, key=lambda one: not one[1].question.endswith("?"))
