"""Other libraries take our datasets, where they are installed."""

from pathlib import Path

import pytest
import xarray as xr

import contactstudy as cs
import studies.accessor  # noqa: F401 (the accessor)
from tests.conftest import LineContact


@pytest.fixture
def solved(line_contact: LineContact) -> xr.Dataset:
    grid = line_contact.grid((16, 6), 1.2)
    return cs.solve(line_contact.scene.problem(grid, cs.ExactPeriodicity())).to_dataset()


def test_a_study_with_units_of_pint_gives_the_same_front(small_run: Path) -> None:
    pytest.importorskip("pint_xarray")
    dataset = xr.load_dataset(small_run / "padding.nc")
    numeric = dataset[[name for name, v in dataset.data_vars.items() if v.dtype.kind == "f"]]
    kept = numeric.assign(case_status=dataset["case_status"])
    plain = kept.study.pareto("pressure_error_l1")
    quantified = kept.pint.quantify({"case_status": None}).study.pareto("pressure_error_l1")
    assert plain.equals(quantified)


def test_zarr_gives_back_a_solution(solved: xr.Dataset, tmp_path: Path) -> None:
    pytest.importorskip("zarr")
    solved.to_zarr(tmp_path / "solved.zarr", consolidated=False)
    found = xr.load_dataset(tmp_path / "solved.zarr", engine="zarr", consolidated=False)
    xr.testing.assert_allclose(found, solved)


def test_hvplot_maps_a_solution(solved: xr.Dataset) -> None:
    pytest.importorskip("hvplot.xarray")
    assert solved["pressure"].hvplot.image(x="x", y="y") is not None


def test_pandas_gets_a_row_for_each_cell(solved: xr.Dataset) -> None:
    frame = solved["pressure"].to_dataframe()
    assert len(frame) == 16 * 6
    assert frame["pressure"].max() == float(solved["pressure"].max())
