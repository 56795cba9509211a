import re
from dataclasses import replace
from functools import partial
from math import pi
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.answers.evolution import evolution_answer
from contactstudy.domain.fields import Array
from contactstudy.evolution.integration import checkpoint
from contactstudy.evolution.integration.evolve import evolve
from contactstudy.evolution.integration.time_stepper import Instant, TimeStepper
from contactstudy.evolution.march import March
from contactstudy.solvers.solution import Solution
from tests.contactstudy.evolution.creeping import (
    LOAD,
    RIGID,
    SOLID,
    evolved,
    pressures,
    relative,
    rolling_cylinder,
)

EXACT = cs.ExactPeriodicity()

GRID = cs.Grid((96, 1), (0.6, 1.0))

# creep that is over in a hundredth of a second
STIFF = cs.ViscoelasticHalfSpace(0.4, 0.0, ((0.6, 4e-3),))

ELASTIC = replace(rolling_cylinder(SOLID), solids=(cs.HalfSpace(1.0, 0.0), RIGID))


def test_an_elastic_scene_forgets_its_path() -> None:
    """One solve an instant, whatever lies between; before the first load the bodies just touch."""
    history = cs.LoadHistory((0.0, 1.0, 2.0, 2.0, 3.0), (0.0, 3 * LOAD, LOAD, 2 * LOAD, 0.5 * LOAD))
    times = [0.0, 0.5, 2.0, 2.0, 3.0]
    found = evolve(replace(ELASTIC, load=history), GRID, EXACT, times=times)
    assert (found.time_discretisation_error, found.status) == (0, cs.Status.CONVERGED)
    assert sum(frame.solves for frame in found.frames) <= 5
    loads = [frame.load / LOAD for frame in found.frames]
    np.testing.assert_allclose(loads, [0.0, 1.5, 1.0, 2.0, 0.5], rtol=1e-15)
    first, *loaded = found.frames
    assert first.pressure.max() == first.gap.min() == 0
    for frame in loaded:
        alone = cs.solve(replace(ELASTIC, load=cs.LineLoad(frame.load)).problem(GRID, EXACT))
        np.testing.assert_allclose(frame.pressure, alone.pressure, atol=1e-5 * alone.pressure.max())


@pytest.mark.cases(1)
@pytest.mark.parametrize("error", [1e-2, 2e-3])
def test_steps_keep_to_the_error_asked_for(error: float) -> None:
    history = cs.LoadHistory((0.0, 0.5, 1.0, 1.0), (LOAD, LOAD, 2 * LOAD, 0.7 * LOAD))
    scene = rolling_cylinder(SOLID, history)
    times = [0.0, 0.25, 0.5, 1.0, 1.0, 2.0]
    fine = np.sort([*np.linspace(0, 2, 201), 1.0])
    exact = evolved(scene, GRID, fine)
    found = evolve(scene, GRID, EXACT, times=times, error=error)
    assert found.time_discretisation_error <= error
    places = np.searchsorted(fine, times)
    places[4] += 1
    for frame, place in zip(found.frames, places, strict=True):
        true = exact.frames[place]
        assert (frame.time, frame.load) == (true.time, true.load)
        assert relative(frame.pressure, true.pressure) <= frame.time_discretisation_error + 1e-5


@pytest.mark.parametrize("wear", [cs.Wear(1.0, 1.0), None], ids=["restarts", "one rejected pair"])
def test_steps_that_are_given_up_count_as_work_alone(wear: cs.Wear | None, monkeypatch: pytest.MonkeyPatch) -> None:
    """The steps of the first pair do not converge, and it is rejected; each replaces one that did not converge."""
    advance, rejects = TimeStepper.advance, March._rejects
    made: list[Solution] = []
    steps: list[float] = []

    def counted(*arguments: Any) -> Instant:
        after = advance(*arguments)
        failed = tuple(replace(one, status=cs.Status.NOT_CONVERGED) for one in after.kept)
        made.extend(after.kept + failed)
        if after.time > 0:
            steps.append(after.time)
        return replace(after, kept=failed if 0 < len(steps) <= 3 else after.kept, replaced=failed)

    def rejects_first(march: March[Instant], error: float, end: float) -> bool:
        return rejects(march, 1.0 if len(steps) == 3 else error, end)

    monkeypatch.setattr(TimeStepper, "advance", counted)
    monkeypatch.setattr(March, "_rejects", rejects_first)
    scene, grid = rolling_cylinder(SOLID, wear=wear), cs.Grid((24, 1), GRID.extent)
    found = evolve(scene, grid, EXACT, times=[0.0, 1.0], error=2e-2)
    assert (found.restarts > 0) == (wear is not None)
    assert found.rejected > 0
    assert (found.solves, found.status) == (len(made), cs.Status.CONVERGED)


@pytest.mark.parametrize(
    ("load", "times", "loads"),
    [
        (
            cs.LoadHistory((0.0, 1.0, 2.0, 2.0, 3.0), (0.0, 3.0, 1.0, 2.0, 0.5)),
            [0, 1, 2, 2, 3],
            [0, 3, 1, 2, 0.5],
        ),
        (cs.SineLoad(2.0, 1.0, 1.0, pi / 4), [0, 1 / 8, 5 / 8, 1], [2 + 0.5**0.5, 3, 1, 2 + 0.5**0.5]),
        (cs.SineLoad(1.0, 2.0, 1.0), [0, 1 / 4, 7 / 12, 11 / 12, 1], [1, 3, 0, 0, 1]),
    ],
    ids=["history", "sine", "sine cut off at zero"],
)  # fmt: skip
def test_without_times_elastic_bodies_are_recorded_where_the_load_turns_or_jumps(
    load: cs.LoadHistory | cs.SineLoad, times: list[float], loads: list[float]
) -> None:
    found = cs.solve(
        cs.Scene(load, (cs.HalfSpace(200.0, 0.0), RIGID), (cs.Cylinder(1.0),)),
        cs.Grid((24, 1), (0.6, 1.0)),
        EXACT,
        times=cs.TimeSteps(error=1e-2),
    )
    assert isinstance(found, cs.Evolution)
    np.testing.assert_allclose(found.times, times, atol=1e-15)
    np.testing.assert_allclose(found.over_time("load_per_length"), loads, rtol=1e-12)


class KilledError(Exception):
    """The process is gone."""


@pytest.mark.parametrize("error", [3e-2, None], ids=["chosen steps", "given steps"])
def test_a_killed_integration_goes_on_to_the_same_bits(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, error: float | None
) -> None:
    """After whichever file."""
    load = cs.LoadHistory((0.0, 0.7, 0.7, 1.0), (LOAD, LOAD, 0.6 * LOAD, 0.6 * LOAD))
    scene = rolling_cylinder(SOLID, load, wear=cs.Wear(0.1, 1.0))
    grid, times = cs.Grid((24, 1), GRID.extent), np.linspace(0, 1, 9)
    integrated = partial(evolve, scene, grid, EXACT, times=times, error=error)
    whole = integrated()
    write = checkpoint.Checkpoint.write
    for files in (9, 10, 11, 12):
        folder, written = tmp_path / str(files), []

        def killed(*arguments: Any, files: int = files, written: list[str] = written) -> None:
            write(*arguments)
            written.append(arguments[1])
            if len(written) == files:
                raise KilledError

        with monkeypatch.context() as patch:
            patch.setattr(checkpoint.Checkpoint, "write", killed)
            with pytest.raises(KilledError):
                integrated(folder=folder)
        seen: list[float] = []
        again = integrated(folder=folder, progress=lambda time, end, seen=seen: seen.append(time))
        assert seen[0] > 0.05  # it did not begin again
        for one, other in zip(again.frames, whole.frames, strict=True):
            np.testing.assert_array_equal(one.pressure, other.pressure)
            np.testing.assert_array_equal(one.gap, other.gap)
            assert one.errors_by_steps == other.errors_by_steps
        assert again.counts == whole.counts
    read = integrated(folder=folder)
    np.testing.assert_array_equal(pressures(read), pressures(whole))


def test_a_folder_is_of_one_integration_one_version_and_one_process(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A file that a kill left half written is none of its own."""
    (tmp_path / f".request.json.{2**22 + 1}.partial.json").write_text("x")
    scene = rolling_cylinder(SOLID)
    seen: list[str] = []

    def second(time: float, end: float) -> None:
        with pytest.raises(cs.InvalidInput, match=r"is locked by process .*: run again when that has"):
            evolve(scene, GRID, EXACT, times=[0.0, 1.0], folder=tmp_path)
        seen.append("second")

    evolve(scene, GRID, EXACT, times=[0.0, 1.0], folder=tmp_path, progress=second)
    assert seen
    assert not list(tmp_path.glob(".*"))
    with pytest.raises(cs.InvalidInput, match=r"^solve\.folder is .*: give another folder\.$"):
        evolve(scene, GRID, EXACT, times=[0.0, 2.0], folder=tmp_path)
    monkeypatch.setattr(checkpoint, "source_hash", lambda: "other")
    with pytest.raises(cs.InvalidInput, match="an integration of another version of this program"):
        evolve(scene, GRID, EXACT, times=[0.0, 1.0], folder=tmp_path)


@pytest.mark.parametrize("name", ["request.json", "frame_00001.npz", "state.npz"])
@pytest.mark.parametrize("other", [None, "frame_00000.npz"], ids=["flipped bit", "another file"])
def test_a_damaged_folder_is_refused_by_its_name(tmp_path: Path, name: str, other: str | None) -> None:
    scene, times = rolling_cylinder(SOLID, wear=cs.Wear(0.1, 1.0)), [0.0, 0.5, 1.0]
    evolve(scene, GRID, EXACT, times=times, folder=tmp_path)
    raw = bytearray((tmp_path / (other or name)).read_bytes())
    raw[len(raw) // 2] ^= 0 if other else 1
    (tmp_path / name).write_bytes(raw)
    with pytest.raises(cs.InvalidInput, match=re.escape(str(tmp_path))):
        evolve(scene, GRID, EXACT, times=times, folder=tmp_path)


def test_a_dataset_names_all_that_was_found() -> None:
    scene = rolling_cylinder(SOLID, wear=cs.Wear(0.1, 1.0), outputs=(cs.SubsurfaceStress(depths=(0.05, 0.1)),))
    grid = cs.Grid((32, 4), (0.6, 0.2))
    found = evolve(scene, grid, cs.ZeroPadding(), times=[0.0, 0.5, 1.0])
    dataset = evolution_answer(found).to_dataset()
    for name in ("wear_depth", "von_mises", "approach", "peak_pressure", "load", "status"):
        assert dataset[name].sizes["time"] == 3
    load = dataset["pressure"].sum(("x", "y")) * grid.cell_area / grid.length
    np.testing.assert_allclose(load, LOAD, rtol=1e-7)
    answers = evolution_answer(found)
    np.testing.assert_array_equal(dataset["contact_area"], answers.over_time("contact_area"))
    alone = cs.solve(replace(scene, solids=ELASTIC.solids, wear=None).problem(grid, cs.ZeroPadding()))
    stress = alone.to_dataset()["stress"]
    np.testing.assert_allclose(dataset["stress"][0], stress, atol=1e-5 * float(abs(stress).max()))


@pytest.mark.parametrize(
    "padding",
    [
        (cs.ZeroPadding(), cs.ZeroPadding()), cs.DuplicatedPadding(), cs.Superposition(2), cs.CircularSuperposition(2),
        (EXACT, EXACT),
    ],
    ids=str,
)  # fmt: skip
def test_every_padding_is_integrated(padding: cs.Padding | cs.Paddings) -> None:
    scene = rolling_cylinder(SOLID, wear=cs.Wear(0.1, 1.0))
    scene = replace(scene, shapes=(*scene.shapes, cs.Waviness(1e-3, across=0.2, along=0.3)))
    grid = cs.Grid((48, 16), (0.8, 0.6))
    found = evolved(scene, grid, [0.0, 0.5, 1.0], padding=padding)
    assert found.status in (cs.Status.CONVERGED, cs.Status.CONTACT_AT_EDGE)
    borne = found.frames[-1].pressure.sum() * grid.cell_area / grid.length
    assert borne == pytest.approx(LOAD, rel=1e-7)
    whole = padding if padding == (EXACT, EXACT) else EXACT
    peak = evolve(scene, grid, whole, times=[0.0]).frames[0].peak_pressure
    error = dict(evolution_answer(found).frames[0].error)["peak_pressure"].by_cause
    assert abs(found.frames[0].peak_pressure - peak) <= (error["images"] + 1e-6) * peak


@pytest.mark.parametrize("named", [{"error_estimator": one} for one in ("step_doubling", "none")] + [{"error": 1e-2}])
def test_a_march_stops_without_a_bound_where_no_pressure_carries_the_load(
    named: dict[str, Any],
) -> None:
    history = cs.LoadHistory((0.0, 1.0), (LOAD, 100 * LOAD))
    scene = replace(ELASTIC, load=history, hardness=0.06)
    times = np.linspace(0, 1, 5)
    found = evolution_answer(evolve(scene, GRID, EXACT, times=times, **named))
    assert found.status is cs.Status.NO_ADMISSIBLE_PRESSURE
    assert found.times[-1] < 1
    assert history.at(found.times[-1]) == found.trajectory.frames[-1].load > 0.06 * GRID.extent[0]
    errors = found.frames[-1].error.l1
    assert errors.by_cause["steps"] == errors.by_cause["discretisation"] == np.inf
    assert errors.reason == f"No bound: {found.status}"


@pytest.mark.parametrize(
    ("body", "load", "times"),
    [
        # a jump between two instants
        (SOLID, cs.LoadHistory((0, 0.5, 0.5, 1), (LOAD, LOAD, 2 * LOAD, 2 * LOAD)), np.array([0, 1])),
        (STIFF, cs.LoadHistory((0, 1), (0.1 * LOAD, LOAD)), np.linspace(0, 1, 5)),
        *((SOLID, None, np.array(times)) for times in ([0, 1e-3, 1], [0, 0.9, 1])),
        *((SOLID, None, np.linspace(0, 1, 1 + n)) for n in (1, 2, 3, 4)),
        (replace(STIFF, relaxation=((0.6, 0.036),)), None, np.array([0, 10, 20, 21, 22]) / 22),
        # whole periods, which are cut
        *((SOLID, cs.SineLoad(LOAD, 0.7 * LOAD, 1.0, phase), np.arange(4.0)) for phase in (0.7, 0, pi / 2)),
    ],
)  # fmt: skip
def test_the_error_of_given_steps_is_bounded_for_any_lengths_of_them(
    body: cs.ViscoelasticHalfSpace, load: cs.LoadHistory | cs.SineLoad | None, times: Array
) -> None:
    scene = rolling_cylinder(body, load)
    fine = np.union1d(np.linspace(0, times[-1], 201), times)
    exact = evolved(scene, GRID, fine)
    for frame in evolve(scene, GRID, EXACT, times=times).frames[1:]:
        true = pressures(exact)[np.searchsorted(fine, frame.time)]
        assert relative(frame.pressure, true) <= frame.time_discretisation_error
    assert frame.time_discretisation_error < 0.1


def test_a_frame_before_the_load_is_zero_keeps_its_own_error() -> None:
    scene = rolling_cylinder(SOLID, cs.SineLoad(0.0, LOAD, 0.5))
    before, unloaded = evolve(scene, GRID, EXACT, times=[0.5, 1.0]).frames
    true = evolved(scene, GRID, np.linspace(0, 0.5, 65)).frames[-1].pressure
    assert 0 < relative(before.pressure, true) <= before.time_discretisation_error
    assert unloaded.time_discretisation_error == 0


@pytest.mark.parametrize(
    ("options", "status"),
    [
        (cs.SolveOptions(max_iterations=3), cs.Status.ITERATION_LIMIT),
        (cs.SolveOptions(precision="single"), cs.Status.PRECISION_LIMIT),
    ],
)
def test_contacts_that_stop_early_count_in_the_errors_of_later_instants(
    options: cs.SolveOptions, status: cs.Status
) -> None:
    scene, times = rolling_cylinder(SOLID), np.linspace(0, 1, 9)
    exact, found = (evolve(scene, GRID, EXACT, times=times, options=one) for one in (cs.SolveOptions(), options))
    assert found.status is status
    for frame, true in zip(found.frames, exact.frames, strict=True):
        assert 1e-9 < relative(frame.pressure, true.pressure) <= frame.grid_error_parts.residual


@pytest.mark.parametrize("requested", [{"error": 1e-2}, {}], ids=["requested", "default"])
def test_steps_whose_error_is_not_estimated_go_from_instant_to_instant(
    requested: dict[str, float],
) -> None:
    scene = rolling_cylinder(SOLID)
    grid = cs.Grid((24, 1), (0.6, 1.0)) if requested else None
    steps = cs.TimeSteps((0.0, 1.0, 2.0), error_estimator="none")
    found = cs.solve(scene, grid, times=steps, period=None if grid else 1.0, **requested)
    assert isinstance(found, cs.Evolution)
    assert found.counts["solves"][0] == 3
    assert found.error.l1.steps == np.inf
    assert "time-discretisation error was not estimated" in found.accuracy
