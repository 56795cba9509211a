from pathlib import Path

import pytest

from contactstudy import InvalidInput
from studies.registry import BUILT_IN, load

FILE = '''"""Two grids, nothing else."""

import xarray as xr

from studies.model.axis import Axis
from studies.reference.line_contact import case_at

axes = (
    Axis("padding", ("exact",), "representation of the periodic direction"),
    Axis("images", (6,), "periods superposed on each side"),
    Axis("period", (2.4,), "period length over Hertz half-width"),
    Axis("grid", (16, 24), "cells across the width and along one period"),
)


def measures(case, solution):
    return {"peak": xr.Variable((), solution.pressure.max(), {"units": "Pa", "long_name": "peak"})}


def figure(dataset):
    return ()
'''


@pytest.fixture
def study_file(tmp_path: Path) -> Path:
    path = tmp_path / "two_grids.py"
    path.write_text(FILE)
    return path


@pytest.mark.parametrize("name", BUILT_IN)
def test_built_in_studies_have_a_title_and_cases(name: str) -> None:
    study = load(name)
    assert study.title.endswith(".")
    assert len(study.cases()) > 1


def test_a_study_may_stand_in_a_file(study_file: Path) -> None:
    study = load(str(study_file))
    assert (study.name, study.title) == ("two_grids", "Two grids, nothing else.")
    assert len(study.cases()) == 2


@pytest.mark.parametrize("part", ["axes", "case_at", "measures"])
def test_a_study_without_one_of_its_names_is_refused(study_file: Path, part: str) -> None:
    study_file.write_text(FILE + f"\ndel {part}\n", encoding="utf-8")
    with pytest.raises(InvalidInput, match=f"has no '{part}'"):
        load(str(study_file))


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("paddin", "did you mean 'padding'"),
        ("xyz", "choose from accuracy, coating, creep"),
        ("nowhere.py", "cannot be read"),
    ],
)
def test_an_unknown_study_is_refused_with_a_remedy(name: str, message: str) -> None:
    with pytest.raises(InvalidInput, match=message):
        load(name)


@pytest.mark.parametrize(
    ("axis", "values", "message"),
    [
        ("period", "0", "period is 0.0: give a period above 0"),
        ("period", "-2.4", "period is -2.4"),
        ("grid", "1", "grid is 1: give at least 2 cells"),
        ("images", "-1", "images is -1: must be a whole number, at least 0"),
        ("padding", "exakt", "padding is 'exakt': did you mean 'exact'"),
    ],
)
def test_a_point_that_cannot_be_is_refused_before_anything_runs(
    axis: str, values: str, message: str
) -> None:
    with pytest.raises(InvalidInput, match=f"^{message}"):
        load("padding").override({axis: values}).cases()
