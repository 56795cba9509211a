"""What a march or rolling takes for the numbers that a user leaves out."""

import contactstudy as cs
from tests.contactstudy.defaults import check_defaults


def test_a_number_that_is_left_out_is_this_one() -> None:
    check_defaults(cs.roll_repeatedly, steady=5e-3)
    check_defaults(cs.solve_rolling, change=1e-6, max_passes=100)
