"""How many cases a process takes at a time."""

from studies.engine.executors import CHUNK, STOPPED, ProcessPool, _SharedCases
from studies.engine.stop import Stop
from studies.model.outcome import Outcome, Work
from tests.studies.engine import trouble
from tests.studies.engine.trouble import Trouble


def shared(count: int) -> _SharedCases:
    return _SharedCases([Trouble(float(n)) for n in range(count)])


def test_quick_cases_are_taken_one_more_at_a_time_and_slow_ones_half_as_many() -> None:
    cases = shared(100)
    sizes = [len(cases._take())]
    # four of a ninth each are less than half of what is sent in one go, five are not
    for seconds in (CHUNK / 9,) * 6 + (CHUNK / 4,) + (10 * CHUNK,) * 4:
        cases._resize(seconds)
        sizes.append(len(cases._take()))
    assert sizes == [1, 2, 3, 4, 5, 5, 5, 2, 1, 1, 1, 1]


def test_every_case_is_taken_once_and_the_last_chunk_is_what_is_left() -> None:
    cases = shared(7)
    taken = []
    while chunk := cases._take():
        taken.append(chunk)
        cases._resize(0.0)
    assert taken == [range(1), range(1, 3), range(3, 6), range(6, 7)]
    cases.stop()
    assert cases.found.get() is STOPPED


def test_there_are_no_more_processes_than_cases() -> None:
    found: dict[int, Outcome] = {}
    with ProcessPool(3) as pool:
        pool.run([], Work(trouble.measures), found.__setitem__, Stop())
        assert pool._supervisors == []
        pool.run([Trouble(2.0)], Work(trouble.measures), found.__setitem__, Stop())
        assert len(pool._supervisors) == 1
        pool.run([Trouble(2.0), Trouble(4.0)], Work(trouble.measures), found.__setitem__, Stop())
        assert len(pool._supervisors) == 2
    assert [float(found[n].variables["square"]) for n in (0, 1)] == [4, 16]
