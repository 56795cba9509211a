"""Times that can be trusted: one case at a time, one thread, in rounds, every sample kept."""

import cloudpickle

from studies.engine.progress import progress_of
from studies.engine.results import Results
from studies.engine.workers.compute import limit_of_timed_run
from studies.model.outcome import RunSettings
from studies.store.stop import Stop

# Seconds. Of each kind of case the longest one below this limit is first run untimed, so that imports and the first
# allocation of memory are not timed; in a longer case they are negligible.
MAX_WARM_UP = 0.3


def take_times(results: Results, settings: RunSettings, stop: Stop) -> None:
    """Take the missing timed runs in a separate process, since a case may die there although it did not before."""
    journal, cases = results.journal, results.request.cases
    counts = results.missing_timed_runs()
    if results.options.old_times == "dropped":
        journal.drop_times(counts)
    if not counts:
        return
    # what processes need is imported where there are some
    from studies.engine.workers.compute import failed
    from studies.engine.workers.process import SupervisedProcess, pickled_settings

    expected = {name: journal.records[name].seconds for name in counts}
    longest = {type(cases[name]): name for name in sorted(expected, key=expected.__getitem__)
               if expected[name] < MAX_WARM_UP}  # fmt: skip
    # every case once, then every case again
    repeats = max(counts.values())
    runs = [name for repeat in range(repeats) for name, count in counts.items() if repeat < count]
    without_times = set()
    with (
        SupervisedProcess(pickled_settings(settings)) as process,
        progress_of(results.study.name, "timing", len(runs), "run", results.log) as progress,
    ):
        for counted, name in (
            *((False, name) for name in longest.values()),
            *((True, name) for name in runs),
        ):
            if name in without_times:
                continue
            limit = limit_of_timed_run(expected[name], results.options.time_limit)
            with stop.interruptible():
                try:
                    pickled = cloudpickle.dumps((cases[name],))
                except Exception as error:  # noqa: BLE001 (a study's class may do anything)
                    outcome = failed(error, "setup")
                else:
                    (outcome,) = process.run(pickled, (name,), limit, "time")
            if outcome.sample is None:
                without_times.add(name)
                journal.add_timing_failure(name, outcome.error)
                progress.update(counts[name])
            elif counted:
                journal.add_timed_run(name, outcome.sample)
                progress.update()
        journal.sync()
