"""Run the missing cases of a study, each distinct one once, then time them one at a time."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING

import xarray as xr

from contactstudy.domain.files import locked, remove_partial_files
from studies.engine.forecast import (
    Forecast,
    ForecastModel,
    describe_score,
    fit_model,
    forecast,
    mode,
    score,
)
from studies.engine.options import RunOptions
from studies.engine.progress import Progress
from studies.engine.stop import Stop, end_like
from studies.engine.timing import longest, time_cases
from studies.engine.workers.compute import StopRun
from studies.model.outcome import CaseStatus, Failure, Outcome, Sample, Work, summary_messages
from studies.model.study import Study
from studies.store.journal import Journal, Record
from studies.store.netcdf import check_kind, open_folder
from studies.store.provenance import machine, provenance
from studies.store.request import Request, recompute_reasons
from studies.store.result_file import ResultFile, has_fields, save_fields
from studies.store.table import requested_table, stored_table

if TYPE_CHECKING:
    from studies.engine.executors import Executor
    from studies.engine.workers.supervisor import WorkerSupervisor

Log = Callable[[str], object]
MANY = 50_000  # points that take more than a moment


class _FirstFailureError(Exception):
    """Ends a run that is to stop there."""


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
    """Compute what is missing of ``study`` and leave ``<out>/<study>.nc``; returns what was written.

    ``options`` stand in place of ``workers`` and ``repeats``, and an ``executor`` in place of the workers.
    Every finished case is in ``<out>/<study>.journal.jsonl`` before it is reported, and is not computed
    again. The file holds what else is stored of the study as well, unless ``options`` say otherwise.
    Bad points raise :class:`~contactstudy.InvalidInput` before anything runs or is written, as does
    a folder that cannot be written to.
    """
    chosen = options or RunOptions(workers=workers, repeats=repeats)
    study.check_size(chosen.most_points)
    request = _request(study, log)
    folder = open_folder(out)
    with locked(folder / f".{study.name}.lock", log), _stopping() as stop:
        remove_partial_files(folder)
        journal = Journal(folder / f"{study.name}.journal.jsonl", request.context, machine())
        with journal:
            return _Run(study, request, folder, journal, chosen, log, stop, executor).go()


def estimate_cost(study: Study, out: Path, *, options: RunOptions, log: Log = print) -> Forecast:
    """What :func:`run` would compute, and what that would take; nothing is computed or written."""
    study.check_size(options.most_points)
    request = _request(study, log)
    journal = Journal(out / f"{study.name}.journal.jsonl", request.context, machine())
    return _Run(study, request, out, journal, options, log, Stop()).estimate_cost()


def _request(study: Study, log: Log) -> Request:
    if study.size > MANY:
        log(f"{study.name}: {study.size} points, whose cases are now made")
    return Request.of(study)


@contextmanager
def _stopping() -> Iterator[Stop]:
    stop = Stop()
    try:
        with stop:
            yield stop
    except StopRun as stopped:
        raise end_like(stopped) from None


class _Run:
    """One run, with the journal in hand."""

    def __init__(
        self,
        study: Study,
        request: Request,
        folder: Path,
        journal: Journal,
        options: RunOptions,
        log: Log,
        stop: Stop,
        executor: "Executor | None" = None,
    ) -> None:
        self.executor, self.stop = executor, stop
        self.study, self.request, self.folder = study, request, folder
        self.journal, self.options = journal, options
        self.file = ResultFile(study, request, folder, journal, requested_table(study, request))
        self.log: Log = lambda text: log(f"{study.name}: {text}")

    def go(self) -> xr.Dataset:
        cases = self.request.cases
        for note in self.journal.notes:
            self.log(note)
        self.log(f"{len(self.request.keys)} points, {len(cases)} distinct cases")
        for note in self.study.notes:
            self.log(note)
        missing = self._missing()
        if len(missing) < len(cases):
            self.log(f"{len(cases) - len(missing)} cases are stored, {len(missing)} to compute")
        predicted = self._forecast(missing)
        if missing and predicted.seconds is not None:
            self.log(str(predicted))
        check_kind(self.file.path, "study")
        self.file.provenance = provenance()
        axes = {axis.name: axis.values for axis in self.study.points}
        self.journal.start(self.file.provenance, axes)
        if self.options.table == "stored":
            self.file.table = stored_table(self.study, self.request, self.journal.contents)
        if missing:
            self.file.write()
        doing = "solving"
        try:
            self._solve(missing)
            self._score(predicted, missing)
            if missing and self._times_missing():
                self.file.write()
            doing = "timing"
            self._time()
        except _FirstFailureError:
            self.file.skipped = {name for name in missing if self._record(name) is None}
            self.log("stopped at the first failure; what was not reached is marked as skipped")
        except StopRun:
            self._write_once_more()
            self.log(f"stopped while {doing}; {self._state()}; run the same command to go on")
            raise
        except BaseException:
            # whatever it was: the netCDF says what the journal says, if there is room for it
            with suppress(Exception):
                self._write_once_more()
            raise
        self.file.write(fields=self.options.fields)
        dataset = self.file.read()
        if "left_out" in dataset.attrs:
            self.log(f"left out: {dataset.attrs['left_out']}")
        for sentence in summary_messages(self._records()):
            self.log(sentence)
        if untimed := [why for name, why in self.journal.contents.untimed.items() if name in cases]:
            self.log(
                f"{len(untimed)} cases have no times, the first since {untimed[0]}; --retime tries again"
            )
        self.log(f"wrote {self.file.path}")
        return dataset

    def estimate_cost(self) -> Forecast:
        """What there is to compute, and what it will take; nothing is computed or written."""
        for note in (*self.journal.notes, *self.study.notes):
            self.log(note)
        cases, missing = self.request.cases, self._missing()
        predicted = self._forecast(missing)
        runs = sum(self._times_missing().values()) + self._repeats * len(missing)
        self.log(
            f"{len(self.request.keys)} points, {len(cases)} distinct cases, {len(cases) - len(missing)} stored, "
            f"{len(missing)} to compute, {runs} timed runs to take"
        )
        if missing or runs:
            self.log(str(predicted))
        return predicted

    def _record(self, name: str) -> Record | None:
        """What is stored of the case, in this context and with these defaults."""
        record = self.journal.contents.records.get(name)
        identity = self.request.identities[name]
        return record if record is not None and record.is_of(identity) else None

    def _records(self) -> Iterator[Record]:
        for name in self.request.cases:
            if (record := self._record(name)) is not None:
                yield record

    def _state(self) -> str:
        stored = sum(1 for _ in self._records())
        missing = sum(self._times_missing().values())
        times = f", {missing} timed runs are missing" if missing else ""
        return f"{stored} of {len(self.request.cases)} cases are stored{times}"

    def _write_once_more(self) -> None:
        self.journal.sync()
        self.file.write(fields=self.options.fields)

    def _forecast(self, missing: Sequence[str]) -> Forecast:
        trees = {name: self.request.identities[name].tree for name in missing}
        counts = self._times_missing() | dict.fromkeys(missing, self._repeats)
        if not counts and not missing:
            return forecast(ForecastModel([]), {}, {})
        timed = {name: (self.request.identities[name].tree, n) for name, n in counts.items()}
        return forecast(fit_model(self.folder, machine()), trees, timed)

    @property
    def _repeats(self) -> int:
        return self.options.repeats if self.study.times == "taken" else 0

    def _score(self, predicted: Forecast, missing: Sequence[str]) -> None:
        records = {name: self._record(name) for name in missing}
        taken = {
            name: record.cpu
            for name, record in records.items()
            if record is not None and record.case_status is CaseStatus.OK
        }
        found = score(predicted, taken)
        if found:
            self.journal.score(found)
            self.log(describe_score(found))

    def _missing(self) -> list[str]:
        """The cases to compute; says why what is stored does not serve, where there is something."""
        contents, missing = self.journal.contents, []
        changes: dict[str, int] = {}
        for name, identity in self.request.identities.items():
            record = self._record(name)
            if record is not None:
                if self._is_done(name, record.case_status):
                    continue
            elif contents.records or contents.others:
                for change in recompute_reasons(contents, identity, self.request.context):
                    changes[change] = changes.get(change, 0) + 1
            missing.append(name)
        for change, count in changes.items():
            self.log(f"{count} stored cases are computed anew, since {change}")
        return missing

    def _is_done(self, name: str, case_status: CaseStatus) -> bool:
        wants_fields = self.options.fields == "kept" and case_status is CaseStatus.OK
        return case_status not in self.options.retry and (
            not wants_fields or has_fields(self.file.fields_folder, name)
        )

    def _solve(self, missing: Sequence[str]) -> None:
        if not missing:
            return
        not_on_disk = 0

        def finished(number: int, outcome: Outcome) -> None:
            nonlocal not_on_disk
            name = missing[number]
            if outcome.fields:
                save_fields(self.file.fields_folder, name, outcome.fields)
                outcome = replace(outcome, fields={})
            is_on_disk = self.journal.add(self.request.identities[name], outcome)
            not_on_disk += 1
            if is_on_disk:
                progress.add(not_on_disk)
                not_on_disk = 0
            if outcome.case_status is not CaseStatus.OK and self.options.after_failure == "stop":
                self.log(f"a case failed: {outcome.error}")
                raise _FirstFailureError
            if monotonic() > self.file.next_write:
                self.file.write()

        with Progress(self.study.name, "solving", len(missing), "case", self.log) as progress:
            cases = [self.request.cases[name] for name in missing]
            self._executor(missing).run(cases, self._work, finished, self.stop)
            self.journal.sync()
            progress.add(not_on_disk)

    @property
    def _work(self) -> Work:
        return Work(
            self.study.measures,
            self.options.fields == "kept",
            self.options.time_limit,
            frozenset(axis.name for axis in self.study.points),
        )

    def _executor(self, missing: Sequence[str]) -> "Executor":
        if self.executor is not None:
            return self.executor
        # what an executor needs is imported with it
        if self.options.scheduler is not None:
            from studies.engine.cluster import Cluster

            return Cluster(self.options.scheduler, log=self.log)
        from studies.engine.executors import InProcess, Processes

        if self.options.workers:
            return Processes(self.options.workers)
        begun = self.journal.contents.begun
        suspects = frozenset(number for number, name in enumerate(missing) if name == begun)
        if suspects:
            self.log("the last run ended during a case, which now needs a process of its own")
        return InProcess(lambda number: self.journal.begin(missing[number]), suspects)

    def _times_missing(self) -> dict[str, int]:
        """How many timed runs each good case lacks; none of those that cannot be timed."""
        contents, anew = self.journal.contents, self.options.old_times == "dropped"
        counts = {}
        for name in self.request.cases:
            record = self._record(name)
            if record is None or record.case_status is not CaseStatus.OK:
                continue
            there = 0 if anew else len(contents.samples.get(name, ()))
            if there < self._repeats and (anew or name not in contents.untimed):
                counts[name] = self._repeats - there
        return counts

    def _time(self) -> None:
        counts = self._times_missing()
        if self.options.old_times == "dropped":
            self.journal.forget_times()
        if not counts:
            return
        expected = {name: self.journal.contents.records[name].seconds for name in counts}
        kinds = {name: mode(self.request.identities[name].tree) for name in counts}
        with (
            Progress(self.study.name, "timing", sum(counts.values()), "run", self.log) as progress,
            self._worker() as worker,
        ):

            def time_once(name: str) -> Sample | Failure | None:
                limit = longest(expected[name], self.options.time_limit)
                with self.stop.interruptible():
                    return worker.time_once(self.request.cases[name], limit)

            def taken(name: str, sample: Sample) -> None:
                self.journal.time(name, sample)
                progress.add()

            def failed(name: str, failure: Failure) -> None:
                self.journal.cannot_time(name, failure.sentence)
                progress.add(counts[name])

            time_cases(counts, expected, kinds, time_once, taken, failed)
            self.journal.sync()

    @contextmanager
    def _worker(self) -> "Iterator[WorkerSupervisor]":
        """A process to time cases in: they may hang or die there though they did not before."""
        from studies.engine.executors import packed
        from studies.engine.workers.supervisor import WorkerSupervisor

        worker = WorkerSupervisor(packed(self._work))
        try:
            yield worker
        finally:
            worker.end()
