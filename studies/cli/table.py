"""``contactstudy show FILE.nc --csv``: the numbers of a stored file, or some of its fields, as a table."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from contactstudy import InvalidInput
from contactstudy.domain.checks import suggestion
from contactstudy.domain.units import display_unit_of
from studies.model.outcome import is_time
from studies.store.netcdf import fields_of

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

# Columns at the end of a table, in this order: the solver's work, the case, the times.
SORTED_LAST = ("status", "iterations", "convolutions", "residual", "case_", "_time")
# What stands for all columns.
ALL = "all"


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
    columns.sort(key=_column_order)
    if "solve_time" not in columns:
        columns = [name for name in columns if not is_time(name)]
    chosen = columns if ALL in names else [*names] or _main(columns)
    if set(chosen) <= set(columns):
        return _text(dataset, _rows(dataset, chosen, axes)), len(columns) - len(chosen)
    found: list[tuple[dict[str, Any], xr.Dataset]] = [({}, dataset)]
    if "case_status" in dataset:
        found = fields_of(dataset, file)
    known = dict.fromkeys([*columns, *(str(name) for _, one in found for name in one.data_vars)])
    for name in chosen:
        if name not in known or any(name not in one for _, one in found):
            fields = "" if found else ", and run the study with --fields for its fields"
            raise InvalidInput(f"--csv names {name!r}: {suggestion(name, known)}{fields}.")
    import pandas as pd

    dims = list(dict.fromkeys(str(dim) for name in chosen for dim in found[0][1][name].dims))
    tables = [_rows(one, chosen, dims).assign(**point) for point, one in found]
    table = pd.concat(tables)[[*(axes if found[0][0] else ()), *dims, *chosen]]
    return _text(found[0][1].assign_coords({axis: dataset[axis] for axis in axes}), table), 0


def _main(columns: Sequence[str]) -> list[str]:
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


def _text(dataset: "xr.Dataset", table: "pd.DataFrame") -> str:
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


def _column_order(name: str) -> int:
    """Return the position of a column among :data:`SORTED_LAST`, 0 for any other."""
    places = [place for place, word in enumerate(SORTED_LAST, start=1) if word in name]
    return max(places, default=0)


def _with_flag_meanings(variable: "xr.DataArray") -> "xr.DataArray":
    """Return a flag variable with the meaning of each value, empty for nan, and any other variable unchanged."""
    meanings = str(variable.attrs.get("flag_meanings", "")).split()
    if not meanings:
        return variable
    values = [int(value) for value in np.atleast_1d(variable.attrs["flag_values"])]
    words = dict(zip(values, meanings, strict=True))
    named = np.vectorize(lambda value: words.get(value, ""), otypes=[object])(variable.values)
    return variable.copy(data=named)
