"""The projection of shear onto Coulomb's limit, with and without a given resultant."""

import numpy as np
import pytest

from contactstudy.solvers.friction.disks import Disks

CHANCE = np.random.default_rng(3)
RADIUS = CHANCE.uniform(0.01, 1, 40)
TRIAL = CHANCE.normal(size=(2, 40))


@pytest.mark.parametrize("fraction", [0.0, 0.01, 0.6, 0.999])
def test_the_projection_is_nearest_among_those_with_the_sum(fraction: float) -> None:
    total = np.array([fraction * RADIUS.sum(), 0.0])
    found = Disks(RADIUS, total).project(TRIAL)
    assert (np.hypot(*found) <= RADIUS * (1 + 1e-14)).all()
    assert found.sum(axis=1) == pytest.approx(total, abs=1e-9)
    # no admissible direction comes nearer: others of the same sum, on their disks
    for _ in range(20):
        other = Disks(RADIUS, total).project(CHANCE.normal(size=(2, 40)))
        assert ((TRIAL - found) * (other - found)).sum() <= 1e-7


@pytest.mark.parametrize("total", [None, np.array([3.0, -1.0]), np.array([3.0, np.nan])], ids=str)
def test_the_derivative_is_that_of_differences(total: np.ndarray | None) -> None:
    disks = Disks(RADIUS, total)
    disks.project(TRIAL)
    derivative, stick = disks.derivative(TRIAL)
    if total is not None:
        given = ~np.isnan(total)
        np.testing.assert_allclose(disks.project(TRIAL).sum(axis=1)[given], total[given])
        np.testing.assert_array_equal(disks.shift[~given], 0)
    assert stick.any()
    assert not stick.all()
    change, part = CHANCE.normal(size=(2, 40)), 1e-6
    ahead, behind = (disks.project(TRIAL + sign * part * change) for sign in (1, -1))
    np.testing.assert_allclose(derivative(change), (ahead - behind) / (2 * part), atol=1e-6)


def test_a_shift_that_belonged_to_another_trial_does_no_harm() -> None:
    """The first trial leaves a shift that brings all cells of the second one to their rims, on the wrong side."""
    radius = np.sqrt(1 - np.linspace(-0.99, 0.99, 60) ** 2)
    total = np.array([-0.6 * radius.sum(), 0.0])
    disks = Disks(radius, total)
    for far in (1e3, -1e3, 1e6, 0.0):
        found = disks.project(np.stack([radius + far, 0 * radius]))
        assert found.sum(axis=1) == pytest.approx(total, rel=1e-8)
