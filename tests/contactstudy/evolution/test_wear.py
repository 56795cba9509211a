from dataclasses import replace
from itertools import pairwise
from math import exp, inf, pi

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.answers.evolution import evolution_answer
from contactstudy.evolution.evolve import evolve
from contactstudy.evolution.march import SDIRK_GAMMA, STAGES, Scheme
from tests.conftest import STEEL
from tests.contactstudy.evolution.creeping import EXACT, LOAD, RIGID, evolved, pressures, rolling_cylinder
from tests.contactstudy.scene.shapes.test_shapes import Own

ELASTIC = cs.HalfSpace(1.0, 0.0)
CYLINDER = rolling_cylinder(ELASTIC, wear=cs.Wear(1.0, 1.0))


@pytest.mark.parametrize(
    ("step", "cells", "scheme"),
    [(0.1, 64, "implicit"), (100.0, 64, "implicit"), (0.05, 8, "explicit"), (0.1, 64, "two_stage")],
)
def test_a_wave_decays_by_the_recursion_of_the_scheme_to_rounding(step: float, cells: int, scheme: Scheme) -> None:
    """By ``k ds / lambda = z`` of eigenvalue lambda a step: ``1 / (1 + z)``, ``1 - z``, or that of Alexander (1977)."""
    grid, number = cs.Grid((cells, 1), (1.0, 1.0)), np.arange(6.0)
    shapes = (cs.Waviness(1e-3, across=1.0, along=1e9),)
    scene = cs.Scene(cs.LineLoad(1.0), (ELASTIC, RIGID), shapes, wear=cs.Wear(2.0, 0.5))
    found = evolved(scene, grid, step * number, padding=(EXACT, EXACT), tolerance=1e-12, scheme=scheme)
    wave = np.cos(2 * pi * grid.x)[:, None]
    left = (pressures(found) * wave).sum(axis=(1, 2))
    # in place of 2 / (E* q): cells of constant pressure make it a little less
    eigenvalue = float((found.frames[0].problem.operator(wave) * wave).sum() / (wave**2).sum())
    ratio, gamma = step / eigenvalue, SDIRK_GAMMA
    factor = {
        "implicit": 1 / (1 + ratio),
        "explicit": 1 - ratio,
        "two_stage": (1 - (1 - 2 * gamma) * ratio) / (1 + gamma * ratio) ** 2,
    }[scheme]
    # the first amplitude is 3e-3 of the mean pressure, of which the solver leaves 1e-12
    np.testing.assert_allclose(left / left[0], factor**number, atol=1e-8)
    # exp(-k E* q s / 2) at k s E* = 1, less by pi (pi / cells)^2 / 3 of it
    assert exp(-1 / eigenvalue) == pytest.approx(0.0432139, rel=12 / cells**2)


@pytest.mark.parametrize(("tilt", "rate"), [(0.0, 1.72667), (1e-3, 1.00306)])
def test_the_pressure_of_a_punch_evens_out_at_the_known_rate(tilt: float, rate: float) -> None:
    """The slowest even mode of a flat punch decays at 1.72667 k E* / a, the slowest odd one at 1.00306."""
    grid, step = cs.Grid((100, 1), (2.0, 1.0)), 0.02
    shapes = (Own(lambda grid: tilt * grid.x[:, None]),) if tilt else ()
    scene = cs.Scene(cs.LineLoad(1.0), (ELASTIC, RIGID), shapes, wear=cs.Wear(1.0, 1.0))
    pressure = pressures(evolved(scene, grid, step * np.arange(200), tolerance=1e-12))[:, :, 0]
    uneven = np.linalg.norm(pressure - (pressure[:, ::-1] if tilt else 0.5), axis=1)
    # implicit Euler: one step divides by 1 + rate ds
    assert (uneven[-2] / uneven[-1] - 1) / step == pytest.approx(rate, rel=1e-3)


@pytest.mark.cases(3)
@pytest.mark.parametrize("scheme", list(STAGES))
def test_the_wear_volume_is_that_of_archard_to_rounding(scheme: Scheme) -> None:
    """``k v int P dt``, whatever the steps: the pressures of each step carry its load to rounding."""
    grid, times = cs.Grid((96, 1), (0.6, 1.0)), np.linspace(0, 2, 12)
    load = cs.LoadHistory((0.0, 1.0, 1.0, 2.0), (0.0, LOAD, 0.3 * LOAD, 0.0))
    found = evolved(replace(CYLINDER, load=load, wear=cs.Wear(1e-3, 1.0)), grid, times, scheme=scheme)
    breakpoints = sorted({*times.tolist(), *load.breaks(2.0)})
    impulse = sum((end - start) * load.mean(start, end) for start, end in pairwise(breakpoints))
    worn = found.frames[-1].fields["wear_depth"].values
    assert worn.sum() * grid.cell_size[0] == pytest.approx(1e-3 * impulse, rel=1e-13)


def test_errors_of_two_stage_steps_bound_the_pressure_and_the_peak_of_a_rounded_punch() -> None:
    rounded = Own(lambda grid: 3 * np.maximum(np.abs(grid.x[:, None]) - 0.3, 0) ** 2)
    scene = replace(CYLINDER, load=cs.LineLoad(0.05), shapes=(rounded,))
    grid, scheme = cs.Grid((64, 1), (1.0, 1.0)), "two_stage"
    fine = 3 * np.unique([*np.linspace(0, 1, 129), *np.geomspace(1e-6, 0.2, 40)])
    exact = pressures(evolved(scene, grid, fine, scheme=scheme))
    found = evolve(scene, grid, EXACT, times=3 * np.linspace(0, 1, 5), scheme=scheme)
    for frame in evolution_answer(found).frames[1:]:
        true = exact[np.argmin(np.abs(fine - frame.time))]
        l1, peak = (dict(frame.error)[of].by_cause["steps"] for of in ("l1", "peak_pressure"))
        assert np.abs(frame.pressure - true).sum() <= l1 * true.sum()
        assert abs(frame.pressure.max() - true.max()) <= peak * true.max()


@pytest.mark.parametrize(("rolling", "around", "slower"), [(None, None, 1), (cs.Rolling(1.0), 0.06, 500)])
def test_a_contact_whose_coating_is_worn_through_ends_with_the_time(
    rolling: cs.Rolling | None, around: float | None, slower: float
) -> None:
    """Until then its errors have no bound, as it is thinner than its response is for; the other body is not coated."""
    coat, wear = cs.CoatedHalfSpace(cs.HalfSpace(600e9, 0.2), 1e-6, STEEL), cs.Wear(1e-15, 0.1, circumference=around)
    scene = cs.Scene(cs.LineLoad(1e5), (coat, STEEL), (cs.Cylinder(0.01),), rolling=rolling, wear=wear)
    grid, times = cs.Grid((32, 1), (8e-4, 1e-3)), (0.0, 4.0 * slower, 100.0 * slower, 200.0 * slower)
    found = cs.solve(scene, grid, EXACT, times=times)
    assert found.status is cs.Status.WORN_THROUGH
    assert len(found.frames) == 3
    assert any(f"between {times[1]:g} s and {times[2]:g} s" in sentence for sentence in found.error.warnings)
    assert found.frames[0].error.l1.total < inf
    assert "is thinner by up to" in found.frames[1].error.l1.reason
    other = replace(scene, wear=replace(wear, body=1))
    assert cs.solve(other, grid, EXACT, times=times).status is cs.Status.CONVERGED


@pytest.mark.parametrize(("body", "circumference"), [(0, None), (1, 0.1)])
def test_a_block_wears_in_place_and_the_ring_below_it_along_its_track(body: int, circumference: float | None) -> None:
    """``k P s`` of either; the depth of the ring is that over its circumference, and leaves the pressure as it is."""
    friction, wear = cs.Sliding(0.1, standing=0), cs.Wear(1e-15, 0.1, body, circumference)
    scene = cs.Scene(cs.LineLoad(1e5), (STEEL, STEEL), (cs.Cylinder(0.01),), friction=friction, wear=wear)
    found = cs.solve(scene, cs.Grid((32, 1), (6e-4, 1e-3)), EXACT, times=[0, 50])
    assert found.quantities["wear_volume"].value == pytest.approx(1e-15 * 1e5 * 5)
    first, last = found.over_time("peak_pressure")
    if circumference:
        depth = found.quantities["largest_wear_depth"].value
        assert depth == pytest.approx(1e-15 * 1e5 * 5 / circumference)
    assert (last == pytest.approx(first, rel=1e-6)) == (circumference is not None)
