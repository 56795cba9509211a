"""What the studies of creep, wear and yield record of marches whose frames are written here."""

from dataclasses import replace
from math import exp, pi
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import contactstudy as cs
from studies.definitions import creep, plastic, wear
from studies.registry import load


def frame(time: float, pressure: np.ndarray, **more: Any) -> SimpleNamespace:
    return SimpleNamespace(
        time=time, pressure=pressure[:, None], peak_pressure=float(pressure.max()), **more
    )


def test_creep_is_of_a_load_that_is_held_for_two_times_of_creep() -> None:
    """A body of 0.4 E* that is 2.5 times as stiff at first; a sudden load of half-width 0.1 and of E* = 1."""
    case: Any = load("creep").scene_at({"steps": 20, "grid": 64})
    assert case.grid == cs.Grid((64, 1), (0.36, 1.0))
    assert np.diff(case.times) == pytest.approx(np.full(20, 0.1))
    hertz = cs.analytic.HertzLine(case.scene.load.largest, 1.0, 1.0)
    assert hertz.half_width == pytest.approx(0.1)
    # Lee and Radok: the half-width grows like the root of the compliance
    for t in (0.3, 1.0):
        grown = float(creep.CLOSED.half_width(t)) / 0.1
        assert grown**2 == pytest.approx(1 + 1.5 * (1 - exp(-t)))
    # Hertz's pressure at first, a / 2 R times E*, and then always one that bears the load; the midpoint rule
    # errs at a root like the 1.5th power of its step
    x = (np.arange(2000) + 0.5) * 0.36 / 2000 - 0.18
    assert float(creep.CLOSED.pressure(0.0, 0.0)) == pytest.approx(0.05)
    for t in (0.1, 0.5, 2.0):
        carried = float(creep.CLOSED.pressure(x, t).sum()) * 0.36 / 2000
        assert carried == pytest.approx(pi * 0.1**2 / 4, rel=1e-3)
    least: Any = load("creep").scene_at({"steps": 2, "grid": 4})
    assert (len(least.times), least.grid.cells) == (3, (4, 1))


def test_creep_records_eleven_instants_over_the_sudden_contact_s_numbers() -> None:
    case: Any = load("creep").scene_at({"steps": 20, "grid": 64})
    x = case.grid.x
    frames = []
    for n in range(21):
        time = 0.1 * n
        exact = creep.CLOSED.pressure(x, time)
        # a share too much in every cell, the more the later, but for the frames in between
        wrong = 1 + (0.01 * n if n % 2 == 0 else 0.9)
        # the jump counts for nothing, and the record after it for the most
        wrong = {0: 1.5, 2: 1.3}.get(n, wrong)
        frames.append(
            frame(
                time,
                exact * wrong,
                step_error=5e-3 if n == 2 else 1e-4 * n,
                grid_error=1e-3 * (21 - n),
            )
        )
    found = load("creep").measures(case, SimpleNamespace(frames=frames))  # type: ignore[arg-type]
    assert found["time"].values == pytest.approx(np.linspace(0, 2, 11))
    cell = 0.36 / 64
    for record, one in enumerate(frames[::2]):
        width = np.count_nonzero(one.pressure) * cell / 2
        assert found["half_width"].values[record] == pytest.approx(width / 0.1)
        assert found["peak_pressure"].values[record] == pytest.approx(one.pressure.max() / 0.05)
    # of all records, those in between left out
    assert float(found["pressure_error_l1"]) == pytest.approx(0.3)
    assert float(found["last_error_l1"]) == pytest.approx(0.2)
    assert float(found["step_error"]) == pytest.approx(5e-3)
    # the first, after the jump, left out
    assert float(found["grid_error"]) == pytest.approx(19e-3)
    five = load("creep").measures(case, SimpleNamespace(frames=frames[:5]))  # type: ignore[arg-type]
    assert five["half_width"].shape == (11,)
    assert np.isnan(five["half_width"].values[5:]).all()
    assert float(five["last_error_l1"]) == pytest.approx(0.04)


def test_wear_goes_on_to_twice_the_half_width_of_a_rigid_cylinder() -> None:
    """Archard: the volume ``k P s`` is that of a flat cut off a cylinder, 2 a^3 / 3 R."""
    case: Any = load("wear").scene_at({"scheme": "explicit", "steps": 16, "grid": 64})
    assert case.grid == cs.Grid((64, 1), (0.5, 1.0))
    assert case.scheme == "EXPLICIT"
    hertz = cs.analytic.HertzLine(case.scene.load.largest, 1.0, 1.0)
    assert hertz.half_width == pytest.approx(0.1)
    assert len(case.times) == 17
    assert case.times[0] == 0
    # half-widths and depths are of E* = 1 and k = 1
    assert case.scene.contact_modulus == pytest.approx(1)
    assert (case.scene.wear.coefficient, case.scene.wear.speed) == (1, 1)
    least: Any = load("wear").scene_at({"scheme": "implicit", "steps": 2, "grid": 4})
    assert (len(least.times), least.grid.cells) == (3, (4, 1))
    volume = case.scene.load.largest * case.times[-1]
    assert volume == pytest.approx(2 * 0.2**3 / 3)


def test_wear_records_nine_instants_and_the_last_one_s_errors(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    case: Any = load("wear").scene_at({"scheme": "explicit", "steps": 16, "grid": 64})
    cell = 0.5 / 64
    frames = []
    for n in range(17):
        pressure = np.zeros(64)
        pressure[30 - n : 34 + n] = 0.02
        # three quarters more than Archard's volume at the end
        depth = np.full((64, 1), 1.75 * wear.LOAD * wear.DISTANCE / 0.5)
        fields = {"worn_depth": SimpleNamespace(values=depth)}
        frames.append(frame(n, pressure, fields=fields))
    fine = np.zeros((64, 1))
    fine[14:54] = 0.018
    monkeypatch.setattr(wear, "_fine", lambda cells: fine if cells == 64 else None)
    found = load("wear").measures(case, SimpleNamespace(frames=frames))  # type: ignore[arg-type]
    assert found["distance"].values == pytest.approx(np.linspace(0, 1, 9))
    cells = 4 + 4 * np.arange(9)
    assert found["half_width"].values == pytest.approx(cells * cell / 2 / 0.1)
    # 36 cells with 0.002 too much and four with 0.018 too little, of 40 times 0.018
    assert float(found["pressure_error_l1"]) == pytest.approx(
        (36 * 0.002 + 4 * 0.018) / (40 * 0.018)
    )
    assert float(found["volume_error"]) == pytest.approx(0.75)
    assert float(found["peak_pressure"]) == pytest.approx(0.02 / 0.05)
    step = wear.DISTANCE / 16
    # Johnson's compliance of a cell's own mean: the longest explicit step is 1.484 cells by k E*
    assert float(found["longest_explicit"]) == pytest.approx(1.484 * cell / step)


def test_a_fine_march_of_wear_has_512_steps_of_second_order(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    seen = []

    def run(case: Any, _: object) -> SimpleNamespace:
        seen.append((len(case.times) - 1, case.scheme, case.grid.cells))
        return SimpleNamespace(frames=[None, None, SimpleNamespace(pressure="last")])

    monkeypatch.setattr(wear.EvolutionCase, "run", run)
    assert wear._fine.__wrapped__(48) == "last"
    assert seen == [(512, "TWO_STAGE", (48, 1))]


def yielded(case: Any, pressure: np.ndarray) -> SimpleNamespace:
    """Loaded and unloaded: it has yielded in the second and third of four layers, to 0.9 % strain."""
    deep = np.zeros((4, 48, 1))
    deep[1:3, 20:28] = 0.009
    x = case.grid.x
    surface = 0.002 - 0.001 * np.abs(x)
    last = frame(
        2.0,
        0 * pressure,
        joint_state={"equivalent0": deep, "edges0": np.array([0.0, 0.5, 1.1, 1.8, 3.0])},
        fields={"residual_displacement": SimpleNamespace(values=surface[:, None])},
    )
    return SimpleNamespace(frames=[None, frame(1.0, pressure), last])


@pytest.mark.parametrize("peak", [3.0, 2.0])
def test_yield_is_recorded_over_hertz_s_contact_and_the_yield_strain(
    peak: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    case: Any = load("plastic").scene_at(
        {"pressure": peak, "hardening": 0.1, "steps": 8, "grid": 48}
    )
    hertz = cs.analytic.HertzLine(
        case.scene.load.largest, case.scene.shapes[0].radius, 1000 / (1 - 0.3**2)
    )
    assert hertz.half_width == pytest.approx(1)
    assert hertz.peak_pressure == pytest.approx(peak)
    assert case.times == pytest.approx((*np.arange(1, 9) / 8, 2.0))
    assert case.grid == cs.Grid((48, 1), (6.4, 1.0))
    assert case.scene.solids[0].hardening_modulus == pytest.approx(100)
    x = case.grid.x
    # Hertz's of half-width 1.5, whose half-width the edge law knows to a thousandth of a cell
    pressure = 0.8 * peak * np.sqrt(np.maximum(1 - (x / 1.5) ** 2, 0))
    capped = SimpleNamespace(
        pressure=np.where(pressure > 0, 2.8, 0.0)[:, None], gap=np.array([[0.1], [-0.004]])
    )
    monkeypatch.setattr(plastic, "_capped", lambda _: capped)
    monkeypatch.setattr(plastic, "half_widths", lambda p, _: np.array([p.sum()]))
    found = {
        name: float(one)
        for name, one in load("plastic").measures(case, yielded(case, pressure)).items()  # type: ignore[arg-type]
    }
    assert found["peak_pressure"] == pytest.approx(pressure.max() / peak)
    assert found["half_width"] == pytest.approx(pressure.sum())
    assert found["cap_half_width"] == pytest.approx(capped.pressure.sum())
    # from the middle to three half-widths away the surface falls by 0.003, less by what lies between cell
    # centres; the yield strain is 0.001
    middle = 0.5 * 6.4 / 48
    assert found["dent"] == pytest.approx(3 - middle)
    assert found["plastic_depth"] == pytest.approx(1.8)
    assert found["plastic_strain"] == pytest.approx(9)
    assert found["cap_pressure"] == pytest.approx(2.8 / peak)
    assert found["cap_dent"] == pytest.approx(4)
    wrong = np.abs(capped.pressure[:, 0] - pressure).sum() / pressure.sum()
    assert found["cap_difference"] == pytest.approx(wrong)
    assert found["layers"] == 4
    known = {name for name in found if name.endswith("_error")}
    assert bool(known) == (peak == 3.0)
    if known:
        assert found["plastic_depth_error"] == pytest.approx(abs(1.8 / 2.54 - 1))
        assert found["plastic_strain_error"] == pytest.approx(abs(9 / 1.012 - 1))
        assert len(known) == 5


def test_an_elastic_body_has_yielded_nowhere_and_the_cap_is_of_the_same_load() -> None:
    case: Any = load("plastic").scene_at(
        {"pressure": 3.0, "hardening": 0.0, "steps": 2, "grid": 48}
    )
    result = yielded(case, np.ones(48))
    result.frames[-1].joint_state["equivalent0"][:] = 0.0
    found = load("plastic").measures(case, result)  # type: ignore[arg-type]
    assert float(found["plastic_depth"]) == float(found["plastic_strain"]) == 0.0
    # another hardening than that of the known contact
    assert "dent_error" not in found
    capped = plastic._capped(case)
    assert capped.pressure.max() == pytest.approx(2.8)
    carried = capped.pressure.sum() * case.grid.cell[0]
    assert carried == pytest.approx(pi * 3 / 2)


def test_a_march_records_the_numbers_of_all_its_steps() -> None:
    case: Any = load("creep").scene_at({"steps": 10, "grid": 64})
    result = SimpleNamespace(
        status=cs.Status.CONVERGED, iterations=70, convolutions=210.5, residual=3e-9, steps=11
    )
    found = case.record(result)
    numbers = {name: float(one) for name, one in found.items()}
    assert numbers == {
        "solver_status": 0, "iterations": 70, "convolutions": 210.5, "residual": 3e-9, "solves": 11
    }  # fmt: skip
    assert replace(case, error=0.1) != case
