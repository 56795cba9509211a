import numpy as np
import pytest

import contactstudy as cs
from contactstudy.accuracy.coarser import contact_perimeter
from contactstudy.io.quantities.quantity import Quantity

GRID = cs.Grid((4, 5), (4 * 2.0, 5 * 3.0))  # a cell is 2 m across and 3 m along

EXACT, FREE = cs.ExactPeriodicity(), cs.ZeroPadding()


@pytest.mark.parametrize(
    ("paddings", "round_the_ends"),
    [
        (None, 0), ((FREE, FREE), 0), ((EXACT, FREE), 3), ((FREE, EXACT), 4), ((EXACT, EXACT), 7),
        ((FREE, cs.DuplicatedPadding()), 4), ((FREE, cs.CircularSuperposition(0)), 4),
    ],
)  # fmt: skip
def test_a_perimeter_counts_the_edges_of_cells_round_the_ends_that_repeat(
    paddings: cs.Paddings | None, round_the_ends: float
) -> None:
    """Two cells in the corner, one behind the other along x, and one alone in the middle."""
    touching = np.zeros(GRID.cells, dtype=bool)
    touching[0, 0] = touching[1, 0] = touching[2, 3] = True
    # along x an edge is 3 m: one behind the two, and two of the one; along y it is 2 m: two and two
    assert contact_perimeter(touching, GRID, paddings) == 3 * 3 + 2 * 4 + round_the_ends


def test_the_area_of_alike_islands_lies_within_its_bound_on_every_grid() -> None:
    """The edges of an egg-box wave are mirrored and repeated, so that their errors are alike."""
    modulus, wavelength, amplitude = 2e11, 1e-4, 1e-7
    body = cs.HalfSpace(modulus, 0.0)
    wave = cs.Waviness(amplitude, across=wavelength, along=wavelength)
    load = cs.LineLoad(0.2 * np.pi * modulus * amplitude)
    scene = cs.Scene(load, (body, cs.HalfSpace(np.inf, 0.0)), (wave,))

    def area(cells: int) -> Quantity:
        grid = cs.Grid((cells, cells), (wavelength, wavelength))
        return cs.solve(scene, grid, (EXACT, EXACT)).quantities["contact_area"]

    # their errors cancel over grids that lie differently
    true = np.mean([area(cells).value for cells in range(111, 132, 5)])
    for found in map(area, range(24, 97, 6)):
        assert abs(found.value - true) < found.bound < found.value
