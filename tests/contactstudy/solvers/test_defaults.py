"""What a solver takes for the numbers that a user leaves out."""

import contactstudy as cs
from tests.contactstudy.defaults import check_defaults


def test_a_number_that_is_left_out_is_this_one() -> None:
    check_defaults(cs.SolveOptions, tolerance=1e-8, max_iterations=2000)
    check_defaults(cs.PolonskyKeer, patience=400)
    check_defaults(cs.PreconditionedCG, patience=40, coarse_tolerance=1e-3)
