"""The scheme of Polonsky & Keer (1999) beside its own text, on a dense operator."""

from dataclasses import replace

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.domain.device import Precision
from contactstudy.problem.bare_problem import BareProblem
from contactstudy.solvers.conjugate_gradients import PolonskyKeer
from tests.conftest import LineContact


def bare_problem(scene: cs.Scene, grid: cs.Grid) -> BareProblem:
    return scene.problem(grid, cs.ExactPeriodicity()).bare(Precision.DOUBLE)


@pytest.fixture
def bare(line_contact: LineContact) -> BareProblem:
    return bare_problem(line_contact.scene, line_contact.grid((24, 2), 0.3))


def published(operator: np.ndarray, separation: np.ndarray, start: np.ndarray, iterations: int) -> np.ndarray:
    """Their section 3, word for word: the pressure after so many iterations."""
    pressure, load = start.copy(), start.sum()
    direction, old, conjugate = np.zeros(len(separation)), 1.0, 0.0
    for _ in range(iterations):
        bears = pressure > 0
        gap = operator @ pressure + separation
        gap -= gap[bears].mean()
        new = (gap[bears] ** 2).sum()
        direction = np.where(bears, gap + conjugate * (new / old) * direction, 0.0)
        old = new
        response = operator @ direction
        response -= response[bears].mean()
        step = (gap * direction)[bears].sum() / (response * direction)[bears].sum()
        pressure = np.where(bears, np.maximum(pressure - step * direction, 0), pressure)
        overlaps = (pressure == 0) & (gap < 0)
        conjugate = 0.0 if overlaps.any() else 1.0
        pressure[overlaps] -= step * gap[overlaps]
        pressure *= load / pressure.sum()
    return pressure


@pytest.mark.parametrize("iterations", [0, 1, 2, 3, 4, 5, 6, 8, 10])
@pytest.mark.parametrize("bearing", [slice(None), slice(10, 15), slice(4, 9)])
def test_the_iterates_are_those_of_polonsky_and_keer(bare: BareProblem, bearing: slice, iterations: int) -> None:
    """From all cells it loses some, from a few in the middle it gains some, from a few aside it does both."""
    cells = bare.undeformed_gap.shape
    each = np.eye(cells[0] * cells[1]).reshape(-1, *cells)
    operator = np.transpose([bare.operator(one).ravel() for one in each])
    start = np.zeros(cells)
    start[bearing, :] = bare.uniform().sum() / start[bearing, :].size
    wanted = published(operator, bare.undeformed_gap.ravel(), start.ravel(), iterations)
    solver = PolonskyKeer()
    found = solver.iterate(bare, tolerance=0.0, max_iterations=iterations, start=start)
    np.testing.assert_allclose(found.pressure.ravel(), wanted, rtol=1e-9, atol=1e-12 * start.sum())
    assert (found.iterations, found.convolutions) == (iterations, 2 * iterations + 1)


@pytest.mark.parametrize("rough", range(6))
def test_no_iteration_raises_the_energy_where_a_hardness_cuts_the_step(line_contact: LineContact, rough: int) -> None:
    """``p (K p / 2 + gap)`` over all cells is convex: a step uphill on its slope would raise it."""
    hard = replace(line_contact.scene, hardness=0.8 * line_contact.hertz.peak_pressure)
    bare = bare_problem(hard, line_contact.grid((24, 2), 0.3))
    own = bare.undeformed_gap
    heights = 3 * np.abs(own).max() * np.random.default_rng(rough).standard_normal(own.shape)
    bare = replace(bare, undeformed_gap=own + heights)
    solver, energies = PolonskyKeer(), []
    for iterations in range(8):
        pressure = solver.iterate(bare, tolerance=1e-14, max_iterations=iterations).pressure
        each = pressure * (bare.operator(pressure) / 2 + bare.undeformed_gap)
        energies.append(float(each.sum()))
    assert (np.diff(energies) <= 1e-12 * np.abs(energies).max()).all()
