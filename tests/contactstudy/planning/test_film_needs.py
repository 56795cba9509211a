"""What a lubricated scene asks of a grid, and what a solve on it costs."""

import pytest

import contactstudy as cs
from contactstudy.planning.film_needs import film_needs
from contactstudy.planning.grid_requirements import needs_of
from tests.contactstudy.lubrication.scenes import by_moes, grid


def test_a_film_on_a_given_grid_says_where_its_inlet_begins_and_costs_a_direct_step() -> None:
    """Twelve steps of 6e-11 s for each cube of the cells; six matrices of numbers of 8 bytes."""
    scene, given = by_moes(20, 5), grid(100, 4.5)
    found = film_needs(scene, needs_of(scene), 0.01, None, given)
    assert found.grid == given
    moes, inlet, cells = found.reasons
    assert moes.endswith(" at M = 20, L = 5")
    assert inlet.startswith("the inlet begins 4.5 half-widths from the axis")
    assert cells.startswith(f"cells of {given.cell[0]:.2g} m across")
    assert found.seconds == pytest.approx(12 * 6e-11 * 100**3, rel=1e-14)
    assert found.bytes == 8 * 6 * 100**2
    assert "the grid is given" in found.warnings[0]


def test_a_film_along_the_length_costs_its_cells_and_holds_a_basis_and_matrices() -> None:
    """5e-5 s, and 180 numbers a cell; 50 matrices (x, x)."""
    scene = by_moes(20, 5, cs.Waviness(1e-8, across=1e-4, along=5e-5))
    found = film_needs(scene, needs_of(scene), 0.01, None, grid(20, 4.5, along=4))
    assert found.seconds == pytest.approx(5e-5 * 80, rel=1e-14)
    assert found.bytes == 8 * (180 * 80 + 50 * 20**2)
    assert found.reasons[-1] == "8 cells or more for the shortest wave"
    assert (
        found.warnings[-1] == "the error of a film between rough surfaces is not known beforehand"
    )
