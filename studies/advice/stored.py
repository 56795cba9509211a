"""A comparison as a netCDF file: written once, read by the report and by recommendations."""

import json
from collections.abc import Sequence
from dataclasses import replace
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

import contactstudy as cs
from contactstudy.domain.version import source_hash
from studies.advice.compared_scene import SceneText, Setting
from studies.advice.comparison import Comparison, MeasuredPadding, MeasuredSetting, name_and_images
from studies.advice.measuring import compare_settings
from studies.advice.nested_answers import Budget
from studies.model.plain_text import Log
from studies.reference.line_contact import padding_at
from studies.store.netcdf import check_kind, open_folder, read, write
from studies.store.provenance import provenance

SETTINGS = "settings"
# Attributes that must be equal for stored times and errors to be those of a scene, here and now.
MATCHED_ATTRIBUTES = ("cpu", "source", "sources", "key")
ERROR, TIME = (
    {"units": "1", "long_name": "relative L1 error"},
    {"units": "s", "long_name": "processor time"},
)
# Variables of a setting in the order in which it is made.
SETTING = (
    "padding", "cells_across", "cells_along", "solver_tolerance", "label", "pressure_error_l1", "is_bounded", "time_all",
    "time_in_rounds",
)  # fmt: skip
# Fields of a comparison that are kept as JSON.
AS_JSON = (
    "name", "text", "extent", "error", "reference_bound", "reference", "paddings_on", "bounds", "notes",
    "seconds", "budget",
)  # fmt: skip


def path_in(out: Path) -> Path:
    """Return the file of a comparison in a folder."""
    return out / f"{SETTINGS}.nc"


def store(comparison: Comparison, key: str, out: Path) -> xr.Dataset:
    """Write the comparison of a scene with a key into a folder, and return its Dataset."""
    dataset = to_dataset(comparison).assign_attrs(_identity(key))
    write(dataset, path_in(out))
    return dataset


def _identity(key: str) -> dict[str, str]:
    """Return what a comparison is stored under: its provenance, hashes of what solves and compares, and its key."""
    advice = Path(__file__).parent
    hashes = source_hash(), source_hash(advice), source_hash(advice.parent / "reference")
    return {**provenance(), "sources": " ".join(hashes), "key": key}


def stored(key: str, out: Path) -> Comparison | None:
    """Return the comparison of a scene that a folder has; None if it has none of its key, program and processor.

    Raises :class:`~contactstudy.InvalidInput` if the file in its place holds a study or a solution.
    """
    check_kind(path_in(out), "comparison")
    if not path_in(out).is_file():
        return None
    dataset = read(path_in(out))
    now = _identity(key)
    if any(dataset.attrs.get(name) != now[name] for name in MATCHED_ATTRIBUTES):
        return None
    return from_dataset(dataset)


def comparison_of(
    described: SceneText, error: float, budget: Budget, out: Path, log: Log
) -> Comparison:
    """Return the comparison of a scene that a folder has, if it answers the request; else measure and store it.

    The request is a relative L1 error of the pressure. A comparison that does not meet it answers it unless there are
    more seconds in the budget now.
    """
    comparison = stored(described.key, out)
    if comparison is not None:
        verdict = comparison.verdict(error)
        had_time = comparison.error == error and budget.seconds <= comparison.budget
        if had_time or (verdict is not None and verdict.meets and verdict.best.rounds):
            log(f"read the rounds stored in {path_in(out)}")
            return replace(comparison, error=error)
    folder = open_folder(out)  # refused before anything is measured
    comparison = compare_settings(described.subject(error), error, budget, log)
    store(comparison, described.key, folder)
    return comparison


def to_dataset(comparison: Comparison) -> xr.Dataset:
    """Return a comparison as a Dataset: settings, what each padding and tolerance does alone, the rest as JSON."""
    settings, paddings = comparison.settings, comparison.paddings
    quantities = sorted({name for item in paddings for name in item.changes})
    changes = [[item.changes.get(name, np.nan) for name in quantities] for item in paddings]
    table = np.array(changes).reshape(len(paddings), len(quantities))
    data = {
        "padding": ("setting", [as_text(item.setting.padding) for item in settings]),
        "label": ("setting", [item.label for item in settings]),
        "cells_across": ("setting", [item.setting.cells[0] for item in settings]),
        "cells_along": ("setting", [item.setting.cells[1] for item in settings]),
        "solver_tolerance": ("setting", [item.setting.tolerance for item in settings]),
        "pressure_error_l1": ("setting", [item.error for item in settings], ERROR),
        "is_bounded": ("setting", [int(item.is_bounded) for item in settings]),
        "time_all": (("setting", "repeat"), _padded([item.seconds for item in settings]), TIME),
        "time_in_rounds": (("setting", "round"), _padded([item.rounds for item in settings]), TIME),
        "padding_alone": ("alone", [as_text(item.padding) for item in paddings]),
        "padding_error_l1": ("alone", [item.l1 for item in paddings], ERROR),
        "padding_change": (("alone", "quantity"), table),
        "tolerance_error_l1": ("tolerance", list(comparison.tolerances.values()), ERROR),
    }
    names = np.array(quantities, dtype=object)
    coords = {"quantity": names, "tolerance": list(comparison.tolerances)}
    texts = {name: getattr(comparison, name) for name in AS_JSON}
    attributes = {
        "title": f"Settings of {comparison.name}", "scene": comparison.text, "own": as_text(comparison.boundary),
        "comparison": json.dumps(texts),
    }  # fmt: skip
    return xr.Dataset(data, coords, attributes)


def from_dataset(dataset: xr.Dataset) -> Comparison:
    """Return the comparison in a Dataset."""
    variables = dataset.variables
    values: dict[str, list[Any]] = {
        str(name): variables[name].values.tolist() for name in variables
    }
    rows = zip(*(values[name] for name in SETTING), strict=True)
    settings = tuple(
        MeasuredSetting(
            Setting(from_text(padding), (across, along), tolerance),
            label, error, bool(bounded), _known(times), _known(rounds),
        )
        for padding, across, along, tolerance, label, error, bounded, times, rounds in rows
    )  # fmt: skip
    columns = (values[name] for name in ("padding_alone", "padding_error_l1", "padding_change"))
    paddings = tuple(
        MeasuredPadding(
            from_text(text), error, {name: part for name, part in row if isfinite(part)}
        )
        for text, error, changes in zip(*columns, strict=True)
        for row in [zip(values["quantity"], changes, strict=True)]
    )
    attributes = json.loads(dataset.attrs["comparison"])
    tuples = {name: tuple(value) for name, value in attributes.items() if isinstance(value, list)}
    return Comparison(
        **attributes | tuples,
        boundary=from_text(dataset.attrs["own"]),
        paddings=paddings,
        tolerances=dict(zip(values["tolerance"], values["tolerance_error_l1"], strict=True)),
        settings=settings,
    )


def as_text(padding: cs.Padding | cs.Paddings) -> str:
    """Return a padding as text, such as "circular 6", or "zero 0, zero 0" for two axes."""
    if isinstance(padding, tuple):
        return ", ".join(as_text(axis) for axis in padding)
    name, images = name_and_images(padding)
    return f"{name} {images}"


def from_text(text: str) -> cs.Padding | cs.Paddings:
    """Return the padding of a text."""
    parts = [part.split(" ") for part in text.split(", ")]
    paddings = [padding_at(name, int(images)) for name, images in parts]
    return paddings[0] if len(paddings) == 1 else (paddings[0], paddings[1])


def _padded(rows: Sequence[tuple[float, ...]]) -> np.ndarray:
    """Return times of all settings in rows of one length, filled with nan."""
    padded = np.full((len(rows), max([1, *map(len, rows)])), np.nan)
    for line, row in zip(padded, rows, strict=True):
        line[: len(row)] = row
    return padded


def _known(times: Sequence[float]) -> tuple[float, ...]:
    """Return the times that are not nan."""
    return tuple(second for second in times if isfinite(second))
