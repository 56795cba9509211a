from dataclasses import replace
from math import inf
from pathlib import Path

import cf_xarray  # noqa: F401 (the accessor)
import numpy as np
import pytest
import xarray as xr

import contactstudy as cs
from contactstudy.answers.lubricated_contact import film_answer
from contactstudy.domain.errors import ErrorParts
from contactstudy.lubrication.steady_film import solve_lubricated
from tests.conftest import LineContact
from tests.contactstudy.lubrication.scenes import by_moes
from tests.contactstudy.lubrication.scenes import grid as film_cells


def test_dataset_labels_every_variable(line_contact: LineContact, tmp_path: Path) -> None:
    scene = replace(line_contact.scene, outputs=(cs.SubsurfaceStress(depths=(1e-5, 2e-5)),))
    solution = cs.solve(scene, line_contact.grid((16, 6), 1.2), cs.DuplicatedPadding())
    dataset = solution.to_dataset()
    assert dataset["pressure"].sizes == {"x": 16, "y": 6}
    assert dataset.cf.axes == {"X": ["x"], "Y": ["y"], "Z": ["z"]}
    for variable in dataset.drop_vars("component").variables.values():
        assert variable.attrs["units"]
        assert variable.attrs["long_name"]
    np.testing.assert_array_equal(dataset["gap"], solution.gap)
    meanings = dataset["status"].attrs["flag_meanings"].split()
    assert meanings[int(dataset["status"])] == "CONVERGED"
    assert float(dataset["hertz_peak_pressure"]) == line_contact.hertz.peak_pressure
    load = dataset["load_per_length"]
    assert float(load) == pytest.approx(1e5)
    assert float(dataset[load.attrs["ancillary_variables"]]) == solution.quantities["load_per_length"].bound
    error = dataset["pressure_l1_error_estimate"]
    assert float(error.sel(cause="images")) == solution.error.l1.images
    assert float(error.sum("cause")) == pytest.approx(solution.error.l1.total, rel=1e-14)
    dataset.to_netcdf(tmp_path / "solution.nc")
    xr.testing.assert_identical(xr.load_dataset(tmp_path / "solution.nc"), dataset)


def test_the_scene_of_a_dataset_reads_back(line_contact: LineContact, tmp_path: Path) -> None:
    grid = line_contact.grid((16, 6), 1.2)
    paddings = (cs.ZeroPadding(), cs.Superposition(3))
    solution = cs.solve(line_contact.scene.problem(grid, paddings))
    path = tmp_path / "scene.toml"
    path.write_text(solution.to_dataset().attrs["scene"])
    read = cs.read_scene(path)
    assert (read.scene, read.grid, read.padding) == (line_contact.scene, grid, paddings)


def test_an_answer_is_shown_with_its_accuracy_first_and_a_picture(line_contact: LineContact) -> None:
    grid = line_contact.grid((32, 16), 1.2)
    contact = cs.solve(line_contact.scene, grid, cs.ExactPeriodicity(), error="2 %")
    assert contact.accuracy in repr(contact).splitlines()[0]
    varying = line_contact.with_shapes(cs.Waviness(1e-7, along=grid.length))
    on_one_row = cs.solve(varying, line_contact.grid((32, 1), 1.2), cs.ExactPeriodicity())
    assert "along the length of a Waviness is left out" in repr(on_one_row).splitlines()[1]
    assert "data:image/png;base64," in contact._repr_html_()
    assert contact.plot()._repr_png_().startswith(b"\x89PNG")  # shown once, as pyplot does not know it
    for value, said in (
        (contact, "CONVERGED, 32 x 16 cells"),
        (contact.scene, "solids[1]"),
        (contact.error, "peak_pressure"),
        (cs.plan(line_contact.scene, grid=grid), "Grid(cells=(32, 16)"),
    ):
        html = value._repr_html_()
        assert said in html
        assert html.count("\n") < 20


def test_a_lubricated_contact_is_labelled_with_its_errors_and_drawn() -> None:
    contact = solve_lubricated(by_moes(20, 5), film_cells(100, 5.43), cs.ExactPeriodicity())
    parts = ErrorParts(discretisation=0.1, inlet=0.2, residual=inf)
    estimate = cs.ErrorEstimate(parts, central_film=parts, minimum_film=parts, warnings=("a spike",))
    contact = film_answer(contact, estimate=estimate)
    dataset = contact.to_dataset()
    np.testing.assert_array_equal(dataset["film"].values, contact.film)
    assert dataset["minimum_film_error_estimate"].sel(cause="inlet") == 0.2
    assert dataset.attrs["warnings"] == "a spike"
    assert contact.plot().axes
