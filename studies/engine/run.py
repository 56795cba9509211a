"""Run the missing cases of a study, each distinct one once, then time them one at a time."""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from time import monotonic
from typing import Any

import xarray as xr

import contactstudy as cs
from contactstudy import InvalidInput
from contactstudy.domain.files import locked, remove_partial_files
from studies.engine.options import RunOptions
from studies.engine.progress import progress_of
from studies.engine.results import Results, save_fields
from studies.engine.timing import take_times
from studies.model.case import Computation
from studies.model.outcome import CaseStatus, OnFinished, Outcome, RunSettings, summary_messages
from studies.model.plain_text import Log, two_digits
from studies.model.study import Study
from studies.store.fingerprint.modules import listed
from studies.store.netcdf import check_kind, open_folder, read
from studies.store.provenance import provenance
from studies.store.request import Request
from studies.store.stop import Stop, StopRun
from studies.store.table import points_of

MAX_PLANNED = 16  # cases that are planned at most, evenly spaced
MANY_POINTS = 50_000  # points whose cases take more than a moment to make


class _FirstFailureError(Exception):
    """Raised to end a run that stops at its first failure."""


def run(
    study: Study,
    out: Path,
    *,
    workers: int | None = None,
    repeats: int | None = None,
    log: Log = print,
    options: RunOptions | None = None,
) -> xr.Dataset:
    """Compute the missing cases of a study, write ``<out>/<study>.nc``, and return its Dataset.

    Every finished case is in ``<out>/<study>.journal.jsonl`` before it is reported, and is not computed again.

    Parameters
    ----------
    study
        The study.
    out
        Folder of the results, made if need be. The file also holds other stored points of the study, unless
        `options` say otherwise.
    workers, repeats
        Processes that compute, and timed runs of each case, in place of those of the `options`.
    log
        Takes each message of the run.
    options
        Options of the run, by default those of :class:`~studies.RunOptions`.

    Raises
    ------
    InvalidInput
        For bad points and for a folder that cannot be written to, before anything runs or is written.
    """
    chosen = options or RunOptions()
    chosen = replace(
        chosen,
        workers=chosen.workers if workers is None else workers,
        repeats=chosen.repeats if repeats is None else repeats,
    )
    study.check_size(chosen.max_points)
    named_log = _with_name(study, log)
    request = _request(study, named_log)
    folder = open_folder(out.absolute())
    with locked(folder / f".{study.name}.lock", log), Stop() as stop:
        remove_partial_files(folder)
        results = Results.of(study, request, folder, chosen, named_log)
        with results.journal:
            return _Run(results, stop).execute()


def estimate_cost(
    study: Study, out: Path, *, options: RunOptions, log: Log = print
) -> float | None:
    """Report what :func:`run` would do, and return the seconds to compute; None where the plan of a case fails.

    No case is computed and nothing is stored: the plans of some cases solve coarse grids. Of a large study some points
    are looked at, evenly spaced. A damaged file of fields is set aside, as in a run.
    """
    study.check_size(options.max_points)
    every, log = study.size, _with_name(study, log)
    while study.size > MANY_POINTS:
        longest = max(study.axes, key=lambda axis: len(axis.values))
        thinned = replace(longest, values=longest.values[::2])
        points = tuple(thinned if axis is longest else axis for axis in study.axes)
        study = replace(study, axes=points)
    scale = every / study.size
    if scale > 1:
        log(f"{every} points, estimated from {study.size} of them in proportion")
    results = Results.of(study, _request(study, log), out, options, log)
    cases, missing = results.request.cases, results.missing()
    runs = sum(results.missing_timed_runs().values()) + results.repeats * len(missing)
    counts = (len(results.request.keys), len(cases), len(cases) - len(missing), len(missing), runs)
    text = "{} points, {} distinct cases, {} stored, {} to compute, {} timed runs to take"
    log(text.format(*(round(scale * count) for count in counts)))
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
    """Return the seconds of all cases, one after the other on one thread, from the plans of a few of them."""
    chosen: Sequence[Any] = cases[:: -(-len(cases) // MAX_PLANNED) or 1]
    planned = [
        cs.plan(
            case.scene, grid=case.grid, padding=case.padding,
            times=getattr(case, "time_steps", None),
        ).seconds
        for case in chosen
    ]  # fmt: skip
    return sum(planned) * len(cases) / max(len(planned), 1)


def _with_name(study: Study, log: Log) -> Log:
    """Return a log whose messages begin with the name of a study."""
    return lambda text: log(f"{study.name}: {text}")


def _request(study: Study, log: Log) -> Request:
    """Return the cases of a study."""
    if study.size > MANY_POINTS:
        log(f"making the cases of {study.size} points")
    return Request.of(study)


class _Run:
    """State of a run: computes, times and writes the missing cases."""

    def __init__(self, results: Results, stop: Stop) -> None:
        self.results, self.stop = results, stop
        self.study, self.request, self.journal = results.study, results.request, results.journal
        self.options, self.log = results.options, results.log
        self._has_warned = False
        axes, keeps_fields = {axis.name for axis in self.study.axes}, self.options.fields == "kept"
        limit = self.options.time_limit
        self.settings = RunSettings(self.study.measures, keeps_fields, limit, frozenset(axes))

    def execute(self) -> xr.Dataset:
        """Compute, time and write the missing cases, and return the Dataset."""
        missing = self._begin()
        activity = "solving"
        try:
            if missing:
                self._solve(missing)
                if self.results.missing_timed_runs():
                    self.results.write()
            activity = "timing"
            take_times(self.results, self.settings, self.stop)
        except _FirstFailureError:
            self.results.skipped = {name for name in missing if self.results.record(name) is None}
            self.log("stopped at the first failure; the remaining cases are marked as skipped")
        except StopRun:
            self._write_once_more()
            stored = sum(self.results.record(name) is not None for name in self.request.cases)
            times = sum(self.results.missing_timed_runs().values())
            untimed = f", {times} timed runs are missing" if times else ""
            self.log(
                f"stopped while {activity}; {stored} of {len(self.request.cases)} cases are stored{untimed}; "
                "run the same command to go on"
            )
            raise
        except BaseException:
            # after any error the netCDF file has what the journal has, if the disk has room
            with suppress(Exception):
                self._write_once_more()
            raise
        return self._end()

    def _begin(self) -> list[str]:
        """Report what is to be done, open journal and file, and return the missing cases."""
        cases = self.request.cases
        self.log(f"{len(self.request.keys)} points, {len(cases)} distinct cases")
        missing = self.results.missing()
        if len(missing) < len(cases):
            self.log(f"{len(cases) - len(missing)} cases are stored, {len(missing)} to compute")
        check_kind(self.results.path, "study", self.log)
        self.results.provenance = provenance()
        axes = {axis.name: axis.values for axis in self.study.axes}
        self.journal.start(self.results.provenance["history"], axes)
        missing = self.results.copy_from_other_studies(missing)
        self.results.extend_table()
        if missing:
            self.results.write()
        return missing

    def _solve(self, missing: Sequence[str]) -> None:
        """Compute the ``missing`` cases, each in the journal before it counts as done."""
        unsynced, solved_seconds = 0, 0.0
        repeats = self.results.repeats

        def finished(name: str, outcome: Outcome) -> None:
            nonlocal unsynced, solved_seconds
            self._check_program(outcome)
            identity = self.request.identities[name]
            if outcome.fields:
                stamp = self.journal.stamp(identity.state, outcome.loaded)
                save_fields(self.results.fields_folder, name, stamp, outcome.fields)
                outcome = replace(outcome, fields={})
            is_on_disk = self.journal.add(identity, outcome)
            unsynced += 1
            solved_seconds += outcome.seconds
            if is_on_disk:
                progress.update(unsynced)
                unsynced = 0
                timing = repeats * solved_seconds / progress.n * len(missing)
                text = f"then {timing:.0f} s timing" if timing else ""
                progress.set_postfix_str(text, refresh=False)
            if outcome.case_status is not CaseStatus.OK and self.options.after_failure == "stop":
                self.log(f"a case failed: {outcome.error}")
                raise _FirstFailureError
            if monotonic() > self.results.next_write:
                self.results.write()

        with progress_of(self.study.name, "solving", len(missing), "case", self.log) as progress:
            self._compute(missing, finished)
            self.journal.sync()
            progress.update(unsynced)

    def _compute(self, missing: Sequence[str], finished: OnFinished) -> None:
        """Compute the missing cases as the options ask for."""
        workers, scheduler = min(self.options.workers, len(missing)), self.options.scheduler
        if not workers and not scheduler and self.journal.interrupted in missing:
            self.log(
                "the last run ended during a case: cases are computed in a process of their own"
            )
            workers = 1
        cases = {name: self.request.cases[name] for name in missing}
        arguments = cases, self.settings, finished, self.stop
        # what computes is imported where it is needed
        if workers or scheduler:
            from studies.engine.cluster import DaskRun

            DaskRun(*arguments, workers=workers, address=scheduler, log=self.log).run()
        else:
            from studies.engine.in_process import compute_here

            compute_here(*arguments, self.journal.begin)

    def _check_program(self, outcome: Outcome) -> None:
        """Refuse an outcome of another program on another machine; report that a file here has been edited meanwhile."""
        changes = self.request.context.modules.changes(outcome.loaded)
        if changes and outcome.worker:
            raise InvalidInput(
                f"{listed(changes)} {'differs' if len(changes) == 1 else 'differ'} on worker {outcome.worker}, whose "
                "results are not stored: install the same there, and run the same command again."
            )
        if changes and not self._has_warned:
            self.log(
                f"{listed(changes)} changed since this program loaded it: the next run recomputes what depends on it"
            )
            self._has_warned = True

    def _write_once_more(self) -> None:
        """Write journal and file before the run ends."""
        self.journal.sync()
        self.results.write(fields=self.options.fields)

    def _end(self) -> xr.Dataset:
        """Write the file, report the outcomes, and return the Dataset."""
        dataset = self.results.stored() if self.options.fields == "none" else None
        if dataset is None:
            self.results.write(fields=self.options.fields)
            dataset = read(self.results.path)
        if "left_out" in dataset.attrs:
            self.log(f"left out: {dataset.attrs['left_out']}")
        for sentence in summary_messages(points_of(dataset, self.study)):
            self.log(sentence)
        untimed = map(self.journal.reason_without_times, self.request.cases)
        if reasons := [reason for reason in untimed if reason]:
            self.log(
                f"{len(reasons)} cases have no times, the first since {reasons[0]}; --retime tries again"
            )
        self.log(f"wrote {self.results.path}")
        return dataset
