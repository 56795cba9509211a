"""A comparison as a netCDF file: written once, read by the report and by recommendations."""

import json
from collections.abc import Mapping
from math import inf, isfinite
from pathlib import Path

import numpy as np
import xarray as xr

import contactstudy as cs
from studies.advice.comparison import Comparison, Measured, PaddingError, mode_of
from studies.advice.subject import Setting
from studies.reference.line_contact import padding_at
from studies.store.netcdf import read, write
from studies.store.provenance import provenance

NAME = "settings"
# Attributes that must be equal for stored times and errors to be those of a scene, here and now.
MATCHED_ATTRIBUTES = ("cpu", "source", "git_revision", "key")


def path_in(out: Path) -> Path:
    """Return the file of a comparison in a folder."""
    return out / f"{NAME}.nc"


def store(measured: Comparison, key: str, out: Path) -> xr.Dataset:
    """Write the comparison of a scene with a key into a folder, and return its Dataset."""
    dataset = to_dataset(measured).assign_attrs({**provenance(), "key": key})
    write(dataset, path_in(out))
    return dataset


def stored(key: str, out: Path) -> Comparison | None:
    """Return the comparison of a scene that a folder has; None if it has none of its key, program and processor."""
    if not path_in(out).is_file():
        return None
    dataset = read(path_in(out))
    now = {**provenance(), "key": key}
    if any(dataset.attrs.get(name) != now[name] for name in MATCHED_ATTRIBUTES):
        return None
    return from_dataset(dataset)


def to_dataset(measured: Comparison) -> xr.Dataset:
    """Return a comparison as a Dataset."""
    settings = measured.settings
    changes = sorted({name for item in measured.paddings for name in item.changes})
    bounds = list(measured.bounds)

    def dimensionless(dims: str | tuple[str, ...], values: object, what: str) -> xr.Variable:
        return xr.Variable(dims, values, {"units": "1", "long_name": what})

    data = {
        "padding": ("setting", [as_text(item.setting.padding) for item in settings]),
        "label": ("setting", [item.label for item in settings]),
        "cells_across": ("setting", [item.setting.cells[0] for item in settings]),
        "cells_along": ("setting", [item.setting.cells[1] for item in settings]),
        "solver_tolerance": ("setting", [item.setting.tolerance for item in settings]),
        "pressure_error_l1": dimensionless(
            "setting", [item.error for item in settings], "relative L1 error of the pressure"
        ),
        "is_bounded": ("setting", [int(item.is_bounded) for item in settings]),
        "time_all": _times([item.seconds for item in settings], "repeat"),
        "time_in_rounds": _times([item.rounds for item in settings], "round"),
        "padding_alone": ("alone", [as_text(item.padding) for item in measured.paddings]),
        "padding_error_l1": dimensionless(
            "alone",
            [item.l1 for item in measured.paddings],
            "relative L1 error of the pressure by the padding alone",
        ),
        "padding_change": dimensionless(
            ("alone", "quantity"),
            np.array(
                [[item.changes.get(name, np.nan) for name in changes] for item in measured.paddings]
            ).reshape(len(measured.paddings), len(changes)),
            "relative change by the padding alone",
        ),
        "tolerance_error_l1": dimensionless(
            "tolerance",
            list(measured.tolerances.values()),
            "relative L1 error of the pressure by the tolerance",
        ),
        "reference_bound": dimensionless(
            "bound", [measured.bounds[name] for name in bounds], "bound on the reference's error"
        ),
    }
    coords = {
        "quantity": ("quantity", np.array(changes, dtype=object)),
        "tolerance": ("tolerance", list(measured.tolerances)),
        "bound": ("bound", np.array(bounds, dtype=object)),
    }
    attributes = {
        "title": f"Settings of {measured.name}",
        "scene_name": measured.name,
        "scene": measured.text,
        "extent": list(measured.extent),
        "own": as_text(measured.own),
        "requested_error": measured.error,
        "floor": measured.floor,
        "reference_cells": list(measured.reference or (0, 0)),
        "paddings_on": list(measured.paddings_on),
        "notes": json.dumps(measured.notes),
        "seconds": measured.spent,
    }
    return xr.Dataset(data, coords, attributes)


def from_dataset(dataset: xr.Dataset) -> Comparison:
    """Return the comparison in a Dataset."""
    attributes = dataset.attrs
    settings = tuple(
        Measured(
            Setting(
                from_text(str(row["padding"].values)),
                (int(row["cells_across"]), int(row["cells_along"])),
                float(row["solver_tolerance"]),
            ),
            str(row["label"].values),
            float(row["pressure_error_l1"]),
            bool(row["is_bounded"]),
            _known(row["time_all"]),
            _known(row["time_in_rounds"]),
        )
        for row in (dataset.isel(setting=k) for k in range(dataset.sizes["setting"]))
    )
    quantities = [str(name) for name in dataset["quantity"].values]
    paddings = tuple(
        PaddingError(
            from_text(str(row["padding_alone"].values)),
            float(row["padding_error_l1"]),
            _changes(quantities, row["padding_change"].values),
        )
        for row in (dataset.isel(alone=k) for k in range(dataset.sizes["alone"]))
    )
    reference = tuple(int(cells) for cells in attributes["reference_cells"])
    width, length = map(float, attributes["extent"])
    across, along = map(int, attributes["paddings_on"])
    return Comparison(
        name=str(attributes["scene_name"]),
        text=str(attributes["scene"]),
        extent=(width, length),
        own=from_text(attributes["own"]),
        error=float(attributes["requested_error"]),
        floor=float(attributes["floor"]),
        reference=(reference[0], reference[1]) if reference[0] else None,
        bounds={
            str(name): float(value)
            for name, value in zip(
                dataset["bound"].values, dataset["reference_bound"].values, strict=True
            )
        },
        paddings=paddings,
        paddings_on=(across, along),
        tolerances={
            float(tolerance): float(error)
            for tolerance, error in zip(
                dataset["tolerance"].values, dataset["tolerance_error_l1"].values, strict=True
            )
        },
        settings=settings,
        notes=tuple(json.loads(attributes["notes"])),
        spent=float(attributes["seconds"]),
    )


def as_text(padding: cs.Padding | cs.Paddings) -> str:
    """Return a padding as text, such as "circular 6", or "zero, zero" for two axes."""
    if isinstance(padding, tuple):
        return ", ".join(as_text(axis) for axis in padding)
    name, images = mode_of(padding)
    return f"{name} {images}"


def from_text(text: str) -> cs.Padding | cs.Paddings:
    """Return the padding of a text."""
    paddings = [padding_at(*_split(part)) for part in text.split(", ")]
    return paddings[0] if len(paddings) == 1 else (paddings[0], paddings[1])


def _split(text: str) -> tuple[str, int]:
    name, _, images = text.partition(" ")
    return name, int(images)


def _times(rows: list[tuple[float, ...]], dim: str) -> xr.Variable:
    """Return times of all settings, filled with nan."""
    length = max((len(row) for row in rows), default=0)
    values = np.full((len(rows), max(length, 1)), np.nan)
    for index, row in enumerate(rows):
        values[index, : len(row)] = row
    return xr.Variable(("setting", dim), values, {"units": "s", "long_name": "processor time"})


def _known(times: xr.DataArray) -> tuple[float, ...]:
    return tuple(float(second) for second in times.values if isfinite(second))


def _changes(names: list[str], values: np.ndarray) -> Mapping[str, float]:
    pairs = zip(names, values.tolist(), strict=True)
    return {name: value for name, value in pairs if -inf < value < inf}
