"""Options of a run that cannot be."""

import pytest

from contactstudy.domain.checks import InvalidInput
from studies.engine.options import RunOptions


@pytest.mark.parametrize("seconds", [0.0, -1.0, float("nan")])
def test_a_time_limit_is_above_zero(seconds: float) -> None:
    with pytest.raises(InvalidInput, match="give seconds above 0"):
        RunOptions(time_limit=seconds)
    assert RunOptions(time_limit=0.5).time_limit == 0.5
