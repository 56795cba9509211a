from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import contactstudy as cs
from contactstudy.problem.constraint import Constraint
from contactstudy.solvers.conjugate_gradients import PolonskyKeer, PreconditionedCG
from tests.conftest import LineContact
from tests.contactstudy.solvers.test_preconditioned_cg import problem

CONSTRAINTS = [Constraint(), *map(Constraint, (4.0, 1.0, 10 / 12))]

TOTAL = 10.0


@given(seed=st.integers(0, 2**32), which=st.sampled_from(CONSTRAINTS), scale=st.sampled_from([1e-8, 1.0, 1e8, 1e40]))
def test_projected_pressures_are_admissible(seed: int, which: Constraint, scale: float) -> None:
    trial = np.random.default_rng(seed).standard_normal((3, 4)) * scale
    trial[0, 0] = scale  # one cell at least bears
    for admitted in (which.scale_to_load(trial.copy(), TOTAL), which.project(trial.copy(), TOTAL)):
        assert admitted.min() >= 0
        assert admitted.max() <= which.capacity(1)
        # under a hardness, cells may have to be lifted by as much as they are below the others
        lifted = scale if which.capacity(1) < TOTAL else 0.0
        assert admitted.sum() == pytest.approx(TOTAL, rel=1e-12, abs=1e-14 * lifted)


@given(seed=st.integers(0, 2**32), which=st.sampled_from(CONSTRAINTS))
def test_the_projection_is_the_nearest_admissible_pressure(seed: int, which: Constraint) -> None:
    rng = np.random.default_rng(seed)
    trial = rng.standard_normal((3, 4)) * 3
    nearest = which.project(trial.copy(), TOTAL)
    for _ in range(10):
        other = which.scale_to_load(rng.exponential(size=(3, 4)), TOTAL)
        # the step on from the nearest to any other leads away: a convex set's own property
        assert ((trial - nearest) * (other - nearest)).sum() <= 1e-11
        assert ((nearest - trial) ** 2).sum() <= ((other - trial) ** 2).sum() + 1e-11


@pytest.mark.parametrize("fraction", [10.0, 0.6, 0.328])  # the mean over the width is 0.327 p_H
def test_both_solvers_agree_under_a_hardness(fraction: float, line_contact: LineContact) -> None:
    hardness = fraction * line_contact.hertz.peak_pressure
    posed = replace(problem(line_contact, 64, "30 %"), constraint=Constraint(hardness))
    solutions = [cs.solve(posed, tolerance=1e-10, solver=solver) for solver in (PreconditionedCG(), PolonskyKeer())]
    for solution in solutions:
        assert solution.residual <= 1e-10
        assert solution.note == ""
        assert (solution.pressure <= hardness).all()
        assert (solution.gap[solution.pressure == hardness] <= 1e-10 * posed.scales.gap).all()
        assert solution.pressure.sum() == pytest.approx(posed.control.total, rel=1e-10)
    ours, reference = (solution.pressure / posed.scales.pressure for solution in solutions)
    assert np.abs(ours - reference).max() < 64 * 1e-10 * 10


def test_a_body_that_yields_under_a_hardness_conforms(line_contact: LineContact) -> None:
    """Its dent is what the gap would be below zero; the mean gap is that of the open cells."""
    hard = replace(line_contact.scene, hardness=0.6 * line_contact.hertz.peak_pressure)
    contact = cs.solve(hard, line_contact.grid((128, 1), 1.0, 4.0), cs.ExactPeriodicity())
    identity = contact.problem.undeformed_gap + contact.displacement - contact.approach
    yields = contact.pressure == hard.hardness
    np.testing.assert_allclose(contact.gap - contact.dent, identity, rtol=0, atol=1e-20)
    assert (contact.gap[yields] == 0).all()
    assert contact.dent[yields].min() > 0 == np.abs(contact.dent[~yields]).max()
    open_gap = identity[contact.pressure == 0].sum() / identity.size
    assert contact.quantities["mean_gap"].value == pytest.approx(open_gap, rel=1e-6)
    assert contact.to_dataset()["dent"].max() == contact.dent.max()
    assert contact.quantities["yielded_depth"].value == contact.dent.max()


def test_a_hardness_below_the_mean_pressure_has_a_status(line_contact: LineContact) -> None:
    soft = replace(line_contact.scene, hardness=0.3 * line_contact.hertz.peak_pressure)
    grid = line_contact.grid((32, 4), 1.2, width=4.8)
    solution = cs.solve(soft.problem(grid, cs.ExactPeriodicity()))
    assert solution.status is cs.Status.NO_ADMISSIBLE_PRESSURE
    assert "larger hardness" in str(solution.status)
    assert np.isfinite(solution.gap).all()


def test_the_residual_is_the_largest_violation_of_the_contact_conditions() -> None:
    for constraint, pressure, gap, residual in (
        # the mean gap under the pressure, (2 * 0.3 + 0.5 * 0.8) / 2.5; the deepest penetration where there is none
        (Constraint(), (2.0, 0.5, 0.0, 0.0), (0.3, -0.8, -0.25, 0.9), 0.4),
        (Constraint(), (2.0, 0.5, 0.0, 0.0), (0.3, -0.8, -0.75, 0.9), 0.75),
        # the mean gap under the pressure of free cells; the widest gap where one has yielded
        (Constraint(4.0), (4.0, 2.0, 0.5, 0.0), (0.2, 0.3, -0.8, -0.1), 0.4),
        (Constraint(4.0), (4.0, 2.0, 0.5, 0.0), (0.6, 0.3, -0.8, -0.1), 0.6),
    ):
        violation = constraint.violation(np.array([pressure]), np.array([gap]))
        assert violation == pytest.approx(residual)
