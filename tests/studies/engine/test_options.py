"""Options of a run that cannot be."""

import pytest

from contactstudy.domain.checks import InvalidInput
from studies.engine.options import RunOptions


@pytest.mark.parametrize("seconds", [0.0, -1.0, float("nan")])
def test_a_time_limit_is_above_zero(seconds: float) -> None:
    with pytest.raises(InvalidInput, match="give seconds above 0"):
        RunOptions(time_limit=seconds)
    assert RunOptions(time_limit=0.5).time_limit == 0.5


def test_a_run_keeps_what_is_stored_and_times_twice_unless_told_otherwise() -> None:
    options = RunOptions()
    assert (options.workers, options.repeats, options.time_limit) == (2, 2, None)
    assert (options.old_times, options.after_failure) == ("kept", "go on")
    assert (options.fields, options.table) == ("none", "stored")
    for name in ("old_times", "after_failure", "fields", "table"):
        with pytest.raises(InvalidInput, match=name):
            RunOptions(**{name: "other"})  # type: ignore[arg-type]
