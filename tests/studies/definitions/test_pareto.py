from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from studies.advice.settings_table import settings
from studies.engine.run import run
from studies.reference.line_contact import LINE
from studies.registry import load
from studies.report.drawings.pareto import (
    decades,
    dominated_modes,
    recommendation_check,
    savings,
)
from studies.store.netcdf import read
from tests.studies.conftest import quiet


@pytest.fixture(scope="module")
def swept(tmp_path_factory: pytest.TempPathFactory) -> xr.Dataset:
    """Two grids, timed by the transforms they took, so that no clock decides."""
    out = tmp_path_factory.mktemp("pareto")
    axes = {"grid": "32,64", "period": "0.6,2.4", "solver_tolerance": "1e-6"}
    run(load("pareto").override(axes), out, workers=0, repeats=1, log=quiet)
    dataset = read(Path(out) / "pareto.nc")
    points = dataset["grid"] ** 2 * xr.where(dataset["padding"] == LINE, 1 / dataset["grid"], 1)
    padded = points * xr.where(dataset["padding"].isin(["zero", "superposed"]), 2, 1)
    work = 1e-8 * padded * dataset["convolutions"]
    dataset["solve_time"] = work.transpose(*dataset["convolutions"].dims)
    dataset["setup_time"] = 0 * dataset["solve_time"] + 1e-3
    return dataset


@pytest.mark.whole
def test_one_cell_along_the_length_is_as_accurate_as_many(swept: xr.Dataset) -> None:
    errors = swept["corrected_error_l1"].sel(solver="preconditioned_cg", grid=64).isel(images=0)
    line, exact = (errors.sel(padding=name, period=2.4).item() for name in (LINE, "exact"))
    # to the solver's tolerance of 1e-6
    assert line == pytest.approx(exact, abs=2e-5)
    assert exact < 1e-4
    raw = swept["pressure_error_l1"].sel(solver="preconditioned_cg", grid=64, padding="exact")
    assert float(raw.max()) > 10 * exact


def test_points_of_one_computation_count_once(swept: xr.Dataset) -> None:
    every = settings(swept.sel(period=0.6), "pressure_error_l1")
    # two grids and two solvers; two n for those that count images
    counts = {mode: int((every.modes == mode).sum()) for mode in every.modes}
    assert counts == {
        "zero": 4, "duplicated": 4, "superposed": 8, "circular": 8, "exact": 4, LINE: 4
    }  # fmt: skip


def test_padding_the_length_with_zeros_never_pays(swept: xr.Dataset) -> None:
    claim, measured = dominated_modes(swept)
    assert claim.startswith("Zero")
    assert "superposed" in claim
    assert "exact is the only one" in measured
    saved = savings(swept)
    assert all(best < 1 for mode in ("zero", "superposed") for best, _ in saved[mode].values())
    assert saved["exact"][0.6][0] == np.inf
    assert LINE not in saved


def test_only_exact_periodicity_buys_the_fifth_digit(swept: xr.Dataset) -> None:
    bought = decades(swept)
    assert np.isfinite(bought["exact", "0.6 a"][3])
    assert not np.isfinite(bought["circular", "0.6 a"][3])
    assert bought[LINE, "any"][3] < bought["exact", "2.4 a"][3]
    assert "100\xa0%" in recommendation_check(swept)[0]
