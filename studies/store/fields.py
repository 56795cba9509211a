"""Fields of a study's cases: a file each while they are computed, groups of the study's netCDF in the end."""

import os
from collections.abc import Mapping
from pathlib import Path

import xarray as xr

from contactstudy import InvalidInput
from studies.store.files.partial_file import reason, replacing
from studies.store.lines.encoding import VariableTypes
from studies.store.lines.journal_line import decoded, encoded


def save(folder: Path, key: str, variables: Mapping[str, xr.Variable]) -> None:
    """``variables`` of the case ``key``, on disk when this returns."""
    kinds, values = VariableTypes().encode(variables)
    try:
        with replacing(folder / f"{key}.json") as partial, partial.open("xb") as file:
            file.write(encoded({"kinds": kinds, "values": values}))
            file.flush()
            os.fsync(file.fileno())
    except OSError as error:
        raise InvalidInput(
            f"Fields in {str(folder)!r} cannot be written ({reason(error, folder / key)}): what was stored is "
            "kept; make room or give another folder with --out, and run the same command again."
        ) from None


def exist(folder: Path, key: str) -> bool:
    """Whether the case ``key`` has its fields here."""
    return (folder / f"{key}.json").is_file()


def load(folder: Path, key: str) -> xr.Dataset | None:
    """The fields of the case ``key``; a variable named like its dimension is its coordinate.

    None for a damaged file, which is renamed, so that the case is computed for its fields again.
    """
    path = folder / f"{key}.json"
    held = decoded(path.read_bytes())
    if held is None:
        path.replace(path.with_suffix(".damaged"))
        return None
    kinds = VariableTypes()
    for name, kind in held["kinds"].items():
        kinds.add(name, kind)
    variables = kinds.decode(held["values"])
    coords = {name: v for name, v in variables.items() if v.dims == (name,)}
    data = {name: v for name, v in variables.items() if name not in coords}
    return xr.Dataset(data, coords)
