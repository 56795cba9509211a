"""NetCDF files: written as a whole or not at all, and read with a sentence on what is wrong.

A signal waits until a file is done: xarray's locks stay locked if it comes between two of them.
"""

import os
import tempfile
from collections.abc import Hashable, Iterable
from pathlib import Path
from typing import Any, Literal

import netCDF4
import numpy as np
import xarray as xr

from contactstudy import InvalidInput
from contactstudy.domain.files import append_checksum, is_damaged, reason, replacing, set_aside
from studies.model.plain_text import Log, one_line, quoted
from studies.store.stop import Stop


def open_folder(path: Path) -> Path:
    """Return `path` as a folder that can be written to, made if need be.

    Raises
    ------
    InvalidInput
        If it cannot be made or written to.
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=path):
            pass
    except (OSError, ValueError) as error:
        why = "it is a file" if os.path.isfile(path) else reason(error)  # noqa: PTH113 (no error for any name)
        raise InvalidInput(
            f"Output folder {quoted(path)} cannot be written to ({why}): give another with --out."
        ) from None
    return path


def write(dataset: xr.Dataset, path: Path, groups: Iterable[tuple[str, xr.Dataset]] = ()) -> None:
    """Write a dataset as netCDF, with `groups` (name, dataset) below it; an earlier file stays until it is complete.

    Raises
    ------
    InvalidInput
        If the file cannot be written.
    """
    try:
        with Stop(), replacing(path) as partial:
            dataset.to_netcdf(partial, engine="netcdf4", encoding=_encoding(dataset))
            for name, group in groups:
                group.to_netcdf(partial, engine="netcdf4", group=name, mode="a", encoding=_encoding(group))
            append_checksum(partial)
    except (OSError, RuntimeError) as error:  # the netCDF library raises RuntimeError
        raise InvalidInput(
            f"Study file {quoted(path)} cannot be written ({reason(error, path)}): what was stored is kept; "
            "make room or give another folder with --out, and run the same command again."
        ) from None


def _encoding(dataset: xr.Dataset) -> dict[Hashable, dict[str, None]]:
    """Return the encoding by which coordinates have no fill value, as CF requires."""
    return {name: {"_FillValue": None} for name in dataset.coords}


def read_any(path: Path) -> xr.Dataset:
    """Return the Dataset of a solution or a study in `path`, in memory."""
    return read(path, "File", "give a file that contactstudy solve or run wrote")


def fields_of(dataset: xr.Dataset, path: Path) -> list[tuple[dict[str, Any], xr.Dataset]]:
    """Return each point of the study in `path` whose fields are stored, with these fields."""
    keys, matching = dataset["case_key"], []
    # through one open file: xarray's own crashes where it opens groups of one file in turn
    with Stop(), netCDF4.Dataset(path) as file:
        stored = file.groups["fields"].groups if "fields" in file.groups else {}
        for index in np.ndindex(keys.shape):
            if (group := f"case_{keys.values[index]}") in stored:
                at = zip(keys.dims, index, strict=True)
                point = {str(dim): keys[dim].values[number] for dim, number in at}
                store = xr.backends.NetCDF4DataStore(stored[group])
                matching.append((point, xr.open_dataset(store).load()))
    return matching


def check_kind(path: Path, kind: Literal["solution", "study", "comparison"], log: Log = print) -> None:
    """Raise InvalidInput if `path` holds a file of another kind, which would be replaced.

    A damaged file is set aside, which is reported to `log`.
    """
    if not path.is_file():
        return
    try:
        with Stop(), netCDF4.Dataset(_checked(path)) as file:
            kinds = {"study": "case_status", "solution": "pressure", "comparison": "error_bound"}
            present = next((name for name in kinds if kinds[name] in file.variables), kind)
    except Exception:  # noqa: BLE001 (libraries raise anything for a damaged file)
        log(f"{path} is damaged: it is set aside as {set_aside(path).name}, and is made again")
        return
    if present != kind:
        raise InvalidInput(
            f"{quoted(path)} holds a {present}, which the {kind} would replace: give another folder with --out."
        )


def _checked(path: Path) -> Path:
    """Return `path`; raise ValueError for a damaged file, which HDF5 may read wrongly or without end."""
    if is_damaged(path):
        raise ValueError("its checksum is not that of its content")
    return path


def read(path: Path, what: str = "Study file", remedy: str = "run the study first") -> xr.Dataset:
    """Return the Dataset in `path`, in memory.

    Raises :class:`~contactstudy.InvalidInput`, with `what` the file is called and the `remedy`, for one that is
    missing or damaged.
    """
    try:
        with Stop():
            return xr.load_dataset(_checked(path), engine="netcdf4")
    except Exception as error:  # noqa: BLE001 (libraries raise anything for a damaged file)
        if isinstance(error, OSError | RuntimeError) and str(error):
            why = reason(error)
        else:
            why = f"it is damaged: {type(error).__name__}: {one_line(error, 100)}"
        raise InvalidInput(f"{what} {quoted(path)} cannot be read ({why}): {remedy}.") from None
