from dataclasses import replace
from math import prod

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.domain.grid import on_cells
from contactstudy.planning.refinement import BoundedSolution, solve_to
from tests.conftest import LineContact

STEEL = cs.HalfSpace(210e9, 0.3)


def true_error(refined: BoundedSolution, scene: cs.Scene) -> float:
    """Relative L1 error by cell means, against three times the cells along each axis."""
    problem = refined.solution.problem
    nx, ny = problem.grid.cells
    finer = cs.Grid((3 * nx, 3 * ny if ny > 1 else 1), problem.grid.extent)
    fine = cs.solve(scene.problem(finer, problem.paddings), tolerance=1e-6)
    means = on_cells(fine.pressure, (nx, ny))
    return float(np.abs(refined.solution.pressure - means).sum() / means.sum())


def shapes(contact: LineContact) -> dict[str, tuple[cs.Shape, ...]]:
    a, gap = contact.hertz.half_width, contact.hertz.half_width**2 / contact.hertz.radius / 2
    return {
        "smooth": (),
        "waves": (cs.Waviness(0.1 * gap, along=0.6 * a),),
        "rough": (cs.Roughness(0.1 * gap, 0.8, roll_off=1.1 * a, cut_off=0.35 * a, seed=5, extent=(4.4 * a, 4.4 * a)),),
        "dimples": (cs.Texture(cs.Dimple(0.2 * gap, 0.4 * a, "cosine"), pitch=(0.9 * a, 0.8 * a)),),
        "sharp end": (cs.FiniteLength(14 * a),),
        "crown": (cs.Crown.of_drop(0.5 * gap, 15 * a), cs.FiniteLength(15 * a)),
    }  # fmt: skip


@pytest.mark.parametrize("kind", ["smooth", "waves", "rough", "dimples", "sharp end", "crown"])
def test_the_error_that_is_asked_for_is_kept(kind: str, line_contact: LineContact) -> None:
    scene = line_contact.with_shapes(*shapes(line_contact)[kind])
    refined = solve_to(scene, 2e-2)
    assert refined.solution.status is cs.Status.CONVERGED
    assert true_error(refined, scene) <= refined.estimate.l1.total <= 2e-2


def test_an_error_out_of_reach_ends_with_what_stands_in_the_way(
    line_contact: LineContact, monkeypatch: pytest.MonkeyPatch
) -> None:
    refined = solve_to(line_contact.scene, 1e-12)
    assert refined.estimate.l1.total > 1e-12
    assert "residual" in refined.estimate.l1.reason
    rough = line_contact.with_shapes(*shapes(line_contact)["rough"])
    monkeypatch.setattr("contactstudy.planning.refinement.MOST_CELLS", 5000)
    refined = solve_to(rough, 1e-3)
    assert refined.estimate.l1.total > 1e-3
    assert prod(refined.grid.cells) <= 5000
    assert "5,000 are allowed" in refined.estimate.l1.reason


def test_a_roller_that_ends_within_its_period_takes_few_cells() -> None:
    cylinder = cs.Cylinder(0.01)
    hertz = cs.Scene(cs.LineLoad(1e5), (STEEL, STEEL), (cylinder,)).hertz
    a = hertz.half_width
    scene = cs.Scene(cs.LineLoad(1e5), (STEEL, STEEL), (cylinder, cs.FiniteLength(10 * a)))
    refined = solve_to(scene, 3e-2, period=10.2 * a)
    assert refined.estimate.l1.total <= 3e-2
    # the end lies between cells from 51 of them on
    assert prod(refined.grid.cells) <= 4 * 16 * 51


@pytest.mark.parametrize("fraction", [0.2, 0.7, 0.95])
def test_a_line_contact_that_slips_in_part_is_solved_on_cells_that_show_where(
    fraction: float, line_contact: LineContact
) -> None:
    """The half-width that sticks is ``sqrt(1 - Q / mu P)`` (Cattaneo 1938; Mindlin 1949)."""
    load = line_contact.scene.load
    assert isinstance(load, cs.LineLoad)
    slips = cs.PartialSlip(0.3, 0.3 * fraction * load.per_length)
    answer = cs.solve(replace(line_contact.scene, friction=slips), error=1e-2)
    number = answer.quantities["stick_fraction"]
    off = abs(number.value - np.sqrt(1 - fraction))
    assert off <= min(number.bound, 1e-2)
    assert answer.quantities["traction_coefficient"].relative_bound < 1e-6  # it is given
    assert answer.met


def test_a_number_that_takes_too_many_cells_at_first_sight_is_met_all_the_same() -> None:
    """On 16 cells the power lost has an error of 100 times itself, which falls faster than is expected of it."""
    scene = cs.Scene(
        cs.LineLoad(1e5),
        (cs.HalfSpace(70e9, 0.33), STEEL),
        (cs.Cylinder(0.01),),
        friction=cs.TractiveRolling(0.3, longitudinal=1e-3),
    )
    assert cs.solve(scene, error="5 %").met


def test_a_random_surface_stays_where_the_grid_is_as_narrow_as_the_contact() -> None:
    rough = cs.Roughness(rms=1e-7, hurst=0.8, roll_off=1e-4, cut_off=5e-5, seed=1)
    scene = cs.Scene(cs.LineLoad(1e4), (STEEL, STEEL), (cs.Cylinder(0.01), rough))
    light, heavier = (cs.solve(replace(scene, load=cs.LineLoad(load)), error=0.3) for load in (1e4, 5e4))
    assert light.grid.extent[0] < heavier.grid.extent[0] <= 4e-4
    for answer in (light, heavier):
        surface = answer.scene.shapes[1]
        assert surface == cs.plan(scene, error=0.3).scene.shapes[1]
        heights = answer.problem.undeformed_gap - scene.shapes[0].gap(answer.grid)
        np.testing.assert_allclose(heights, surface.gap(answer.grid), rtol=0, atol=1e-20)
