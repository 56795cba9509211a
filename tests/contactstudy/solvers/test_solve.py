import math
from dataclasses import replace
from itertools import product

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.domain import grid as rows
from tests.conftest import STEEL, LineContact
from tests.contactstudy.solvers.test_preconditioned_cg import problem


def test_approach_of_the_line_contact_is_hertz(line_contact: LineContact) -> None:
    grid = line_contact.grid((256, 1), 2.4)
    solution = cs.solve(line_contact.scene.problem(grid, cs.ExactPeriodicity()))
    # second order in the cell, for the pressure is constant in each
    assert solution.approach == pytest.approx(
        line_contact.hertz.displacement(0.0, 2 * line_contact.hertz.radius), rel=(2.4 / 256) ** 2
    )


def test_no_iterations_means_no_convergence(line_contact: LineContact) -> None:
    problem = line_contact.scene.problem(line_contact.grid(16, 1.2), cs.ExactPeriodicity())
    for limit, solver in product((0, 1, 3), (cs.PolonskyKeer(), cs.PreconditionedCG())):
        solution = cs.solve(problem, max_iterations=limit, solver=solver)
        assert solution.status is cs.Status.ITERATION_LIMIT
        assert solution.iterations == limit
        assert "max_iterations" in str(solution.status)


def test_contact_that_outgrows_the_width_is_flagged_but_a_closed_width_has_no_edge(line_contact: LineContact) -> None:
    grid, along = line_contact.grid(16, 1.2, width=1.5), cs.ExactPeriodicity()
    for across, status in ((cs.ZeroPadding(), cs.Status.CONTACT_AT_EDGE), (along, cs.Status.CONVERGED)):
        assert cs.solve(line_contact.scene.problem(grid, (across, along))).status is status
    assert "larger width" in str(cs.Status.CONTACT_AT_EDGE)


def test_heights_that_are_not_numbers_end_in_a_status(line_contact: LineContact) -> None:
    problem = line_contact.scene.problem(line_contact.grid(16, 1.2), cs.ExactPeriodicity())
    heights = problem.undeformed_gap.copy()
    heights[3, 3] = np.nan
    solution = cs.solve(replace(problem, undeformed_gap=heights))
    assert solution.status is cs.Status.NOT_FINITE
    assert solution.error.l1.total == math.inf
    assert "NOT_FINITE" in repr(solution)


def test_contact_cut_off_at_the_ends_is_flagged_but_not_a_rollers_own_end(line_contact: LineContact) -> None:
    free = (cs.ZeroPadding(), cs.ZeroPadding())
    solids, load = line_contact.scene.solids, cs.LineLoad(3e4)
    width = 6 * cs.analytic.HertzLine(3e4, 0.01, line_contact.scene.contact_modulus).half_width
    grid = cs.Grid((24, 12), (width, width / 8))
    crowned = (cs.Cylinder(0.01), cs.Crown(10.0))
    for shapes, status in (
        (crowned, cs.Status.CONTACT_AT_EDGE),
        ((*crowned, cs.FiniteLength(width / 8)), cs.Status.CONVERGED),
    ):
        scene = cs.Scene(load, solids, shapes)
        assert cs.solve(scene.problem(grid, free)).status is status


@pytest.mark.parametrize("solver", [cs.PolonskyKeer(), cs.PreconditionedCG()], ids=str)
def test_a_single_cell_in_contact_converges(solver: cs.Solver) -> None:
    """A cell alone is level with itself, which leaves conjugate gradients no direction."""
    scene = cs.Scene(load=cs.LineLoad(1e5), solids=(STEEL, STEEL))
    grid = cs.Grid(cells=(2, 2), extent=(2e-5, 2.3513e-6))
    problem = scene.problem(grid, cs.ExactPeriodicity())
    heights = np.array([[-0.21, -0.32], [-0.07, -0.46]]) * problem.scales.gap
    solution = cs.solve(replace(problem, undeformed_gap=heights), solver=solver)
    assert solution.residual <= 1e-8


@pytest.mark.parametrize("solver", [cs.PolonskyKeer(), cs.PreconditionedCG()], ids=str)
def test_a_solution_is_its_own_start(solver: cs.Solver, line_contact: LineContact) -> None:
    grid = line_contact.grid((32, 8), 1.2)
    hard = replace(line_contact.scene, hardness=0.8 * line_contact.hertz.peak_pressure)
    for scene in (line_contact.scene, hard):
        problem = scene.problem(grid, cs.ExactPeriodicity())
        solution = cs.solve(problem, solver=solver)
        again = cs.solve(problem, solver=solver, start=solution.pressure)
        assert again.iterations == 0
        np.testing.assert_allclose(again.pressure, solution.pressure, rtol=1e-14)


def test_threads_give_the_same_answer(line_contact: LineContact, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rows, "BLOCK_CELLS", 256)
    monkeypatch.setattr(rows, "CELLS_PER_THREAD", 256)
    posed = problem(line_contact, (64, 48), "30 %")
    by_one, by_two = (cs.solve(posed, tolerance=1e-10, device=cs.Cpu(threads)) for threads in (1, 2))
    assert by_two.residual <= 1e-10
    # another rounding of the transforms, times the operator's condition, up to 64 waves across
    assert np.abs(by_one.pressure - by_two.pressure).max() < 64 * 1e-10 * 10 * posed.scales.pressure


def test_an_approach_below_the_mean_gap_is_reached_and_gives_the_load_that_gives_it() -> None:
    """Of a wave that repeats along both axes, whose mean gap is 0: half open, and closed but for one per mille."""
    scene = cs.Scene(cs.LineLoad(1.0), (STEEL, STEEL), (cs.Waviness(1e-6, across=1e-3),))
    grid, padding = cs.Grid((32, 1), (1e-3, 1e-3)), (cs.ExactPeriodicity(),) * 2
    for approach in (-5e-7, -1e-9):
        near = cs.solve(replace(scene, load=cs.Approach(approach)), grid, padding)
        loaded = cs.solve(replace(scene, load=cs.LineLoad(near.pressure.mean() * 1e-3)), grid, padding)
        assert near.status is loaded.status is cs.Status.CONVERGED
        assert (near.approach, loaded.approach) == pytest.approx((approach, approach), rel=1e-4)
