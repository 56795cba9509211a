from dataclasses import replace
from math import inf, log, pi

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.accuracy.approach_and_stress import approach_error
from contactstudy.accuracy.estimate import error_estimate
from tests.conftest import LineContact

EXACT = cs.ExactPeriodicity()
DEPTHS = tuple(np.geomspace(1e-6, 2e-4, 30))


@pytest.mark.parametrize(
    ("wave", "slip"), [(None, 0.0), (None, 0.6), ((3e-8, 20.0), 0.0), ((1e-7, 40.0), 0.0)]
)
def test_bounds_of_approach_and_stress_hold_on_smooth_wavy_and_tractive_contacts(
    wave: tuple[float, float] | None, slip: float, line_contact: LineContact
) -> None:
    grid = line_contact.grid((90, 1), 1.0, width=3.2)
    shapes = line_contact.scene.shapes
    if wave is not None:
        shapes = (*shapes, cs.Waviness(wave[0], across=wave[1] * grid.cell_size[0], phase=0.4))
    scene = replace(line_contact.scene, shapes=shapes, outputs=(cs.SubsurfaceStress(DEPTHS),))
    if slip:  # the stress is the largest at the surface, beside the stick-slip boundary
        force = 0.5 * slip * scene.load.per_length
        scene = replace(scene, friction=cs.TractiveRolling(0.5, tangential=force))

    def solved(cells: int) -> cs.Contact:
        return cs.solve(scene.problem(cs.Grid((cells, 1), grid.extent), EXACT))

    coarse, fine = solved(90).quantities, solved(720).quantities
    for name, largest in (
        ("approach", 0.05),
        ("largest_von_mises", 0.3),
        ("largest_von_mises_depth", 1.0),
        ("largest_shear_stress", 0.3),
    ):
        assert abs(fine[name].value - coarse[name].value) <= coarse[name].bound, name
        assert coarse[name].relative_bound < largest, name


def test_the_approach_has_no_bound_where_images_are_left_out(line_contact: LineContact) -> None:
    problem = line_contact.scene.problem(
        line_contact.grid((48, 4), 1.2), cs.CircularSuperposition(2)
    )
    solution = cs.solve(problem)
    found = approach_error(solution, error_estimate(solution), None)
    assert found.total == inf
    assert "ExactPeriodicity" in found.reason


def test_at_a_given_approach_nothing_has_a_bound_where_images_are_left_out(
    line_contact: LineContact,
) -> None:
    """The load is 0.74 of that with all images with ten, and 1.5 times as high with one."""
    scene = replace(line_contact.scene, load=cs.Approach(2e-6))
    grid = line_contact.grid((96, 1), 1.0, width=8.0)
    for padding, is_bounded in ((cs.CircularSuperposition(10), False), (EXACT, True)):
        estimate = error_estimate(cs.solve(scene.problem(grid, padding)))
        assert all((parts.total < inf) is is_bounded for _, parts in estimate)
        assert any("at a given approach" in said for said in estimate.warnings) is not is_bounded


def test_a_bound_relative_to_an_approach_of_zero_is_infinite_with_a_reason(
    line_contact: LineContact,
) -> None:
    solution = cs.solve(line_contact.scene.problem(line_contact.grid((48, 1), 1.0), EXACT))
    found = approach_error(replace(solution, approach=0.0), error_estimate(solution), None)
    assert found.total == inf
    assert "it is zero" in found.reason


def test_a_contact_as_narrow_as_a_cell_has_no_bound_of_its_peak_and_its_stress(
    line_contact: LineContact,
) -> None:
    """Its peak is 2.4 times as high as on two cells, and the stress 5.7 times as high as on one."""
    outputs = (cs.SubsurfaceStress(),)
    scene = replace(line_contact.scene, load=cs.LineLoad(50.0), outputs=outputs)
    for cells in (31, 32):
        found = cs.solve(scene, cs.Grid((cells, 1), (3e-4, 1e-3)), EXACT).quantities
        assert found["peak_pressure"].bound == found["largest_von_mises"].bound == inf


def test_a_scene_has_one_approach_and_one_load_of_it_on_any_grid() -> None:
    """They count from twice the radius: Johnson (1985), eq. 4.45."""
    steel = cs.HalfSpace(210e9, 0.3)
    scene = cs.Scene(cs.LineLoad(1e5), (steel, steel), (cs.Cylinder(0.01),))
    hertz, period = scene.hertz, 1e-3
    assert hertz is not None
    moved = hertz.load_per_length / pi / hertz.contact_modulus
    true = moved * (2 * log(2 * 0.02 / hertz.half_width) + 1)
    for grid in (cs.Grid((40, 1), (3e-4, period)), cs.Grid((300, 1), (2e-3, period))):
        loaded = cs.solve(scene, grid, cs.ExactPeriodicity()).quantities["approach"]
        assert abs(loaded.value - true) <= loaded.bound
        near = cs.solve(replace(scene, load=cs.Approach(true)), grid, cs.ExactPeriodicity())
        load = near.quantities["load_per_length"]
        assert abs(load.value - 1e5) <= load.bound < 0.1 * 1e5


def test_stresses_have_no_bound_below_a_sharp_end_that_carries_pressure() -> None:
    """Coarse cells show the largest shear stress at the middle, by 138 MPa, finer ones 190 MPa and more at the ends."""
    steel, length = cs.HalfSpace(77.248e9, 0.3477), 1.464e-3
    shapes = cs.Cylinder(9.5575e-3), cs.Crown(radius=0.1002545, length=length)
    scene = cs.Scene(cs.LineLoad(97e3), (steel, steel), shapes, outputs=(cs.SubsurfaceStress(),))
    grid = cs.Grid((20, 43), (4.925e-4, length))
    found = cs.solve(scene, error={"largest_shear_stress": "5 %"})
    assert not found.met
    assert "sharp end" in found.accuracy
    assert "cells" not in found.accuracy
    numbers = cs.solve(scene, grid, cs.ZeroPadding()).quantities
    of_stress = [name for name in numbers if "mises" in name or "shear" in name]
    assert len(of_stress) >= 6
    assert all("sharp end" in numbers[name].reason for name in (*of_stress, "peak_pressure"))
    unloaded_ends = replace(scene, load=cs.LineLoad(2e3))
    below = replace(scene, outputs=(cs.SubsurfaceStress(depths=(1e-4, 2e-4)),))
    for bounded in (unloaded_ends, below):
        numbers = cs.solve(bounded, grid, cs.ZeroPadding()).quantities
        assert numbers["largest_shear_stress"].bound < inf
