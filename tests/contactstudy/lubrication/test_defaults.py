"""What a lubricated solve takes for the numbers that a user leaves out."""

import contactstudy as cs
from tests.contactstudy.defaults import check_defaults


def test_a_number_that_is_left_out_is_this_one() -> None:
    check_defaults(cs.solve_lubricated, tolerance=1e-8, max_iterations=300)
    check_defaults(cs.evolve_lubricated, tolerance=1e-6)
    check_defaults(cs.film_grid, error=1e-2, period=1e-3, longer=1, finer=1)
