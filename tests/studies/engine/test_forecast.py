"""What a run is expected to cost, as the plans of its cases say."""

from pathlib import Path

from studies.engine.options import RunOptions
from studies.engine.run import estimate_cost, run
from studies.registry import load
from tests.studies.conftest import quiet
from tests.studies.engine import trouble


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
