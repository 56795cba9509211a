import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from studies.advice.front import pareto_front

PAIRS = st.lists(st.tuples(st.floats(0, 10), st.floats(0, 10)), max_size=30)


@given(PAIRS)
def test_nothing_on_the_front_is_beaten_and_all_else_is(pairs: list[tuple[float, float]]) -> None:
    cost, error = np.array(pairs).reshape(-1, 2).T
    front = pareto_front(cost, error)
    assert (np.diff(cost[front]) > 0).all()
    assert (np.diff(error[front]) < 0).all()
    for c, e in pairs:
        assert ((cost[front] <= c) & (error[front] <= e)).any()


def test_points_without_numbers_are_left_out() -> None:
    front = pareto_front(np.array([1.0, np.nan, 0.5]), np.array([1.0, 0.0, np.nan]))
    assert front.tolist() == [0]
