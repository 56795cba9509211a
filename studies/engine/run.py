"""Run the missing cases of a study, each distinct one once, then time them one at a time."""

import gc
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import replace
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING

import xarray as xr

from contactstudy import InvalidInput
from contactstudy.domain.files import locked, remove_partial_files
from studies.engine.forecast import Forecast
from studies.engine.inventory import Inventory
from studies.engine.options import RunOptions
from studies.engine.progress import Progress
from studies.engine.stop import Stop, end_like
from studies.engine.timing import take_times
from studies.engine.workers.compute import StopRun
from studies.model.outcome import CaseStatus, Outcome, Work, summary_messages
from studies.model.study import Study
from studies.store.journal import Journal
from studies.store.loaded import shown
from studies.store.netcdf import check_kind, open_folder, read
from studies.store.provenance import machine, provenance
from studies.store.request import Request
from studies.store.result_file import ResultFile, save_fields
from studies.store.table import PointTable, stored_table

if TYPE_CHECKING:
    from studies.engine.executors import Executor

Log = Callable[[str], object]
MANY_POINTS = 50_000  # points whose cases take more than a moment to make


class _FirstFailureError(Exception):
    """Raised to end a run that stops at its first failure."""


def run(
    study: Study,
    out: Path,
    *,
    workers: int = 2,
    repeats: int = 2,
    log: Log = print,
    options: RunOptions | None = None,
    executor: "Executor | None" = None,
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
        Processes that compute, and timed runs of each case, where no `options` are given.
    log
        Takes each message of the run.
    options
        Options in place of `workers` and `repeats`.
    executor
        Executor in place of the workers; it is left open for the next study.

    Raises
    ------
    InvalidInput
        For bad points and for a folder that cannot be written to, before anything runs or is written.
    """
    chosen = options or RunOptions(workers=workers, repeats=repeats)
    out = out.absolute()
    study.check_size(chosen.most_points)
    request = _request(study, log)
    folder = open_folder(out)
    with locked(folder / f".{study.name}.lock", log), _stopping() as stop:
        remove_partial_files(folder)
        with _without_collection():
            journal = Journal(folder / f"{study.name}.journal.jsonl", request.context, machine())
        study, request = _beside_stored(study, request, journal, log)
        with journal, ExitStack() as closing:
            return _Run(study, request, journal, chosen, log, stop).execute(executor, closing)


def estimate_cost(study: Study, out: Path, *, options: RunOptions, log: Log = print) -> Forecast:
    """Report what :func:`run` would compute, and return its predicted cost; nothing is computed or written.

    Of a large study some points are looked at, evenly spaced.
    """
    study.check_size(options.most_points)
    every = study.size
    while study.size > MANY_POINTS:
        longest = max(study.points, key=lambda axis: len(axis.values))
        thinned = replace(longest, values=longest.values[::2])
        study = replace(
            study, points=tuple(thinned if axis is longest else axis for axis in study.points)
        )
    scale = every / study.size
    if scale > 1:
        log(f"{study.name}: {every} points, judged by {study.size} of them in proportion")
    request = _request(study, log)
    journal = Journal(out / f"{study.name}.journal.jsonl", request.context, machine())
    study, request = _beside_stored(study, request, journal, log)
    return _Run(study, request, journal, options, log, Stop()).estimate_cost(scale)


def _request(study: Study, log: Log) -> Request:
    """Return the cases of a study."""
    if study.size > MANY_POINTS:
        log(f"{study.name}: {study.size} points, whose cases are now made")
    with _without_collection():
        return Request.of(study)


@contextmanager
def _without_collection() -> Iterator[None]:
    """Collect no garbage in a block that makes many objects to last, a fourth of whose time it would take."""
    was_enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_enabled:
            gc.enable()


def _beside_stored(
    study: Study, request: Request, journal: Journal, log: Log
) -> tuple[Study, Request]:
    """Replace values of axes by stored ones that differ by rounding only, and report it."""
    stored = journal.contents.axes
    axes = tuple(axis.with_stored(stored.get(axis.name, ())) for axis in study.points)
    for axis in axes:
        if axis.merged:
            log(
                f"{study.name}: {axis.merged} values of {axis.name} differ from others by rounding alone, which stand "
                "for them"
            )
    if axes == study.points:
        return study, request
    study = replace(study, points=axes)
    return study, Request.of(study)


@contextmanager
def _stopping() -> Iterator[Stop]:
    """Take signals in a block, and raise at its end what a program that was stopped by one raises."""
    stop = Stop()
    try:
        with stop:
            yield stop
            stop.check()  # a signal during the last write stops the program, too
    except StopRun as stopped:
        raise end_like(stopped) from None


class _Run:
    """State of a run: computes, times and writes the missing cases."""

    def __init__(
        self,
        study: Study,
        request: Request,
        journal: Journal,
        options: RunOptions,
        log: Log,
        stop: Stop,
    ) -> None:
        self.study, self.request, self.journal = study, request, journal
        self.options, self.stop = options, stop
        self.file = ResultFile(study, request, journal, PointTable(study.points, request.keys))
        self.inventory = Inventory(study, request, journal, options, self.file.fields_folder)
        self._said = False
        self.log: Log = lambda text: log(f"{study.name}: {text}")
        self.work = Work(
            study.measures,
            options.fields == "kept",
            options.time_limit,
            frozenset(axis.name for axis in study.points),
        )

    def execute(self, executor: "Executor | None", closing: ExitStack) -> xr.Dataset:
        """Compute, time and write the missing cases, and return the Dataset.

        An executor that is made here is closed with `closing`.
        """
        missing = self._begin()
        activity = "solving"
        try:
            if missing:
                executor = executor or self._executor(missing, closing)
                self._solve(missing, executor)
            if missing and self.inventory.times_missing():
                self.file.write()
            activity = "timing"
            take_times(self.inventory, self.work, self.stop, self.log)
        except _FirstFailureError:
            self.file.skipped = {name for name in missing if self.inventory.record(name) is None}
            self.log("stopped at the first failure; what was not reached is marked as skipped")
        except StopRun:
            self._write_once_more()
            state = self.inventory.state()
            self.log(f"stopped while {activity}; {state}; run the same command to go on")
            raise
        except BaseException:
            # after any error the netCDF file has what the journal has, if the disk has room
            with suppress(Exception):
                self._write_once_more()
            raise
        return self._end()

    def estimate_cost(self, scale: float) -> Forecast:
        """Report what is to be computed, and return its predicted cost, all of it `scale` times that of these points."""
        cases, missing = self.request.cases, self._missing()
        predicted = self.inventory.forecast(missing, scale)
        points, all_cases, computed = (
            round(scale * len(part)) for part in (self.request.keys, cases, missing)
        )
        self.log(
            f"{points} points, {all_cases} distinct cases, {all_cases - computed} stored, {computed} to compute, "
            f"{predicted.runs} timed runs to take"
        )
        if missing:
            self.log(str(predicted))
        return predicted

    def _missing(self) -> list[str]:
        """Report what there is to say of journal and study, and return the cases to compute."""
        for note in (*self.journal.notes, *self.study.notes):
            self.log(note)
        return self.inventory.missing(self.log)

    def _begin(self) -> list[str]:
        """Report what is to be done, open journal and file, and return the missing cases."""
        cases = self.request.cases
        self.log(f"{len(self.request.keys)} points, {len(cases)} distinct cases")
        missing = self._missing()
        if len(missing) < len(cases):
            self.log(f"{len(cases) - len(missing)} cases are stored, {len(missing)} to compute")
        check_kind(self.file.path, "study", self.log)
        self.file.provenance = provenance()
        axes = {axis.name: axis.values for axis in self.study.points}
        self.journal.start(self.file.provenance["history"], axes)
        if adopted := self.inventory.adopt(missing):
            self.log(f"{adopted} cases are taken over from other studies in the folder")
            missing = self.inventory.missing(self.log)
        if self.options.table == "stored":
            self.file.table = stored_table(self.study, self.request, self.journal.contents)
        if missing:
            self.file.write()
        return missing

    def _solve(self, missing: Sequence[str], executor: "Executor") -> None:
        """Compute the ``missing`` cases, each in the journal before it counts as done."""
        unsynced, solved_seconds = 0, 0.0
        repeats = self.inventory.repeats

        def finished(name: str, outcome: Outcome) -> None:
            nonlocal unsynced, solved_seconds
            self._check_program(outcome)
            identity = self.request.identities[name]
            if outcome.fields:
                stamp = self.journal.stamp(identity.state, outcome.loaded)
                save_fields(self.file.fields_folder, name, stamp, outcome.fields)
                outcome = replace(outcome, fields={})
            is_on_disk = self.journal.add(identity, outcome)
            unsynced += 1
            solved_seconds += outcome.seconds
            if is_on_disk:
                progress.add(unsynced, afterwards=repeats * solved_seconds)
                unsynced = 0
            if outcome.case_status is not CaseStatus.OK and self.options.after_failure == "stop":
                self.log(f"a case failed: {outcome.error}")
                raise _FirstFailureError
            if monotonic() > self.file.next_write:
                self.file.write()

        with Progress(self.study.name, "solving", len(missing), "case", self.log) as progress:
            cases = {name: self.request.cases[name] for name in missing}
            executor.run(cases, self.work, finished, self.stop)
            self.journal.sync()
            progress.add(unsynced)

    def _executor(self, missing: Sequence[str], closing: ExitStack) -> "Executor":
        """Return the executor that the options ask for."""
        workers, scheduler = min(self.options.workers, len(missing)), self.options.scheduler
        if not workers and not scheduler and self.journal.contents.begun in missing:
            self.log(
                "the last run ended during a case: cases are computed in a process of their own"
            )
            workers = 1
        # what an executor needs is imported with it
        if workers or scheduler:
            from studies.engine.cluster import Cluster

            return closing.enter_context(Cluster(workers, scheduler, log=self.log))
        from studies.engine.executors import InProcess

        return InProcess(self.journal.begin)

    def _check_program(self, outcome: Outcome) -> None:
        """Refuse an outcome of another program on another machine; report that a file here has been edited meanwhile."""
        changes = self.request.context.present.changes(outcome.loaded)
        if changes and outcome.worker:
            raise InvalidInput(
                f"{shown(changes)} {'differs' if len(changes) == 1 else 'differ'} on worker {outcome.worker}, whose "
                "results are not stored: install the same there, and run the same command again."
            )
        if changes and not self._said:
            self.log(
                f"{shown(changes)} changed since this program loaded it: the next run recomputes what depends on it"
            )
            self._said = True

    def _write_once_more(self) -> None:
        """Write journal and file before the run ends."""
        self.journal.sync()
        self.file.write(fields=self.options.fields)

    def _end(self) -> xr.Dataset:
        """Write the file, report the outcomes, and return the Dataset."""
        dataset = self.file.stored() if self.options.fields == "none" else None
        if dataset is None:
            self.file.write(fields=self.options.fields)
            dataset = read(self.file.path)
        if "left_out" in dataset.attrs:
            self.log(f"left out: {dataset.attrs['left_out']}")
        for sentence in summary_messages(self.inventory.records()):
            self.log(sentence)
        untimed = map(self.journal.contents.reason_without_times, self.request.cases)
        if reasons := [reason for reason in untimed if reason]:
            self.log(
                f"{len(reasons)} cases have no times, the first since {reasons[0]}; --retime tries again"
            )
        self.log(f"wrote {self.file.path}")
        return dataset
