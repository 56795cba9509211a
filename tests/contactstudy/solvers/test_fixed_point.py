"""Fixed-point iteration over the displacement that sliding friction adds to a contact of unlike bodies."""

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.solvers.friction import laws

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
def test_outer_iterations_that_do_not_converge_have_a_status(
    monkeypatch: pytest.MonkeyPatch, width: float
) -> None:
    monkeypatch.setattr(laws, "MAX_SLIDING_ITERATIONS", 2)
    posed = UNLIKE.problem(cs.Grid((96, 1), (width, 1e-3)), cs.ZeroPadding())
    found = cs.solve(posed, tolerance=1e-9)
    assert found.status is cs.Status.NOT_CONVERGED
    assert found.residual > 1e-9
