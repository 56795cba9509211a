from dataclasses import replace

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.elasticity.tangential import shear_response
from contactstudy.solvers.coulomb import FrictionSet, SlipStep
from contactstudy.solvers.fretting import slip_step

FREE = cs.ZeroPadding(), cs.ZeroPadding()
GRID = cs.Grid((24, 12), (2.2, 2.2))
RESPONSE = shear_response((cs.HalfSpace(2 * (1 - 0.25**2), 0.25),) * 2, GRID, FREE, 1.0)
SPHERE = np.sqrt(np.maximum(1 - GRID.x[:, None] ** 2 - GRID.y**2, 0))
LIMIT = 0.3 * SPHERE
NONE = np.zeros((2, *GRID.cells))


def step(reference: np.ndarray = NONE, limit: np.ndarray = LIMIT, **given: np.ndarray) -> SlipStep:
    after = slip_step(RESPONSE, limit, reference, 1e-9, 400, **given)
    assert after.residual <= 1e-9
    return after


def forced(fraction: float) -> np.ndarray:
    return np.array([fraction * LIMIT.sum(), 0.0])


def check_coulombs_law(after: SlipStep, reference: np.ndarray, limit: np.ndarray) -> None:
    """The slip is that of the displacement, none where cells stick, and against the shear elsewhere."""
    slip = RESPONSE(after.shear - reference) - after.rigid[:, None, None]
    unit = np.abs(slip).max()
    touching = limit > 0
    np.testing.assert_allclose(after.slip[:, touching], slip[:, touching], atol=1e-7 * unit)
    assert np.abs(slip[:, after.stick]).max(initial=0) <= 1e-6 * unit
    slips = touching & ~after.stick
    size = np.hypot(*after.shear)
    np.testing.assert_allclose(size[slips], limit[slips], atol=2e-6 * limit.max())
    against = -np.einsum("cxy,cxy->xy", after.shear, slip)
    np.testing.assert_allclose(against[slips], (size * np.hypot(*slip))[slips], atol=1e-6 * unit)


def test_a_step_of_force_leaves_a_state_of_coulombs_law() -> None:
    """A force that turns back; and a falling pressure takes its shear along: what is cut off moves the surface back."""
    before = step(total=forced(0.7)).shear
    for fraction, limit in ((0.4, LIMIT), (-0.9, LIMIT), (0.9999, LIMIT), (0.3, 0.5 * LIMIT)):
        after = step(before, limit, total=forced(fraction))
        np.testing.assert_allclose(after.shear.sum(axis=(1, 2)), forced(fraction), atol=1e-9)
        check_coulombs_law(after, before, limit)


def test_the_displacement_of_a_force_gives_its_shear() -> None:
    known = step(total=forced(0.6))
    after = step(rigid=known.rigid)
    np.testing.assert_allclose(after.shear, known.shear, atol=1e-6 * LIMIT.max())
    check_coulombs_law(after, NONE, LIMIT)


def test_a_contact_converges_whose_newton_steps_fail_far_from_the_solution() -> None:
    """Nearly all cells of a rough contact stick: Newton's first step fails there, and projections lead on."""
    chance = np.random.default_rng(1)
    limit = LIMIT * chance.uniform(0, 1, LIMIT.shape) ** 6
    for moved in (1e-3, 1e-2, 1e-1):
        check_coulombs_law(step(rigid=np.array([moved, 0.0]), limit=limit), NONE, limit)


def test_a_contact_at_the_edge_does_not_hide_a_shear_that_did_not_converge() -> None:
    solids = (cs.HalfSpace(210e9, 0.3),) * 2
    friction = cs.PartialSlip(0.5, 0.4)
    scene = cs.Scene(cs.LineLoad(1e5), solids, (cs.Cylinder(0.01),), friction=friction)
    problem = scene.problem(cs.Grid((32, 8), (1e-4, 1e-4)), cs.ZeroPadding())
    stopped = cs.solve(problem, max_iterations=12)
    normal = cs.solve(replace(problem, friction=None), max_iterations=12)
    assert normal.status is cs.Status.CONTACT_AT_EDGE
    assert stopped.status is cs.Status.ITERATION_LIMIT
    assert stopped.residual > 1e-8


CHANCE = np.random.default_rng(3)
RADIUS = CHANCE.uniform(0.01, 1, 40)
TRIAL = CHANCE.normal(size=(2, 40))


@pytest.mark.parametrize("fraction", [0.0, 0.01, 0.6, 0.999])
def test_the_projection_is_nearest_among_those_with_the_sum(fraction: float) -> None:
    total = np.array([fraction * RADIUS.sum(), 0.0])
    nearest = FrictionSet(RADIUS, total).project(TRIAL).traction
    assert (np.hypot(*nearest) <= RADIUS * (1 + 1e-14)).all()
    assert nearest.sum(axis=1) == pytest.approx(total, abs=1e-9)
    # no admissible direction comes nearer: others of the same sum, on their disks
    for _ in range(20):
        other = FrictionSet(RADIUS, total).project(CHANCE.normal(size=(2, 40))).traction
        assert ((TRIAL - nearest) * (other - nearest)).sum() <= 1e-7
