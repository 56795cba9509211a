from dataclasses import replace
from math import inf, pi
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.answers.evolution import evolution_answer
from contactstudy.evolution.evolve import evolve
from contactstudy.evolution.states import plastic
from contactstudy.evolution.time_stepper import Trajectory
from contactstudy.solvers import plasticity
from tests.contactstudy.evolution.creeping import EXACT, by_steps, evolved, pressures, relative

YOUNG, NU, YIELD, RADIUS = 210e9, 0.3, 1e9, 0.01
UNIT = YIELD / YOUNG
RIGID = cs.HalfSpace(inf, 0.0)
TIMES = (0.0, 0.5, 1.0, 2.0)


def half_width(times_yield: float) -> float:
    """Of Hertz's contact [m] whose peak pressure is so many times the yield stress."""
    return 2 * RADIUS * times_yield * YIELD * (1 - NU**2) / YOUNG


def load(times_yield: float) -> float:
    """[N/m]"""
    return pi / 2 * times_yield * YIELD * half_width(times_yield)


def pressed(times_yield: float, hardening: float = 0.1, **named: Any) -> cs.Scene:
    """A rigid cylinder pressed on a body and unloaded, in 1 s each; hardening modulus over Young's."""
    body = cs.ElasticPlasticHalfSpace(YOUNG, NU, YIELD, hardening * YOUNG)
    named.setdefault("load", cs.LoadHistory((0.0, 1.0, 2.0), (0.0, load(times_yield), 0.0)))
    return cs.Scene(solids=(body, RIGID), **{"shapes": (cs.Cylinder(RADIUS),)} | named)


def grid_of(times_yield: float, cell: float, width: float = 3.2) -> cs.Grid:
    """Lengths over the half-width of Hertz."""
    a, cells = half_width(times_yield), round(width / cell)
    return cs.Grid((cells, 1), (cells * cell * a, a))


def slowly(scene: cs.Scene, grid: cs.Grid) -> np.ndarray:
    """The pressure under the largest load, by so many steps up to it that a tenth of the least error here is left."""
    return evolved(scene, grid, np.linspace(0.3, 1, 48), tolerance=1e-7).frames[-1].pressure


def von_mises_over_limit(found: Trajectory, number: int, hardening: float) -> np.ndarray:
    """Von Mises stress (layers, x, y) over the yield stress after hardening."""
    (operator,), frame = found.coupled.operators, found.frames[number]
    stress = operator.stress_of_pressure(frame.pressure)
    stress -= operator.negative_residual_stress(frame.coupled_state["plastic0"][:-1])
    limit = YIELD + hardening * YOUNG * frame.coupled_state["plastic0"][-1]
    return np.sqrt(1.5 * (stress**2).sum(axis=0)) / limit


def test_a_body_yields_first_where_von_mises_says() -> None:
    """At 1.793670 Y and z = 0.704292 a: stress in means over cells is less by a fraction of the cell squared."""
    errors = []
    for cell in (0.2, 0.1):
        found = evolved(pressed(1.5), grid_of(1.5, cell), (1,))
        stress = von_mises_over_limit(found, 0, 0.1)
        errors.append(1.5 / stress.max() / 1.793670 - 1)
        layer = np.unravel_index(stress.argmax(), stress.shape)[0]
        depths = found.coupled.operators[0].volume.depths
        assert depths[layer] / half_width(1.5) == pytest.approx(0.704, abs=cell)
        for step, yields in ((-1e-3, False), (1e-3, True)):
            peak = 1.5 / stress.max()
            found = evolve(pressed(peak * (1 + step)), grid_of(peak, cell), EXACT, times=(0, 1))
            assert evolution_answer(found).to_dataset()["plastic_strain"].any() == yields
    assert 0 < errors[1] < 5e-3
    # a quarter, but for where the highest stress lies in its cell
    assert 2 < errors[0] / errors[1] < 8


def test_a_cylinder_at_three_times_yield_has_the_numbers_of_finite_elements() -> None:
    """Eight equal steps, as an independent finite-element integration took: Q2, contact by penalty, box of 1000 a.

    Its own elements of 0.05 a and this mesh differ by 0.2 % in the pressure, 0.6 % in strain and dent.
    """
    found = evolved(pressed(3), grid_of(3, 0.05, 6.4), [*np.linspace(0, 1, 9), 2], tolerance=1e-7)
    assert evolution_answer(found).status is cs.Status.CONVERGED
    data = evolution_answer(found).to_dataset().squeeze("y").isel(time=[-2, -1])
    data = data.assign_coords(x=data["x"] / half_width(3), z=data["z"] / half_width(3))
    assert data["peak_pressure"].max() == pytest.approx(0.79269 * 3 * YIELD, rel=2e-3)
    assert data["equivalent_plastic_strain"].max() == pytest.approx(1.0320 * UNIT, rel=8e-3)
    # residual stress on the axis, by cells on both sides of it; cubic, for between means over layers it bends
    axis = data["residual_stress"].isel(time=-1, x=[63, 64]).mean("x") / YIELD
    assert axis.sel(component="xx").min() == pytest.approx(-0.2343, rel=1e-2)
    assert axis.sel(component="yy").min() == pytest.approx(-0.3261, rel=1e-2)
    residual = axis.sel(component="xx").interp(z=[0.25, 0.5, 0.75, 1, 1.5, 2], method="cubic")
    np.testing.assert_allclose(residual, [0.2319, 0.0041, -0.1667, -0.2308, -0.1739, -0.0273], atol=2e-3)
    surface = data["residual_displacement"].isel(time=-1) / (half_width(3) * UNIT)
    shape = surface.interp(x=[0, 0.25, 0.5, 0.75, 1, 1.25, 1.5]) - surface.interp(x=3)
    np.testing.assert_allclose(shape, [1.2106, 1.1387, 0.9331, 0.6082, 0.2280, -0.0183, -0.0688], atol=1e-2)


def test_in_a_first_loading_kinematic_hardening_is_as_isotropic_one() -> None:
    moduli = {"isotropic": (0.1 * YOUNG, 0.0), "kinematic": (0.0, 0.1 * YOUNG), "none": (0.0, 0.0)}
    peaks = {}
    for name, hardening in moduli.items():
        scene = replace(pressed(3), solids=(cs.ElasticPlasticHalfSpace(YOUNG, NU, YIELD, *hardening), RIGID))
        peaks[name] = evolved(scene, grid_of(3, 0.2), np.linspace(0, 1, 9)).frames[-1].peak_pressure
    assert peaks["kinematic"] == pytest.approx(peaks["isotropic"], rel=5e-3)
    assert peaks["none"] < 0.97 * peaks["kinematic"]


def test_loading_again_is_elastic_up_to_where_it_was() -> None:
    scene = pressed(3, load=cs.LoadHistory((0, 1, 2, 3), (0, load(3), 0, load(3))))
    found = evolve(scene, grid_of(3, 0.2), EXACT, times=(0, 0.5, 1, 2, 2.5, 3), options=cs.SolveOptions(1e-9))
    strains, again = evolution_answer(found).to_dataset()["plastic_strain"], pressures(found)
    assert float(np.abs(strains[2] - strains[5]).max()) < 1e-8 * UNIT  # what the Newton method leaves over
    np.testing.assert_allclose(again[5], again[2], atol=1e-6 * again[2].max())


@pytest.mark.whole
def test_two_equal_bodies_that_yield_share_the_gap_evenly() -> None:
    one = pressed(3)
    both, single = replace(one, solids=(one.solids[0], one.solids[0])), replace(one, shapes=(cs.Cylinder(2 * RADIUS),))
    first, second = (cs.solve(scene, grid_of(3 * 2**-0.5, 0.15, 4.0), EXACT, times=TIMES) for scene in (both, single))
    np.testing.assert_allclose(first.pressure, second.pressure, atol=1e-6 * second.pressure.max())
    labelled, alone = first.to_dataset(), second.to_dataset()
    assert alone["equivalent_plastic_strain"].max() > 0.1 * UNIT
    for name in ("plastic_strain", "residual_stress", "residual_displacement"):
        np.testing.assert_array_equal(labelled[f"{name}_0"], labelled[f"{name}_1"])
        np.testing.assert_allclose(labelled[f"{name}_0"], alone[name], atol=1e-5 * float(np.abs(alone[name]).max()))


@pytest.mark.whole
def test_the_volume_grows_to_what_yields_and_an_integration_goes_on_in_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def integrated(**named: Any) -> Trajectory:
        scene, grid, options = pressed(4, hardening=0.02), grid_of(4, 0.2, 4.8), cs.SolveOptions(1e-7)
        return evolve(scene, grid, EXACT, times=(0, 0.5, 1), options=options, **named)

    def kill(time: float, end: float) -> None:
        if time >= end:
            raise KeyboardInterrupt

    generous = pressures(integrated())
    monkeypatch.setattr(plastic, "NEAR_YIELD", 2.0)
    tight = integrated()
    first, *_, last = (frame.coupled_state["plastic0"].shape for frame in tight.frames)
    assert first < last
    np.testing.assert_allclose(pressures(tight), generous, atol=1e-5 * generous.max())
    with pytest.raises(KeyboardInterrupt):
        integrated(folder=tmp_path, progress=kill)
    np.testing.assert_array_equal(pressures(integrated(folder=tmp_path)), pressures(tight))


@pytest.mark.whole
def test_a_sudden_load_is_applied_by_parts_and_says_its_error() -> None:
    grid, sudden, options = grid_of(3, 0.2), pressed(3, load=cs.LineLoad(load(3))), cs.SolveOptions(1e-7)
    fine = slowly(pressed(3), grid)
    found, closer = (evolve(sudden, grid, EXACT, times=(0,), error=error, options=options) for error in (None, 1.5e-2))
    # first order: the difference of two integrations is the error of the finer one, and a half more is on the safe side
    assert 0.3 < relative(found.frames[-1].pressure, fine) / by_steps(found) < 1
    assert relative(closer.frames[-1].pressure, fine) < by_steps(closer) <= 1.5e-2


def test_steps_are_chosen_for_an_error() -> None:
    scene, grid = pressed(2), grid_of(2, 0.15)
    found = evolve(scene, grid, EXACT, times=np.linspace(0, 2, 5), error=1e-2, options=cs.SolveOptions(1e-6))
    off = relative(max(found.frames, key=lambda frame: frame.load).pressure, slowly(scene, grid))
    # the integration so finely stepped has an error too, some third of the smaller one here
    assert 0.5 * off < by_steps(found) < min(3 * off, 1e-2)
    assert off < 1e-2


def test_a_body_keeps_the_dent_of_a_load_that_turns_between_the_instants() -> None:
    """Quarters of the period from a phase of 45 degrees on are 0.71 of the amplitude away from the mean."""
    scene = pressed(2, load=cs.SineLoad(load(2) / 1.9, 0.9 * load(2) / 1.9, 1.0, pi / 4))
    found, at_turns = (
        cs.solve(scene, grid_of(2, 0.2), EXACT, times=times).quantities["dent_depth"].value
        for times in ([0.0, 1.0], [0.0, 1 / 8, 5 / 8, 1.0])
    )
    assert found == pytest.approx(at_turns, rel=0.05)


def test_what_does_not_settle_says_how_far_it_came(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(plasticity, "MAX_ITERATIONS", 2)
    found = evolved(pressed(3), grid_of(3, 0.2), (0, 1))
    assert found.frames[-1].status is cs.Status.NOT_CONVERGED
    assert 1e-8 < found.frames[-1].residual < 1


def test_strain_that_reaches_the_edge_of_the_width_is_said_and_has_no_bound() -> None:
    found = cs.solve(pressed(3), grid_of(3, 0.1, 2.5), EXACT, times=(0.0, 0.5, 1.0))
    assert found.status is cs.Status.YIELD_AT_EDGE
    last = found.frames[-1].error.l1
    assert (last.discretisation, "cut off" in last.reason) == (inf, True)


def test_a_body_that_yields_can_wear_and_its_strain_moves_with_the_surface() -> None:
    """The wear volume is k P s to rounding; a depth that wear takes off every column leaves the strain below it."""
    scene = pressed(3, load=cs.LineLoad(load(3)), wear=cs.Wear(1e-15, 1.0))
    found = evolve(scene, grid_of(3, 0.2), EXACT, times=(0, 1), options=cs.SolveOptions(1e-7))
    first, last = found.frames
    worn = last.fields["wear_depth"].values.sum() * found.description.grid.cell_size[0]
    assert worn == pytest.approx(1e-15 * load(3), rel=1e-9)
    assert last.peak_pressure < first.peak_pressure
    surface = [frame.coupled_state["plastic0"][-1][0].max() for frame in found.frames]
    assert surface[1] > surface[0] == 0
    plastic, state = found.coupled, first.coupled_state
    thickness, depth = np.diff(state["edges0"])[:, None, None], np.full(first.pressure.shape, state["edges0"][2])
    left = (state["plastic0"][:-1] * thickness)[..., 2:, :, :].sum(axis=-3)
    after = plastic.worn(state, 0, depth)["plastic0"][:-1]
    np.testing.assert_allclose((after * thickness).sum(axis=-3), left, atol=1e-12)
    assert not plastic.worn(state, 0, depth * 1e6)["plastic0"][:-1].any()
    assert plastic.worn(state, 1, depth) is state  # the other body


def with_stress(scene: cs.Scene, depths: Any, solid: int = 0, cell: float = 0.2) -> cs.Evolution:
    scene = replace(scene, outputs=(cs.SubsurfaceStress(depths, solid),))
    return cs.solve(scene, grid_of(3, cell, 4.8), EXACT, times=TIMES)


@pytest.mark.whole
def test_stress_below_a_body_that_yields_is_elastic_and_residual_stress_together() -> None:
    """Residual stress at middles of layers is that of the cells, far below all of them it falls as 1 / depth^2."""
    grid = grid_of(3, 0.1, 4.8)
    middles = cs.solve(pressed(3), grid, EXACT, times=TIMES).to_dataset()["z"].values
    depths = (0.0, *middles, 20 * half_width(3), 40 * half_width(3))
    found = with_stress(pressed(3), depths, cell=0.1).to_dataset().isel(y=0)
    elastic = cs.SubsurfaceStress(depths).of((cs.HalfSpace(YOUNG, NU), RIGID), grid, (cs.ZeroPadding(), EXACT))
    for number in (2, 3):
        now = found.isel(time=number)
        left = now["stress"].values - elastic(now["pressure"].values[:, None])[..., 0]
        np.testing.assert_allclose(left[:, 1:-2], now["residual_stress"].values, atol=1e-6 * YIELD)
        near, far = np.abs(left[:, -2:]).max(axis=(0, 2))
        assert near / far == pytest.approx(4, rel=0.1)
        # the surface is free of residual traction
        assert np.abs(left[[2, 4], 0]).max() < 1e-9 * YIELD < 1e-8 * np.abs(left).max()


@pytest.mark.parametrize("solid", [0, 1])
def test_only_the_body_that_yields_has_residual_stress(solid: int) -> None:
    body = cs.ElasticPlasticHalfSpace(YOUNG, NU, YIELD)
    found = with_stress(replace(pressed(3), solids=(body, cs.HalfSpace(YOUNG, NU))), (1e-4,), solid)
    stress, number = found.to_dataset()["von_mises"], found.quantities["largest_von_mises"]
    assert bool(stress[3].any()) == (solid == 0)
    assert 0 < number.bound < inf  # by the same on larger cells


def test_depths_that_are_chosen_in_time_are_those_under_the_highest_pressure() -> None:
    stress = with_stress(pressed(3), "auto").to_dataset()["von_mises"]
    assert float(stress.isel(time=2).max()) > YIELD


def test_a_dent_has_no_bound_where_nothing_yields_on_half_the_cells() -> None:
    found = cs.solve(pressed(1.92), grid_of(1.92, 0.425, 6.8), EXACT, times=(0.0, 1.0, 2.0))
    dent = found.quantities["dent_depth"]
    assert dent.value > 0
    assert (dent.bound, "half the cells" in dent.reason) == (inf, True)


@pytest.mark.whole
def test_a_wavy_cylinder_keeps_to_the_yield_surface_wherever_its_waves_begin() -> None:
    a, found = half_width(2.5), {}
    for cells in (0, 3):
        waves = cs.Waviness(0.15 * a**2 / RADIUS, across=2.4 * a, along=2 * a, phase=-2 * np.pi * cells / 8)
        scene = pressed(2.5, hardening=0.02, shapes=(cs.Cylinder(RADIUS), waves))
        evolution = evolved(scene, cs.Grid((18, 8), (3 * a, 2 * a)), (1.0, 2.0), tolerance=1e-7)
        assert evolution_answer(evolution).status is cs.Status.CONVERGED
        found[cells] = evolution_answer(evolution).to_dataset()
    fraction = von_mises_over_limit(evolution, 0, 0.02)
    assert np.all(fraction < 1 + 1e-6)
    equivalent = evolution.frames[0].coupled_state["plastic0"][-1]
    assert np.abs(fraction - 1)[equivalent > 1e-3 * UNIT].max() < 1e-6
    # it varies along, and shear along takes part
    along = equivalent.max(axis=(0, 1))
    assert along.max() > 1.05 * along.min() > 0
    strain = found[3]["plastic_strain"][0]
    assert np.abs(strain.sel(component=["xy", "yz"])).max() > 0.05 * np.abs(strain).max()
    for name in ("pressure", "plastic_strain", "residual_displacement"):
        moved = found[0][name].roll(y=3).values
        assert np.abs(found[3][name].values - moved).max() < 1e-6 * np.abs(moved).max()
