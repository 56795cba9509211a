"""What ``show`` writes beside pictures: tables, interactive pages and files for ParaView."""

import csv
import json
import re
import tomllib
from base64 import b64decode
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import contactstudy as cs
from studies.cli.exports import MAX_VALUES, contents, page_of
from tests.studies.cli.conftest import ended, said
from tests.studies.scene_study.conftest import SMOOTH, given


def table(file: Path, *words: object) -> list[dict[str, str]]:
    said("show", file, "--csv", *words, "--out", file.parent)
    text = file.with_suffix(".csv").read_text(encoding="utf-8")
    return list(csv.DictReader(StringIO(text)))


def test_a_study_is_a_table_with_a_row_for_each_point(tmp_path: Path) -> None:
    points = xr.Dataset(
        {
            "case_status": ended(("load", "n"), [[1, 1, 1], [1, 0, 1]]),
            "peak": (("n", "load"), np.arange(6.0).reshape(3, 2), {"units": "Pa"}),
            "field": (("n", "load", "x"), np.zeros((3, 2, 4))),
            "solver_status": ended(("load", "n"), [[1, 1, 1], [1, 0, 1]]).where([[True], [False]]),
        },
        {"load": ("load", [1e3, 2e3], {"units": "N m-1"}), "n": ("n", [0, 1, 2], {"units": "1"})},
    )
    points.to_netcdf(tmp_path / "points.nc")
    rows = table(tmp_path / "points.nc")
    assert set(rows[0]) == {"load [N/mm]", "n", "peak [Pa]", "case_status", "solver_status"}
    assert [row["peak [Pa]"] for row in rows] == ["0", "2", "4", "1", "3", "5"]
    assert [row["case_status"] for row in rows] == ["ok", "ok", "ok", "ok", "failed", "ok"]
    assert [row["solver_status"] for row in rows] == ["ok", "ok", "ok", "", "", ""]
    assert [(row["load [N/mm]"], row["n"]) for row in rows[2:4]] == [("1", "2"), ("2", "0")]


def test_a_solution_is_one_row_of_its_numbers_and_an_evolution_one_for_each_instant(folder: Path) -> None:
    (row,) = table(folder / "out" / "smooth.nc")
    peak = float(xr.load_dataset(folder / "out" / "smooth.nc")["pressure"].max())
    assert float(row["peak_pressure [MPa]"]) == pytest.approx(peak / 1e6, rel=1e-12)
    assert row["status"] == "CONVERGED"
    data = {"load": ("time", [1.0, 2.0], {"units": "N m-1"}), "pressure": (("time", "x"), np.ones((2, 3)))}
    xr.Dataset(data, {"time": ("time", [0.0, 0.5], {"units": "s"})}).to_netcdf(folder / "evolution.nc")
    first, second = table(folder / "evolution.nc")
    assert (first, second) == ({"time [s]": "0", "load [N/m]": "1"}, {"time [s]": "0.5", "load [N/m]": "2"})


def test_a_table_has_the_quantities_or_what_is_named(folder: Path) -> None:
    study = folder / "study" / "smooth-sweep.nc"
    (row, *others) = table(study)
    assert len(others) == 3
    assert {"peak_pressure [MPa]", "peak_pressure_bound [MPa]", "case_status"} <= set(row)
    assert not {"iterations", "case_key", "pressure_l1_estimate"} & set(row)
    assert {"iterations", "case_key", "pressure_l1_estimate"} <= set(table(study, "all")[0])
    named = table(study, "--plot", "residual", "peak_pressure")[0]
    assert list(named)[-2:] == ["residual", "peak_pressure [MPa]"]
    marked = said("show", study, "peak_pressure", "--csv", "--format", "excel")
    assert marked.startswith("\ufeffshapes_0_radius [mm],")


def test_a_solution_for_paraview_has_the_edges_of_its_cells(folder: Path, tmp_path: Path) -> None:
    said("show", folder / "out" / "smooth.nc", "--out", tmp_path, "--format", "vtk")
    text = (tmp_path / "smooth.vtr").read_bytes()
    assert b"RectilinearGrid" in text
    assert b"pressure" in text
    # each block of bytes after its size
    scene = tomllib.loads(xr.load_dataset(folder / "out" / "smooth.nc").attrs["scene"])
    half = np.array(scene["grid"]["extent"]) / 2
    for edge in (*half, *-half):
        assert any((edge + k * np.spacing(edge)).tobytes() in text for k in range(-9, 10))


def test_fields_of_the_cases_of_a_sweep_are_a_table_and_a_series_for_paraview(tmp_path: Path) -> None:
    scene, sweep = tmp_path / "deep.toml", tmp_path / "deep-sweep.nc"
    depths = '[[outputs]]\nkind = "SubsurfaceStress"\ndepths = ["50 um", "90 um"]\n'
    scene.write_text(SMOOTH + given(16, "0.4 mm") + depths)
    said("run", scene, "--vary", "load.per_length=80,90 N/mm", "--workers", 0, "--fields", "--out", tmp_path)
    rows = table(sweep, "von_mises")
    cells = xr.open_dataset(sweep, group=f"fields/case_{xr.load_dataset(sweep)['case_key'].values[1]}")
    assert len(rows) == 2 * cells["von_mises"].size
    first = next(row for row in rows if row["load_per_length [N/mm]"] == "90")
    stress = float(cells["von_mises"].transpose("z", "x", "y")[0, 0, 0])
    assert float(first["von_mises [MPa]"]) * 1e6 == pytest.approx(stress)
    text = said("show", sweep, "--format", "vtk", "--out", tmp_path / "vtk")
    written = [Path(line.removeprefix("wrote ")) for line in text.splitlines()]
    assert [path.name for path in written] == ["deep-sweep.pvd", "deep-sweep-stress.pvd"]
    for path in written:
        named = re.findall(r'file="([^"]*)"', path.read_text())
        assert [(path.parent / name).is_file() for name in named] == [True, True]
    stresses = (tmp_path / "vtk" / "deep-sweep-stress-1.vtr").read_bytes()
    values = cells["stress"].sel(component="xz").transpose("x", "y", "z").values[:, :, ::-1]
    assert b"stress_xz" in stresses
    assert np.ascontiguousarray(values).tobytes(order="F") in stresses


@pytest.fixture
def study() -> xr.Dataset:
    """A study over a load of two decades and a name, one of whose cases failed."""
    peak = np.array([[1e8, 2e8], [3e8, np.nan], [9e8, 8e8]])
    dims, label = ("load", "mode"), {"units": "Pa", "long_name": "peak pressure"}
    return xr.Dataset(
        {"peak_pressure": (dims, peak, label), "case_status": ended(dims, [[1, 1], [1, 0], [1, 1]])},
        {"load": ("load", [1e3, 1e4, 1e5], {"units": "N m-1", "long_name": "load"}), "mode": ["a", "b"]},
        {"title": "two modes"},
    )


def values(variable: dict[str, Any]) -> np.ndarray:
    return np.frombuffer(b64decode(variable["data"]), dtype="<f4")


def test_a_page_stands_alone_beside_its_file(study: xr.Dataset, tmp_path: Path) -> None:
    study.to_netcdf(tmp_path / "study.nc")
    said("show", tmp_path / "study.nc", "--format", "html")
    page = (tmp_path / "study-explore.html").read_text(encoding="utf-8")
    assert "<title>study: two modes</title>" in page
    assert not re.search(r"<(script|link|img)[^>]*(src|href)=", page)
    assert "default-src 'none'" in page
    with pytest.raises(cs.InvalidInput, match="holds no numbers over an axis"):
        page_of(xr.Dataset(), "nothing")


def test_numbers_are_in_the_units_that_are_usual(study: xr.Dataset) -> None:
    shows = contents(study, "study")
    assert shows["axes"]["load"]["values"] == [1, 10, 100]
    assert shows["axes"]["load"]["unit"] == "N/mm"
    peak = shows["variables"]["peak_pressure"]
    assert peak["unit"] == "MPa"
    assert values(peak) == pytest.approx([100, 200, 300, np.nan, 900, 800], nan_ok=True)


def test_an_evolution_begins_at_the_instant_of_its_largest_pressure() -> None:
    pressure = 1e6 * np.arange(4.0)[[0, 1, 3, 2]][:, None] * np.ones((4, 6))
    evolution = xr.Dataset({"pressure": (("time", "x"), pressure, {"units": "Pa"})}, {"time": [0.0, 1.0, 2.0, 4.0]})
    assert contents(evolution, "evolution")["instant"] == 2


def test_texts_of_a_hostile_file_are_data_that_no_page_executes(study: xr.Dataset) -> None:
    hostile = '"><img src=x onerror="x()"></title></script><script>x()</script>'
    study.attrs["title"] = hostile
    for name in ("peak_pressure", "load"):
        study[name].attrs |= {"long_name": hostile, "units": hostile}
    page = page_of(study.assign_coords(mode=[hostile, "b"]).rename(peak_pressure=hostile.replace("/", "|")), hostile)
    [data] = re.findall(r'<script type="application/json" id="data">(.*?)</script>', page)
    assert json.loads(data)["axes"]["mode"]["values"][0] == hostile
    assert not re.search("<img|<script>x", page)
    # what a script puts on the page, it puts there as text
    assert not re.search("innerHTML|outerHTML|insertAdjacentHTML|document.write", page)


def test_a_fine_contact_is_shown_by_means_of_blocks() -> None:
    ones = np.ones((800, 501))
    axes = {"x": ("x", np.linspace(-1, 1, 800)), "y": ("y", np.linspace(-1, 1, 501))}
    shows = contents(xr.Dataset({"pressure": (("x", "y"), ones), "load": ("x", ones[:, 0])}, axes), "fine")
    pressure = shows["variables"]["pressure"]
    assert MAX_VALUES / 8 < len(values(pressure)) <= MAX_VALUES
    assert (values(pressure) == 1).all()
    across, along = (shows["axes"][dim]["values"] for dim in pressure["dims"])
    assert len(across) * len(along) == len(values(pressure))
    assert along[-1] == 1  # a block of the last cell alone
    assert len(values(shows["variables"]["load"])) == 800  # what is small is shown as it is
