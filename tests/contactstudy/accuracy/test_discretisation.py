from dataclasses import replace

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.accuracy.coarser import coarse_solution, coarser_problem, discretisation_errors
from contactstudy.accuracy.contact_edge import edge_error
from tests.conftest import LineContact

EXACT = cs.ExactPeriodicity()


def test_the_edge_error_is_the_largest_of_edges_nearby(
    line_contact: LineContact,
) -> None:
    """The law holds to the order of cell over half-width, 1 / 100; its leap makes it larger, not smaller."""
    hertz = line_contact.hertz
    found = []
    for width in np.linspace(2.4, 2.45, 40):
        grid = line_contact.grid((256, 1), 1.0, width)
        pressure = cs.solve(line_contact.scene.problem(grid, EXACT), tolerance=1e-11).pressure
        touching = np.flatnonzero(pressure[:, 0])
        beside = pressure[touching[-1] - np.arange(16), 0]
        true = hertz.pressure(grid.x[touching[-1] - np.arange(16)])
        estimate = edge_error(beside[:1], beside[1:2])[0]
        found.append(estimate / np.abs(beside - true).sum())
    assert min(found) > 0.98
    assert np.median(found) < 1.5


def test_uniform_pressure_without_an_edge_has_no_error() -> None:
    assert discretisation_errors(np.ones((6, 5)), (True, True)) == (0.0, (0.0, 0.0))
    assert discretisation_errors(np.ones((6, 5)), (False, True)) == (0.0, (0.0, 0.0))


def test_within_the_contact_a_cell_s_mean_is_a_12th_of_the_second_difference_aside() -> None:
    """Of a wave without an edge: ``2 - 2 cos(2 pi / n)`` of its height, whose mean size is 2 / pi."""
    cells = 64
    wave = 3 + np.cos(2 * np.pi * np.arange(cells) / cells)[:, None]
    _, (l1, along) = discretisation_errors(wave, (True, True))
    assert along == 0
    bend = 2 - 2 * np.cos(2 * np.pi / cells)
    # the mean over cells is the integral's up to the square of a cell
    assert l1 == pytest.approx(bend * 2 / np.pi / 12 / 3, rel=1 / cells)


def test_heights_of_a_problem_are_averaged_over_larger_cells(line_contact: LineContact) -> None:
    problem = line_contact.scene.problem(line_contact.grid((16, 8), 1.2), cs.ExactPeriodicity())
    added = np.random.default_rng(0).normal(scale=1e-7, size=(16, 8))
    rough = replace(problem, undeformed_gap=problem.undeformed_gap + added)
    smooth, coarse = coarser_problem(problem), coarser_problem(rough)
    means = added.reshape(8, 2, 4, 2).mean(axis=(1, 3))
    assert coarse.undeformed_gap - smooth.undeformed_gap == pytest.approx(means, rel=1e-6)


@pytest.mark.parametrize("cells", [48, 33])
def test_a_problem_keeps_its_own_limits_and_load_on_larger_cells(cells: int, line_contact: LineContact) -> None:
    scene, grid = line_contact.scene, line_contact.grid((cells, 1), 1.0, width=6.0)
    hardness = line_contact.hertz.peak_pressure
    plain = scene.problem(grid, EXACT)
    changed = replace(plain, control=plain.control.scaled(3), constraint=cs.HardnessLimited(hardness))
    named = replace(scene, load=cs.LineLoad(3e5), hardness=hardness).problem(grid, EXACT)
    ours, theirs = (coarse_solution(problem) for problem in (changed, named))
    np.testing.assert_allclose(ours.pressure, theirs.pressure, rtol=1e-9)
