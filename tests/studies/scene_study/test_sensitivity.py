"""What quantities change by as each number of a scene is lowered and raised alone."""

from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import contactstudy as cs
from contactstudy import InvalidInput
from studies import RunOptions, sensitivity
from studies.scene_study.sensitivity import sensitivity_study
from tests.studies.cli.conftest import said
from tests.studies.scene_study.conftest import CYLINDER, LOAD, STEEL, given

HERE = RunOptions(workers=0)
SCENE = (
    LOAD.replace("100 N/mm", "100 N/mm ± 5 %")
    + STEEL
    + STEEL.replace("0.3", "0.5").replace("210 GPa", "2 GPa +- 500 MPa")
    + CYLINDER.replace("10 mm", "10 mm +- 50 um")
    + '[[shapes]]\nkind = "Tilt"\nangle = 0.0\n'
    + given(64, "1.8 mm")
)


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("sensitivity") / "steel.toml"
    path.write_text(SCENE)
    return path


@pytest.fixture(scope="module")
def changes(scene: Path) -> xr.Dataset:
    return sensitivity(scene, options=HERE)


def test_each_number_changes_the_peak_pressure_as_hertz_has_it(changes: xr.Dataset) -> None:
    change = changes["peak_pressure_change"] / changes["peak_pressure"]
    bound = 2 * changes["peak_pressure_change_bound"] / changes["peak_pressure"]
    factors = np.array([-1, 1])
    expected = {
        "load.per_length": (1 + 0.05 * factors) ** 0.5 - 1,
        "shapes.0.radius": (1 + 0.005 * factors) ** -0.5 - 1,
    }
    for number, found in expected.items():
        assert change.sel(number=number).values == pytest.approx(found, abs=float(bound.sel(number=number).max()))
    assert float(abs(change.sel(number="solids.1.youngs_modulus")).min()) > 0.1


def test_whole_numbers_zeros_and_settings_are_not_changed(changes: xr.Dataset) -> None:
    solids = [f"solids.{n}.{key}" for n in (0, 1) for key in ("youngs_modulus", "poisson_ratio")]
    assert changes["number"].values.tolist() == ["load.per_length", *solids, "shapes.0.radius"]
    assert "shapes.1.angle" in changes.attrs["notes"]
    # the scene cannot have a Poisson's ratio above a half
    raised = changes["peak_pressure_change"].sel(number="solids.1.poisson_ratio")
    assert np.isnan(raised).values.tolist() == [False, True]


def test_lists_change_in_size_as_a_whole_and_bodies_that_must_be_alike_together(scene: Path) -> None:
    fretting = scene.with_name("fretting.toml")
    cycle = '[friction]\nkind = "Fretting"\ncoefficient = 0.5\nforces = ["20 N/mm", "-20 N/mm ± 1 N/mm", "20 N/mm"]\n'
    fretting.write_text(LOAD + STEEL + STEEL + CYLINDER + cycle + given(64, "0.4 mm"))
    study = sensitivity_study(cs.read_scene(fretting))
    assert "solids.youngs_modulus" in study.axes[0].values
    study = sensitivity_study(fretting)
    raised = study.case_at({"number": "friction.forces", "side": "raised"}).scene.friction.forces
    assert raised == pytest.approx((20.2e3, -21e3, 20.2e3))


def test_the_command_prints_and_draws_the_changes_and_goes_on_where_it_stopped(scene: Path) -> None:
    command = ("run", scene, "--sensitivity", "--workers", 0, "--out", scene.parent / "out")
    said(*command)
    again = said(*command, "--plot", "peak_pressure")
    assert "cases are stored, 0 to compute" in again
    within = {row.split()[1]: "within the bound" in row for row in again.splitlines() if "peak_pressure" in row}
    # a hundredth of the stiffness of steel is nothing beside a soft body
    assert within["solids.0.youngs_modulus"]
    assert not within["load.per_length"]
    table = (scene.parent / "out" / "steel-sensitivity.csv").read_text()
    assert table.count("peak_pressure") == len(within) == 6
    assert (scene.parent / "out" / "steel-sensitivity" / "tornado.png").is_file()
    with pytest.raises(InvalidInput, match="--vary is for a sweep"):
        said(*command, "--vary", "load.per_length=1 N/mm")
