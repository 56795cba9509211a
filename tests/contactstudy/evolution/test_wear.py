from dataclasses import replace
from itertools import pairwise
from math import exp, inf, pi

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.answers.evolution import evolution_answer
from contactstudy.domain.fields import Array
from contactstudy.evolution.integration.evolve import evolve
from contactstudy.evolution.time_steps import SDIRK_GAMMA, STAGES, Scheme
from contactstudy.evolution.trajectory import Trajectory
from tests.contactstudy.evolution.creeping import LOAD, RIGID, evolved, pressures
from tests.contactstudy.scene.shapes.test_shapes import Own

EXACT = cs.ExactPeriodicity()
ELASTIC = cs.HalfSpace(1.0, 0.0)
WAVY = cs.Scene(
    cs.LineLoad(1.0),
    (ELASTIC, RIGID),
    (cs.Waviness(1e-3, across=1.0, along=1e9),),
    wear=cs.Wear(2.0, 0.5),
)
CYLINDER = cs.Scene(cs.LineLoad(LOAD), (ELASTIC, RIGID), (cs.Cylinder(1.0),), wear=cs.Wear(1.0, 1.0))


def wave(evolution: Trajectory) -> Array:
    """How much of the wave is left in the pressure, at every instant."""
    left = np.cos(2 * pi * evolution.description.grid.x) @ pressures(evolution)[:, :, 0].T
    return left / left[0]


def eigenvalue(grid: cs.Grid) -> float:
    """Of the wave across ``grid``, in place of 2 / (E* q): cells of constant pressure make it a little less."""
    problem = replace(WAVY, wear=None).problem(grid, (EXACT, EXACT))
    pressed = np.cos(2 * pi * grid.x)[:, None]
    return float((problem.operator(pressed) * pressed).sum() / (pressed**2).sum())


@pytest.mark.parametrize(
    ("step", "cells", "scheme"),
    [(0.1, 64, "implicit"), (100.0, 64, "implicit"), (0.05, 8, "explicit"), (0.1, 64, "two_stage")],
)
def test_a_wave_decays_by_the_recursion_of_the_scheme_to_rounding(step: float, cells: int, scheme: Scheme) -> None:
    """By ``k ds / lambda = z`` of eigenvalue lambda a step: ``1 / (1 + z)``, ``1 - z``, or that of Alexander (1977)."""
    grid, number = cs.Grid((cells, 1), (1.0, 1.0)), np.arange(6.0)
    found = evolved(WAVY, grid, step * number, padding=(EXACT, EXACT), tolerance=1e-12, scheme=scheme)
    ratio, gamma = step / eigenvalue(grid), SDIRK_GAMMA
    factor = {
        "implicit": 1 / (1 + ratio),
        "explicit": 1 - ratio,
        "two_stage": (1 - (1 - 2 * gamma) * ratio) / (1 + gamma * ratio) ** 2,
    }[scheme]
    # the first amplitude is 3e-3 of the mean pressure, of which the solver leaves 1e-12
    np.testing.assert_allclose(wave(found), factor**number, atol=1e-8)
    # exp(-k E* q s / 2) at k s E* = 1, less by pi (pi / cells)^2 / 3 of it
    assert exp(-1 / eigenvalue(grid)) == pytest.approx(0.0432139, rel=12 / cells**2)


@pytest.mark.parametrize(("tilt", "rate"), [(0.0, 1.72667), (1e-3, 1.00306)])
def test_the_pressure_of_a_punch_evens_out_at_the_known_rate(tilt: float, rate: float) -> None:
    """The slowest even mode of a flat punch decays at 1.72667 k E* / a, the slowest odd one at 1.00306."""
    grid, step = cs.Grid((100, 1), (2.0, 1.0)), 0.02
    shapes = (Own(lambda grid: tilt * grid.x[:, None]),) if tilt else ()
    scene = cs.Scene(cs.LineLoad(1.0), (ELASTIC, RIGID), shapes, wear=cs.Wear(1.0, 1.0))
    found = evolved(scene, grid, step * np.arange(200), tolerance=1e-12)
    pressure = pressures(found)[:, :, 0]
    uneven = np.linalg.norm(pressure - (pressure[:, ::-1] if tilt else 0.5), axis=1)
    # implicit Euler: one step divides by 1 + rate ds
    assert (uneven[-2] / uneven[-1] - 1) / step == pytest.approx(rate, rel=1e-3)


@pytest.mark.parametrize("scheme", list(STAGES))
@pytest.mark.parametrize(
    "load",
    [
        cs.LoadHistory((0.0, 2.0), (LOAD, LOAD)),
        cs.LoadHistory((0.0, 1.0, 1.0, 2.0), (0.0, LOAD, 0.3 * LOAD, 0.0)),
        cs.SineLoad(0.5 * LOAD, 0.4 * LOAD, frequency=0.7),
    ],
    ids=["constant", "a ramp, a jump and back to zero", "sine"],
)
def test_the_wear_volume_is_that_of_archard_to_rounding(load: cs.LoadHistory | cs.SineLoad, scheme: Scheme) -> None:
    """``k v int P dt``, whatever the steps: the pressures of each step carry its load to rounding."""
    grid = cs.Grid((96, 1), (0.6, 1.0))
    scene = replace(CYLINDER, load=load, wear=cs.Wear(1e-3, 1.0))
    times = np.linspace(0, 2, 12)
    found = evolved(scene, grid, times, scheme=scheme)
    breakpoints = sorted({*times.tolist(), *load.breaks(2.0)})
    impulse = sum((end - start) * load.mean(start, end) for start, end in pairwise(breakpoints))
    worn = found.frames[-1].fields["wear_depth"].values
    assert worn.sum() * grid.cell_size[0] == pytest.approx(1e-3 * impulse, rel=1e-13)
    assert worn.min() >= 0


@pytest.mark.parametrize("duration", [0.01, 3.0])
def test_errors_of_two_stage_steps_bound_the_pressure_and_the_peak_of_a_rounded_punch(
    duration: float,
) -> None:
    rounded = Own(lambda grid: 3 * np.maximum(np.abs(grid.x[:, None]) - 0.3, 0) ** 2)
    scene = replace(CYLINDER, load=cs.LineLoad(0.05), shapes=(rounded,))
    grid, scheme = cs.Grid((64, 1), (1.0, 1.0)), "two_stage"
    fine = duration * np.unique([*np.linspace(0, 1, 129), *np.geomspace(1e-6, 0.2, 40)])
    exact = evolved(scene, grid, fine, scheme=scheme)
    found = evolve(scene, grid, EXACT, times=duration * np.linspace(0, 1, 5), scheme=scheme)
    for frame in evolution_answer(found).frames[1:]:
        true = pressures(exact)[np.argmin(np.abs(fine - frame.time))]
        l1, peak = (dict(frame.error)[of].by_cause["steps"] for of in ("l1", "peak_pressure"))
        assert np.abs(frame.pressure - true).sum() <= l1 * true.sum()
        assert abs(frame.pressure.max() - true.max()) <= peak * true.max()


@pytest.mark.parametrize("rolling", [None, cs.Rolling(1.0)])
def test_a_contact_whose_coating_is_worn_through_ends_with_the_time(
    rolling: cs.Rolling | None,
) -> None:
    """Until then its errors have no bound, as it is thinner than its response is for; the other body is not coated."""
    steel, hard = cs.HalfSpace(210e9, 0.3), cs.HalfSpace(600e9, 0.2)
    wear = cs.Wear(1e-15, 0.1, circumference=None if rolling is None else 0.06)
    scene = cs.Scene(
        cs.LineLoad(1e5), (cs.CoatedHalfSpace(hard, 1e-6, steel), steel), (cs.Cylinder(0.01),), rolling=rolling,
        wear=wear, outputs=(cs.SubsurfaceStress((5e-7, 1e-6)),),
    )  # fmt: skip
    grid, times = cs.Grid((32, 1), (8e-4, 1e-3)), np.array([0.0, 4.0, 100.0, 200.0])
    times[1:] *= 1 if rolling is None else 500
    found = cs.solve(scene, grid, EXACT, times=times)
    assert found.status is cs.Status.WORN_THROUGH
    assert len(found.frames) == len(found.to_dataset()["time"]) == 3
    through = f"worn through between {times[1]:g} s and {times[2]:g} s"
    assert any(through in sentence for sentence in found.error.warnings)
    assert ["interface_shear" in frame.quantities for frame in found.frames] == [True, True, False]
    assert found.frames[0].error.l1.total < inf
    assert "is thinner by up to" in found.frames[1].error.l1.reason
    other = replace(scene, wear=replace(wear, body=1))
    assert cs.solve(other, grid, EXACT, times=times).status is cs.Status.CONVERGED


@pytest.mark.parametrize(("body", "circumference"), [(0, None), (1, 0.1)])
def test_a_block_wears_in_place_and_the_ring_below_it_along_its_track(body: int, circumference: float | None) -> None:
    """``k P s`` of either; the depth of the ring is that over its circumference, and leaves the pressure as it is."""
    steel = cs.HalfSpace(210e9, 0.3)
    scene = cs.Scene(
        cs.LineLoad(1e5), (steel, steel), (cs.Cylinder(0.01),),
        friction=cs.Sliding(0.1, standing=0), wear=cs.Wear(1e-15, 0.1, body, circumference),
    )  # fmt: skip
    found = cs.solve(scene, cs.Grid((32, 1), (6e-4, 1e-3)), EXACT, times=[0, 50])
    assert found.quantities["wear_volume"].value == pytest.approx(1e-15 * 1e5 * 5)
    depth, (first, last) = (
        found.quantities["largest_wear_depth"].value,
        found.over_time("peak_pressure"),
    )
    if circumference:
        assert depth == pytest.approx(1e-15 * 1e5 * 5 / circumference)
    assert (last == pytest.approx(first, rel=1e-6)) == (circumference is not None)


def test_the_peak_of_a_worn_contact_is_known_as_well_on_fine_cells_as_on_coarse_ones() -> None:
    # the pressure at the edge, far below the peak, depends on the steps the more the finer the cells
    steel = cs.HalfSpace(210e9, 0.3)
    scene = cs.Scene(cs.LineLoad(1e5), (steel, steel), (cs.Cylinder(0.01),), wear=cs.Wear(1e-15, 0.1))
    times = cs.TimeSteps((0.0, 100.0), error=0.02)
    coarse, fine = (
        cs.solve(scene, cs.Grid((cells, 1), (6e-4, 2e-4)), times=times).quantities["final_peak_pressure"]
        for cells in (60, 240)
    )
    assert abs(coarse.value - fine.value) < coarse.bound + fine.bound
    assert fine.bound < 0.02 * fine.value < coarse.bound
