import numpy as np
import pytest
from scipy.special import erfinv

import contactstudy as cs
from contactstudy.solvers.conjugate_gradients import PolonskyKeer, PreconditionedCG
from tests.conftest import LineContact

# rms heights over the gap scale that leave 80 %, 30 % and 9 % of Hertz's area in contact, and none
ROUGH = {"smooth": 0.0, "80 %": 0.15, "30 %": 0.6, "9 %": 2.2}


def problem(
    contact: LineContact,
    cells: int | tuple[int, int],
    heights: str,
    padding: cs.Padding | cs.Paddings | None = None,
    width: float = 4.8,
) -> cs.Problem:
    padding = padding or cs.ExactPeriodicity()
    a = contact.hertz.half_width
    grid = contact.grid(cells, 2.4, width)
    smooth = contact.scene.problem(grid, padding)
    rms = ROUGH[heights] * smooth.scales.gap
    shape = cs.Roughness(rms=rms, hurst=0.8, roll_off=1.2 * a, cut_off=0.15 * a, seed=1)
    scene = contact.with_shapes(shape)
    return scene.problem(grid, padding)


@pytest.mark.parametrize("hurst", [0.2, 0.8])
@pytest.mark.parametrize("fraction", [0.05, 0.6])
def test_iterations_do_not_grow_with_detail_down_to_the_cell(fraction: float, hurst: float) -> None:
    both = cs.ExactPeriodicity(), cs.ExactPeriodicity()
    rigid, body = cs.HalfSpace(np.inf, 0.3), cs.HalfSpace(1e11, 0.0)
    iterations = []
    for cells in (64, 128):
        rough = cs.Roughness(cs.RmsSlope(0.1), hurst, 0.25, 2 / cells * (1 + 1e-9), seed=1)
        # Persson (2001): the fraction in contact of a flat rough surface with this rms slope
        pressure = erfinv(fraction) * 0.1 * 1e11 / 2
        scene = cs.Scene(cs.LineLoad(pressure), (body, rigid), (rough,))
        solution = cs.solve(scene.problem(cs.Grid((cells, cells), (1.0, 1.0)), both))
        assert fraction / 2 < (solution.pressure > 0).mean() < 2 * fraction
        iterations.append(solution.iterations)
    assert max(iterations) <= 10
    assert iterations[-1] <= iterations[0] + 2


@pytest.mark.parametrize(("shape", "most"), [(cs.Sphere(1.0), 12), (cs.Roughness(0.05, 0.8, 0.25, 0.05, seed=1), 16)])
def test_contacts_at_free_ends_take_as_few_iterations_as_within(shape: cs.Shape, most: int) -> None:
    body, rigid = cs.HalfSpace(1.0, 0.0), cs.HalfSpace(np.inf, 0.0)
    scene = cs.Scene(cs.TotalLoad(1.0, length=1.0), (body, rigid), (shape,))
    for cells in (64, 192):
        problem = scene.problem(cs.Grid((cells, cells), (1.0, 1.0)), (cs.ZeroPadding(), cs.ZeroPadding()))
        solution = cs.solve(problem, tolerance=1e-10)
        assert solution.pressure[[0, -1]].any(axis=1).all()
        assert solution.pressure[:, [0, -1]].any(axis=0).all()
        assert solution.iterations <= most


@pytest.mark.parametrize("cells", [(4099, 1), (127, 131)])
def test_grids_that_do_not_halve_take_few_iterations(cells: tuple[int, int], line_contact: LineContact) -> None:
    for heights in ("smooth", "30 %"):
        assert cs.solve(problem(line_contact, cells, heights)).iterations <= 30


def test_a_stalled_solve_goes_on_by_polonsky_and_keer_with_a_note(line_contact: LineContact) -> None:
    posed = problem(line_contact, 64, "30 %")
    impatient = PreconditionedCG(patience=0)
    solution = cs.solve(posed, solver=impatient, tolerance=1e-9)
    assert solution.residual <= 1e-9
    assert "Polonsky & Keer's scheme went on" in solution.note
    reference = cs.solve(posed, solver=PolonskyKeer(), tolerance=1e-9)
    difference = np.abs(solution.pressure - reference.pressure).max() / posed.scales.pressure
    assert difference < 64 * 1e-9 * 10


@pytest.mark.parametrize("solver", [PreconditionedCG(), PolonskyKeer(patience=60)], ids=str)
def test_a_tolerance_below_rounding_has_a_status(solver: cs.Solver, line_contact: LineContact) -> None:
    solution = cs.solve(problem(line_contact, 64, "80 %"), tolerance=1e-17, solver=solver)
    assert solution.status is cs.Status.PRECISION_LIMIT
    assert solution.residual < 1e-12


def published(operator: np.ndarray, separation: np.ndarray, start: np.ndarray, iterations: int) -> np.ndarray:
    """Their section 3, word for word: the pressure after so many iterations."""
    pressure, load = start.copy(), start.sum()
    direction, old, conjugate = np.zeros(len(separation)), 1.0, 0.0
    for _ in range(iterations):
        bears = pressure > 0
        gap = operator @ pressure + separation
        gap -= gap[bears].mean()
        new = (gap[bears] ** 2).sum()
        direction = np.where(bears, gap + conjugate * (new / old) * direction, 0.0)
        old = new
        response = operator @ direction
        response -= response[bears].mean()
        step = (gap * direction)[bears].sum() / (response * direction)[bears].sum()
        pressure = np.where(bears, np.maximum(pressure - step * direction, 0), pressure)
        overlaps = (pressure == 0) & (gap < 0)
        conjugate = 0.0 if overlaps.any() else 1.0
        pressure[overlaps] -= step * gap[overlaps]
        pressure *= load / pressure.sum()
    return pressure


@pytest.mark.parametrize("iterations", [1, 10])
@pytest.mark.parametrize("bearing", [slice(None), slice(10, 15), slice(4, 9)])
def test_the_iterates_are_those_of_polonsky_and_keer(
    line_contact: LineContact, bearing: slice, iterations: int
) -> None:
    """From all cells it loses some, from a few in the middle it gains some, from a few aside it does both."""
    bare = line_contact.scene.problem(line_contact.grid((24, 2), 0.3), cs.ExactPeriodicity()).bare()
    cells = bare.undeformed_gap.shape
    each = np.eye(cells[0] * cells[1]).reshape(-1, *cells)
    operator = np.transpose([bare.operator(pressure).ravel() for pressure in each])
    start = np.zeros(cells)
    start[bearing, :] = bare.uniform().sum() / start[bearing, :].size
    wanted = published(operator, bare.undeformed_gap.ravel(), start.ravel(), iterations)
    last = PolonskyKeer().iterate(bare, tolerance=0.0, max_iterations=iterations, start=start)
    np.testing.assert_allclose(last.pressure.ravel(), wanted, rtol=1e-9, atol=1e-12 * start.sum())
    assert (last.iterations, last.convolutions) == (iterations, 2 * iterations + 1)


def measured(solution: cs.Solution) -> float:
    """The residual of a solution's pressure in double precision."""
    bare = solution.problem.bare()
    pressure = solution.pressure / solution.problem.scales.pressure
    return bare.residual(pressure, bare.gap(pressure, bare.operator(pressure)))


@pytest.mark.parametrize("solver", [cs.PreconditionedCG(), cs.PolonskyKeer()], ids=str)
def test_single_precision_ends_at_its_rounding_with_a_status(solver: cs.Solver, line_contact: LineContact) -> None:
    posed = problem(line_contact, 64, "30 %")
    solution = cs.solve(posed, tolerance=1e-12, precision="single", solver=solver)
    assert solution.status is cs.Status.PRECISION_LIMIT
    assert "double precision" in str(solution.status)
    assert solution.iterations < 200
    # it stops at two machine epsilons of the largest displacement, which here went to metres and back
    rounding = np.finfo(np.float32).eps * np.abs(solution.displacement).max() / posed.scales.gap
    assert solution.residual <= 2 * rounding * (1 + 4 * np.finfo(float).eps)
    # found again without rounding, it is another by no more than the gap was uncertain by
    assert measured(solution) <= solution.residual + 2 * rounding


def test_single_precision_solves_to_a_tolerance_it_can_reach(line_contact: LineContact) -> None:
    posed = problem(line_contact, 64, "30 %")
    single = cs.solve(posed, tolerance=1e-5, precision="single")
    assert single.residual <= 1e-5
    assert measured(single) <= 1.1e-5
    double = cs.solve(posed, tolerance=1e-9)
    difference = np.abs(single.pressure - double.pressure).max() / posed.scales.pressure
    assert difference < 64 * 1e-5 * 10  # a residual times the operator's condition
