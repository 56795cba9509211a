"""Writes docs/reference/study-variables.json from the files of a report: python docs/_ext/study_variables.py outputs."""

import json
import sys
from pathlib import Path

import xarray as xr

from studies.registry import BUILT_IN, SCENES

HERE = Path(__file__).parents[1] / "reference" / "study-variables.json"


def variables(folder: Path) -> dict[str, list[tuple[str, str, str]]]:
    """Name, meaning and units of the variables of each built-in study that is no scene file."""
    found = {}
    for name in (one for one in BUILT_IN if one not in SCENES):
        with xr.open_dataset(folder / f"{name}.nc", decode_times=False) as dataset:
            found[name] = [
                (str(one), str(v.attrs.get("long_name", "")), str(v.attrs.get("units", "")))
                for one, v in dataset.data_vars.items()
            ]
    return found


if __name__ == "__main__":
    text = json.dumps(variables(Path(sys.argv[1])), indent=1, ensure_ascii=False)
    HERE.write_text(text + "\n", encoding="utf-8")
