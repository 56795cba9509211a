import re
from dataclasses import replace
from functools import partial
from math import inf
from pathlib import Path
from socket import gethostname
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.answers.evolution import evolution_answer
from contactstudy.evolution import evolve as checkpoint
from contactstudy.evolution.evolve import DrySteps, evolve
from contactstudy.evolution.time_stepper import Instant
from tests.contactstudy.evolution.creeping import (
    EXACT,
    LOAD,
    SOLID,
    by_steps,
    evolved,
    pressures,
    relative,
    rolling_cylinder,
)

GRID, COARSE = cs.Grid((96, 1), (0.6, 1.0)), cs.Grid((24, 1), (0.6, 1.0))
# creep that is over in a hundredth of a second
STIFF = cs.ViscoelasticHalfSpace(0.4, 0.0, ((0.6, 4e-3),))
ELASTIC = rolling_cylinder(cs.HalfSpace(1.0, 0.0))


def test_an_elastic_scene_forgets_its_path() -> None:
    """One solve an instant, whatever lies between; before the first load the bodies just touch."""
    history = cs.LoadHistory((0.0, 1.0, 2.0, 2.0, 3.0), (0.0, 3 * LOAD, LOAD, 2 * LOAD, 0.5 * LOAD))
    found = evolve(replace(ELASTIC, load=history), GRID, EXACT, times=[0.0, 0.5, 2.0, 2.0, 3.0])
    assert (by_steps(found), evolution_answer(found).status) == (0, cs.Status.CONVERGED)
    assert found.work["solves"] <= 5
    assert [frame.load / LOAD for frame in found.frames] == pytest.approx([0.0, 1.5, 1.0, 2.0, 0.5])
    first, *loaded = found.frames
    assert first.pressure.max() == first.gap.min() == 0
    for frame in loaded:
        alone = cs.solve(replace(ELASTIC, load=cs.LineLoad(frame.load)).problem(GRID, EXACT))
        np.testing.assert_allclose(frame.pressure, alone.pressure, atol=1e-5 * alone.pressure.max())


def test_steps_keep_to_the_error_asked_for() -> None:
    history = cs.LoadHistory((0.0, 0.5, 1.0, 1.0), (LOAD, LOAD, 2 * LOAD, 0.7 * LOAD))
    scene, times = rolling_cylinder(SOLID, history), [0.0, 0.25, 0.5, 1.0, 1.0, 2.0]
    fine = np.sort([*np.linspace(0, 2, 201), 1.0])
    exact = evolved(scene, GRID, fine)
    found = evolve(scene, GRID, EXACT, times=times, error=2e-3)
    assert by_steps(found) <= 2e-3
    places = np.searchsorted(fine, times)
    places[4] += 1
    for frame, place in zip(found.frames, places, strict=True):
        true = exact.frames[place]
        assert (frame.time, frame.load) == (true.time, true.load)
        assert relative(frame.pressure, true.pressure) <= frame.errors_by_steps["l1"] + 1e-5


@pytest.mark.parametrize("error", [3e-2, None], ids=["chosen steps", "given steps"])
def test_a_killed_integration_goes_on_to_the_same_bits(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, error: float | None
) -> None:
    """After whichever file."""
    load = cs.LoadHistory((0.0, 0.7, 0.7, 1.0), (LOAD, LOAD, 0.6 * LOAD, 0.6 * LOAD))
    scene, times = rolling_cylinder(SOLID, load, wear=cs.Wear(0.1, 1.0)), np.linspace(0, 1, 9)
    integrated = partial(evolve, scene, COARSE, EXACT, times=times, error=error)
    whole, write = integrated(), checkpoint.Checkpoint.write
    for files in (9, 10, 13):
        written: list[str] = []

        def killed(*arguments: Any, files: int = files, written: list[str] = written) -> None:
            write(*arguments)
            written.append(arguments[1])
            if len(written) == files:
                raise KeyboardInterrupt

        folder = tmp_path / str(files)
        monkeypatch.setattr(checkpoint.Checkpoint, "write", killed)
        with pytest.raises(KeyboardInterrupt):
            integrated(folder=folder)
        monkeypatch.undo()
        seen: list[float] = []
        again = integrated(folder=folder, progress=lambda time, end, seen=seen: seen.append(time))
        assert seen[0] > 0.05  # it did not begin again
        for one, other in zip(again.frames, whole.frames, strict=True):
            np.testing.assert_array_equal(one.pressure, other.pressure)
            np.testing.assert_array_equal(one.gap, other.gap)
            assert one.errors_by_steps == other.errors_by_steps
            assert one.convolutions == other.convolutions
        assert again.counts == whole.counts
    np.testing.assert_array_equal(pressures(integrated(folder=folder)), pressures(whole))


def test_a_folder_is_of_one_integration_one_version_and_one_process(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A file that a kill left half written is none of its own."""
    (tmp_path / f".request.json.{2**22 + 1}@{gethostname()}.partial.json").write_text("x")
    integrated = partial(evolve, rolling_cylinder(SOLID), COARSE, EXACT, folder=tmp_path)

    def second(time: float, end: float) -> None:
        with pytest.raises(cs.InvalidInput, match=r"is locked by process .*: run again when that has"):
            integrated(times=[0.0, 1.0])

    integrated(times=[0.0, 1.0], progress=second)
    assert not list(tmp_path.glob(".*"))
    with pytest.raises(cs.InvalidInput, match=r"^solve\.folder is .*: give another folder\.$"):
        integrated(times=[0.0, 2.0])
    monkeypatch.setattr(checkpoint, "source_hash", lambda: "other")
    with pytest.raises(cs.InvalidInput, match="an integration of another version of this program"):
        integrated(times=[0.0, 1.0])


@pytest.mark.parametrize(
    ("name", "other"), [("request.json", None), ("state.npz", None), ("state.npz", "frame_00000.npz")]
)
def test_a_damaged_folder_is_refused_by_its_name(tmp_path: Path, name: str, other: str | None) -> None:
    """A bit is flipped, or a file stands in the place of another."""
    integrated = partial(evolve, rolling_cylinder(SOLID), COARSE, EXACT, times=[0.0, 0.5, 1.0], folder=tmp_path)
    integrated()
    raw = bytearray((tmp_path / (other or name)).read_bytes())
    raw[len(raw) // 2] ^= 0 if other else 1
    (tmp_path / name).write_bytes(raw)
    with pytest.raises(cs.InvalidInput, match=re.escape(str(tmp_path))):
        integrated()


@pytest.mark.parametrize("padding", [cs.Superposition(2), (cs.ZeroPadding(), cs.ZeroPadding())], ids=str)
def test_every_padding_is_integrated(padding: cs.Padding | cs.Paddings) -> None:
    scene = rolling_cylinder(SOLID, wear=cs.Wear(0.1, 1.0))
    scene = replace(scene, shapes=(*scene.shapes, cs.Waviness(1e-3, across=0.2, along=0.3)))
    grid = cs.Grid((48, 16), (0.8, 0.6))
    found = evolved(scene, grid, [0.0, 0.5, 1.0], padding=padding)
    first, last = found.frames[0], found.frames[-1]
    assert last.pressure.sum() * grid.cell_area / grid.length == pytest.approx(LOAD, rel=1e-7)
    peak = evolve(scene, grid, EXACT, times=[0.0]).frames[0].peak_pressure
    error = dict(evolution_answer(found).frames[0].error)["peak_pressure"].by_cause
    assert abs(first.peak_pressure - peak) <= (error["images"] + 1e-6) * peak


@pytest.mark.parametrize("named", [{"error_estimator": "none"}, {"error": 1e-2}], ids=str)
def test_a_march_stops_without_a_bound_where_no_pressure_carries_the_load(named: dict[str, Any]) -> None:
    history = cs.LoadHistory((0.0, 1.0), (LOAD, 100 * LOAD))
    scene = replace(ELASTIC, load=history, hardness=0.06)
    found = evolution_answer(evolve(scene, COARSE, EXACT, times=np.linspace(0, 1, 5), **named))
    assert found.status is cs.Status.NO_ADMISSIBLE_PRESSURE
    assert LOAD < 0.06 * COARSE.extent[0] < history.at(found.times[-1]) < 100 * LOAD
    errors = found.frames[-1].error.l1
    assert errors.by_cause["steps"] == errors.by_cause["discretisation"] == np.inf
    assert errors.reason == f"No bound: {found.status}"


@pytest.mark.parametrize(
    ("body", "load", "times"),
    [
        # a jump between two instants
        (SOLID, cs.LoadHistory((0, 0.5, 0.5, 1), (LOAD, LOAD, 2 * LOAD, 2 * LOAD)), [0, 1]),
        (STIFF, cs.LoadHistory((0, 1), (0.1 * LOAD, LOAD)), [0, 0.25, 0.5, 0.75, 1]),
        (SOLID, None, [0, 1e-3, 1]),
        (SOLID, None, [0, 1 / 3, 2 / 3, 1]),
        (replace(STIFF, relaxation=((0.6, 0.036),)), None, [0, 10 / 22, 20 / 22, 21 / 22, 1]),
        # whole periods, which are cut
        (SOLID, cs.SineLoad(LOAD, 0.7 * LOAD, 1.0, 0.7), [0, 1, 2, 3]),
    ],
    ids=["jump", "stiff", "short and long", "odd number", "short after long", "periods"],
)
def test_the_error_of_given_steps_is_bounded_for_any_lengths_of_them(
    body: cs.ViscoelasticHalfSpace, load: cs.LoadHistory | cs.SineLoad | None, times: list[float]
) -> None:
    scene = rolling_cylinder(body, load)
    fine = np.union1d(np.linspace(0, times[-1], 201), times)
    exact = pressures(evolved(scene, GRID, fine))
    for frame in evolve(scene, GRID, EXACT, times=times).frames[1:]:
        assert relative(frame.pressure, exact[np.searchsorted(fine, frame.time)]) <= frame.errors_by_steps["l1"]
    assert frame.errors_by_steps["l1"] < 0.1


@pytest.mark.parametrize("failed", [0, 1])
def test_a_pair_has_an_infinite_error_where_short_or_long_steps_have_no_solution(failed: int) -> None:
    unknown: Any = SimpleNamespace(coupled=None)
    before = Instant(time=0.0, load=1.0, pressure=np.ones((1, 1)), states=())
    after = [replace(before, time=1.0), replace(before, time=1.0)]
    after[failed] = replace(after[failed], pressure=np.full((1, 1), np.nan), step_error=inf)
    steps = DrySteps(unknown, "step_doubling")
    assert steps.error((before, before), before, (after[0], after[1])) == inf


def test_a_frame_before_the_load_is_zero_keeps_its_own_error() -> None:
    scene = rolling_cylinder(SOLID, cs.SineLoad(0.0, LOAD, 0.5))
    before, unloaded = evolve(scene, GRID, EXACT, times=[0.5, 1.0]).frames
    true = evolved(scene, GRID, np.linspace(0, 0.5, 65)).frames[-1].pressure
    assert 0 < relative(before.pressure, true) <= before.errors_by_steps["l1"]
    assert unloaded.errors_by_steps["l1"] == 0


def test_the_largest_recorded_pressure_of_a_jump_is_given_though_a_peak_before_it_is_not_recorded() -> None:
    load = cs.LoadHistory((0.0, 0.2, 0.5, 0.5, 1.0), (LOAD, 3 * LOAD, LOAD, 2 * LOAD, LOAD))
    found = cs.solve(rolling_cylinder(SOLID, load), COARSE, EXACT, times=(0.5, 0.5, 1.0))
    peak = found.quantities["peak_pressure"]
    assert (peak.value, peak.bound) == (found.frames[1].peak_pressure, np.inf)
    assert "at 0.2 s, between the recorded instants" in peak.reason


def test_contacts_that_stop_early_count_in_the_errors_of_later_instants() -> None:
    scene, times = rolling_cylinder(SOLID), np.linspace(0, 1, 9)
    exact = evolve(scene, GRID, EXACT, times=times)
    found = evolve(scene, GRID, EXACT, times=times, options=cs.SolveOptions(max_iterations=3))
    assert evolution_answer(found).status is cs.Status.ITERATION_LIMIT
    for frame, true in zip(found.frames, exact.frames, strict=True):
        assert 1e-9 < relative(frame.pressure, true.pressure) <= frame.estimate.l1.residual


def test_steps_whose_error_is_not_estimated_go_from_instant_to_instant() -> None:
    steps = cs.TimeSteps((0.0, 1.0, 2.0), error_estimator="none")
    found = cs.solve(rolling_cylinder(SOLID), times=steps, period=1.0)
    assert found.counts["solves"][0] == 3
    assert found.error.l1.steps == np.inf
    assert "time-discretisation error was not estimated" in found.accuracy
