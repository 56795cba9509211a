import subprocess
import sys

import numpy as np
import xarray as xr

import contactstudy as cs
from tests.conftest import LineContact


def test_dataset_labels_every_variable(line_contact: LineContact, tmp_path) -> None:  # noqa: ANN001
    grid = line_contact.grid((16, 6), 1.2)
    solution = cs.solve(line_contact.scene.problem(grid, cs.ExactPeriodicity()))
    dataset = cs.to_dataset(solution)
    assert dataset["pressure"].dims == ("width", "length")
    assert dataset.sizes == {"width": 16, "length": 6}
    for variable in dataset.variables.values():
        assert variable.attrs["units"]
        assert variable.attrs["long_name"]
    np.testing.assert_array_equal(dataset["gap"], solution.gap)
    assert dataset.attrs["status"] == "CONVERGED"
    assert "ExactPeriodicity" in dataset.attrs["padding"]
    dataset.to_netcdf(tmp_path / "solution.nc")
    xr.testing.assert_identical(xr.load_dataset(tmp_path / "solution.nc"), dataset)


def test_dataset_holds_an_estimate_by_cause(line_contact: LineContact, tmp_path) -> None:  # noqa: ANN001
    problem = line_contact.scene.problem(line_contact.grid(16, 1.2), cs.DuplicatedPadding())
    solution = cs.solve(problem)
    estimate = cs.error_estimate(solution)
    dataset = cs.to_dataset(solution, estimate)
    for name, parts in (("peak_pressure", estimate.peak_pressure), ("pressure_l1", estimate.l1)):
        error = dataset[f"{name}_error_estimate"]
        assert float(error.sel(cause="truncation")) == parts.truncation
        assert float(error.sum("cause")) == parts.total
        assert error.attrs["units"]
        assert error.attrs["long_name"]
    dataset.to_netcdf(tmp_path / "solution.nc")
    xr.testing.assert_identical(xr.load_dataset(tmp_path / "solution.nc"), dataset)
    assert "cause" not in cs.to_dataset(solution).dims


def test_a_solve_imports_neither_xarray_nor_matplotlib() -> None:
    code = (
        "import sys, contactstudy as cs; s = cs.HalfSpace(youngs_modulus=1e9, poisson_ratio=0.3); "
        "scene = cs.Scene(load=cs.LineLoad(1e3), solids=(s, s), shapes=(cs.Cylinder(radius=0.1),)); "
        "a = scene.hertz.half_width; "
        "cs.solve(scene.problem(cs.Grid(cells=(8, 2), extent=(3 * a, a)), cs.ExactPeriodicity())); "
        "print(sorted({'xarray', 'matplotlib', 'dask', 'netCDF4', 'studies'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
