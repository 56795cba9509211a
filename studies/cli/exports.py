"""What ``contactstudy show FILE.nc`` writes beside pictures: a table, an interactive page, files for ParaView."""

import html
import json
import tomllib
from base64 import b64encode
from collections.abc import Sequence
from difflib import get_close_matches
from importlib.resources import files
from math import ceil
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

import contactstudy as cs
from contactstudy import InvalidInput
from contactstudy.domain.imports import import_for
from contactstudy.domain.validation import Metres, display_unit_of, readable, suggestion
from studies.model.outcome import is_time
from studies.store.netcdf import fields_of

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

# Words in the names of columns at the end of a table: the solver's work, the case, the times.
SORTED_LAST = ("status", "iterations", "convolutions", "residual", "case_", "_time")
# What stands for all columns.
ALL = "all"
# Values of a variable that a page holds; a field of more cells is replaced by its means over blocks of cells.
MAX_VALUES = 200_000
# Variables of which the page shows first the one that the file has: numbers of a study, fields of another file.
NUMBERS = ("central_film", "peak_pressure", "largest_pressure")
FIELDS = ("pressure", "film")
# Ratio of the largest to the least value of an axis of a study above which it starts as logarithmic.
LOGARITHMIC_FROM = 30.0


def csv_of(dataset: "xr.Dataset", file: Path, names: Sequence[str]) -> tuple[str, int]:
    """Return a table as CSV, with units in its header, and the number of columns that it leaves out.

    It has a row for each point of a study or instant of an evolution, or one row of a solution, and of fields a row for
    each cell. A value that is missing is empty.

    Parameters
    ----------
    dataset, file
        A stored solution or study, and its file.
    names
        Variables, or ``all`` that have no further dimension. Without names the table has the quantities with their
        bounds and how the cases ended.

    Raises
    ------
    InvalidInput
        For a name that the file does not have.
    """
    if "case_status" in dataset:
        axes = [str(name) for name in dataset["case_status"].dims]
    else:
        axes = [name for name in ("time", "pass_number") if name in dataset.dims]
    # beside axes, leave out scalars: they would repeat in every row
    columns = [
        str(name)
        for name, variable in dataset.data_vars.items()
        if set(variable.dims) <= set(axes) and bool(variable.dims) == bool(axes)
    ]
    columns.sort(key=lambda name: any(word in name for word in SORTED_LAST))
    if "solve_time" not in columns:
        columns = [name for name in columns if not is_time(name)]
    chosen = columns if ALL in names else [*names] or _default_columns(columns)
    if not chosen:
        raise InvalidInput(f"{str(file)!r} has no numbers for a table: give what contactstudy solve or run wrote.")
    if set(chosen) <= set(columns):
        return _csv_text(dataset, _rows(dataset, chosen, axes)), len(columns) - len(chosen)
    at_points: list[tuple[dict[str, Any], xr.Dataset]] = [({}, dataset)]
    if "case_status" in dataset:
        at_points = fields_of(dataset, file)
    all_names = dict.fromkeys([*columns, *(str(name) for _, point_data in at_points for name in point_data.data_vars)])
    for name in chosen:
        if name not in all_names or any(name not in point_data for _, point_data in at_points):
            if at_points or get_close_matches(name, all_names, n=1, cutoff=0.8):
                raise InvalidInput(f"--csv names {name!r}: {suggestion(name, all_names)}.")
            raise InvalidInput(
                f"--csv names {name!r}, which is not stored: run the study with --fields for its fields."
            )
    import pandas as pd

    dims = list(dict.fromkeys(str(dim) for name in chosen for dim in at_points[0][1][name].dims))
    tables = [_rows(point_data, chosen, dims).assign(**point) for point, point_data in at_points]
    table = pd.concat(tables)[[*(axes if at_points[0][0] else ()), *dims, *chosen]]
    return _csv_text(at_points[0][1].assign_coords({axis: dataset[axis] for axis in axes}), table), 0


def _default_columns(columns: Sequence[str]) -> list[str]:
    """Return the quantities with their bounds, the statuses and the times; all columns where none has a bound."""
    has_bounds = any(name.endswith("_bound") for name in columns)
    return [
        name
        for name in columns
        if not has_bounds or name.endswith(("_bound", "status")) or f"{name}_bound" in columns or is_time(name)
    ]


def _rows(dataset: "xr.Dataset", names: Sequence[str], dims: Sequence[str]) -> "pd.DataFrame":
    """Return variables as columns with a row for each point of `dims`, or one row."""
    flat = dataset[names].assign({name: _with_flag_meanings(dataset[name]) for name in names})
    flat = flat.reset_coords(drop=True)
    if dims:
        return flat.to_dataframe(dim_order=[*dims]).reset_index()
    return flat.expand_dims("row").to_dataframe().reset_index(drop=True)


def _csv_text(dataset: "xr.Dataset", table: "pd.DataFrame") -> str:
    """Return a table as CSV, each column in the unit in which it is read best."""
    heads, in_si = {}, table
    for name in map(str, table.columns):
        if name not in dataset.variables:
            continue
        units = str(dataset[name].attrs.get("units", "1"))
        # a bound in the unit of what it bounds
        bounded = name.removesuffix("_bound")
        values = in_si.get(bounded, in_si[name]).to_numpy()
        if units != "1":
            factor, unit = display_unit_of(values, units) if values.dtype.kind in "iuf" else (1.0, units)
            heads[name] = f"{name} [{unit}]"
            if factor != 1:
                table = table.assign(**{name: in_si[name] / factor})
    return str(table.rename(columns=heads).to_csv(index=False, float_format="%.14g"))


def _with_flag_meanings(variable: "xr.DataArray") -> "xr.DataArray":
    """Return a flag variable with the meaning of each value, empty for nan, and any other variable unchanged."""
    meanings = str(variable.attrs.get("flag_meanings", "")).split()
    if not meanings:
        return variable
    values = [int(value) for value in np.atleast_1d(variable.attrs["flag_values"])]
    words = dict(zip(values, meanings, strict=True))
    named = np.vectorize(lambda value: words.get(value, ""), otypes=[object])(variable.values)
    return variable.copy(data=named)


def page_of(dataset: "xr.Dataset", name: str) -> str:
    """Return the self-contained HTML page of a stored study, contact, film or evolution.

    Raises :class:`~contactstudy.InvalidInput` for a dataset without numbers over an axis.
    """
    page_data = contents(dataset, name)
    template = (files("studies.cli") / "explore.html").read_text(encoding="utf-8")
    before, after = template.replace("TITLE", html.escape(page_data["title"]), 1).split(">DATA<")
    return f"{before}>{_json(page_data)}<{after}"


def _instant_of_largest(field: "xr.DataArray") -> int | None:
    """Return the index of the instant at which `field` has its largest value; None without a time."""
    if "time" not in field.dims:
        return None
    return int(field.max([dim for dim in field.dims if dim != "time"]).argmax("time"))


def _json(value: object) -> str:
    """Return JSON that cannot end the script element that holds it."""
    text = json.dumps(value, allow_nan=False, separators=(",", ":"))
    return text.replace("&", r"\u0026").replace("<", r"\u003c").replace(">", r"\u003e")


def contents(dataset: "xr.Dataset", name: str) -> dict[str, Any]:
    """Return the data of a page: axes with their values, variables over them, and single numbers, in usual units.

    Raises :class:`~contactstudy.InvalidInput` for a dataset without numbers over an axis.
    """
    variables = {
        str(key): variable
        for key, variable in dataset.data_vars.items()
        if variable.dtype.kind in "fiub" and "flag_values" not in variable.attrs
    }
    fields = {
        key: _coarse(variable)
        for key, variable in variables.items()
        if max(variable.shape, default=1) > 1 and np.isfinite(variable.values).any()
    }
    is_study = "case_status" in dataset
    if is_study:
        axes = set(dataset["case_status"].dims)
        fields = {key: field for key, field in fields.items() if set(field.dims) <= axes}
    if not fields:
        raise InvalidInput(f"{name} holds no numbers over an axis: give a file that contactstudy solve or run wrote.")
    title = str(dataset.attrs.get("title", "contact"))
    dims = {str(dim): field for field in fields.values() for dim in field.dims}
    first = (*NUMBERS, *FIELDS) if is_study else (*FIELDS, *NUMBERS)
    first_variable = next((key for key in first if key in fields), next(iter(fields)))
    page_data: dict[str, Any] = {
        "title": title if title.startswith(name) else f"{name}: {title}",
        "study": is_study,
        "first": first_variable,
        "instant": _instant_of_largest(fields[first_variable]),
        "axes": {dim: _axis(field, dim, in_study=is_study) for dim, field in dims.items()},
        "variables": {key: _variable(field) for key, field in fields.items()},
        "numbers": [
            (_label(variable), readable(float(variable), _units(variable)))
            for key, variable in variables.items()
            if variable.ndim == 0
        ],
    }
    if is_study and dataset["case_status"].ndim:
        status = dataset["case_status"]
        numbers = np.atleast_1d(status.attrs["flag_values"]).tolist()
        meanings = str(status.attrs["flag_meanings"]).split()
        page_data["words"] = dict(zip(map(str, numbers), meanings, strict=True))
        page_data["variables"]["case_status"] = _variable(status) | {"hidden": True}
    return page_data


def _coarse(variable: "xr.DataArray") -> "xr.DataArray":
    """Return a field of real numbers, of means over blocks of cells where the page would otherwise hold too many.

    Such a field has axes of its own, such as ``x by 2``; the last block may be smaller.
    """
    field = variable.astype(float)
    cells = [dim for dim in ("x", "y") if field.sizes.get(dim, 1) > 1]
    block = ceil((field.size / MAX_VALUES) ** (1 / max(len(cells), 1)))
    if block == 1 or not cells:
        return field
    blocks = field.coarsen(dict.fromkeys(cells, block), boundary="pad").mean()
    return blocks.rename({dim: f"{dim} by {block}" for dim in cells})


def _axis(field: "xr.DataArray", dim: str, *, in_study: bool) -> dict[str, Any]:
    """Return an axis: label, unit, values, whether it points down, and can be and begins as logarithmic."""
    coordinate = field[dim]  # numbers from 0 on where the file has none
    values, units = coordinate.values, _units(coordinate)
    axis = {"label": _label(coordinate), "down": coordinate.attrs.get("positive") == "down"}
    if values.dtype.kind not in "iuf" or not np.isfinite(values).all():
        texts = [str(value) for value in values.tolist()]
        return axis | {"unit": "", "values": texts, "canLog": False, "log": False}
    factor, unit = display_unit_of(values, units)
    can_log = bool(values.min() > 0)
    spans = bool(values.max() > LOGARITHMIC_FROM * values.min())
    return axis | {
        "unit": unit,
        "values": [float(f"{value / factor:.9g}") for value in values.tolist()],
        "canLog": can_log,
        "log": can_log and in_study and spans,
    }


def _variable(field: "xr.DataArray") -> dict[str, Any]:
    """Return a variable: label, unit, names of its axes, values as text of float32 numbers."""
    values = field.values.astype(float)
    factor, unit = display_unit_of(values, _units(field))
    data = np.ascontiguousarray(values / factor, dtype="<f4").tobytes()
    dims = [str(dim) for dim in field.dims]
    return {"label": _label(field), "unit": unit, "dims": dims, "data": b64encode(data).decode("ascii")}


def _label(variable: "xr.DataArray") -> str:
    """Return the long name of a variable."""
    return str(variable.attrs.get("long_name", variable.name))


def _units(variable: "xr.DataArray") -> str:
    """Return the units of a variable, empty for a number without."""
    units = str(variable.attrs.get("units", "1"))
    return "" if units == "1" else units


def write_vtk(dataset: "xr.Dataset", file: Path, stem: Path) -> list[Path]:
    """Write the fields of a solution, of each instant or of each case of a study as VTK; return the files to open.

    Fields of the surface are a rectilinear grid of cells, ``STEM.vtr``, those below it one of points,
    ``STEM-stress.vtr``. Instants are a series with their times, ``STEM.pvd``, cases one with their numbers.

    Parameters
    ----------
    dataset, file
        A stored solution or study, and its file.
    stem
        Path of the files to write, without their endings.
    """
    frames: list[tuple[float, xr.Dataset]] = [(0.0, dataset)]
    if "case_status" in dataset:
        frames = [(float(number), fields) for number, (_, fields) in enumerate(fields_of(dataset, file))]
    elif "time" in dataset.dims:
        times = dataset["time"].values
        frames = [(float(time), dataset.isel(time=number)) for number, time in enumerate(times)]
    if not frames or not {"x", "y"} <= set(frames[0][1].dims):
        raise InvalidInput(f"--format has vtk, and {str(file)!r} has no fields over (x, y): run a study with --fields.")
    # a cell alone is as long as the scene's grid, or square where that is not known
    extent = tomllib.loads(str(dataset.attrs.get("scene", ""))).get("grid", {}).get("extent")
    length = None if extent is None else cs.Grid((2, 1), extent).length
    if len(frames) == 1:
        return _write_frame(frames[0][1], stem, "", length)
    numbers = [f"-{number:0{len(str(len(frames)))}d}" for number in range(len(frames))]
    written = [_write_frame(fields, stem, number, length) for number, (_, fields) in zip(numbers, frames, strict=True)]
    group, series = import_for("--format vtk", "pyevtk.vtk").VtkGroup, []
    for number, path in enumerate(written[0]):
        series.append(path.with_name(path.name.replace(f"{numbers[0]}.vtr", ".pvd")))
        collection = group(str(series[-1].with_suffix("")))
        for (time, _), paths in zip(frames, written, strict=True):
            collection.addFile(str(paths[number]), time)
        collection.save()
    return series


def _write_frame(fields: "xr.Dataset", stem: Path, number: str, length: Metres | None) -> list[Path]:
    """Write the fields at one instant, and return the files: that of the surface, and one for each body's depths."""
    write = import_for("--format vtk", "pyevtk.hl").gridToVTK
    edges = [_edges(fields[axis].values) for axis in ("x", "y")]
    if len(edges[1]) == 2:
        edges[1] *= length or np.diff(edges[0])[0]
    # its cells lie between edges: one thin layer, so that the map is seen from above
    flat = np.array([0.0, min(np.diff(edge).min() for edge in edges)])
    on_surface = {
        str(name): np.ascontiguousarray(field.transpose("x", "y").values[:, :, None])
        for name, field in fields.data_vars.items()
        if set(field.dims) == {"x", "y"}
    }
    # the library adds the ending
    files = [write(f"{stem}{number}", edges[0], edges[1], flat, cellData=on_surface)]
    axes = [np.ascontiguousarray(fields[axis].values, dtype=float) for axis in ("x", "y")]
    for axis in [str(name) for name in fields.dims if str(name).startswith("z")]:
        order = np.argsort(-fields[axis].values)
        below: dict[str, np.ndarray] = {}
        for name, field in fields.data_vars.items():
            if not {"x", "y", axis} <= set(field.dims):
                continue
            parts = (
                {f"{name}_{part}": field.sel(component=part) for part in fields["component"].values}
                if "component" in field.dims
                else {str(name): field}
            )
            for key, part in parts.items():
                values = part.transpose("x", "y", axis).values
                below[key] = np.ascontiguousarray(values[:, :, order])
        depths = np.ascontiguousarray(-fields[axis].values[order])
        path = f"{stem}-stress{axis.removeprefix('z')}{number}"
        files.append(write(path, axes[0], axes[1], depths, pointData=below))
    return [Path(path) for path in files]


def _edges(centres: np.ndarray) -> np.ndarray:
    """Return the edges of cells with these centres [m]; of a single one those of a cell of length 1."""
    step = float(centres[-1] - centres[0]) / (len(centres) - 1) if len(centres) > 1 else 1.0
    return np.asarray(centres[0] + step * (np.arange(len(centres) + 1) - 0.5))
