import numpy as np
import pytest

import contactstudy as cs
from tests.conftest import LineContact
from tests.contactstudy.solvers.test_preconditioned_cg import PADDINGS, ROUGH, problem

SINGLE = cs.Precision.SINGLE


def measured(solution: cs.Solution) -> float:
    """The residual of a solution's pressure in double precision."""
    bare = solution.problem.bare()
    pressure = solution.pressure / solution.problem.scales.pressure
    return bare.residual(pressure, bare.gap(pressure, bare.operator(pressure)))


@pytest.mark.parametrize("padding", PADDINGS, ids=str)
@pytest.mark.parametrize("heights", ROUGH)
@pytest.mark.parametrize("solver", [cs.PreconditionedCG(), cs.PolonskyKeer()], ids=str)
def test_single_precision_says_what_residual_it_can_reach_and_stops_there(
    solver: cs.Solver, heights: str, padding: cs.Padding | cs.Paddings, line_contact: LineContact
) -> None:
    posed = problem(line_contact, 64, heights, padding)
    solution = cs.solve(posed, tolerance=1e-12, precision=SINGLE, solver=solver)
    assert solution.status is cs.Status.PRECISION_LIMIT
    assert "double precision" in str(solution.status)
    assert solution.note == ""
    assert solution.iterations < 200
    # it stops at two roundings of the largest displacement, which here went to metres and back
    rounding = np.finfo(np.float32).eps * np.abs(solution.displacement).max() / posed.scales.gap
    assert solution.residual <= 2 * rounding * (1 + 4 * np.finfo(float).eps)
    # found again without rounding, it is another by no more than the gap was uncertain by
    assert measured(solution) <= solution.residual + 2 * rounding


@pytest.mark.parametrize("heights", ROUGH)
def test_single_precision_solves_to_a_tolerance_it_can_reach(
    heights: str, line_contact: LineContact
) -> None:
    posed = problem(line_contact, 64, heights)
    single = cs.solve(posed, tolerance=1e-5, precision=SINGLE)
    assert single.residual <= 1e-5
    assert measured(single) <= 1.1e-5
    double = cs.solve(posed, tolerance=1e-9)
    difference = np.abs(single.pressure - double.pressure).max() / posed.scales.pressure
    assert difference < 64 * 1e-5 * 10  # a residual times the operator's condition


def test_no_array_of_a_single_precision_problem_is_double(line_contact: LineContact) -> None:
    bare = problem(line_contact, 64, "30 %").bare(SINGLE)
    seen = bare
    while seen is not None:
        assert seen.undeformed_gap.dtype == np.float32
        operator = seen.operator
        assert isinstance(operator, cs.Convolution)
        assert operator.spectrum.dtype == np.float32
        assert operator(seen.uniform()).dtype == np.float32
        extension = operator.approximate_inverse().extension(np.ones_like(seen.uniform()))
        assert extension.pressure(extension(seen.uniform())).dtype == np.float32
        seen = seen.coarsened()
    last = cs.PreconditionedCG().iterate(bare, tolerance=1e-6, max_iterations=50)
    assert last.pressure.dtype == last.displacement.dtype == np.float32


def test_a_solution_is_double_whatever_it_was_solved_in(line_contact: LineContact) -> None:
    solution = cs.solve(problem(line_contact, 32, "smooth"), precision=SINGLE)
    for field in (solution.pressure, solution.displacement, solution.gap):
        assert field.dtype == np.float64
