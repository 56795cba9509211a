from dataclasses import replace
from math import inf, pi

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.problem.constraint import Dugdale, Exponential
from contactstudy.solvers import adhesion as pull_off

SOFT, RIGID = cs.HalfSpace(1.0, 0.0), cs.HalfSpace(inf, 0.3)
LINE = cs.ExactPeriodicity()
# Where R = E* = 1 and w = pi, lengths and loads over pi have the units of Johnson, Kendall & Roberts.
UNIT = pi


def cylinder(lam: float, load: float, law: str = "exponential", **named: str) -> cs.Scene:
    """Cylinder whose attraction has Maugis' parameter `lam`, under a `load` in the unit."""
    adhesion = cs.Adhesion(pi, 4 / lam, law, **named)
    return cs.Scene(cs.LineLoad(load * UNIT), (SOFT, RIGID), (cs.Cylinder(1.0),), adhesion=adhesion)


def force(solution: cs.Solution) -> float:
    """Load per length that pressure and attraction carry [N/m]."""
    grid = solution.problem.grid
    net = solution.pressure - solution.adhesion.attraction
    return float(net.sum()) * grid.cell_area / grid.length


def pulled(scene: cs.Scene, grid: cs.Grid, error: float, padding: object = LINE) -> cs.Solution:
    """The last state held of a scene under a pull, begun at the scene's load."""
    pull = cs.PullOff(scene.largest_load, error)
    solution = cs.solve(replace(scene, load=pull), grid, padding, tolerance=1e-9)  # type: ignore[arg-type]
    assert solution.status is cs.Status.CONVERGED
    return solution


@pytest.mark.parametrize(("lam", "width", "expected"), [(0.5, 50.0, 0.82149), (2.0, 24.0, 1.14064)])
def test_a_cylinder_separates_at_the_pull_off_load_of_fine_grids(lam: float, width: float, expected: float) -> None:
    last = pulled(cylinder(lam, 0.5), cs.Grid((2048, 1), (width, 1.0)), error=1e-4)
    assert -force(last) / UNIT == pytest.approx(expected, rel=2e-4)
    assert last.adhesion.first_unstable_load == pytest.approx(force(last), rel=1.01e-4)


def test_a_stiff_cylinder_separates_as_a_rigid_one() -> None:
    # w sqrt(2 pi R / rho), less by the deformation, of first order in Maugis' parameter
    held = -force(pulled(cylinder(0.2, 0.3), cs.Grid((1024, 1), (80.0, 1.0)), 1e-3)) / UNIT
    assert 0.56050 * (1 - 0.1 * 0.2) < held < 0.56050


def test_the_law_of_dugdale_has_the_pull_off_load_of_baney_and_hui() -> None:
    last = pulled(cylinder(1.0, 0.5, "dugdale"), cs.Grid((2048, 1), (36.0, 1.0)), 2e-4)
    # the fall of the attraction over a fifth of its range takes up to 2.1e-4
    assert -force(last) / UNIT == pytest.approx(1.11303, rel=6e-4)


@pytest.mark.parametrize(
    ("branch", "lam", "load", "cells", "half_width", "peak"),
    [  # by the equations of Baney & Hui (1997)
        ("from afar", 4.0, 1.0, 256, 3.761244, 1.230132),
        ("from full contact", 3.0, -0.5, 128, 2.481765, 0.488991),
    ],
)
def test_few_cells_in_the_zone_of_dugdale_do_not_trap_the_contact(
    branch: str, lam: float, load: float, cells: int, half_width: float, peak: float
) -> None:
    scene = cylinder(lam, load, "dugdale", branch=branch)
    numbers = cs.solve(scene, cs.Grid((cells, 1), (16.0, 1.0)), LINE).quantities
    assert 3 < numbers["cells_in_zone"].value < 5
    for name, true in (("peak_pressure", peak), ("half_width", half_width)):
        assert numbers[name].value == pytest.approx(true, abs=numbers[name].bound)
        assert numbers[name].value == pytest.approx(true, rel=0.02)


def test_a_pull_that_does_not_converge_at_some_load_returns_the_last_stable_state(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(pull_off, "ITERATION_FACTOR", 1)
    scene = replace(cylinder(2.0, 0.5), load=cs.PullOff(0.5 * UNIT, 1e-4))
    last = cs.solve(scene, cs.Grid((128, 1), (24.0, 1.0)), LINE, tolerance=1e-9, max_iterations=80)
    assert last.status is cs.Status.ITERATION_LIMIT
    assert "search for the pull-off load ended at" in last.note
    assert last.residual <= 1e-9
    # both loads still enclose that of fine grids
    assert last.adhesion.first_unstable_load / UNIT < -1.14064 < force(last) / UNIT


def test_a_wave_separates_as_johnson_says_of_short_ranges() -> None:
    height, alpha, cells, zone = 0.05, 0.3, 1024, 12
    closing = pi * height
    work = (alpha * closing) ** 2 / 2
    strength = np.sqrt(pi * work * cells / (4 * zone))
    wave, adhesion = cs.Waviness(height, across=1.0), cs.Adhesion(work, work / strength)
    scene = cs.Scene(cs.LineLoad(0.05 * closing), (SOFT, RIGID), (wave,), adhesion=adhesion)
    held = -force(pulled(scene, cs.Grid((cells, 1), (1.0, 1.0)), 1e-3, (LINE, LINE)))
    # max over psi of alpha sqrt(tan psi) - sin^2 psi, Johnson (1995); the zone of 12 cells is a part of the wave
    assert held / closing == pytest.approx(0.095944, rel=0.01)


def test_a_sphere_separates_between_the_limits_of_bradley_and_of_johnson_kendall_and_roberts() -> None:
    width = 9.5
    load, adhesion = cs.TotalLoad(0.5, length=width), cs.Adhesion(1.0, 1.0)
    scene = cs.Scene(load, (SOFT, RIGID), (cs.Sphere(1.0),), adhesion=adhesion)
    free = cs.ZeroPadding(), cs.ZeroPadding()
    last = pulled(scene, cs.Grid((64, 64), (width, width)), 1e-3, free)
    assert last.adhesion.tabor == pytest.approx(1.0)
    assert -force(last) * width / pi == pytest.approx(1.6639, rel=2e-3)


@pytest.mark.parametrize(("work", "attraction_range"), [(1e-30, None), (1e-30, 1e-7)])
def test_no_work_gives_the_contact_without_adhesion_to_the_last_bit(
    work: float, attraction_range: float | None
) -> None:
    plain, cells = replace(cylinder(1.0, 1.0), adhesion=None), cs.Grid((128, 1), (24.0, 1.0))
    adhesive = cs.solve(replace(plain, adhesion=cs.Adhesion(work, attraction_range)), cells, LINE)
    without = cs.solve(plain, cells, LINE)
    np.testing.assert_array_equal(adhesive.pressure, without.pressure)
    np.testing.assert_array_equal(adhesive.gap, without.gap)
    assert adhesive.approach == without.approach


@pytest.mark.parametrize("branch", ["from afar", "from full contact"])
@pytest.mark.parametrize("law", [Exponential, Dugdale])
def test_an_outer_iteration_without_mixing_never_raises_the_energy(branch: str, law: type) -> None:
    scene = cylinder(2.0, 0.2, branch=branch)
    problem = scene.problem(cs.Grid((256, 1), (24.0, 1.0)), LINE)
    plain = replace(problem.adhesion, depth=0, law=law(pi, 2.0))  # type: ignore[type-var]
    solution = cs.solve(replace(problem, adhesion=plain))
    energies = np.array(solution.adhesion.energies)
    assert len(energies) > 10
    # to the tolerance of each contact, a thousandth of the range at most
    assert (np.diff(energies) < 1e-8 * abs(energies[-1])).all()


def test_a_short_range_leaves_two_states_and_the_history_decides() -> None:
    grid = cs.Grid((512, 1), (16.0, 1.0))
    near = replace(cylinder(4.0, 0.5), load=cs.Approach(-4.5, datum=16.0))
    afar = cs.solve(near, grid, LINE)
    leaving = cs.Adhesion(pi, 1.0, branch="from full contact")
    left = cs.solve(replace(near, adhesion=leaving), grid, LINE)
    assert afar.status is cs.Status.DETACHED
    assert left.status is cs.Status.CONVERGED
    assert force(left) < 2 * force(afar) < 0
    assert left.adhesion.energy < afar.adhesion.energy


def test_below_a_tabor_parameter_of_0_3_loading_equals_unloading() -> None:
    grid = cs.Grid((256, 1), (50.0, 1.0))
    for load in (0.1, 0.5):
        afar = cs.solve(cylinder(0.5, load), grid, LINE)
        left = cs.solve(cylinder(0.5, load, branch="from full contact"), grid, LINE)
        # the passes leave 1e-5 of the traction
        np.testing.assert_allclose(left.pressure, afar.pressure, atol=1e-4 * afar.pressure.max())


def test_a_load_beyond_the_pull_off_leaves_the_bodies_detached() -> None:
    grid = cs.Grid((256, 1), (24.0, 1.0))
    solution = cs.solve(cylinder(2.0, -1.5, branch="from full contact"), grid, LINE)
    assert solution.status is cs.Status.DETACHED
    assert not solution.pressure.any()
    assert force(solution) == 0


def test_an_attraction_cut_off_at_the_edge_has_a_status() -> None:
    solution = cs.solve(cylinder(0.5, 0.5), cs.Grid((128, 1), (8.0, 1.0)), LINE)
    assert solution.status is cs.Status.ATTRACTION_AT_EDGE


@pytest.mark.parametrize("law", [Exponential(2.0, 0.5), Dugdale(2.0, 0.5)])
def test_the_remaining_work_is_the_integral_of_the_traction(law: Exponential | Dugdale) -> None:
    gap = np.linspace(0, 20, 400_001)
    traction = law.traction(gap)
    step = gap[1]
    beyond = np.cumsum((traction[::-1][1:] + traction[::-1][:-1]) * step / 2)[::-1]
    np.testing.assert_allclose(law.remaining_work(gap[:-1]), beyond, atol=4 * step**2)
    assert law.remaining_work(np.zeros(1))[0] == pytest.approx(2.0)
