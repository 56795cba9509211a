from dataclasses import dataclass

import numpy as np
import pytest

import contactstudy as cs
from tests.conftest import STEEL, LineContact

Array = np.ndarray


@dataclass(frozen=True)
class ProjectedGradient:
    """A solver of one's own: steps against the gap, each to the nearest admissible pressure."""

    def iterate(
        self, problem: cs.BareProblem, *, tolerance: float, max_iterations: int, start: Array | None = None
    ) -> cs.Iterate:
        pressure = problem.clip_and_scale(problem.uniform() if start is None else start.copy())
        waves = np.random.default_rng(1).standard_normal(pressure.shape)
        for _ in range(30):  # the stiffest wave, by power iteration
            moved = problem.operator(waves / np.linalg.norm(waves))
            waves = moved - moved.mean()
        length = 1 / np.linalg.norm(waves)
        for iteration in range(max_iterations + 1):
            moved = problem.operator(pressure)
            gap = problem.gap(pressure, moved)
            left = problem.residual(pressure, gap)
            if problem.should_stop(left, moved, tolerance) or iteration == max_iterations:
                break
            pressure = problem.project(pressure - length * gap.height)
        return cs.Iterate(pressure, moved, gap.approach, left, iteration, iteration + 31.0)


def test_a_solver_of_ones_own_finds_the_same_pressure(line_contact: LineContact) -> None:
    problem = line_contact.scene.problem(line_contact.grid((32, 1), 1.2), cs.ExactPeriodicity())
    own = cs.solve(problem, solver=ProjectedGradient(), tolerance=1e-7, max_iterations=5000)
    ours = cs.solve(problem, tolerance=1e-7)
    assert own.status is cs.Status.CONVERGED
    # complementarity and penetration up to the tolerance leave an energy e A e of 2 sum(p) times it to the
    # error e of each, and the stiffest wave turns that into a norm
    bare = problem.bare()
    matrix = np.stack([bare.operator(unit[:, None])[:, 0] for unit in np.eye(32)])
    eigenvalues = np.linalg.eigvalsh(matrix - matrix.mean(0) - matrix.mean(1)[:, None] + matrix.mean())
    difference = (own.pressure - ours.pressure) / problem.scales.pressure
    energy = 2 * 1e-7 * bare.uniform().sum()
    assert np.linalg.norm(difference) <= 2 * np.sqrt(energy / eigenvalues[1])


def test_a_problem_is_built_from_arrays_an_operator_and_a_load() -> None:
    grid = cs.Grid((64, 1), (3e-4, 1e-4))
    operator = cs.convolution(1e11, grid, cs.ExactPeriodicity(), datum=1e-4)
    problem = cs.Problem(
        grid=grid,
        undeformed_gap=(grid.x**2 / 0.02)[:, None],
        operator=operator,
        constraint=cs.Constraint(),
        control=cs.PrescribedLoad(1e5 / grid.cell_size[0]),
        scales=cs.Scales(length=1e-4, pressure=6e8, gap=6e8 * 1e-4 / 1e11),
    )
    solution = cs.solve(problem)
    assert solution.status is cs.Status.CONVERGED
    # at rounding of the largest of the cells' pressures
    assert solution.pressure.sum() * grid.cell_size[0] == pytest.approx(1e5, rel=1e-8)
    assert solution.to_dataset()["pressure"].sizes == {"x": 64, "y": 1}


def test_completion_lists_the_public_names_and_nothing_else() -> None:
    assert {"read_scene", "SubsurfaceStress", "solve", "analytic", "Problem"} <= set(dir(cs)) == set(cs.__all__)
    for name in dir(cs):
        assert getattr(cs, name) is not None
    with pytest.raises(AttributeError, match="solvee"):
        cs.solvee  # noqa: B018


def test_a_question_without_an_answer_is_told_from_bad_input() -> None:
    flat = cs.Scene(cs.LineLoad(1.0), (STEEL, STEEL), (cs.Waviness(1e-6, across=1e-4),))
    with pytest.raises(cs.NotDefined, match="no curvature"):
        cs.plan(flat)
    with pytest.raises(cs.InvalidInput) as refused:
        cs.plan(flat, error=-1.0)
    assert not isinstance(refused.value, cs.NotDefined)
