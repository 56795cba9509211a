"""Runs a study: what is not stored yet, each distinct case once, then alone against the clock."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING

import xarray as xr
from tqdm import tqdm

from studies.engine.forecast import Forecast, forecast, in_words, model, score
from studies.engine.forecast_model import mode
from studies.engine.options import Settings
from studies.engine.timing import time
from studies.model.outcome import Fate, Outcome, Work, remarks
from studies.model.study import Study
from studies.model.timing_samples import Sample
from studies.store import fields as stored_fields
from studies.store.identity import differences
from studies.store.journal import Journal
from studies.store.lock import holding
from studies.store.netcdf import open_folder
from studies.store.provenance import machine, provenance
from studies.store.request import Asked, reasons
from studies.store.result_file import ResultFile

if TYPE_CHECKING:
    from studies.engine.executors import Engine

Say = Callable[[str], object]


class _FirstFailureError(Exception):
    """Ends a run that is to stop there."""


def run(
    study: Study,
    out: Path,
    *,
    workers: int = 2,
    repeats: int = 2,
    say: Say = print,
    settings: Settings | None = None,
    engine: "Engine | None" = None,
) -> xr.Dataset:
    """Compute what is lacking of ``study`` and leave ``<out>/<study>.nc``; returns what was written.

    ``settings`` stand in place of ``workers`` and ``repeats``, and an ``engine`` in place of the workers.
    Every finished case is in ``<out>/<study>.journal.jsonl`` before it is reported, and is not computed
    again. Bad points raise :class:`~contactstudy.InvalidInput` before anything runs or is written, as does
    a folder that cannot be written to.
    """
    chosen = settings or Settings(workers=workers, repeats=repeats)
    asked = Asked.of(study)
    folder = open_folder(out)
    with holding(folder / f".{study.name}.lock", say):
        journal = Journal(folder / f"{study.name}.journal.jsonl", asked.context, machine())
        with journal:
            return _Run(study, asked, folder, journal, chosen, say, engine).go()


def foresee(study: Study, out: Path, *, settings: Settings, say: Say = print) -> Forecast:
    """What :func:`run` would compute, and what that would take; nothing is computed or written."""
    asked = Asked.of(study)
    journal = Journal(out / f"{study.name}.journal.jsonl", asked.context, machine())
    return _Run(study, asked, out, journal, settings, say).foresee()


class _Run:
    """One run, with the journal in hand."""

    def __init__(
        self,
        study: Study,
        asked: Asked,
        folder: Path,
        journal: Journal,
        settings: Settings,
        say: Say,
        engine: "Engine | None" = None,
    ) -> None:
        self.engine = engine
        self.study, self.asked, self.folder = study, asked, folder
        self.file = ResultFile(study, asked, folder, journal)
        self.journal, self.settings = journal, settings
        self.say: Say = lambda text: say(f"{study.name}: {text}")
        self.outcomes: dict[str, Outcome] = {}

    def go(self) -> xr.Dataset:
        cases = self.asked.cases
        self.say(f"{len(self.asked.keys)} points, {len(cases)} distinct cases")
        lacking = self._lacking()
        if len(lacking) < len(cases):
            self.say(f"{len(cases) - len(lacking)} cases are stored, {len(lacking)} to compute")
        predicted = self._forecast(lacking)
        if lacking and predicted.seconds is not None:
            self.say(str(predicted))
        self.file.where = provenance()
        self.journal.start(self.file.where)
        self.file.write(self.outcomes)
        try:
            self._solve(lacking)
            self._score(predicted, lacking)
            self.file.write(self.outcomes)
            self._time()
        except _FirstFailureError:
            for name in lacking:
                self.outcomes.setdefault(name, Outcome(Fate.SKIPPED))
            self.say("stopped at the first failure; what was not reached is marked as skipped")
        except KeyboardInterrupt:
            self.journal.sync()
            self.file.write(self.outcomes, fields=self.settings.fields)
            done = sum(name in self.outcomes for name in cases)
            self.say(f"{done} of {len(cases)} cases are stored; run the same command to go on")
            raise
        self.file.write(self.outcomes, fields=self.settings.fields)
        dataset = self.file.read()
        if "left_out" in dataset.attrs:
            self.say(f"left out, {dataset.attrs['left_out']}")
        for sentence in remarks([self.outcomes[name] for name in cases]):
            self.say(sentence)
        self.say(f"wrote {self.file.path}")
        return dataset

    def foresee(self) -> Forecast:
        """What there is to compute, and what it will take; nothing is computed or written."""
        cases, lacking = self.asked.cases, self._lacking()
        predicted = self._forecast(lacking)
        self.say(
            f"{len(self.asked.keys)} points, {len(cases)} distinct cases, {len(cases) - len(lacking)} stored, "
            f"{len(lacking)} to compute"
        )
        if lacking:
            self.say(str(predicted))
        return predicted

    def _forecast(self, lacking: Sequence[str]) -> Forecast:
        trees = {name: self.asked.names[name].tree for name in lacking}
        return forecast(model(self.folder, machine()), trees, lacking, self._repeats)

    @property
    def _repeats(self) -> int:
        return self.settings.repeats if self.study.times == "taken" else 0

    def _score(self, predicted: Forecast, lacking: Sequence[str]) -> None:
        good = [name for name in lacking if self.outcomes[name].fate is Fate.OK]
        found = score(predicted, {name: self.outcomes[name].cpu for name in good})
        if found:
            self.journal.score(found)
            self.say(in_words(found))

    def _lacking(self) -> list[str]:
        """The cases to compute; says why what is stored does not serve, where there is something."""
        contents, lacking = self.journal.contents, []
        changes: dict[str, int] = {}
        for name, named in self.asked.names.items():
            record = contents.records.get(name)
            if record is not None and not differences(record.named.tree, named.tree):
                if self._is_done(name, record.outcome.fate):
                    self.outcomes[name] = record.outcome
                    continue
            else:
                for change in reasons(contents, named, self.asked.context):
                    changes[change] = changes.get(change, 0) + 1
            lacking.append(name)
        for change, count in changes.items():
            self.say(f"{count} stored cases are computed anew, since {change}")
        return lacking

    def _is_done(self, name: str, fate: Fate) -> bool:
        wants_fields = self.settings.fields == "kept" and fate is Fate.OK
        return fate not in self.settings.retry and (
            not wants_fields or stored_fields.are_kept(self.file.pictures, name)
        )

    def _solve(self, lacking: Sequence[str]) -> None:
        if not lacking:
            return
        work = Work(self.study.measures, self.settings.fields == "kept", self.settings.time_limit)
        bar = tqdm(
            total=len(lacking), desc=f"{self.study.name}: solving", unit="case", disable=None
        )
        unseen = 0

        def finished(number: int, outcome: Outcome) -> None:
            nonlocal unseen
            name = lacking[number]
            if outcome.fields:
                stored_fields.keep(self.file.pictures, name, outcome.fields)
                outcome = replace(outcome, fields={})
            named = self.asked.names[name]
            is_on_disk = self.journal.add(named, outcome)
            self.outcomes[name] = outcome
            unseen += 1
            if is_on_disk:
                bar.update(unseen)
                unseen = 0
            if outcome.fate is not Fate.OK and self.settings.after_failure == "stop":
                self.say(f"a case failed: {outcome.error}")
                raise _FirstFailureError
            if monotonic() > self.file.written + 60:
                self.file.write(self.outcomes)

        with bar:
            self._engine(lacking).run([self.asked.cases[name] for name in lacking], work, finished)
            self.journal.sync()
            bar.update(unseen)

    def _engine(self, lacking: Sequence[str]) -> "Engine":
        if self.engine is not None:
            return self.engine
        # what an engine needs is imported with it
        if self.settings.scheduler is not None:
            from studies.engine.cluster import Cluster

            return Cluster(self.settings.scheduler)
        from studies.engine.executors import InProcess, Processes

        if self.settings.workers:
            return Processes(self.settings.workers)
        begun = self.journal.contents.begun
        suspects = frozenset(number for number, name in enumerate(lacking) if name == begun)
        if suspects:
            self.say("the last run ended during a case, which now needs a process of its own")
        return InProcess(lambda number: self.journal.begin(lacking[number]), suspects)

    def _time(self) -> None:
        if self.settings.old_times == "dropped":
            self.journal.forget_times()
        there = self.journal.contents.samples
        counts = {
            name: self._repeats - len(there.get(name, ()))
            for name, outcome in self.outcomes.items()
            if outcome.fate is Fate.OK
        }
        counts = {name: count for name, count in counts.items() if count > 0}
        expected = {name: self.outcomes[name].seconds for name in counts}
        kinds = {name: mode(self.asked.names[name].tree) for name in counts}
        total, words = sum(counts.values()), f"{self.study.name}: timing"
        with tqdm(total=total, desc=words, unit="run", disable=None) as bar:
            time(self.asked.cases, counts, expected, kinds, partial(self._timed, bar))
            self.journal.sync()

    def _timed(self, bar: "tqdm[None]", name: str, sample: Sample) -> None:
        self.journal.time(name, sample)
        bar.update()
