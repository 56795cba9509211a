"""What a run is expected to cost, as the plans of its cases say."""

from pathlib import Path

import pytest

import contactstudy as cs
from studies.engine.forecast import SAMPLE, Forecast, forecast
from studies.engine.options import RunOptions
from studies.engine.run import estimate_cost, run
from studies.model.case import Case
from studies.registry import load
from tests.studies.conftest import quiet
from tests.studies.engine import trouble


@pytest.fixture
def _seconds_are_cells(monkeypatch: pytest.MonkeyPatch) -> None:
    class Plan:
        def __init__(self, scene: cs.Scene, grid: cs.Grid) -> None:
            self.seconds = float(grid.cells[0])

    monkeypatch.setattr(cs, "plan", Plan)


def cases(*cells: int) -> list[Case]:
    study = load("grid").override({"padding": "exact", "grid": list(cells)})
    return [case for case in study.cases() if isinstance(case, Case)]


@pytest.mark.usefixtures("_seconds_are_cells")
def test_the_seconds_of_a_run_are_the_sum_of_those_of_its_plans() -> None:
    found = forecast(cases(16, 32, 64), 6, [1000, 3000])
    assert found == Forecast(3, 6, 112.0, 6000.0)
    assert (
        str(found)
        == "about 1.1e+02 s to compute (shared by the workers), 2.2e+02 s to time, 6 kB on disk"
    )


@pytest.mark.usefixtures("_seconds_are_cells")
def test_of_many_cases_a_few_are_planned_and_stand_for_the_others() -> None:
    few = cases(16, 32)
    found = forecast([few[n % 2] for n in range(10 * SAMPLE)], 0, [])
    assert found.seconds == pytest.approx(10 * SAMPLE * 16, rel=1.0)
    assert found.size is None


def test_computations_without_a_plan_are_said_to_be_unknown(tmp_path: Path) -> None:
    said: list[str] = []
    found = estimate_cost(trouble.study([1, 2]), tmp_path, options=RunOptions(), log=said.append)
    assert (found.cases, found.runs, found.seconds) == (2, 4, None)
    assert "how long is not known" in said[-1]
    assert not any(tmp_path.iterdir())


def test_a_study_of_scenes_is_expected_to_take_some_time(tmp_path: Path) -> None:
    study = load("grid").override({"padding": "exact,zero", "grid": "16,24"})
    run(study, tmp_path, workers=0, repeats=0, log=quiet)
    grown = study.override({"grid": "16,24,32"})
    found = estimate_cost(grown, tmp_path, options=RunOptions(repeats=0), log=quiet)
    assert found.cases == 2
    assert found.seconds is not None
    assert 0 < found.seconds < 10
    assert found.size is not None
