import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from contactstudy import InvalidInput
from studies.engine.options import RunOptions
from studies.engine.run import run
from studies.registry import load
from studies.store import provenance
from studies.store.netcdf import read
from tests.studies.conftest import quiet

ONE = RunOptions(workers=0, repeats=0)
KEPT = RunOptions(workers=0, repeats=0, fields="kept")


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("fields")
    study = load("grid").override({"padding": "exact,zero", "grid": "16,24"})
    run(study, folder, options=KEPT, log=quiet)
    return folder


def test_fields_are_groups_by_the_key_of_the_case(out: Path) -> None:
    with xr.open_datatree(out / "grid.nc") as tree:
        one = tree.to_dataset().sel(padding="exact", images=6, period=2.4, grid=24)
        pressure = tree[f"fields/case_{one['case_key'].item()}"]["pressure"]
        assert pressure.attrs["units"] == "Pa"
        load_per_length = float(pressure.sum() * (pressure["x"][1] - pressure["x"][0]) / 24)
        assert load_per_length == pytest.approx(1e5, rel=1e-8)


def test_a_case_is_computed_again_where_its_fields_lack_or_are_damaged(tmp_path: Path) -> None:
    study = load("grid").override({"padding": "exact", "grid": "16,24"})
    said: list[str] = []
    first = run(study, tmp_path, options=ONE, log=quiet)
    run(study, tmp_path, options=KEPT, log=quiet)
    (one, _) = sorted((tmp_path / "grid.fields").iterdir())
    one.write_bytes(one.read_bytes()[:-9])
    again = run(study, tmp_path, options=KEPT, log=said.append)
    assert any(f"set aside as {one.name}.damaged" in line for line in said)
    assert any("1 case is stored, 1 to compute" in line for line in said)
    np.testing.assert_array_equal(first["residual"], again["residual"])
    with xr.open_datatree(tmp_path / "grid.nc") as tree:
        assert len(tree["fields"].children) == 2


@pytest.mark.parametrize("place", [20, 5000])
def test_a_damaged_study_file_is_set_aside_and_made_again(tmp_path: Path, place: int) -> None:
    study = load("grid").override({"padding": "exact", "grid": "16"})
    before = run(study, tmp_path, options=ONE, log=quiet)
    path = tmp_path / "grid.nc"
    path.write_bytes(path.read_bytes()[:place])
    with pytest.raises(InvalidInput, match=r"^Study file .* cannot be read"):
        read(path)
    said: list[str] = []
    after = run(study, tmp_path, options=ONE, log=said.append)
    assert any("set aside as grid.nc.damaged" in line for line in said)
    xr.testing.assert_equal(before, after)


@pytest.mark.whole
def test_a_cf_checker_finds_nothing(out: Path) -> None:
    pytest.importorskip("compliance_checker")
    command = [str(Path(sys.executable).with_name("compliance-checker")), "--test=cf:1.11", "--format", "json"]
    report = out / "report.json"
    subprocess.run([*command, "--output", str(report), str(out / "grid.nc")], capture_output=True)
    found = json.loads(report.read_text(encoding="utf-8"))["cf:1.11"]
    for priority in ("high_priorities", "medium_priorities"):
        assert [message for check in found[priority] for message in check["msgs"]] == [], priority


def test_the_history_is_the_command_as_a_shell_takes_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(provenance.sys, "argv", ["/opt/bin/contactstudy", "run", "my study.py"])
    assert provenance.provenance()["history"].partition(" ")[2] == "contactstudy run 'my study.py'"
