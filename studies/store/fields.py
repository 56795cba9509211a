"""Fields of a study's cases: a file each while they are computed, groups of the study's netCDF in the end."""

import json
import os
from collections.abc import Mapping
from pathlib import Path

import xarray as xr

from contactstudy import InvalidInput
from studies.store.encoding import VariableTypes
from studies.store.netcdf import replacing


def save(folder: Path, key: str, variables: Mapping[str, xr.Variable]) -> None:
    """``variables`` of the case ``key``, on disk when this returns."""
    kinds, values = VariableTypes().encode(variables)
    try:
        with replacing(folder / f"{key}.json") as partial, partial.open("w") as file:
            json.dump({"kinds": kinds, "values": values}, file)
            file.flush()
            os.fsync(file.fileno())
    except OSError as error:
        raise InvalidInput(
            f"Fields in {str(folder)!r} cannot be written ({error.strerror}): what was stored is kept; "
            "make room or give another folder with --out, and run the same command again."
        ) from None


def exist(folder: Path, key: str) -> bool:
    """Whether the case ``key`` has its fields here."""
    return (folder / f"{key}.json").is_file()


def load(folder: Path, key: str) -> xr.Dataset:
    """The fields of the case ``key``; a variable named like its dimension is its coordinate."""
    stored = json.loads((folder / f"{key}.json").read_text())
    kinds = VariableTypes()
    for kind in stored["kinds"]:
        kinds.add(kind)
    variables = kinds.decode(stored["values"])
    coords = {name: v for name, v in variables.items() if v.dims == (name,)}
    data = {name: v for name, v in variables.items() if name not in coords}
    return xr.Dataset(data, coords)
