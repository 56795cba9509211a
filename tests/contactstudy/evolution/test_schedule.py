"""The instants that a march lands on, by hand."""

import contactstudy as cs
from contactstudy.evolution.schedule import Mark, schedule

LOAD = cs.LoadHistory(times=(0.0, 1.0, 1.0, 3.0), per_length=(0.0, 2.0, 5.0, 1.0))


def test_marks_are_breaks_of_the_load_and_what_is_recorded() -> None:
    found = schedule(LOAD, (0.5, 1.0, 1.0, 2.0))
    assert found == (
        Mark(0.0, before=found[0].before, after=0.0, records=0, breaks=True),
        Mark(0.5, before=1.0, after=1.0, records=1, breaks=False),
        Mark(1.0, before=2.0, after=5.0, records=2, breaks=True),
        Mark(2.0, before=3.0, after=3.0, records=1, breaks=False),
    )
    assert [mark.jumps for mark in found[1:]] == [False, True, False]


def test_without_times_a_march_goes_to_the_end_of_the_load() -> None:
    found = schedule(LOAD, None)
    assert [mark.time for mark in found] == [0.0, 1.0, 3.0]
    assert [mark.records for mark in found] == [0, 0, 0]
    assert found[-1].after == 1.0
