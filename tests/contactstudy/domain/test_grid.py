import numpy as np
import pytest

import contactstudy as cs


def test_cell_centres_are_symmetric_to_the_last_bit() -> None:
    grid = cs.Grid(cells=(7, 10), extent=(0.3, 0.7))
    assert (grid.x == -grid.x[::-1]).all()
    assert (grid.y == -grid.y[::-1]).all()
    assert grid.x[3] == 0
    np.testing.assert_allclose(np.diff(grid.y), grid.cell_size[1], rtol=1e-14)
    np.testing.assert_allclose(grid.x[-1] + grid.cell_size[0] / 2, 0.15, rtol=1e-15)


def test_cells_divide_the_extent() -> None:
    grid = cs.Grid(cells=(4, 2), extent=(8.0, 6.0))
    assert (grid.cell_size, grid.cell_area, grid.length) == ((2, 3), 6, 6)
    assert grid.x.tolist() == [-3, -1, 1, 3]
    assert grid.y.tolist() == [-1.5, 1.5]


def test_cells_may_be_a_billion_times_as_long_as_wide_and_no_longer() -> None:
    for extent in ((2.0, 0.9e9), (0.9e9 * 2, 1.0), (2.0, 1e9), (2e9, 1.0), (2e20, 3e20)):
        assert cs.Grid(cells=(2, 1), extent=extent).extent == extent
    for extent in ((2.0, 1.1e9), (1.1e9 * 2, 1.0)):
        with pytest.raises(cs.InvalidInput, match=r"^Grid\.extent is .* times as"):
            cs.Grid(cells=(2, 1), extent=extent)
