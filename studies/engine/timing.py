"""Times that can be trusted: one case at a time, one thread, in rounds, every sample kept."""

from collections.abc import Callable, Iterator, Mapping
from itertools import chain
from operator import itemgetter
from typing import TYPE_CHECKING

from studies.engine.inventory import Inventory
from studies.engine.progress import Progress
from studies.engine.stop import Stop
from studies.engine.time_limit import limit_of_timed_run
from studies.model.outcome import Failure, Sample, Work

if TYPE_CHECKING:
    from studies.engine.executors import Executor

# What a process does but once (imports, memory from the system) is done by an untimed run of the longest
# case of each kind that is shorter than this; in a longer one it is lost.
WARM_UP = 0.3


def take_times(
    inventory: Inventory,
    work: Work,
    executor: "Executor | None",
    stop: Stop,
    log: Callable[[str], object],
) -> None:
    """Take the missing timed runs in a separate process, since a case may die there although it did not before.

    It is a process of the executor, or one of its own where nothing had to be computed.
    """
    journal, cases = inventory.journal, inventory.request.cases
    counts = inventory.times_missing()
    if inventory.options.old_times == "dropped":
        journal.forget_times()
    if not counts:
        return
    # what processes need is imported where there are some
    from studies.engine.executors import own_process, packed

    expected = {name: journal.contents.records[name].seconds for name in counts}
    kinds = {name: type(cases[name]).__qualname__ for name in counts}
    timer = executor.timer if executor else own_process
    total = sum(counts.values())
    with (
        timer(packed(work)) as worker,
        Progress(inventory.study.name, "timing", total, "run", log) as progress,
    ):

        def time_once(name: str) -> Sample | Failure | None:
            limit = limit_of_timed_run(expected[name], inventory.options.time_limit)
            with stop.interruptible():
                return worker.time_once(name, cases[name], limit)

        def take(name: str, sample: Sample) -> None:
            journal.time(name, sample)
            progress.add()

        def give_up(name: str, failure: Failure) -> None:
            journal.cannot_time(name, failure.sentence)
            progress.add(counts[name])

        time_cases(counts, expected, kinds, time_once, take, give_up)
        journal.sync()


def time_cases(
    missing: Mapping[str, int],
    expected: Mapping[str, float],
    kinds: Mapping[str, str],
    time_once: Callable[[str], Sample | Failure | None],
    take: Callable[[str, Sample], object],
    give_up: Callable[[str, Failure], object],
) -> None:
    """Time several runs of each case, case after case in rounds.

    Parameters
    ----------
    missing
        Number of runs of each case.
    expected
        Expected seconds of each case.
    kinds
        Kind of each case; one case of each kind is first run untimed.
    time_once
        Runs a case once.
    take
        Takes the name and the times of a run.
    give_up
        Takes the name and the failure of a case, which is not timed again.
    """
    without_times = set()
    untimed = [(-1, name) for name in warm_ups({name: expected[name] for name in missing}, kinds)]
    for turn, name in chain(untimed, rounds(missing)):
        if name in without_times:
            continue
        sample = time_once(name)
        if isinstance(sample, Failure):
            without_times.add(name)
            give_up(name, sample)
        elif sample is not None and turn >= 0:
            take(name, sample)


def warm_ups(expected: Mapping[str, float], kinds: Mapping[str, str]) -> list[str]:
    """Return the longest case below ``WARM_UP`` of each kind."""
    longest: dict[str, str] = {}
    for name, seconds in sorted(expected.items(), key=lambda item: item[1]):
        if seconds < WARM_UP:
            longest[kinds[name]] = name
    return list(longest.values())


def rounds(missing: Mapping[str, int]) -> Iterator[tuple[int, str]]:
    """Yield (round, case) until every case has its number of runs: every case once, then every case again."""
    turns = ((turn, name) for name, count in missing.items() for turn in range(count))
    yield from sorted(turns, key=itemgetter(0))
