"""Stored studies -> figures -> one self-contained page."""

import base64
from collections.abc import Sequence
from pathlib import Path

import xarray as xr
from jinja2 import Environment, PackageLoader, StrictUndefined, select_autoescape

from studies.findings import accuracy_table, decade_table, findings, price_table
from studies.store import read, replacing
from studies.study import BUILT_IN, Plate, Study, load
from studies.style import save


def draw(study: Study, out: Path) -> Sequence[Plate]:
    """The plates of ``study`` as PNG and PDF in ``<out>/<study>/``, from its netCDF alone."""
    return _draw(study, read(out / f"{study.name}.nc"), out)


def _draw(study: Study, dataset: xr.Dataset, out: Path) -> Sequence[Plate]:
    plates = study.figure(dataset)
    save(plates, out / study.name)
    return plates


def write(out: Path) -> Path:
    """Figures and ``<out>/report.html`` from the netCDF files of the built-in studies; returns its path."""
    stored = {name: read(out / f"{name}.nc") for name in BUILT_IN}
    chapters = [_chapter(load(name), dataset, out) for name, dataset in stored.items()]
    environment = Environment(
        loader=PackageLoader("studies", "."),
        autoescape=select_autoescape(),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    page = environment.get_template("report.html").render(
        findings=findings(stored),
        tables=(
            accuracy_table(stored["paper"]),
            price_table(stored["padding"]),
            decade_table(stored["pareto"]),
        ),
        text_columns=("padding", "cheapest padding", "period"),
        chapters=chapters,
        provenance={name: dataset.attrs for name, dataset in stored.items()},
    )
    path = out / "report.html"
    with replacing(path) as partial:
        partial.write_text(page, encoding="utf-8")
    return path


def _chapter(study: Study, dataset: xr.Dataset, out: Path) -> dict[str, object]:
    return {
        "name": study.name,
        "title": study.title.rstrip("."),
        "plates": [_plate(plate, out / study.name) for plate in _draw(study, dataset, out)],
    }


def _plate(plate: Plate, folder: Path) -> dict[str, str]:
    picture = base64.b64encode((folder / f"{plate.name}.png").read_bytes())
    return {
        "name": plate.name,
        "caption": plate.caption,
        "picture": picture.decode(),
        "width": f"{100 * plate.figure.get_figwidth():.0f}px",
    }
