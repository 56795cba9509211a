"""What a lubricated scene asks of a grid, and what a solve on it costs."""

from contactstudy.planning.film_requirements import film_requirements
from contactstudy.planning.grid_requirements import requirements_of
from tests.contactstudy.lubrication.scenes import by_moes, grid


def test_a_film_on_a_given_grid_says_where_its_inlet_begins() -> None:
    """Six matrices of numbers of 8 bytes."""
    scene, given = by_moes(20, 5), grid(100, 4.5)
    found = film_requirements(scene, requirements_of(scene), 0.01, None, given)
    assert found.grid == given
    moes, inlet, cells = found.reasons
    assert moes.endswith(" at M = 20, L = 5")
    assert inlet.startswith("the inlet begins 4.5 half-widths from the axis")
    assert cells.startswith(f"cells of {given.cell[0]:.2g} m across")
    assert found.bytes == 8 * 6 * 100**2
    assert "the grid is given" in found.warnings[0]


def test_a_film_in_time_takes_steps_from_one_instant_to_the_next() -> None:
    scene, given = by_moes(20, 5), grid(100, 4.5)
    requirements = requirements_of(scene)
    steady, few, many = (
        film_requirements(scene, requirements, 0.01, None, given, n) for n in (0, 2, 101)
    )
    assert steady.steps == 1 < few.steps < 101 <= many.steps
    assert steady.seconds < few.seconds < many.seconds
