"""``contactstudy show FILE.nc --format html``: one HTML page, interactive in any browser, without a network."""

import html
import json
from base64 import b64encode
from importlib.resources import files
from math import ceil
from typing import TYPE_CHECKING, Any

import numpy as np

from contactstudy import InvalidInput
from contactstudy.domain.units import display_unit_of, readable

if TYPE_CHECKING:
    import xarray as xr

# Values of a variable that a page holds; a field of more cells is replaced by its means over blocks of cells.
MAX_VALUES = 200_000
# Variables of which the page shows first the one that the file has: numbers of a study, fields of another file.
NUMBERS = ("central_film", "peak_pressure", "largest_pressure")
FIELDS = ("pressure", "film")
# Ratio of the largest to the least value of an axis of a study above which it starts as logarithmic.
LOGARITHMIC_FROM = 30.0


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
        raise InvalidInput(
            f"{name} holds no numbers over an axis: give a file that contactstudy solve or run wrote, and run the "
            "cases of a study first."
        )
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
    return {
        "label": _label(field),
        "unit": unit,
        "dims": dims,
        "data": b64encode(data).decode("ascii"),
    }


def _label(variable: "xr.DataArray") -> str:
    """Return the long name of a variable."""
    return str(variable.attrs.get("long_name", variable.name))


def _units(variable: "xr.DataArray") -> str:
    """Return the units of a variable, empty for a number without."""
    units = str(variable.attrs.get("units", "1"))
    return "" if units == "1" else units
