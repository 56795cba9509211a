from dataclasses import replace

import numpy as np
import pytest
from scipy.special import erfinv

import contactstudy as cs
from contactstudy.solvers.conjugate_gradients import PolonskyKeer, PreconditionedCG
from tests.conftest import LineContact

PADDINGS: list[cs.Padding | cs.Paddings] = [
    cs.ZeroPadding(),
    cs.DuplicatedPadding(),
    cs.Superposition(2),
    cs.CircularSuperposition(2),
    cs.ExactPeriodicity(),
    (cs.ExactPeriodicity(), cs.ExactPeriodicity()),
]
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
@pytest.mark.parametrize("fraction", [0.05, 0.2, 0.6])
def test_iterations_do_not_grow_with_detail_down_to_the_cell(fraction: float, hurst: float) -> None:
    both = cs.ExactPeriodicity(), cs.ExactPeriodicity()
    rigid, body = cs.HalfSpace(np.inf, 0.3), cs.HalfSpace(1e11, 0.0)
    iterations = []
    for cells in (64, 128, 256):
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
    free = cs.ZeroPadding(), cs.ZeroPadding()
    for cells in (64, 192):
        problem = scene.problem(cs.Grid((cells, cells), (1.0, 1.0)), free)
        found = cs.solve(problem, tolerance=1e-10)
        ends = found.pressure[0], found.pressure[-1], found.pressure[:, 0], found.pressure[:, -1]
        assert all((end > 0).any() for end in ends)
        assert found.iterations <= most
        start = cs.solve(problem, solver=PolonskyKeer(), tolerance=1e-10).pressure
        assert found.pressure == pytest.approx(start, abs=1e-7 * start.max())


def test_a_strip_of_cells_a_thousand_times_as_wide_as_long_does_not_stall() -> None:
    """What is expected of cells beside a contact is far off there: no more of it may count than a step closes."""
    steel = cs.HalfSpace(youngs_modulus=210e9, poisson_ratio=0.3)
    smooth = cs.Scene(cs.LineLoad(1e5), (steel, steel), (cs.Cylinder(0.01),))
    a, peak = smooth.hertz.half_width, smooth.hertz.peak_pressure
    wave = np.cos(2 * np.pi * np.arange(32) / 32) * np.ones((64, 1))
    heights = 0.05 * peak * a / smooth.contact_modulus * wave
    scene = replace(smooth, shapes=(*smooth.shapes, cs.MeasuredSurface(heights)))
    grid = cs.Grid((64, 32), (3 * a, 3 * a / 64 * 32e-3))
    solution = cs.solve(scene.problem(grid, cs.ExactPeriodicity()))
    assert solution.status is cs.Status.CONVERGED
    assert solution.note == ""


@pytest.mark.parametrize("cells", [(4099, 1), (1021, 1), (127, 131)])
def test_grids_that_do_not_halve_take_few_iterations(cells: tuple[int, int], line_contact: LineContact) -> None:
    for heights in ("smooth", "30 %"):
        assert cs.solve(problem(line_contact, cells, heights)).iterations <= 30


@pytest.mark.parametrize("cells", [128, 176, 304])
def test_a_sphere_has_the_symmetries_of_the_grid_to_what_the_residual_leaves(
    cells: int, line_contact: LineContact
) -> None:
    """Its cells meet the limit in eights, and rounding may part them on the way but not in the end."""
    scene = replace(line_contact.scene, shapes=(cs.Sphere(0.02),))
    grid = line_contact.grid(cells, 2.4, 2.4)
    posed = scene.problem(grid, (cs.ZeroPadding(), cs.ZeroPadding()))
    solution = cs.solve(posed, tolerance=1e-10)
    p = solution.pressure / posed.scales.pressure
    left = np.where(p > 0, solution.gap, np.minimum(solution.gap, 0)) / posed.scales.gap
    # pressure and mirrored pressure both solve the contact up to this gap, and are so far from the answer,
    # in the mean square, as that is over the operator's stiffest wave: the checkerboard
    checkerboard = (-1.0) ** np.indices(grid.cells).sum(axis=0)
    smallest = np.abs(posed.bare().operator(checkerboard))[cells // 2, cells // 2]
    for mirrored in (p.T, p[::-1]):
        assert ((mirrored > 0) == (p > 0)).all()
        assert np.linalg.norm(mirrored - p) <= 2 * np.linalg.norm(left) / smallest
    # as on rough contacts of any size
    assert solution.iterations <= 40


def test_a_stalled_solve_goes_on_by_polonsky_and_keer_with_a_note(
    line_contact: LineContact,
) -> None:
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
