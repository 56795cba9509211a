from dataclasses import replace

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.domain.device import Cpu
from contactstudy.solvers.fixed_point import solve_by_fixed_point_iteration
from contactstudy.solvers.friction import coulomb as laws
from contactstudy.solvers.friction.coulomb_newton import shear_status
from contactstudy.solvers.solution import TangentialTraction, with_traction

UNLIKE = cs.Scene(
    cs.LineLoad(1e5),
    (cs.HalfSpace(210e9, 0.3), cs.HalfSpace(70e9, 0.33)),
    (cs.Cylinder(0.01),),
    friction=cs.Sliding(0.5),
)


def test_outer_iterations_over_the_shear_of_dissimilar_bodies_end_in_equilibrium() -> None:
    """The gap in the contact is that of the pressure and of its own shear."""
    posed = UNLIKE.problem(cs.Grid((96, 1), (4e-4, 1e-3)), cs.ExactPeriodicity())
    found = cs.solve(posed, tolerance=1e-9)
    assert found.status is cs.Status.CONVERGED
    displacement = posed.operator(found.pressure) + 0.5 * posed.friction.coupling(found.pressure)
    gap = posed.undeformed_gap + displacement
    touching = found.pressure > 0
    assert np.ptp(gap[touching]) <= 1e-8 * posed.scales.gap
    assert gap[~touching].min() > gap[touching].mean()
    assert "outer iterations over the coupled displacement" in found.note


@pytest.mark.parametrize("width", [4e-4, 1e-4], ids=["whole contact", "cut off at the edge"])
def test_outer_iterations_that_do_not_converge_have_a_status(monkeypatch: pytest.MonkeyPatch, width: float) -> None:
    monkeypatch.setattr(laws, "MAX_SLIDING_ITERATIONS", 2)
    posed = UNLIKE.problem(cs.Grid((96, 1), (width, 1e-3)), cs.ZeroPadding())
    found = cs.solve(posed, tolerance=1e-9)
    assert found.status is cs.Status.NOT_CONVERGED
    assert found.residual > 1e-9


def test_a_spring_in_series_lowers_the_load_at_a_given_approach() -> None:
    posed = replace(UNLIKE, load=cs.Approach(1e-6), friction=None).problem(
        cs.Grid((96, 1), (4e-4, 1e-3)), cs.ExactPeriodicity()
    )

    def compressed(pressure: np.ndarray) -> np.ndarray:
        return np.full_like(pressure, 2e-17 * pressure.sum())

    options = cs.SolveOptions(1e-9)
    found = solve_by_fixed_point_iteration(posed, compressed, options, None, Cpu(), 50)
    gap = posed.undeformed_gap + posed.operator(found.pressure) + compressed(found.pressure)
    assert found.status is cs.Status.CONVERGED
    assert np.abs(gap[found.pressure > 0] - 1e-6).max() <= 1e-8 * posed.scales.gap


def test_a_displacement_or_a_traction_of_nan_is_a_failure() -> None:
    posed = replace(UNLIKE, friction=None).problem(cs.Grid((24, 1), (4e-4, 1e-3)), cs.ZeroPadding())
    options = cs.SolveOptions()
    lost = solve_by_fixed_point_iteration(posed, lambda pressure: np.nan * pressure, options, None, Cpu(), 9)
    assert lost.status is cs.Status.NOT_FINITE
    assert np.isnan(lost.residual)
    normal = cs.solve(posed)
    shear = TangentialTraction(np.full((2, 24, 1), np.nan), normal.pressure > 0, "", 1)
    lost = with_traction(normal, shear_status(np.nan, 1, 1e-8, 9), np.nan, 1, 2.0, shear)
    assert lost.status is cs.Status.NOT_FINITE
    assert np.isnan(lost.residual)
