from pathlib import Path

import xarray as xr

from studies.findings import accuracy_table, findings, price_table
from studies.store import read
from studies.study import load
from studies.sweep import run
from tests.studies.conftest import quiet


def swept(name: str, out: Path, **axes: str) -> xr.Dataset:
    run(load(name).override(axes), out, workers=0, repeats=1, say=quiet)
    return read(out / f"{name}.nc")


def test_findings_are_silent_where_the_sweeps_cannot_speak(tmp_path: Path) -> None:
    stored = {
        "padding": swept("padding", tmp_path, padding="exact,zero", grid="16", period="2.4"),
        "images": swept("images", tmp_path, images="0", period="2.4", grid="16"),
        "period": swept("period", tmp_path, period="2.4", grid="16"),
        "grid": swept("grid", tmp_path, grid="16,24"),
    }
    assert findings(stored) == ()
    assert [row[2] for row in price_table(stored["padding"]).rows][-1].startswith("none stored")


def test_the_table_shows_what_is_stored(tmp_path: Path) -> None:
    rows = accuracy_table(swept("paper", tmp_path, padding="circular,exact", images="1")).rows
    assert [row[0] for row in rows] == ["exact", "circular, n = 1"]
