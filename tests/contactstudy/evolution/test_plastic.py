from dataclasses import replace
from functools import cache
from math import inf, pi
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import contactstudy as cs
from contactstudy.answers.evolution import evolution_answer
from contactstudy.evolution.integration.evolve import evolve
from contactstudy.evolution.states import plastic as plastic_volume
from contactstudy.evolution.states.plastic import PlasticState, step_solution
from contactstudy.evolution.trajectory import Trajectory
from contactstudy.solvers import plasticity as elastoplastic_step
from tests.contactstudy.evolution.creeping import evolved, pressures

EXACT = cs.ExactPeriodicity()
YOUNG, NU, YIELD = 210e9, 0.3, 1e9
RADIUS = 0.01
RIGID = cs.HalfSpace(inf, 0.0)

# Over the yield stress, the peak pressure of Hertz at which a body yields first, at z = 0.704292 a.
FIRST_YIELD = 1.793670


def half_width(times_yield: float) -> float:
    """Of Hertz's contact [m] whose peak pressure is so many times the yield stress."""
    return 2 * RADIUS * times_yield * YIELD * (1 - NU**2) / YOUNG


def load(times_yield: float) -> float:
    """[N/m]"""
    return pi / 2 * times_yield * YIELD * half_width(times_yield)


def pressed(
    times_yield: float,
    *,
    hardening: float = 0.1,
    kinematic: float = 0.0,
    yield_stress: float = YIELD,
) -> cs.Scene:
    """A rigid cylinder pressed on a body and unloaded, in 1 s each; hardening moduli over Young's."""
    body = cs.ElasticPlasticHalfSpace(YOUNG, NU, yield_stress, hardening * YOUNG, kinematic * YOUNG)
    history = cs.LoadHistory((0.0, 1.0, 2.0), (0.0, load(times_yield), 0.0))
    return cs.Scene(history, (body, RIGID), (cs.Cylinder(RADIUS),))


def grid_of(times_yield: float, cell: float, width: float = 3.2) -> cs.Grid:
    """Lengths over the half-width of Hertz."""
    a = half_width(times_yield)
    cells = round(width / cell)
    return cs.Grid((cells, 1), (cells * cell * a, a))


def von_mises_of(deviator: np.ndarray) -> np.ndarray:
    """Of deviatoric components in front."""
    return np.sqrt(1.5 * (deviator**2).sum(axis=0))


def test_a_body_yields_first_where_von_mises_says() -> None:
    """At 1.79367 Y: stress in means over cells is less by a fraction of the cell squared."""
    errors = []
    for cell in (0.2, 0.1):
        grid = grid_of(1.5, cell)
        found = evolved(pressed(1.5), grid, (1,))
        assert isinstance(found.coupled, PlasticState)
        (operator,) = found.coupled.operators
        stress = von_mises_of(operator.stress_of_pressure(found.frames[0].pressure))
        fraction = stress.max() / YIELD
        errors.append(1.5 / fraction / FIRST_YIELD - 1)
        layer = np.unravel_index(stress.argmax(), stress.shape)[0]
        depth = operator.volume.depths[layer] / half_width(1.5)
        assert depth == pytest.approx(0.704, abs=cell)
        for step, yields in ((-1e-3, False), (1e-3, True)):
            scene = pressed(1.5 / fraction * (1 + step))
            found = evolve(scene, grid_of(1.5 / fraction, cell), EXACT, times=(0, 1))
            assert evolution_answer(found).to_dataset()["plastic_strain"].any() == yields
    assert 0 < errors[1] < 5e-3
    # a quarter, but for where the highest stress lies in its cell
    assert 2 < errors[0] / errors[1] < 8


@cache
def cycle(cell: float, steps: int, *, kinematic: bool = False) -> xr.Dataset:
    """To 3 Y by equal ``steps`` and back by one, in units: lengths a, stresses Y, strains Y / E, displacement a Y / E.

    At H = 0.1 E; without the axis along.
    """
    moduli = {"hardening": 0.0, "kinematic": 0.1} if kinematic else {"hardening": 0.1}
    times = [*np.linspace(0, 1, steps + 1), 2]
    found = evolved(pressed(3, **moduli), grid_of(3, cell, 6.4), times, tolerance=1e-7)
    assert found.status is cs.Status.CONVERGED
    dataset = evolution_answer(found).to_dataset().squeeze("y")
    a, unit = half_width(3), YIELD / YOUNG
    for name, scale in (
        ("x", a),
        ("z", a),
        ("layer_thickness", a),
        ("pressure", 3 * YIELD),
        ("peak_pressure", 3 * YIELD),
        ("residual_stress", YIELD),
        ("plastic_strain", unit),
        ("equivalent_plastic_strain", unit),
        ("residual_displacement", a * unit),
    ):
        dataset[name] = dataset[name] / scale
    return dataset


def residual_on_axis(dataset: xr.Dataset, depths: list[float]) -> np.ndarray:
    """xx after the load; cubic, for between means over layers it bends."""
    middle = dataset.sizes["x"] // 2
    residual = dataset["residual_stress"].sel(component="xx").isel(time=-1)
    return residual.isel(x=[middle - 1, middle]).mean("x").interp(z=depths, method="cubic").values


def measures(dataset: xr.Dataset) -> dict[str, float]:
    """Those of the reference numbers; residual stress on the axis, by cells on both sides of it."""
    middle = dataset.sizes["x"] // 2
    residual = dataset["residual_stress"].isel(time=-1, x=[middle - 1, middle]).mean("x")
    displacement = dataset["residual_displacement"].isel(time=-1)
    return {
        "peak pressure": float(dataset["peak_pressure"].max()),
        "equivalent strain": float(dataset["equivalent_plastic_strain"].max()),
        "dent": float(displacement.interp(x=0) - displacement.interp(x=3)),
        "sxx": float(residual.sel(component="xx").min()),
        "syy": float(residual.sel(component="yy").min()),
    }


def test_a_cylinder_at_three_times_yield_has_the_numbers_of_finite_elements() -> None:
    """Eight equal steps, as an independent finite-element integration took: Q2, contact by penalty, box of 1000 a.

    Its own elements of 0.05 a and this mesh differ by 0.2 % in the pressure, 0.6 % in strain and dent.
    """
    found = cycle(0.05, 8)
    numbers = measures(found)
    assert numbers["peak pressure"] == pytest.approx(0.79269, rel=2e-3)
    assert numbers["equivalent strain"] == pytest.approx(1.0320, rel=8e-3)
    assert numbers["dent"] == pytest.approx(1.2106, rel=8e-3)
    assert numbers["sxx"] == pytest.approx(-0.2343, rel=1e-2)
    assert numbers["syy"] == pytest.approx(-0.3261, rel=1e-2)
    expected = [0.2319, 0.0041, -0.1667, -0.2308, -0.1739, -0.0273]
    residual = residual_on_axis(found, [0.25, 0.5, 0.75, 1, 1.5, 2])
    np.testing.assert_allclose(residual, expected, atol=2e-3)
    profile = found["residual_displacement"].isel(time=-1)
    across = [0.25, 0.5, 0.75, 1, 1.25, 1.5]
    shape = profile.interp(x=across) - profile.interp(x=3)
    expected = [1.1387, 0.9331, 0.6082, 0.2280, -0.0183, -0.0688]
    np.testing.assert_allclose(shape, expected, atol=1e-2)


@pytest.mark.whole
def test_kinematic_hardening_has_the_numbers_of_the_same_scheme_on_uniform_layers() -> None:
    """At 32 steps; isotropic hardening differs by little in a first loading."""
    numbers = measures(cycle(0.1, 32, kinematic=True))
    coarse, fine = measures(cycle(0.1, 8)), measures(cycle(0.05, 8))
    for name, expected in (
        ("peak pressure", 0.7898),
        ("equivalent strain", 1.0176),
        ("dent", 1.2033),
    ):
        # cells of 0.05 a there, of 0.1 a here
        assert numbers[name] + fine[name] - coarse[name] == pytest.approx(expected, rel=4e-3)


def test_loading_again_is_elastic_up_to_where_it_was() -> None:
    scene = replace(pressed(3), load=cs.LoadHistory((0, 1, 2, 3), (0, load(3), 0, load(3))))
    grid = grid_of(3, 0.2)
    found = evolve(scene, grid, EXACT, times=(0, 0.5, 1, 2, 2.5, 3), options=cs.SolveOptions(1e-9))
    strains = evolution_answer(found).to_dataset()["plastic_strain"]
    unit = YIELD / YOUNG
    # what the Newton method leaves over
    assert float(np.abs(strains[2] - strains[5]).max()) < 1e-8 * unit
    before, again = found.frames[2].pressure, found.frames[5].pressure
    np.testing.assert_allclose(before, again, atol=1e-6 * before.max())


@pytest.mark.whole
def test_two_equal_bodies_that_yield_share_the_gap_evenly() -> None:
    one = pressed(3)
    both = replace(one, solids=(one.solids[0], one.solids[0]), shapes=(cs.Cylinder(RADIUS),))
    single = replace(one, shapes=(cs.Cylinder(2 * RADIUS),))
    grid, times = grid_of(3 * 2**-0.5, 0.15, 4.0), (0.0, 0.5, 1.0, 2.0)
    first, second = (evolve(scene, grid, EXACT, times=times) for scene in (both, single))
    assert float(evolution_answer(first).to_dataset()["equivalent_plastic_strain_0"].max()) > 0.1 * YIELD / YOUNG
    np.testing.assert_allclose(pressures(first), pressures(second), atol=1e-6 * pressures(second).max())
    labelled, alone = evolution_answer(first).to_dataset(), evolution_answer(second).to_dataset()
    for name in ("plastic_strain", "residual_stress", "residual_displacement"):
        np.testing.assert_array_equal(labelled[f"{name}_0"], labelled[f"{name}_1"])
        scale = float(np.abs(alone[name]).max())
        np.testing.assert_allclose(labelled[f"{name}_0"], alone[name], atol=1e-5 * scale)
    dents = [evolution_answer(found).quantities for found in (first, second)]
    assert dents[0]["dent_depth_1"].value == pytest.approx(dents[1]["dent_depth"].value, rel=1e-5)


@pytest.mark.whole
def test_the_volume_grows_to_what_yields_and_an_integration_goes_on_in_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene, grid = pressed(4, hardening=0.02), grid_of(4, 0.2, 4.8)

    def integrated(**named: Any) -> Trajectory:
        return evolve(scene, grid, EXACT, times=(0, 0.5, 1), options=cs.SolveOptions(1e-7), **named)

    def kill(time: float, end: float) -> None:
        if time >= end:
            raise KeyboardInterrupt

    generous = integrated()
    monkeypatch.setattr(plastic_volume, "NEAR_YIELD", 2.0)
    monkeypatch.setattr(plastic_volume, "MARGIN", 0.0)
    tight = integrated()
    first, *_, last = (frame.coupled_state["strain0"].shape for frame in tight.frames)
    assert first < last
    np.testing.assert_allclose(pressures(tight), pressures(generous), atol=1e-5 * pressures(generous).max())
    assert evolution_answer(tight).to_dataset()["plastic_strain"].shape[0] == 3
    with pytest.raises(KeyboardInterrupt):
        integrated(folder=tmp_path, progress=kill)
    np.testing.assert_array_equal(pressures(integrated(folder=tmp_path)), pressures(tight))


@pytest.mark.whole
def test_a_sudden_load_is_applied_by_parts_and_says_its_error() -> None:
    scene, grid = pressed(3), grid_of(3, 0.2)
    sudden = replace(scene, load=cs.LineLoad(load(3)))
    found = evolve(sudden, grid, EXACT, times=(0,), options=cs.SolveOptions(1e-7))
    closer = evolve(sudden, grid, EXACT, times=(0,), error=1.5e-2, options=cs.SolveOptions(1e-7))
    fine = slowly(scene, grid)

    def error(one: Trajectory) -> float:
        return float(np.abs(one.frames[-1].pressure - fine).sum() / fine.sum())

    # first order: the difference of two integrations is the error of the finer one, and a half more is on the safe side
    assert 0.3 < error(found) / found.time_discretisation_error < 1
    assert error(closer) < closer.time_discretisation_error <= 1.5e-2
    assert closer.solves > found.solves


def slowly(scene: cs.Scene, grid: cs.Grid) -> np.ndarray:
    """The pressure under the largest load, by so many steps up to it that a tenth of the least error here is left."""
    return evolved(scene, grid, np.linspace(0.3, 1, 48), tolerance=1e-7).frames[-1].pressure


@pytest.mark.cases(1)
@pytest.mark.parametrize("ratio", [2, 3])
def test_steps_are_chosen_for_an_error(ratio: float) -> None:
    scene, grid = pressed(ratio), grid_of(ratio, 0.3 / ratio)
    found = evolve(scene, grid, EXACT, error=1e-2, options=cs.SolveOptions(1e-6))
    fine = slowly(scene, grid)
    off = np.abs(max(found.frames, key=lambda frame: frame.load).pressure - fine).sum() / fine.sum()
    assert off < 1e-2
    # the integration so finely stepped has an error too, some third of the smaller one here
    assert 0.5 < found.time_discretisation_error / off < 3
    assert found.time_discretisation_error < 1e-2


def test_a_body_keeps_the_dent_of_a_load_that_turns_between_the_instants() -> None:
    """Quarters of the period from a phase of 45 degrees on are 0.71 of the amplitude away from the mean."""
    sine = cs.SineLoad(load(2) / 1.9, 0.9 * load(2) / 1.9, 1.0, pi / 4)
    scene, grid = replace(pressed(2), load=sine), cs.Grid((16, 1), grid_of(2, 0.4).extent)
    found, at_turns = (
        cs.solve(scene, grid, EXACT, times=times).quantities["dent_depth"].value
        for times in ([0.0, 1.0], [0.0, 1 / 8, 5 / 8, 1.0])
    )
    assert found == pytest.approx(at_turns, rel=0.05)


def test_what_does_not_settle_says_how_far_it_came(monkeypatch: pytest.MonkeyPatch) -> None:
    constants = elastoplastic_step.PlasticConstants(max_iterations=2)
    monkeypatch.setattr(elastoplastic_step, "CONSTANTS", constants)
    found = evolved(pressed(3), grid_of(3, 0.2), (0, 1))
    assert found.status is cs.Status.NOT_CONVERGED
    assert 1e-8 < found.frames[-1].residual < 1
    assert "shorter steps" in str(found.status)


def test_strain_that_reaches_the_edge_of_the_width_is_said_and_has_no_bound() -> None:
    grid = grid_of(3, 0.1, 2.5)
    found = evolve(pressed(3), grid, EXACT, times=np.linspace(0, 1, 9))
    assert found.status is cs.Status.YIELD_AT_EDGE
    last = evolution_answer(found).frames[-1]
    assert last.error.l1.discretisation == inf
    assert "cut off" in last.error.l1.reason


def test_a_body_that_yields_can_wear() -> None:
    """The wear volume is k P s to rounding, and the cylinder sinks in as a softer one does."""
    scene = replace(pressed(3), load=cs.LineLoad(load(3)), wear=cs.Wear(1e-15, 1.0))
    found = evolve(scene, grid_of(3, 0.2), EXACT, times=(0, 1, 2), options=cs.SolveOptions(1e-7))
    worn = (
        evolution_answer(found).to_dataset()["wear_depth"].isel(time=-1).sum().item()
        * found.description.grid.cell_size[0]
    )
    assert worn == pytest.approx(2 * 1e-15 * load(3), rel=1e-9)
    assert found.frames[-1].peak_pressure < found.frames[0].peak_pressure


def test_plastic_strain_moves_with_the_surface_that_wears() -> None:
    """A depth that uniform wear takes off every column leaves the strain that lay below it; the rest is gone."""
    scene = replace(pressed(3), load=cs.LineLoad(load(3)), wear=cs.Wear(1e-15, 1.0))
    found = evolve(scene, grid_of(3, 0.2), EXACT, times=(0, 1))
    plastic, state = found.coupled, found.frames[0].coupled_state
    edges, strain, hardened = (state[f"{name}0"] for name in ("edges", "strain", "equivalent"))
    whole = np.full(found.description.grid.cells, edges[2])
    thickness = np.diff(edges)[:, None, None]
    for name, before in (("strain0", strain), ("equivalent0", hardened)):
        left = (before * thickness)[..., 2:, :, :].sum(axis=-3)
        after = plastic.worn(state, 0, whole)[name]
        np.testing.assert_allclose((after * thickness).sum(axis=-3), left, atol=1e-12)
    assert plastic.worn(state, 1, whole) is state  # the other body
    assert not plastic.worn(state, 0, whole * 1e6)["strain0"].any()
    worn = found.frames[1].coupled_state["equivalent0"]
    assert worn[0].max() > hardened[0].max() == 0


def with_stress(scene: cs.Scene, depths: tuple[float, ...] | str, solid: int = 0, cell: float = 0.2) -> cs.Evolution:
    scene = replace(scene, outputs=(cs.SubsurfaceStress(depths, solid),))
    found = cs.solve(scene, grid_of(3, cell, 4.8), EXACT, times=(0.0, 0.5, 1.0, 2.0))
    assert isinstance(found, cs.Evolution)
    return found


@pytest.mark.whole
def test_stress_below_a_body_that_yields_is_elastic_and_residual_stress_together() -> None:
    """Residual stress at middles of layers is that of the cells, far below all of them it falls as 1 / depth^2."""
    deep = (20 * half_width(3), 40 * half_width(3))
    plain = cs.solve(pressed(3), grid_of(3, 0.1, 4.8), EXACT, times=(0.0, 0.5, 1.0, 2.0))
    middles = plain.to_dataset()["z"].values
    found = with_stress(pressed(3), (0.0, *middles, *deep), cell=0.1).to_dataset().isel(y=0)
    elastic = cs.SubsurfaceStress((0.0, *middles, *deep)).of(
        (cs.HalfSpace(YOUNG, NU), RIGID), grid_of(3, 0.1, 4.8), (cs.ZeroPadding(), EXACT)
    )
    for number in (2, 3):
        now = found.isel(time=number)
        left = now["stress"].values - elastic(now["pressure"].values[:, None])[..., 0]
        np.testing.assert_allclose(left[:, 1:-2], now["residual_stress"].values, atol=1e-6 * YIELD)
        near, far = np.abs(left[:, -2:]).max(axis=(0, 2))
        assert near / far == pytest.approx(4, rel=0.1)
        # the surface is free of residual traction
        assert np.abs(left[[2, 4], 0]).max() < 1e-9 * YIELD
        assert np.abs(left).max() > 0.1 * YIELD


@pytest.mark.parametrize("solid", [0, 1])
def test_stress_in_bodies_of_which_none_yields_is_that_of_elastic_ones(solid: int) -> None:
    """An infinite yield stress gives elastic bodies; the other, elastic one has no residual stress."""
    scene = replace(pressed(3), solids=(BODY, cs.HalfSpace(YOUNG, NU)))
    found = with_stress(scene, (1e-4,), solid)
    hard = replace(scene, solids=(replace(BODY, yield_stress=inf), scene.solids[1]))
    elastic = with_stress(hard, (1e-4,), solid)
    stress, unloaded = found.to_dataset()["von_mises"], elastic.to_dataset()["von_mises"][3]
    assert not unloaded.any()
    assert bool(stress[3].any()) == (solid == 0)
    number = found.quantities["largest_von_mises"]
    assert number.value == pytest.approx(float(stress.max()))
    assert 0 < number.bound < inf  # by the same on larger cells
    assert "crept, worn or yielded" in found.frames[1].quantities["largest_von_mises"].reason


def test_depths_that_are_chosen_in_time_are_those_under_the_highest_pressure() -> None:
    found = with_stress(pressed(3), "auto").to_dataset()
    assert found["von_mises"].dims == ("time", "z", "x", "y")
    largest = found["von_mises"].isel(time=2).max(("x", "y"))
    assert float(largest.max()) > YIELD


BODY = cs.ElasticPlasticHalfSpace(YOUNG, NU, YIELD)


@pytest.mark.parametrize(
    ("width", "contact", "step_residual", "expected"),
    [
        (3.2, cs.Status.NOT_FINITE, np.nan, cs.Status.NOT_FINITE),
        (3.2, cs.Status.STALLED, 1e-7, cs.Status.CONVERGED),
        (1.0, cs.Status.STALLED, 1e-7, cs.Status.CONTACT_AT_EDGE),
        (1.0, cs.Status.CONTACT_AT_EDGE, 1e-2, cs.Status.NOT_CONVERGED),
    ],
)
def test_a_step_has_the_worse_status_of_contact_and_plastic_strain(
    width: float, contact: cs.Status, step_residual: float, expected: cs.Status
) -> None:
    scene = replace(pressed(1.0), load=cs.LineLoad(load(1.0)), solids=(cs.HalfSpace(YOUNG, NU), RIGID))
    problem = scene.problem(grid_of(1.0, 0.05, width), cs.ZeroPadding())
    last = replace(cs.solve(problem), status=contact)
    nothing = np.zeros((3, 1))
    step = elastoplastic_step.ElastoplasticStep(last, nothing, nothing[0], step_residual, 1, (last,), 0.0)
    assert step_solution(step, 1e-6).status is expected


def test_a_dent_has_no_bound_where_nothing_yields_on_half_the_cells() -> None:
    found = cs.solve(pressed(1.92), grid_of(1.92, 0.425, 6.8), EXACT, times=(0.0, 1.0, 2.0))
    dent = found.quantities["dent_depth"]
    assert dent.value > 0
    assert dent.bound == inf
    assert "half the cells" in dent.reason


@pytest.mark.whole
def test_a_wavy_cylinder_keeps_to_the_yield_surface_wherever_its_waves_begin() -> None:
    a = half_width(2.5)
    height = 0.3 * a**2 / (2 * RADIUS)
    found = {}
    for cells in (0, 3):
        waves = cs.Waviness(height, across=2.4 * a, along=2 * a, phase=-2 * np.pi * cells / 8)
        scene = pressed(2.5, hardening=0.02)
        scene = replace(scene, shapes=(*scene.shapes, waves))
        evolution = evolved(scene, cs.Grid((18, 8), (3 * a, 2 * a)), (1.0, 2.0), tolerance=1e-7)
        assert evolution.status is cs.Status.CONVERGED
        found[cells] = evolution_answer(evolution).to_dataset()
    loaded = found[3].isel(time=0)
    assert isinstance(evolution.coupled, PlasticState)
    (operator,) = evolution.coupled.operators
    state = evolution.frames[0].coupled_state
    stress = operator.stress_of_pressure(evolution.frames[0].pressure)
    stress -= operator.negative_residual_stress(state["strain0"])
    von_mises = np.sqrt(1.5 * (stress**2).sum(axis=0))
    equivalent = loaded["equivalent_plastic_strain"].values[:, operator.volume.rows]
    limit = YIELD + 0.02 * YOUNG * equivalent
    assert np.all(von_mises < limit * (1 + 1e-6))
    flowing = equivalent > 1e-3 * YIELD / YOUNG
    assert np.abs(von_mises / limit - 1)[flowing].max() < 1e-6
    # it varies along, and shear along takes part
    along = equivalent.max(axis=(0, 1))
    assert along.max() > 1.05 * along.min() > 0
    strain = loaded["plastic_strain"]
    assert np.abs(strain.sel(component=["xx", "yy", "zz"]).sum("component")).max() < 1e-15
    assert np.abs(strain.sel(component=["xy", "yz"])).max() > 0.05 * np.abs(strain).max()
    for name in ("pressure", "plastic_strain", "residual_displacement"):
        moved = found[0][name].roll(y=3).values
        assert np.abs(found[3][name].values - moved).max() < 1e-6 * np.abs(moved).max()
