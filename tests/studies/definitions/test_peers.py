from pathlib import Path

import numpy as np
import pytest

from studies.engine.run import run
from studies.registry import load, load_drawing
from tests.studies.conftest import quiet


def test_a_program_that_is_not_there_is_a_failed_case_that_says_so(tmp_path: Path) -> None:
    study = load("peers").override({"grid": "32"})
    dataset = run(study, tmp_path, workers=0, repeats=1, log=quiet)
    found = dataset.isel(grid=0, threads=0)
    ours = found.sel(program="contactstudy")
    assert (ours["case_status"] == 1).all()
    assert (ours["difference"] < 1e-7).all()
    assert np.isfinite(ours["solve_time"]).all()
    absent = found.sel(program="tamaas", boundary="semi-periodic")
    assert int(absent["case_status"]) == 2
    assert load_drawing("peers").figure(dataset)


@pytest.mark.whole
def test_a_program_without_threads_fails_on_two_and_says_so(tmp_path: Path) -> None:
    axes = {"grid": "32", "program": "contactstudy,ContactMechanics", "boundary": "free"}
    study = load("peers").override(axes | {"threads": "1,2"})
    dataset = run(study, tmp_path, workers=0, repeats=1, log=quiet).isel(grid=0, boundary=0)
    ours = dataset.sel(program="contactstudy")
    assert (ours["difference"] < 1e-7).all()
    without = dataset.sel(program="ContactMechanics", threads=2)
    assert int(without["case_status"]) == 2
    figure = load_drawing("peers").figure(dataset.expand_dims(["boundary", "grid"], [1, 2]))
    assert "1 thread or 2 threads" in figure[0].caption


@pytest.mark.parametrize(
    ("program", "boundaries"),
    [("ContactMechanics", ["semi-periodic", "free"]), ("tamaas", ["free"]), ("aspher", ["free"])],
)
def test_programs_agree_where_they_hold_pressure_constant_in_cells(
    program: str, boundaries: list[str], tmp_path: Path
) -> None:
    pytest.importorskip(program)
    study = load("peers").override({"grid": "32", "program": program, "boundary": boundaries})
    dataset = run(study, tmp_path, workers=0, repeats=0, log=quiet)
    assert (abs(dataset["load_carried"] - 1) < 1e-6).all()
    assert (dataset["difference"] < 1e-2).all()  # 10 images leave 3e-3
