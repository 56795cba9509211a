import numpy as np
import pytest

import contactstudy as cs
from contactstudy.accuracy.contact_edge import CONSTANTS, half_widths
from tests.conftest import STEEL, LineContact

EXACT = cs.ExactPeriodicity()

# widths in half-widths that move the edge through a cell and more, at 128 cells
WIDTHS = np.linspace(2.4, 2.45, 13)


def errors(line_contact: LineContact, cells: int, width: float) -> tuple[float, float]:
    """Of the half-width over a, and the largest of the pressure over p_H."""
    hertz, grid = line_contact.hertz, line_contact.grid((cells, 1), 2.4, width)
    solution = cs.solve(line_contact.scene.problem(grid, EXACT), tolerance=1e-11)
    (half,) = half_widths(solution.pressure, grid.x)
    missed = np.abs(solution.pressure - hertz.pressure(grid.x)[:, None]).max()
    return abs(half / hertz.half_width - 1), float(missed) / hertz.peak_pressure


def test_half_width_at_128_cells_is_known_to_1e_5(line_contact: LineContact) -> None:
    assert max(errors(line_contact, 128, width)[0] for width in WIDTHS) < 1e-5


def test_the_half_width_converges_with_the_cube_of_the_cell_and_the_largest_pressure_with_its_root(
    line_contact: LineContact,
) -> None:
    cells = np.array([48, 96, 192, 384])
    widths = 2.4 + 0.05 * 128 / cells[:, None] * np.linspace(0, 1, 9)
    worst = np.array(
        [
            np.max([errors(line_contact, n, w) for w in row], axis=0)
            for n, row in zip(cells.tolist(), widths.tolist(), strict=True)
        ]
    )
    half, solved = (np.polyfit(np.log(cells), np.log(kind), 1)[0] for kind in worst.T)
    assert half == pytest.approx(-3, abs=0.2)
    assert solved == pytest.approx(-0.5, abs=0.2)


def test_edge_does_not_depend_on_the_cells_along(line_contact: LineContact) -> None:
    halves = []
    for along in (1, 3, 8):
        grid = line_contact.grid((64, along), 0.7)
        solution = cs.solve(line_contact.scene.problem(grid, EXACT), tolerance=1e-11)
        halves.append(half_widths(solution.pressure, grid.x).mean())
    np.testing.assert_allclose(halves, halves[0], rtol=1e-9)


def test_edge_of_a_sphere_is_found_where_it_runs_along_the_cells() -> None:
    """Rows through the middle; further out the edge crosses the cells, and only its cell is told."""
    contact, modulus = cs.analytic.HertzPoint(30.0, 0.01, 1.0), 1.0
    solids = (cs.HalfSpace(youngs_modulus=1.0, poisson_ratio=0.0), cs.HalfSpace(np.inf, 0.0))
    a, length = contact.contact_radius, 2.5 * contact.contact_radius
    scene = cs.Scene(cs.LineLoad(30.0 / length), solids, (cs.Sphere(0.01),))
    assert scene.contact_modulus == modulus
    grid = cs.Grid(cells=(128, 128), extent=(length, length))
    free = cs.ZeroPadding()
    solution = cs.solve(scene.problem(grid, (free, free)))
    halves, step = half_widths(solution.pressure, grid.x), grid.cell_size[0]
    touching = np.flatnonzero(solution.pressure.any(axis=0))
    true = np.sqrt(np.clip(a**2 - grid.y**2, 0, None))
    # an edge of radius a is straight to one part in a / step
    assert np.abs(halves - true)[np.abs(grid.y) < step].max() < step**2 / a
    inner = touching[CONSTANTS.min_touching : -CONSTANTS.min_touching]
    assert np.abs(halves - true)[inner].max() < 1.5 * step


def test_unresolved_edges_stay_as_they_are(line_contact: LineContact) -> None:
    scale = line_contact.hertz.peak_pressure * line_contact.hertz.half_width
    rough = cs.Roughness(
        rms=0.6 * scale / line_contact.scene.contact_modulus, hurst=0.8, seed=1,
        roll_off=line_contact.hertz.half_width, cut_off=0.1 * line_contact.hertz.half_width,
    )  # fmt: skip
    shapes = (*line_contact.scene.shapes, rough)
    scene = cs.Scene(line_contact.scene.load, (STEEL, STEEL), shapes)
    grid = line_contact.grid(64, 2.4, 3.6)
    pressure = cs.solve(scene.problem(grid, EXACT), tolerance=1e-6).pressure
    touching = pressure > 0
    faces = grid.x + grid.cell_size[0] / 2
    right = faces[63 - np.argmax(touching[::-1], axis=0)]
    left = faces[63 - np.argmax(touching, axis=0)]
    expected = np.where(touching.any(axis=0), (right + left) / 2, 0)
    np.testing.assert_allclose(half_widths(pressure, grid.x), expected, rtol=1e-12)


def test_the_half_width_of_few_cells_is_that_of_their_faces() -> None:
    x = cs.Grid(cells=(8, 1), extent=(8.0, 1.0)).x
    pressure = np.zeros((8, 2))
    pressure[3:5, 0] = 1.0
    np.testing.assert_array_equal(half_widths(pressure, x), [1.0, 0.0])
