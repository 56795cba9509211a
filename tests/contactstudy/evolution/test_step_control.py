"""The length of the next step, by hand."""

import pytest

from contactstudy.domain.checks import InvalidInput
from contactstudy.evolution.steps import StepControl

CONTROL = StepControl.for_error(1e-2, 1e-8)


def test_a_pair_of_steps_may_add_half_of_the_error() -> None:
    assert StepControl(1e-2, 5e-3) == CONTROL
    assert CONTROL.accepts(5e-3)
    assert not CONTROL.accepts(5.0001e-3)


@pytest.mark.parametrize(
    ("added", "factor"),
    [
        (5e-3, 0.9),
        (5e-3 / 4, 1.8),
        (5e-3 * 9, 0.3),
        (5e-3 / 100, 2.0),
        (5e-3 * 1e4, 0.2),
        (0.0, 2.0),
        (-1e-9, 2.0),
    ],
)
def test_a_step_follows_the_root_of_what_was_added_within_its_limits(
    added: float, factor: float
) -> None:
    assert CONTROL.factor(added) == pytest.approx(factor, rel=1e-12)


def test_a_march_that_missed_its_error_starts_again_with_shorter_steps() -> None:
    """What is added all together goes as the step, in a pair as its square."""
    assert CONTROL.stricter(2e-2).adds == pytest.approx(5e-3 * 0.45**2, rel=1e-12)
    assert CONTROL.stricter(1.1e-2).adds == pytest.approx(5e-3 * 0.7**2, rel=1e-12)
    assert CONTROL.stricter(2e-2).error == 1e-2


def test_an_error_is_below_one_and_a_hundred_times_the_tolerance() -> None:
    assert StepControl.for_error(1e-6, 1e-8).error == 1e-6
    for error, tolerance in ((0.99e-6, 1e-8), (1.0, 1e-8), (0.0, 1e-8)):
        with pytest.raises(InvalidInput, match=r"evolve\.error"):
            StepControl.for_error(error, tolerance)
