import numpy as np
import pytest

import contactstudy as cs
from contactstudy.solvers.friction.coulomb import FrictionSet

FREE = cs.ZeroPadding(), cs.ZeroPadding()


@pytest.mark.parametrize("elongation", [1.6, 20.0, 62.0])
@pytest.mark.parametrize("poisson_ratio", [0.0, 0.3, 0.49])
def test_a_finite_roller_takes_no_more_applications_than_promised(elongation: float, poisson_ratio: float) -> None:
    body = cs.HalfSpace(210e9, poisson_ratio)
    length = 0.01
    shapes = (cs.Cylinder(0.01), cs.LundbergProfile(2e-6, 2e-5, length))
    friction = cs.TractiveRolling(0.3, longitudinal=1e-3, lateral=5e-4, spin=0.1)
    scene = cs.Scene(cs.LineLoad(1e5), (body, body), shapes, friction=friction)
    width = 2.6 * scene.hertz.half_width
    cells = 48, min(round(1.05 * length / (elongation * width / 48)), 400)
    grid = cs.Grid(cells, (width, 1.05 * length))
    problem = scene.problem(grid, FREE)
    pressure = cs.solve(cs.Scene(scene.load, scene.solids, shapes).problem(grid, FREE), tolerance=1e-6).pressure
    state = problem.friction.steady(grid, pressure, cs.SolveOptions(1e-6))
    assert state.residual <= 1e-6
    assert state.convolutions / 2 <= 75


CHANCE = np.random.default_rng(3)
RADIUS = CHANCE.uniform(0.01, 1, 40)
TRIAL = CHANCE.normal(size=(2, 40))


@pytest.mark.parametrize("fraction", [0.0, 0.01, 0.6, 0.999])
def test_the_projection_is_nearest_among_those_with_the_sum(fraction: float) -> None:
    total = np.array([fraction * RADIUS.sum(), 0.0])
    found = FrictionSet(RADIUS, total).project(TRIAL).traction
    assert (np.hypot(*found) <= RADIUS * (1 + 1e-14)).all()
    assert found.sum(axis=1) == pytest.approx(total, abs=1e-9)
    # no admissible direction comes nearer: others of the same sum, on their disks
    for _ in range(20):
        other = FrictionSet(RADIUS, total).project(CHANCE.normal(size=(2, 40))).traction
        assert ((TRIAL - found) * (other - found)).sum() <= 1e-7


def test_without_a_prescribed_sum_the_projection_has_no_shift() -> None:
    plain = FrictionSet(RADIUS).project(TRIAL).traction
    found = FrictionSet(RADIUS, np.array([plain[0].sum(), np.nan])).project(TRIAL).traction
    np.testing.assert_allclose(found, plain, atol=1e-9)


def test_a_projection_does_not_depend_on_the_one_before() -> None:
    """The first trial leaves a shift that brings all cells of the second one to their rims, on the wrong side."""
    radius = np.sqrt(1 - np.linspace(-0.99, 0.99, 60) ** 2)
    total = np.array([-0.6 * radius.sum(), 0.0])
    disks = FrictionSet(radius, total)
    for far in (1e3, -1e3, 1e6, 0.0):
        found = disks.project(np.stack([radius + far, 0 * radius])).traction
        assert found.sum(axis=1) == pytest.approx(total, rel=1e-8)
