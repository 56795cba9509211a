"""What a run would compute and how long that would take, from the plans of some of its cases."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from time import process_time
from typing import Any

import contactstudy as cs
from studies.engine.options import RunOptions
from studies.engine.request import Request
from studies.engine.run import JOURNAL, MANY_POINTS, Run, with_name
from studies.model.case import Computation
from studies.model.plain_text import Log, counted, two_digits
from studies.model.study import Study
from studies.store.journal import Journal
from studies.store.provenance import machine
from studies.store.stop import Stop

# Cases that are planned at most, evenly spaced, and seconds after which no further one is planned.
MAX_PLANNED, MAX_SECONDS = 16, 2.0


def estimate_cost(study: Study, out: Path, *, options: RunOptions, log: Log = print) -> float | None:
    """Report what :func:`run` would do, and return the seconds to compute; None where the plan of a case fails.

    No case is computed and nothing is stored: the plans of some cases solve coarse grids. Of a large study some points
    are looked at, evenly spaced. A damaged file of fields is set aside, as in a run.
    """
    study.check_size(options.max_points)
    every, log = study.size, with_name(study, log)
    while study.size > MANY_POINTS:
        longest = max(study.axes, key=lambda axis: len(axis.values))
        thinned = replace(longest, values=longest.values[::2])
        points = tuple(thinned if axis is longest else axis for axis in study.axes)
        study = replace(study, axes=points)
    scale = every / study.size
    if scale > 1:
        log(f"{every} points, estimated from {study.size} of them in proportion")
    run = Run(study, Request.of(study), Journal(out / JOURNAL, machine()), options, log, Stop())
    for note in study.notes:
        log(note)
    if "times" in options.retry:
        run.journal.samples.clear()
        run.journal.untimed.clear()
    cases, missing = run.request.cases, run.missing()
    runs = len(run.timed_tasks()) + run.repeats * len(missing)
    counts = (len(run.request.keys), len(cases), len(cases) - len(missing), len(missing), runs)
    of_points, distinct, stored, to_compute, timed = (round(scale * count) for count in counts)
    log(
        f"{counted(of_points, 'point')}, {counted(distinct, 'distinct case')}, {stored} stored, "
        f"{to_compute} to compute, {counted(timed, 'timed run')} to take"
    )
    try:
        seconds = planned_seconds([cases[name] for name in missing])
    except AttributeError:
        log("the time is not known: its cases are not scenes on a grid, and have no plan")
        return None
    except Exception as error:  # noqa: BLE001 (a study's own computation is anything)
        log(f"the time is not known: the plan of a case failed ({type(error).__name__}: {error})")
        return None
    if missing:
        timing = f", {two_digits(scale * seconds * runs / len(missing))} s to time" if runs else ""
        log(f"about {two_digits(scale * seconds)} s to compute (shared by the workers){timing}")
    return scale * seconds


def planned_seconds(cases: Sequence[Computation]) -> float:
    """Return the seconds of all cases, one after the other on one thread, from the plans of a few of them.

    These are evenly spaced, half as far apart from one round to the next, as long as the time allows.
    """
    begin, planned = process_time(), dict[int, float]()
    count = min(len(cases), MAX_PLANNED)
    for parts in (1, 2, 4, 8, 16):
        for part in range(parts):
            number = (2 * part + 1) * len(cases) // (2 * parts)
            is_in_time = not planned or process_time() - begin < MAX_SECONDS
            if number not in planned and len(planned) < count and is_in_time:
                case: Any = cases[number]
                steps = getattr(case, "time_steps", None)
                planned[number] = cs.plan(case.scene, grid=case.grid, padding=case.padding, times=steps).seconds
    return sum(planned.values()) * len(cases) / max(len(planned), 1)
