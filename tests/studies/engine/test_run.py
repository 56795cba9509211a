from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from threadpoolctl import threadpool_info, threadpool_limits

import contactstudy as cs
from contactstudy.domain.checks import InvalidInput
from studies.engine.cost import estimate_cost
from studies.engine.options import RunOptions
from studies.engine.run import run
from studies.reference.line_contact import HERTZ, SCENE
from studies.registry import load
from studies.scene_study.study_of import study_of
from studies.store.netcdf import read
from tests.studies.conftest import quiet
from tests.studies.engine import trouble
from tests.studies.scene_study.conftest import SMOOTH, given

NUMBERS = [
    "axis_pressure_error", "pressure_error_max", "pressure_error_l1", "half_width_error",
    "length_variation", "setup_time", "solve_time", "iterations", "convolutions", "residual",
]  # fmt: skip


@pytest.fixture(scope="module")
def dataset(small_run: Path) -> xr.Dataset:
    return read(small_run / "padding.nc")


def test_a_padding_without_images_is_computed_once_and_broadcast(dataset: xr.Dataset) -> None:
    for name in NUMBERS:  # times too: were the case run twice, they would differ
        exact = dataset[name].sel(padding="exact")
        assert (exact == exact.isel(images=0)).all()
    superposed = dataset["axis_pressure_error"].sel(padding="superposed", period=0.6, grid=24)
    assert len(set(superposed.values.tolist())) == 3


def test_the_file_says_where_its_numbers_come_from(dataset: xr.Dataset) -> None:
    for name in ("title", "first_case", "source", "history", "git_revision", "cpu", "timing"):
        assert dataset.attrs[name], name
    # the instant of the first run, and its command
    assert datetime.fromisoformat(dataset.attrs["date_created"]).tzinfo == UTC
    assert dataset.attrs["history"].startswith(dataset.attrs["date_created"] + " ")
    assert f"contactstudy {cs.__version__}" in dataset.attrs["source"]
    assert "LineLoad(per_length=100000.0)" in dataset.attrs["first_case"]


def test_stored_errors_are_those_of_a_solve_alone(dataset: xr.Dataset) -> None:
    grid = cs.Grid((24, 6), (2.4 * HERTZ.half_width, 0.6 * HERTZ.half_width))
    solution = cs.solve(SCENE.problem(grid, cs.Superposition(images=2)))
    stored = dataset.sel(padding="superposed", images=2, period=0.6, grid=24)
    variation = np.ptp(solution.pressure, axis=1).max() / HERTZ.peak_pressure
    assert stored["length_variation"].item() == pytest.approx(variation, rel=1e-12)
    assert stored["iterations"].item() == solution.iterations
    assert stored["convolutions"].item() == solution.convolutions


@pytest.mark.whole
def test_a_case_that_another_study_in_the_folder_has_is_not_computed_again(tmp_path: Path) -> None:
    axes = {"padding": "exact,zero", "images": "1", "period": "2.4"}
    lines: list[str] = []
    first = run(load("padding").override(axes | {"grid": "16,24"}), tmp_path, workers=0, repeats=1)
    second = run(
        load("grid").override(axes | {"grid": "16,24,32"}),
        tmp_path,
        workers=0,
        repeats=1,
        log=lines.append,
    )
    assert "grid: 4 cases are stored, 2 to compute" in lines
    for name in (*NUMBERS, "setup_time_all"):  # to the last bit, and the very same times
        np.testing.assert_array_equal(second[name].isel(grid=[0, 1]), first[name])
    assert np.isfinite(second["solve_time"]).all()


@dataclass(frozen=True)
class Threads(trouble.Square):
    """The largest number of threads of any library for linear algebra."""

    def run(self, prepared: float) -> float:
        np.ones((2, 2)) @ np.ones((2, 2))
        return max(library["num_threads"] for library in threadpool_info())


def test_a_case_has_one_thread_whatever_the_process_had(tmp_path: Path) -> None:
    study = trouble.study_of(Threads, [1.0], lambda case, result: {"threads": result}, "none")
    with threadpool_limits(2):
        assert Threads(0.0).run(0.0) == 2
        dataset = run(study, tmp_path, workers=0, log=quiet)
        assert Threads(0.0).run(0.0) == 2
    assert dataset["threads"].values.tolist() == [1]


def test_computations_without_a_plan_are_said_to_be_unknown(tmp_path: Path) -> None:
    said: list[str] = []
    found = estimate_cost(trouble.study([1, 2]), tmp_path, options=RunOptions(), log=said.append)
    assert found is None
    assert "the time is not known" in said[-1]
    assert not any(tmp_path.iterdir())


def test_the_reason_why_a_scene_has_no_plan_on_the_padding_of_a_case_is_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object, padding: object, **__: object) -> None:
        raise InvalidInput(f"plan.padding is {padding}: give another.")

    monkeypatch.setattr("contactstudy.plan", refuse)
    said: list[str] = []
    study = load("grid").override({"padding": "duplicated", "grid": "16"})
    assert estimate_cost(study, tmp_path, options=RunOptions(), log=said.append) is None
    assert said[-1].endswith("failed (InvalidInput: plan.padding is DuplicatedPadding(): give another.)")


def test_the_time_of_what_is_missing_is_that_of_its_own_plans(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A grid that is computed already, and instants of an evolution."""
    wear = '[wear]\ncoefficient = 1e-16\nspeed = "1 m/s"\n'
    steps = "[time_steps]\nend = 1\ninstants = 3\n"
    (tmp_path / "worn.toml").write_text(SMOOTH + given(24, "0.8 mm") + wear + steps)
    study, options = (
        load("grid").override({"padding": "exact", "grid": "16"}),
        RunOptions(repeats=0),
    )
    run(study, tmp_path, options=options, workers=0, log=quiet)
    assert estimate_cost(study, tmp_path, options=options, log=quiet) == 0
    worn = study_of(tmp_path / "worn.toml", {"load.per_length": "50,100 N/mm"})
    planned: list[tuple[int, float]] = []
    plan = cs.plan

    def recorded(scene: cs.Scene, *, grid: cs.Grid, **others: Any) -> Any:
        found = plan(scene, grid=grid, **others)
        planned.append((grid.cells[0], found.seconds))
        return found

    monkeypatch.setattr("contactstudy.plan", recorded)
    for more, cells in ((study.override({"grid": "16,24"}), [24]), (worn, [24, 24])):
        planned.clear()
        estimated = estimate_cost(more, tmp_path, options=options, log=quiet)
        assert [of_case for of_case, _ in planned] == cells
        assert estimated == pytest.approx(sum(seconds for _, seconds in planned))
        assert 0 < estimated < np.inf


def test_workers_and_repeats_stand_above_the_options_and_options_are_checked(
    tmp_path: Path,
) -> None:
    options = RunOptions(workers=0, repeats=2)
    dataset = run(trouble.study([1]), tmp_path, options=options, repeats=3, log=quiet)
    assert dataset.sizes["repeat"] == 3
    for name, value in (
        ("workers", -1),
        ("repeats", 1.5),
        ("time_limit", 0.0),
        ("retry", ("all",)),
    ):
        with pytest.raises(InvalidInput, match=rf"^RunOptions\.{name}.* is "):
            RunOptions(**{name: value})
