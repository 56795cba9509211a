"""The study of bodies that yield."""

from pathlib import Path

import pytest

from studies.engine.run import run
from studies.registry import load, load_drawing
from studies.report import page as report
from tests.studies.conftest import quiet


@pytest.mark.whole
def test_a_contact_that_yields_nears_the_known_one_and_a_hardness_does_not(tmp_path: Path) -> None:
    """Errors are of first order in the steps: 0.75 % of the pressure with 8, by finite elements too."""
    study = load("plastic").override({"pressure": "1.5,3", "steps": "4,8", "grid": "48"})
    dataset = run(study, tmp_path, workers=0, repeats=0, log=quiet).isel(grid=0, hardening=0)
    assert (dataset["solver_status"] == 0).all()
    known = dataset.sel(pressure=3.0)
    error = known["peak_pressure_error"].values
    assert error[1] < 1.5e-2
    assert 1.4 < error[0] / error[1] < 2.5
    # a cell is a seventh of the half-width, a layer down there two of them
    assert float(known["half_width_error"][1]) < 0.1
    assert float(known["plastic_depth_error"][1]) < 0.1
    assert float(known["dent_error"][1]) < 0.03
    elastic = dataset.sel(pressure=1.5).isel(steps=-1)
    assert float(elastic["plastic_depth"]) == 0.0
    assert float(elastic["dent"]) == 0.0
    assert float(elastic["cap_difference"]) < 1e-6
    # 2.8 Y over 3 Y, not 0.787
    assert float(known["cap_pressure"][1]) == pytest.approx(2.8 / 3, abs=1e-9)
    assert float(known["cap_difference"][1]) > 0.1
    report.draw(study, load_drawing("plastic"), tmp_path)
    assert (tmp_path / "plastic" / "plastic.png").is_file()
    assert load_drawing("plastic").findings(dataset.expand_dims(("grid", "hardening")))
