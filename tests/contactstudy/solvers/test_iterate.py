"""When an iteration is taken to have stalled."""

from math import nan

from contactstudy.solvers.iterate import Stall


def test_a_residual_stalls_after_so_many_iterations_without_halving() -> None:
    stall = Stall(3)
    # the first is a best one, and so is what is below its half
    assert [stall.sees(one) for one in (1.0, 0.6, 0.5, 0.49)] == [False] * 4
    assert [stall.sees(one) for one in (0.245, 0.3, 9.0)] == [False, False, True]
    stall = Stall(2)
    assert [stall.sees(nan), stall.sees(nan)] == [False, True]
