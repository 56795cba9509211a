"""Runs a study: every distinct case once through dask, then alone against the clock."""

from collections.abc import Callable, Iterable, Mapping
from contextlib import nullcontext
from pathlib import Path

import dask.config
import xarray as xr
from dask.base import compute as compute_all
from dask.callbacks import Callback
from dask.delayed import delayed
from tqdm import tqdm

from studies.case import Computation
from studies.outcome import Fate, Outcome, clock, compute
from studies.pool import process_pool
from studies.provenance import provenance
from studies.store import assemble, open_folder, read, write
from studies.study import Study

Say = Callable[[str], object]


def run(
    study: Study, out: Path, *, workers: int = 2, repeats: int = 2, say: Say = print
) -> xr.Dataset:
    """Compute ``study`` and leave ``<out>/<study>.nc``; returns what was written.

    ``workers`` processes share the cases (0: this process alone); afterwards each case is timed
    ``repeats`` times on one thread, one at a time, in turns. Bad points raise
    :class:`~contactstudy.InvalidInput` before anything runs or is written.
    """
    cases = study.cases()
    distinct = list(dict.fromkeys(cases))
    folder = open_folder(out)
    say(f"{study.name}: {len(cases)} points, {len(distinct)} distinct cases")
    outcomes = _solve(study, distinct, workers)
    path = folder / f"{study.name}.nc"
    attributes = {"title": study.title, "first_case": repr(distinct[0])} | dict(provenance())
    attributes["timing"] = f"wall time, least of {repeats}, one case at a time, one thread"
    # twice, so that an interrupt of the timing leaves what was solved
    write(assemble(study.points, cases, outcomes, {}, attributes), path)
    solved = [case for case, outcome in outcomes.items() if outcome.fate is Fate.OK]
    times = _time(study.name, solved, repeats)
    write(assemble(study.points, cases, outcomes, times, attributes), path)
    dataset = read(path)
    if "left_out" in dataset.attrs:
        say(f"{study.name}: left out, {dataset.attrs['left_out']}")
    failed = [outcome.error for outcome in outcomes.values() if outcome.fate is Fate.FAILED]
    if failed:
        say(
            f"{study.name}: {len(failed)} of {len(distinct)} cases failed, the first with {failed[0]}"
        )
    ends = [o.variables["outcome"] for o in outcomes.values() if "outcome" in o.variables]
    unsettled = sum(int(end) != 0 for end in ends)
    if unsettled:
        say(
            f"{study.name}: {unsettled} of {len(ends)} solves did not simply converge; see 'outcome'"
        )
    say(f"{study.name}: wrote {path}")
    return dataset


def _solve(study: Study, cases: list[Computation], workers: int) -> dict[Computation, Outcome]:
    tasks = [
        delayed(compute, pure=False)(case, study.measures, dask_key_name=f"case-{number}")
        for number, case in enumerate(cases)
    ]
    pool = process_pool(workers) if workers else nullcontext()
    bar = tqdm(total=len(cases), desc=f"{study.name}: solving", unit="case", disable=None)
    with pool as executor, bar, Callback(posttask=lambda *_: bar.update()):
        settings = (
            {"scheduler": "processes", "pool": executor} if workers else {"scheduler": "sync"}
        )
        with dask.config.set(settings):
            return dict(zip(cases, compute_all(*tasks), strict=True))


def _time(
    name: str, cases: Iterable[Computation], repeats: int
) -> Mapping[Computation, tuple[float, float]]:
    turns = [case for _ in range(repeats) for case in cases]
    least: dict[Computation, tuple[float, float]] = {}
    for case in tqdm(turns, desc=f"{name}: timing", unit="run", disable=None):
        pairs = zip(clock(case), least.get(case, (float("inf"),) * 2), strict=True)
        setup, solve = (min(pair) for pair in pairs)
        least[case] = setup, solve
    return least
