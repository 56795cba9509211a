"""A verdict as a netCDF file: written once, read by the pages."""

import json
import re
from pathlib import Path

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
LABELS = {
    "pressure_bound": ("1", "bound of the relative L1 error of the pressure"),
    "error_bound": ("1", "largest bound of the relative error of a number"),
    "pressure_difference": ("1", "relative L1 difference of the pressure to the reference"),
    "processor_time": ("s", "least processor time of a solve on one thread"),
}


def path_in(out: Path) -> Path:
    """Return the file of a verdict in a folder."""
    return out / f"{SETTINGS}.nc"


def verdict_of(
    described: SceneToJudge, error: Request, out: Path, log: Log, measure: str = EVERY_NUMBER
) -> Verdict:
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
    settings = [one.setting for one in verdict.settings]
    numbers = {
        "pressure_bound": [one.l1 for one in verdict.settings],
        "error_bound": [one.error for one in verdict.settings],
        "pressure_difference": [one.difference for one in verdict.settings],
        "processor_time": [one.seconds for one in verdict.settings],
    }
    labelled = {
        name: ("setting", numbers[name], {"units": units, "long_name": long_name})
        for name, (units, long_name) in LABELS.items()
    }
    tolerance = {"units": "1", "long_name": "tolerance of a solve"}
    data = {
        "label": ("setting", [one.label for one in settings], {"long_name": "padding"}),
        "padding": ("setting", [repr(one.padding) for one in settings], {"long_name": "padding as in Python"}),
        "cells": (("setting", "axis"), [one.cells for one in settings], {"units": "1", "long_name": "number of cells"}),
        "solver_tolerance": ("setting", [one.tolerance for one in settings], tolerance),
        "worst": ("setting", [one.worst for one in verdict.settings], {"long_name": "number of the largest bound"}),
        **labelled,
    }  # fmt: skip
    texts = {name: getattr(verdict, name) for name in ("measure", "own", "reference")}
    attributes = {
        "title": f"Settings of {verdict.name}", "scene_name": verdict.name, "scene": verdict.text,
        "requested_error": verdict.error, "extent": verdict.extent, **texts,
    }  # fmt: skip
    if verdict.named:
        attributes["named_errors"] = json.dumps(verdict.named)
    if verdict.notes:
        attributes["notes"] = json.dumps(verdict.notes)
    axis = ("axis", ["across", "along"], {"long_name": "direction of the cells"})
    return xr.Dataset(data, {"axis": axis}, attributes)


def _padding(text: str) -> cs.Padding | cs.Paddings:
    """Return the padding of a representation in Python, or both of two."""
    found = [
        getattr(cs, name)(*map(int, filter(None, [images])))
        for name, images in re.findall(r"(\w+)\((?:images=(\d+))?\)", text)
    ]
    return found[0] if len(found) == 1 else (found[0], found[1])


def from_dataset(dataset: xr.Dataset) -> Verdict:
    """Return the verdict in a Dataset."""
    values = {str(name): variable.values.tolist() for name, variable in dataset.variables.items()}
    names = ("label", "padding", "cells", "solver_tolerance", "worst", *LABELS)
    settings = tuple(
        Measured(
            Setting(label, _padding(padding), (cells[0], cells[1]), tolerance), l1, error, worst, difference, seconds
        )
        for label, padding, cells, tolerance, worst, l1, error, difference, seconds in zip(
            *(values[name] for name in names), strict=True
        )
    )  # fmt: skip
    attributes = dataset.attrs
    width, length = np.asarray(attributes["extent"], float).tolist()
    return Verdict(
        attributes["scene_name"], attributes["scene"], float(attributes["requested_error"]), attributes["measure"],
        (width, length), attributes["own"], attributes["reference"], settings,
        tuple(json.loads(attributes.get("notes", "[]"))), json.loads(attributes.get("named_errors", "{}")),
    )  # fmt: skip
