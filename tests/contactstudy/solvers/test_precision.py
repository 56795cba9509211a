import numpy as np
import pytest

import contactstudy as cs
from tests.conftest import LineContact
from tests.contactstudy.solvers.test_preconditioned_cg import PADDINGS, ROUGH, problem

SINGLE = "single"


def measured(solution: cs.Solution) -> float:
    """The residual of a solution's pressure in double precision."""
    bare = solution.problem.bare()
    pressure = solution.pressure / solution.problem.scales.pressure
    return bare.residual(pressure, bare.gap(pressure, bare.operator(pressure)))


@pytest.mark.parametrize("padding", PADDINGS, ids=str)
@pytest.mark.parametrize("heights", ROUGH)
@pytest.mark.parametrize("solver", [cs.PreconditionedCG(), cs.PolonskyKeer()], ids=str)
def test_single_precision_ends_at_its_rounding_with_a_status(
    solver: cs.Solver, heights: str, padding: cs.Padding | cs.Paddings, line_contact: LineContact
) -> None:
    posed = problem(line_contact, 64, heights, padding)
    solution = cs.solve(posed, tolerance=1e-12, precision=SINGLE, solver=solver)
    assert solution.status is cs.Status.PRECISION_LIMIT
    assert "double precision" in str(solution.status)
    assert solution.note == ""
    assert solution.iterations < 200
    # it stops at two machine epsilons of the largest displacement, which here went to metres and back
    rounding = np.finfo(np.float32).eps * np.abs(solution.displacement).max() / posed.scales.gap
    assert solution.residual <= 2 * rounding * (1 + 4 * np.finfo(float).eps)
    # found again without rounding, it is another by no more than the gap was uncertain by
    assert measured(solution) <= solution.residual + 2 * rounding


@pytest.mark.parametrize("heights", ROUGH)
def test_single_precision_solves_to_a_tolerance_it_can_reach(heights: str, line_contact: LineContact) -> None:
    posed = problem(line_contact, 64, heights)
    single = cs.solve(posed, tolerance=1e-5, precision=SINGLE)
    assert single.residual <= 1e-5
    assert measured(single) <= 1.1e-5
    double = cs.solve(posed, tolerance=1e-9)
    difference = np.abs(single.pressure - double.pressure).max() / posed.scales.pressure
    assert difference < 64 * 1e-5 * 10  # a residual times the operator's condition
