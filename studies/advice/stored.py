"""A verdict as a netCDF file: written once, read by the pages."""

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from threadpoolctl import threadpool_limits

import contactstudy as cs
from contactstudy.domain.errors import Request
from contactstudy.domain.version import source_hash
from studies.advice.trials import verdict_on
from studies.advice.verdict import EVERY_NUMBER, Measured, SceneToJudge, Setting, Verdict
from studies.model.plain_text import Log
from studies.store.netcdf import check_kind, open_folder, read, write
from studies.store.provenance import provenance

SETTINGS = "settings"
# Attributes that are equal where a stored verdict is that of a scene, here and now.
MATCHED_ATTRIBUTES = ("cpu", "source", "sources", "key")
# Variables of a setting and of what was measured of it, in the order of their fields: units and long name.
COLUMNS = {
    "label": ("", "padding"),
    "padding": ("", "padding as in Python"),
    "cells_across": ("1", "number of cells across"),
    "cells_along": ("1", "number of cells along"),
    "solver_tolerance": ("1", "tolerance of a solve"),
    "pressure_bound": ("1", "bound of the relative L1 error of the pressure"),
    "error_bound": ("1", "largest bound of the relative error of a number"),
    "worst": ("", "number of the largest bound"),
    "pressure_difference": ("1", "relative L1 difference of the pressure to the reference"),
    "processor_time": ("s", "least processor time of a solve on one thread"),
}
# Attributes of a verdict, whose texts are JSON where they are not plain.
ATTRIBUTES = {
    "scene_name": "name", "scene": "text", "requested_error": "error", "measure": "measure", "own": "own",
    "extent": "extent", "reference": "reference", "notes": "notes", "named_errors": "named",
}  # fmt: skip


def path_in(out: Path) -> Path:
    """Return the file of a verdict in a folder."""
    return out / f"{SETTINGS}.nc"


def verdict_of(described: SceneToJudge, error: Request, out: Path, log: Log, measure: str = EVERY_NUMBER) -> Verdict:
    """Return the verdict on a scene that a folder has, or measure it and store it there.

    One of another error, scene, processor or program is measured again.
    """
    identity = {
        **provenance(),
        "sources": _sources(),
        "key": f"{described.key} {error!r} {measure}",
    }
    path = path_in(out)
    check_kind(path, "comparison")
    if path.is_file():
        dataset = read(path)
        if all(dataset.attrs.get(name) == identity[name] for name in MATCHED_ATTRIBUTES):
            log(f"read the measurements stored in {path}")
            return from_dataset(dataset)
    open_folder(out)  # refused before anything is measured
    with threadpool_limits(1):  # times are of one thread, and idle ones of a library count as well
        verdict = verdict_on(described, error, log, measure)
    write(to_dataset(verdict).assign_attrs(identity), path)
    return verdict


def _sources() -> str:
    """Return hashes of what solves and what compares."""
    advice = Path(__file__).parent
    return " ".join((source_hash(), source_hash(advice), source_hash(advice.parent / "reference")))


def to_dataset(verdict: Verdict) -> xr.Dataset:
    """Return a verdict as a Dataset of its settings, with the rest as attributes."""
    rows = [
        (one.setting.label, repr(one.setting.padding), *one.setting.cells, one.setting.tolerance,
         one.l1, one.error, one.worst, one.difference, one.seconds)
        for one in verdict.settings
    ]  # fmt: skip
    data = {
        name: ("setting", list(values), {"long_name": about} | ({"units": units} if units else {}))
        for (name, (units, about)), values in zip(COLUMNS.items(), zip(*rows, strict=True), strict=True)
    }
    attributes: dict[str, Any] = {key: getattr(verdict, name) for key, name in ATTRIBUTES.items()}
    for key in ("notes", "named_errors"):
        attributes[key] = json.dumps(attributes[key])
    return xr.Dataset(data, attrs={"title": f"Settings of {verdict.name}"} | attributes)


def _padding(text: str) -> cs.Padding | cs.Paddings:
    """Return the padding of a representation in Python, or both of two."""
    found = [
        getattr(cs, name)(*map(int, filter(None, [images])))
        for name, images in re.findall(r"(\w+)\((?:images=(\d+))?\)", text)
    ]
    return found[0] if len(found) == 1 else (found[0], found[1])


def from_dataset(dataset: xr.Dataset) -> Verdict:
    """Return the verdict in a Dataset."""
    rows = zip(*(dataset[name].values.tolist() for name in COLUMNS), strict=True)
    settings = tuple(
        Measured(Setting(label, _padding(padding), (across, along), tolerance), *measured)
        for label, padding, across, along, tolerance, *measured in rows
    )
    found: dict[str, Any] = {name: dataset.attrs[key] for key, name in ATTRIBUTES.items()}
    found["extent"] = tuple(np.asarray(found["extent"], float).tolist())
    found["notes"], found["named"] = tuple(json.loads(found["notes"])), json.loads(found["named"])
    return Verdict(**found, settings=settings)
