"""The length of the next step, by hand."""

import pytest

from contactstudy.domain.checks import InvalidInput
from contactstudy.evolution.steps import StepControl


def test_an_error_is_below_one_and_a_hundred_times_the_tolerance() -> None:
    assert StepControl.for_error(1e-6, 1e-8).error == 1e-6
    for error, tolerance in ((0.99e-6, 1e-8), (1.0, 1e-8), (0.0, 1e-8)):
        with pytest.raises(InvalidInput, match=r"evolve\.error"):
            StepControl.for_error(error, tolerance)
