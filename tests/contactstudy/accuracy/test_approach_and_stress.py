from dataclasses import replace
from math import inf, log, pi

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.accuracy.estimate import error_estimate
from tests.conftest import LineContact

EXACT = cs.ExactPeriodicity()
DEPTHS = tuple(np.geomspace(1e-6, 2e-4, 30))


@pytest.mark.parametrize(("wave", "slip"), [(None, 0.6), ((3e-8, 20.0), 0.0)])
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


STEEL, RIGID = cs.HalfSpace(210e9, 0.3), cs.HalfSpace(inf, 0.3)
STRESS = (cs.SubsurfaceStress(),)
SLIDING = cs.Scene(
    cs.LineLoad(8421.0),
    (cs.HalfSpace(145.1e9, 0.3475), RIGID),
    (cs.Cylinder(8.785e-3),),
    friction=cs.Sliding(0.3815),
    outputs=STRESS,
)
TILTED = cs.Scene(
    cs.LineLoad(31.51e3),
    (cs.HalfSpace(269.1e9, 0.2884),) * 2,
    (cs.Cylinder(3.628e-3), cs.LundbergProfile(8.74e-8, 3.03e-7, 1.345e-4), cs.Tilt(4.136e-4)),
    outputs=STRESS,
)


@pytest.mark.parametrize(
    ("scene", "cells", "extent", "padding", "finer", "names"),
    [
        (SLIDING, (392, 1), (9.336e-5, 2.4e-5), EXACT, 4, ["largest_shear_stress"]),
        (TILTED, (50, 88), (1.1368e-4, 1.345e-4), cs.ZeroPadding(), 2, ["surface_tension"]),
    ],
)
def test_largest_values_at_edges_have_bounds_where_their_change_is_small_by_chance(
    scene: cs.Scene,
    cells: tuple[int, int],
    extent: tuple[float, float],
    padding: cs.Padding,
    finer: int,
    names: list[str],
) -> None:
    more = [finer * count if count > 1 else 1 for count in cells]
    grids = cs.Grid(cells, extent), cs.Grid((more[0], more[1]), extent)
    coarse, fine = (cs.solve(scene, grid, padding).quantities for grid in grids)
    for name in (key for key in coarse if key.removeprefix("largest_") in names or key in names):
        error = abs(fine[name].value - coarse[name].value)
        assert error <= coarse[name].bound < inf, name


def test_the_shear_beside_asperities_of_few_cells_has_no_bound() -> None:
    """On finer cells it is up to 1.6 times as high, and at a tenth of the depth."""
    extent = (4e-4, 2e-4)
    shapes = cs.Cylinder(0.02), cs.Roughness(2e-8, 0.7, 1e-4, 3e-5, extent=extent, seed=1)
    scene = cs.Scene(cs.LineLoad(8e4), (STEEL, RIGID), shapes, outputs=STRESS)
    found = cs.solve(scene, cs.Grid((16, 16), extent), EXACT).quantities
    assert found["largest_von_mises"].position["z"] < extent[0] / 16
    for name in ("orthogonal_shear", "orthogonal_shear_range", "orthogonal_shear_depth"):
        assert "more cells" in found[name].reason
    assert found["largest_shear_stress"].bound < inf


def test_at_a_given_approach_nothing_has_a_bound_where_images_are_left_out(line_contact: LineContact) -> None:
    """The load is 0.74 of that with all images with ten, and 1.5 times as high with one."""
    scene = replace(line_contact.scene, load=cs.Approach(2e-6))
    grid = line_contact.grid((96, 1), 1.0, width=8.0)
    for padding, is_bounded in ((cs.CircularSuperposition(10), False), (EXACT, True)):
        estimate = error_estimate(cs.solve(scene.problem(grid, padding)))
        assert all((parts.total < inf) is is_bounded for _, parts in estimate)
        assert any("at a given approach" in said for said in estimate.warnings) is not is_bounded


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


def test_the_state_at_pull_off_is_known_to_the_root_of_the_error_of_its_load() -> None:
    solids, adhesion = (cs.HalfSpace(1e6, 0.49), RIGID), cs.Adhesion(0.05, range=5e-6)
    scene = cs.Scene(cs.PullOff(1.0), solids, (cs.Cylinder(0.01),), adhesion=adhesion)
    coarse, fine = (cs.solve(scene, cs.Grid((cells, 1), (2e-3, 1e-3)), EXACT).quantities for cells in (96, 512))
    for name in ("peak_pressure", "peak_repulsive_pressure", "approach"):
        assert abs(coarse[name].value - fine[name].value) <= coarse[name].bound
        # the load is stationary there: it hardly changes between the grids
        assert coarse[name].relative_bound > 5 * fine["pull_off"].relative_bound
