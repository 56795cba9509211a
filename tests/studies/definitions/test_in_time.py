"""The studies of contacts that change in time."""

from pathlib import Path

import numpy as np
import pytest

from studies.engine.run import run
from studies.registry import load, load_drawing
from studies.report import page as report
from tests.studies.conftest import quiet


@pytest.mark.whole
def test_the_error_of_creep_falls_with_the_steps_under_its_estimate(tmp_path: Path) -> None:
    study = load("creep").override({"steps": "10,20,40", "grid": "64,512"})
    dataset = run(study, tmp_path, workers=0, repeats=0, log=quiet)
    assert (dataset["solver_status"] == 0).all()
    fine = dataset.sel(grid=512)
    error = fine["pressure_error_l1"].values
    # by the 1.5th power at least, until the cells count
    assert (error[:-1] / error[1:] > 2).all()
    # the estimate is of the steps alone; 512 cells leave 0.35 (dx / a)^1.5 = 2e-4
    assert (fine["step_error"].values + 3e-4 > error).all()
    # creep multiplies compliance by 1 + 1.5 (1 - exp(-2))
    widest = float(fine["half_width"].isel(steps=-1, time=-1))
    assert abs(widest - np.sqrt(1 + 1.5 * (1 - np.exp(-2)))) < 0.36 / 512 / 0.1
    report.draw(study, load_drawing("creep"), tmp_path)
    assert (tmp_path / "creep" / "creep.png").is_file()
    assert load_drawing("creep").findings(dataset)


@pytest.mark.whole
def test_explicit_wear_breaks_before_its_limit_and_implicit_never(tmp_path: Path) -> None:
    study = load("wear").override({"steps": "16,32,128"})
    stored = run(study, tmp_path, workers=0, repeats=0, log=quiet)
    dataset = stored.isel(grid=0)
    error = dataset["pressure_error_l1"]
    stable = dataset["longest_explicit"].sel(scheme="explicit") > 1
    assert stable.values.tolist() == [False, False, True]
    assert (error.sel(scheme="explicit")[:2] > 0.5).all()
    assert error.sel(scheme="explicit")[2] < 1e-2
    assert (error.sel(scheme="implicit") < 2e-2).all()
    assert (error.sel(scheme="two-stage") < error.sel(scheme="implicit")).all()
    assert float(dataset["volume_error"].max()) < 1e-13
    # between the rigid law and that of the cubes added, and a little above: 2 and 9^(1/3) = 2.08
    last = float(dataset["half_width"].sel(scheme="two-stage").isel(steps=-1, distance=-1))
    assert 2 < last < 2.2
    report.draw(study, load_drawing("wear"), tmp_path)
    assert (tmp_path / "wear" / "wear.png").is_file()
    assert load_drawing("wear").findings(stored)
