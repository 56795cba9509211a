"""Stored studies -> figures -> one self-contained page."""

import base64
import io
from pathlib import Path

import xarray as xr
from jinja2 import Environment, PackageLoader, StrictUndefined, select_autoescape

from studies.findings import accuracy_table, findings, price_table
from studies.store import read, replacing
from studies.study import BUILT_IN, Plate, Study, load
from studies.style import save


def draw(study: Study, out: Path) -> None:
    """The plates of ``study`` as PNG and PDF in ``<out>/<study>/``, from its netCDF alone."""
    save(study.figure(read(out / f"{study.name}.nc")), out / study.name)


def write(out: Path) -> Path:
    """``<out>/report.html`` from the netCDF files of the built-in studies; returns its path."""
    stored = {name: read(out / f"{name}.nc") for name in BUILT_IN}
    chapters = [_chapter(load(name), dataset) for name, dataset in stored.items()]
    environment = Environment(
        loader=PackageLoader("studies", "."),
        autoescape=select_autoescape(),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    page = environment.get_template("report.html").render(
        findings=findings(stored),
        tables=(accuracy_table(stored["paper"]), price_table(stored["padding"])),
        text_columns=("padding", "cheapest padding", "period"),
        chapters=chapters,
        provenance=stored["padding"].attrs,
    )
    path = out / "report.html"
    with replacing(path) as partial:
        partial.write_text(page, encoding="utf-8")
    return path


def _chapter(study: Study, dataset: xr.Dataset) -> dict[str, object]:
    return {
        "name": study.name,
        "title": dataset.attrs["title"],
        "plates": [_plate(plate) for plate in study.figure(dataset)],
    }


def _plate(plate: Plate) -> dict[str, str]:
    buffer = io.BytesIO()
    plate.figure.savefig(buffer, format="png")
    picture = base64.b64encode(buffer.getvalue()).decode()
    return {
        "name": plate.name,
        "caption": plate.caption,
        "picture": picture,
        "width": f"{100 * plate.figure.get_figwidth():.0f}px",
    }
