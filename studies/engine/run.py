"""Runs a study: what is not stored yet, each distinct case once, then alone against the clock."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING

import xarray as xr
from tqdm import tqdm

from studies.engine.forecast import Forecast, describe_score, fit_model, forecast, score
from studies.engine.forecast_model import mode
from studies.engine.options import RunOptions
from studies.engine.timing import time_cases
from studies.model.outcome import CaseStatus, Outcome, Work, summary_messages
from studies.model.study import Study
from studies.model.timing_samples import Sample
from studies.store import fields as stored_fields
from studies.store.identity import differences
from studies.store.journal import Journal
from studies.store.lock import locked
from studies.store.netcdf import open_folder
from studies.store.provenance import machine, provenance
from studies.store.request import Request, recompute_reasons
from studies.store.result_file import ResultFile

if TYPE_CHECKING:
    from studies.engine.executors import Executor

Log = Callable[[str], object]


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
    """Compute what is lacking of ``study`` and leave ``<out>/<study>.nc``; returns what was written.

    ``options`` stand in place of ``workers`` and ``repeats``, and an ``executor`` in place of the workers.
    Every finished case is in ``<out>/<study>.journal.jsonl`` before it is reported, and is not computed
    again. Bad points raise :class:`~contactstudy.InvalidInput` before anything runs or is written, as does
    a folder that cannot be written to.
    """
    chosen = options or RunOptions(workers=workers, repeats=repeats)
    request = Request.of(study)
    folder = open_folder(out)
    with locked(folder / f".{study.name}.lock", log):
        journal = Journal(folder / f"{study.name}.journal.jsonl", request.context, machine())
        with journal:
            return _Run(study, request, folder, journal, chosen, log, executor).go()


def estimate_cost(study: Study, out: Path, *, options: RunOptions, log: Log = print) -> Forecast:
    """What :func:`run` would compute, and what that would take; nothing is computed or written."""
    request = Request.of(study)
    journal = Journal(out / f"{study.name}.journal.jsonl", request.context, machine())
    return _Run(study, request, out, journal, options, log).estimate_cost()


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
        executor: "Executor | None" = None,
    ) -> None:
        self.executor = executor
        self.study, self.request, self.folder = study, request, folder
        self.file = ResultFile(study, request, folder, journal)
        self.journal, self.options = journal, options
        self.log: Log = lambda text: log(f"{study.name}: {text}")
        self.outcomes: dict[str, Outcome] = {}

    def go(self) -> xr.Dataset:
        cases = self.request.cases
        self.log(f"{len(self.request.keys)} points, {len(cases)} distinct cases")
        missing = self._missing()
        if len(missing) < len(cases):
            self.log(f"{len(cases) - len(missing)} cases are stored, {len(missing)} to compute")
        predicted = self._forecast(missing)
        if missing and predicted.seconds is not None:
            self.log(str(predicted))
        self.file.provenance = provenance()
        self.journal.start(self.file.provenance)
        self.file.write(self.outcomes)
        try:
            self._solve(missing)
            self._score(predicted, missing)
            self.file.write(self.outcomes)
            self._time()
        except _FirstFailureError:
            for name in missing:
                self.outcomes.setdefault(name, Outcome(CaseStatus.SKIPPED))
            self.log("stopped at the first failure; what was not reached is marked as skipped")
        except KeyboardInterrupt:
            self.journal.sync()
            self.file.write(self.outcomes, fields=self.options.fields)
            done = sum(name in self.outcomes for name in cases)
            self.log(f"{done} of {len(cases)} cases are stored; run the same command to go on")
            raise
        self.file.write(self.outcomes, fields=self.options.fields)
        dataset = self.file.read()
        if "left_out" in dataset.attrs:
            self.log(f"left out, {dataset.attrs['left_out']}")
        for sentence in summary_messages([self.outcomes[name] for name in cases]):
            self.log(sentence)
        self.log(f"wrote {self.file.path}")
        return dataset

    def estimate_cost(self) -> Forecast:
        """What there is to compute, and what it will take; nothing is computed or written."""
        cases, missing = self.request.cases, self._missing()
        predicted = self._forecast(missing)
        self.log(
            f"{len(self.request.keys)} points, {len(cases)} distinct cases, {len(cases) - len(missing)} stored, "
            f"{len(missing)} to compute"
        )
        if missing:
            self.log(str(predicted))
        return predicted

    def _forecast(self, missing: Sequence[str]) -> Forecast:
        trees = {name: self.request.identities[name].tree for name in missing}
        return forecast(fit_model(self.folder, machine()), trees, missing, self._repeats)

    @property
    def _repeats(self) -> int:
        return self.options.repeats if self.study.times == "taken" else 0

    def _score(self, predicted: Forecast, missing: Sequence[str]) -> None:
        good = [name for name in missing if self.outcomes[name].case_status is CaseStatus.OK]
        found = score(predicted, {name: self.outcomes[name].cpu for name in good})
        if found:
            self.journal.score(found)
            self.log(describe_score(found))

    def _missing(self) -> list[str]:
        """The cases to compute; says why what is stored does not serve, where there is something."""
        contents, missing = self.journal.contents, []
        changes: dict[str, int] = {}
        for name, identity in self.request.identities.items():
            record = contents.records.get(name)
            if record is not None and not differences(record.identity.tree, identity.tree):
                if self._is_done(name, record.outcome.case_status):
                    self.outcomes[name] = record.outcome
                    continue
            else:
                for change in recompute_reasons(contents, identity, self.request.context):
                    changes[change] = changes.get(change, 0) + 1
            missing.append(name)
        for change, count in changes.items():
            self.log(f"{count} stored cases are computed anew, since {change}")
        return missing

    def _is_done(self, name: str, case_status: CaseStatus) -> bool:
        wants_fields = self.options.fields == "kept" and case_status is CaseStatus.OK
        return case_status not in self.options.retry and (
            not wants_fields or stored_fields.exist(self.file.fields_folder, name)
        )

    def _solve(self, missing: Sequence[str]) -> None:
        if not missing:
            return
        work = Work(self.study.measures, self.options.fields == "kept", self.options.time_limit)
        bar = tqdm(
            total=len(missing), desc=f"{self.study.name}: solving", unit="case", disable=None
        )
        not_on_disk = 0

        def finished(number: int, outcome: Outcome) -> None:
            nonlocal not_on_disk
            name = missing[number]
            if outcome.fields:
                stored_fields.save(self.file.fields_folder, name, outcome.fields)
                outcome = replace(outcome, fields={})
            identity = self.request.identities[name]
            is_on_disk = self.journal.add(identity, outcome)
            self.outcomes[name] = outcome
            not_on_disk += 1
            if is_on_disk:
                bar.update(not_on_disk)
                not_on_disk = 0
            if outcome.case_status is not CaseStatus.OK and self.options.after_failure == "stop":
                self.log(f"a case failed: {outcome.error}")
                raise _FirstFailureError
            if monotonic() > self.file.written + 60:
                self.file.write(self.outcomes)

        with bar:
            self._executor(missing).run(
                [self.request.cases[name] for name in missing], work, finished
            )
            self.journal.sync()
            bar.update(not_on_disk)

    def _executor(self, missing: Sequence[str]) -> "Executor":
        if self.executor is not None:
            return self.executor
        # what an engine needs is imported with it
        if self.options.scheduler is not None:
            from studies.engine.cluster import Cluster

            return Cluster(self.options.scheduler)
        from studies.engine.executors import InProcess, Processes

        if self.options.workers:
            return Processes(self.options.workers)
        begun = self.journal.contents.begun
        suspects = frozenset(number for number, name in enumerate(missing) if name == begun)
        if suspects:
            self.log("the last run ended during a case, which now needs a process of its own")
        return InProcess(lambda number: self.journal.begin(missing[number]), suspects)

    def _time(self) -> None:
        if self.options.old_times == "dropped":
            self.journal.forget_times()
        there = self.journal.contents.samples
        counts = {
            name: self._repeats - len(there.get(name, ()))
            for name, outcome in self.outcomes.items()
            if outcome.case_status is CaseStatus.OK
        }
        counts = {name: count for name, count in counts.items() if count > 0}
        expected = {name: self.outcomes[name].seconds for name in counts}
        kinds = {name: mode(self.request.identities[name].tree) for name in counts}
        total, words = sum(counts.values()), f"{self.study.name}: timing"
        with tqdm(total=total, desc=words, unit="run", disable=None) as bar:
            time_cases(self.request.cases, counts, expected, kinds, partial(self._timed, bar))
            self.journal.sync()

    def _timed(self, bar: "tqdm[None]", name: str, sample: Sample) -> None:
        self.journal.time(name, sample)
        bar.update()
