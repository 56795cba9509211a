"""What the built-in studies solve, in Hertz's half-widths and pressures: the words of their captions and docstrings."""

from math import pi
from typing import Any

import pytest

import contactstudy as cs
from studies.definitions import coating, effect_cost, friction, peers, solvers
from studies.definitions.roughness import scene_at as rough_scene
from studies.model.study import Point
from studies.reference.line_contact import FLATTENING, HERTZ, SCENE
from studies.registry import load

A, P_H = HERTZ.half_width, HERTZ.peak_pressure
# what Hertz's pressure flattens: p_H a / E*, half of a^2 / R
GAP = P_H * A / HERTZ.contact_modulus


def of(study: str, **point: Any) -> Any:
    return load(study).scene_at(point)


def half_widths(*lengths: float) -> tuple[Any, ...]:
    """As lengths [m]."""
    return tuple(pytest.approx(one * A) for one in lengths)


def test_the_study_of_solvers_has_three_surfaces_on_a_width_of_4_8_and_a_period_of_2_4() -> None:
    assert pytest.approx(A**2 / (2 * 0.01)) == GAP
    for surface, shapes in solvers.SURFACES.items():
        case = of("solvers", solver="polonsky_keer", surface=surface, grid=32)
        assert case.grid.cells == (32, 32)
        assert half_widths(4.8, 2.4) == case.grid.extent
        assert case.options.max_iterations == 5000
        assert case.options.solver == cs.PolonskyKeer()
        assert case.scene.shapes == (*SCENE.shapes, *shapes)
        assert len(shapes) == (surface != "smooth")
    [wave], [rough] = solvers.SURFACES["wavy"], solvers.SURFACES["rough"]
    assert isinstance(wave, cs.Waviness)
    assert wave.amplitude == pytest.approx(0.3 * GAP)
    assert half_widths(0.6, 0.6) == (wave.across, wave.along)
    assert isinstance(rough, cs.Roughness)
    assert rough.rms == pytest.approx(0.6 * GAP)
    assert half_widths(1.2, 0.15) == (rough.roll_off, rough.cut_off)
    assert (rough.hurst, rough.seed) == (0.8, 1)
    assert of("solvers", solver="polonsky_keer", surface="smooth", grid=2).grid.cells == (2, 2)


def test_effects_are_on_a_width_of_3_6_and_a_period_of_0_9_with_square_cells() -> None:
    two, one = (of("effect_cost", effect=f"smooth, {n}-D", grid=64) for n in (2, 1))
    assert (two.grid.cells, one.grid.cells) == ((64, 16), (64, 1))
    assert half_widths(3.6, 0.9) == two.grid.extent
    assert two.grid.cell[0] == pytest.approx(two.grid.cell[1])
    _, wave, texture, rough = effect_cost.SLIDING.shapes
    assert isinstance(wave, cs.Waviness)
    assert wave.amplitude == pytest.approx(0.05 * FLATTENING)
    assert half_widths(0.45, 0.9) == (wave.across, wave.along)
    assert isinstance(texture, cs.Texture)
    assert half_widths(0.45, 0.45) == texture.pitch
    assert isinstance(texture.feature, cs.Dimple)
    assert texture.feature.depth == pytest.approx(0.3 * FLATTENING)
    assert half_widths(0.2) == (texture.feature.diameter,)
    assert isinstance(rough, cs.Roughness)
    assert rough.rms == pytest.approx(0.1 * FLATTENING)
    assert half_widths(0.225, 0.06) == (rough.roll_off, rough.cut_off)
    assert rough.hurst == 0.8
    coat: Any = effect_cost.COATED.solids[0]
    assert coat.coating == cs.HalfSpace(250e9, 0.22)
    assert coat.thickness == pytest.approx(0.03 * A)
    assert effect_cost.COATED.solids[1] == coat.substrate
    assert effect_cost.YIELDING.hardness == pytest.approx(2.5 * P_H)
    [stress] = effect_cost.STRESSED.outputs
    # where the shear of a smooth contact is greatest
    assert half_widths(0.786) == stress.depths  # type: ignore[attr-defined]
    assert stress.solid == 1  # type: ignore[attr-defined]
    assert effect_cost.SLIDING.friction.coefficient == 0.1  # type: ignore[union-attr]


def test_effects_in_time_are_a_sudden_load_and_one_step_and_yield_comes_in_two() -> None:
    creep, wear = (
        of("effect_cost", effect=f"one step of {one}", grid=64) for one in ("creep", "wear")
    )
    assert creep.times == wear.times == (0.0, 0.2)
    body = creep.scene.solids[0]
    # 0.4 of steel's modulus in the long term, all of it at once
    assert creep.scene.solids == (body, body)
    assert body.equilibrium_modulus == pytest.approx(0.4 * 210e9)
    assert body.youngs_modulus == pytest.approx(210e9)
    assert [time for _, time in body.relaxation] == [1.0]
    worn = wear.scene.wear
    assert worn.coefficient == pytest.approx(0.01 * A / SCENE.contact_modulus)
    assert worn.speed == 1.0
    both = of("effect_cost", effect=effect_cost.YIELD, grid=64)
    assert both.times == (1.0, 2.0)
    assert half_widths(3.6, 0.9) == both.grid.extent
    assert both.scene.load.at(0.0) == 0
    assert both.scene.load.at(1.0) == pytest.approx(SCENE.load.largest / 2)
    assert both.scene.load.at(2.0) == pytest.approx(SCENE.load.largest)
    plastic = both.scene.solids[0]
    assert (plastic.youngs_modulus, plastic.poisson_ratio) == (210e9, 0.3)
    assert body.poisson_ratio == 0.3
    assert plastic.yield_stress == pytest.approx(0.4 * P_H)
    assert plastic.hardening_modulus == pytest.approx(4.2e9)
    assert of("effect_cost", effect=effect_cost.YIELD, grid=4).grid.cells == (2, 1)


def test_rough_surfaces_repeat_after_3_2_across_and_2_4_along() -> None:
    point: Point = {
        "rms": 0.1, "hurst": 0.3, "peklenik": 2.0, "seed": 2, "images": 6, "period": 4.8, "grid": 80,
    }  # fmt: skip
    comparison = rough_scene(point)
    case, shape = comparison, comparison.scene.shapes[1]
    # square cells
    assert case.grid.cells == (80, 120)
    assert half_widths(3.2, 4.8) == case.grid.extent
    assert isinstance(shape, cs.Roughness)
    assert half_widths(3.2, 2.4) == shape.extent
    assert half_widths(0.3, 0.1) == (shape.roll_off, shape.cut_off)
    assert shape.rms == pytest.approx(0.1 * FLATTENING)
    assert (shape.hurst, shape.peklenik, shape.seed) == (0.3, 2.0, 2)
    assert len(rough_scene(point | {"rms": 0.0}).scene.shapes) == 1


def test_coatings_are_pressed_by_a_rigid_cylinder_with_room_for_the_wider_contact() -> None:
    for ratio, wide in ((4.0, 1.0), (0.25, 2.0)):
        case = of("coating", ratio=ratio, thickness=0.3, grid=64)
        body = case.scene.solids[0]
        assert body.coating.youngs_modulus == pytest.approx(ratio * 210e9)
        assert body.thickness == pytest.approx(0.3 * coating.A)
        assert case.grid.cells == (64, 1)
        assert case.grid.extent[0] == pytest.approx(2 * 1.3 * wide * coating.A)
    # a rigid cylinder on steel: twice the modulus of steel on steel
    half_width = (4 * 1e5 * 0.01 * (1 - 0.3**2) / (pi * 210e9)) ** 0.5
    assert pytest.approx(half_width) == coating.A


def test_friction_is_studied_between_bodies_of_one_contact_modulus() -> None:
    case = of("friction", poisson_ratio=0.45, grid=101, rough_grid=24)
    assert case.scene.contact_modulus == pytest.approx(SCENE.contact_modulus)
    assert {solid.poisson_ratio for solid in case.scene.solids} == {0.45}
    assert case.grid.cells == (101, 1)
    assert case.grid.extent[0] == pytest.approx(2.6 * A)
    assert case.cells_rough == 24
    assert friction.COEFFICIENTS == (0.0, 0.1, 0.2, 0.25, 0.3, 0.4)
    assert friction.SHARES == (0.1, 0.3, 0.5, 0.7, 0.9)
    # Johnson (1985): without friction 0.7 deep for nu = 0.3, by fewer tenths where it lies
    steps = [b - a for a, b in zip(friction.DEPTHS, friction.DEPTHS[1:], strict=False)]
    assert max(steps) < 0.101
    assert (friction.DEPTHS[0], friction.DEPTHS[-1]) == (1e-6, 0.9)


def test_programs_are_compared_on_a_cylinder_a_sphere_and_a_rough_flat() -> None:
    grid = peers.ProgramRun("contactstudy", "free", 32).grid
    assert grid.cells == (32, 32)
    assert half_widths(2.4, 2.4) == grid.extent
    assert peers.SHAPES["semi-periodic"] == cs.Cylinder(0.01)
    ball = peers.SHAPES["free"]
    assert isinstance(ball, cs.Sphere)
    # larger than 1.2 half-widths, to which the grid goes, and smaller than that times the root of two
    force = SCENE.load.largest * 2.4 * A
    point = cs.analytic.HertzPoint(force, ball.radius, HERTZ.contact_modulus)
    assert 1.2 * A < point.contact_radius < 1.2 * 2**0.5 * A
    assert ball.radius == 0.02
    rough = peers.SHAPES["periodic"]
    assert isinstance(rough, cs.Roughness)
    assert rough.rms == pytest.approx(GAP)
    assert half_widths(1.0, 0.1) == (rough.roll_off, rough.cut_off)
    assert rough.hurst == 0.8
    solved = cs.solve(peers.ProgramRun("contactstudy", "periodic", 64).problem())
    assert (solved.pressure > 0).mean() == pytest.approx(1 / 7, abs=0.01)
