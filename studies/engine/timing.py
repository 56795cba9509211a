"""Times that can be trusted: one case at a time, one thread, in rounds, every sample kept."""

from collections.abc import Callable

from studies.engine.inventory import Inventory
from studies.engine.progress import Progress
from studies.engine.stop import Stop
from studies.engine.time_limit import limit_of_timed_run
from studies.model.outcome import Failure, Work

# What a process does but once (imports, memory from the system) is done by an untimed run of the longest
# case of each kind that is shorter than this; in a longer one it is lost.
MAX_WARM_UP = 0.3


def take_times(inventory: Inventory, work: Work, stop: Stop, log: Callable[[str], object]) -> None:
    """Take the missing timed runs in a separate process, since a case may die there although it did not before."""
    journal, cases = inventory.journal, inventory.request.cases
    counts = inventory.times_missing()
    if inventory.options.old_times == "dropped":
        journal.forget_times()
    if not counts:
        return
    # what processes need is imported where there are some
    from studies.engine.executors import own_process, packed

    expected = {name: journal.contents.records[name].seconds for name in counts}
    longest = {type(cases[name]): name for name in sorted(expected, key=expected.__getitem__)
               if expected[name] < MAX_WARM_UP}  # fmt: skip
    # every case once, then every case again
    turns = sorted(
        (turn, index) for index, name in enumerate(counts) for turn in range(counts[name])
    )
    names = list(counts)
    without_times = set()
    with (
        own_process(packed(work)) as worker,
        Progress(inventory.study.name, "timing", len(turns), "run", log) as progress,
    ):
        for counted, name in (
            *((False, name) for name in longest.values()),
            *((True, names[index]) for _, index in turns),
        ):
            if name in without_times:
                continue
            limit = limit_of_timed_run(expected[name], inventory.options.time_limit)
            with stop.interruptible():
                sample = worker.time_once(name, cases[name], limit)
            if isinstance(sample, Failure):
                without_times.add(name)
                journal.cannot_time(name, sample.sentence)
                progress.add(counts[name])
            elif sample is not None and counted:
                journal.time(name, sample)
                progress.add()
        journal.sync()
