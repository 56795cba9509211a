from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import pytest

import contactstudy as cs
from tests.conftest import STEEL, LineContact
from tests.contactstudy.scene.shapes.test_shapes import Own

Array = np.ndarray


@dataclass(frozen=True)
class Springs:
    """Coefficients of a bed of independent springs: a cell moves under its own pressure alone."""

    parity: ClassVar[tuple[int, int]] = (1, 1)

    def swap_axes(self) -> "Springs":
        return self

    def cell(self, x: Array, y: Array, dx: float, dy: float) -> Array:
        return ((np.abs(x) < dx / 2) & (np.abs(y) < dy / 2)).astype(float)

    def row(self, x: Array, y: Array, dx: float, dy: float, period: float) -> Array:
        return self.cell(x, y, dx, dy)

    def lattice(self, x: Array, y: Array, dx: float, dy: float, width: float, period: float) -> Array:
        return self.cell(x, y, dx, dy)


@dataclass(frozen=True)
class Foundation:
    """A solid with its own kernel: Winkler's foundation, ``u = p / stiffness`` [Pa/m]."""

    stiffness: float

    @property
    def compliance(self) -> float:
        return 1e-3 / self.stiffness

    def response(self, datum: float) -> Mapping[cs.Coefficients, float]:
        return {Springs(): 1 / self.stiffness}


def test_a_solid_of_ones_own_gives_the_closed_form_of_its_kernel() -> None:
    """On Winkler's foundation ``p = k (approach - x^2 / (2 R))``, and the load is 2/3 of it times the width."""
    stiffness, radius, half_width = 1e13, 0.01, 1e-4
    rigid = cs.HalfSpace(np.inf, 0.0)
    load = 2 / 3 * stiffness * half_width**3 / radius
    shape = Own(lambda grid: (grid.x**2 / (2 * radius))[:, None], 1 / radius)
    scene = cs.Scene(cs.LineLoad(load), (Foundation(stiffness), rigid), (shape,))
    grid = cs.Grid((200, 1), (4 * half_width, half_width))
    solution = cs.solve(scene.problem(grid, cs.ExactPeriodicity()))
    assert solution.status is cs.Status.CONVERGED
    exact = stiffness * np.clip(half_width**2 - grid.x**2, 0, None) / (2 * radius)
    # cells' centres instead of their means: the load differs by the square of a cell over the width
    highest = stiffness * half_width**2 / (2 * radius)
    assert np.abs(solution.pressure[:, 0] - exact).max() < highest * (grid.cell_size[0] / half_width) ** 2


@dataclass(frozen=True)
class CappedBy:
    """A limit of one's own, by composition: what a hardness is."""

    inner: cs.HardnessLimited

    def scaled(self, pressure: float) -> "CappedBy":
        return CappedBy(self.inner.scaled(pressure))

    def __getattr__(self, name: str) -> object:
        return getattr(self.inner, name)


def test_a_limit_of_ones_own_is_obeyed(line_contact: LineContact) -> None:
    grid = line_contact.grid((64, 2), 1.2)
    hardness = 0.8 * line_contact.hertz.peak_pressure
    plain = line_contact.scene.problem(grid, cs.ExactPeriodicity())
    own = cs.solve(replace(plain, constraint=CappedBy(cs.HardnessLimited(hardness))))
    named = cs.solve(replace(line_contact.scene, hardness=hardness).problem(grid, cs.ExactPeriodicity()))
    assert own.pressure.max() == hardness
    np.testing.assert_array_equal(own.pressure, named.pressure)


@dataclass(frozen=True)
class ProjectedGradient:
    """A solver of one's own: steps against the gap, each to the nearest admissible pressure."""

    def iterate(
        self,
        problem: cs.BareProblem,
        *,
        tolerance: float,
        max_iterations: int,
        start: Array | None = None,
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
        constraint=cs.Compressive(),
        control=cs.PrescribedLoad(1e5 / grid.cell_size[0]),
        scales=cs.Scales(length=1e-4, pressure=6e8, gap=6e8 * 1e-4 / 1e11),
    )
    solution = cs.solve(problem)
    assert solution.status is cs.Status.CONVERGED
    # at rounding of the largest of the cells' pressures
    assert solution.pressure.sum() * grid.cell_size[0] == pytest.approx(1e5, rel=1e-8)
    assert solution.to_dataset()["pressure"].sizes == {"x": 64, "y": 1}


def test_completion_lists_the_public_names_and_nothing_else() -> None:
    listed = set(dir(cs))
    assert {"read_scene", "SubsurfaceStress", "solve", "analytic", "Problem"} <= listed
    assert listed == set(cs.__all__)
    for name in listed:
        assert getattr(cs, name) is not None


def test_a_name_that_is_not_there_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="solvee"):
        cs.solvee  # noqa: B018


def test_a_precision_is_named_by_a_word(line_contact: LineContact) -> None:
    problem = line_contact.scene.problem(line_contact.grid(16, 1.2), cs.ExactPeriodicity())
    by_word = cs.solve(problem, precision="single", tolerance=1e-4)
    by_value = cs.solve(problem, precision="single", tolerance=1e-4)
    np.testing.assert_array_equal(by_word.pressure, by_value.pressure)
    with pytest.raises(cs.InvalidInput, match=r"^solve.precision is 'half': choose from single, double"):
        cs.solve(problem, precision="half")


def test_a_grid_takes_an_array_of_two_numbers() -> None:
    taken = cs.Grid(cells=np.array([64, 32]), extent=np.array([1e-4, 2e-4]))  # type: ignore[arg-type]
    assert taken == cs.Grid((64, 32), (1e-4, 2e-4))
    assert type(taken.cells[0]) is int


def test_a_question_without_an_answer_is_told_from_bad_input() -> None:
    flat = cs.Scene(cs.LineLoad(1.0), (STEEL, STEEL), (cs.Waviness(1e-6, across=1e-4),))
    with pytest.raises(cs.NotDefined, match="no curvature"):
        cs.plan(flat)
    with pytest.raises(cs.InvalidInput) as refused:
        cs.plan(flat, error=-1.0)
    assert not isinstance(refused.value, cs.NotDefined)
