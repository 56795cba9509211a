"""Fields of cases, a file each while cases are computed; in the end they are groups of the netCDF file."""

import json
from collections.abc import Callable, Mapping
from pathlib import Path

import xarray as xr

from contactstudy import InvalidInput
from contactstudy.domain.files import read_verified, reason, set_aside, write_with_checksum
from studies.store.journal_lines import decoded_variable, encoded_variable


def save_fields(folder: Path, key: str, stamp: str, variables: Mapping[str, xr.Variable]) -> None:
    """Write the fields of the case `key`, computed by the program `stamp`, to a file that is then on the disk."""
    fields = {name: encoded_variable(variable) for name, variable in variables.items()}
    content = {"program": stamp, "fields": fields}
    try:
        write_with_checksum(folder / f"{key}.json", json.dumps(content).encode())
    except OSError as error:
        raise InvalidInput(
            f"Fields in {str(folder)!r} cannot be written ({reason(error, folder / key)}): what was stored is "
            "kept; make room or give another folder with --out, and run the same command again."
        ) from None


def load_fields(
    folder: Path, key: str, stamp: str, log: Callable[[str], object] = lambda text: None
) -> xr.Dataset | None:
    """Return the fields of a case that a program computed; None where there are none.

    A damaged file is set aside, which is reported to `log`. A variable named like its dimension is its coordinate.
    """
    path = folder / f"{key}.json"
    if not path.is_file():
        return None
    content = read_verified(path)
    if content is None:
        log(
            f"{path} is damaged: it is set aside as {set_aside(path).name}, and its case is recomputed"
        )
        return None
    stored = json.loads(content)
    if stored.get("program") != stamp:
        return None
    return xr.Dataset({name: decoded_variable(v) for name, v in stored["fields"].items()})
