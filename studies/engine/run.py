"""Run the missing cases of a study, each distinct one once, then time them one at a time."""

import itertools
import random
import sys
from collections import Counter
from collections.abc import Generator, Iterable, Iterator, Mapping, Sequence
from contextlib import closing, suppress
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from functools import cached_property
from pathlib import Path
from time import monotonic

import cloudpickle
import numpy as np
import xarray as xr
from threadpoolctl import threadpool_limits

from contactstudy.domain.files import read_verified, remove_partial_files, set_aside
from studies.engine.compute import Task, failed, perform, warm_up
from studies.engine.options import RETRIES, RunOptions
from studies.engine.progress import progress_of
from studies.engine.request import Request
from studies.model.outcome import CaseStatus, Outcome, RunSettings, TimedRun, is_time, summary_messages
from studies.model.plain_text import Log, counted, one_line, two_digits
from studies.model.study import Study
from studies.store.journal import Journal, Key
from studies.store.netcdf import check_kind, open_folder, read, write
from studies.store.program import differences
from studies.store.provenance import machine, provenance
from studies.store.stop import Stop, StopRun
from studies.store.table import assemble

JOURNAL = "cases.jsonl"
MIN_WRITE_INTERVAL = 60.0  # least seconds between two writes of the file while cases are computed
WRITE_INTERVAL_FACTOR = 20  # least ratio of the time between two writes to the time of one
CHECK_SECONDS = 0.25  # seconds after which it is checked that the program in this process is the same
MANY_POINTS = 50_000  # points whose cases take more than a moment to make
Outcomes = Generator[tuple[Task, Outcome], None, None]


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

    Every finished case is in ``<out>/cases.jsonl`` before it is reported, and is not computed again: not by another
    study in the folder either, if it has the same measures and sources.

    Parameters
    ----------
    study
        The study.
    out
        Folder of the results, made if need be.
    workers, repeats
        Processes that compute, and timed runs of each case, in place of those of the `options`.
    log
        Takes each message of the run.
    options
        Options of the run, by default those of :class:`~studies.RunOptions`.

    Raises
    ------
    InvalidInput
        For bad points and for a folder that cannot be written to, before anything runs or is written; if a file of the
        program changes meanwhile.
    """
    chosen = options or RunOptions()
    chosen = replace(
        chosen,
        workers=chosen.workers if workers is None else workers,
        repeats=chosen.repeats if repeats is None else repeats,
    )
    study.check_size(chosen.max_points)
    named_log = with_name(study, log)
    if study.size > MANY_POINTS:
        named_log(f"making the cases of {study.size} points")
    request = Request.of(study)
    folder = open_folder(out.absolute())
    with Stop() as stop, Journal(folder / JOURNAL, machine()) as journal:
        remove_partial_files(folder)
        return Run(study, request, journal, chosen, named_log, stop).execute()


def with_name(study: Study, log: Log) -> Log:
    """Return a log whose messages begin with the name of a study."""
    return lambda text: log(f"{study.name}: {text}")


@dataclass(eq=False)
class Run:
    """Run of a study in the folder of a `journal`: what is stored, what is missing, and the netCDF file of it."""

    study: Study
    request: Request
    journal: Journal
    options: RunOptions
    log: Log
    stop: Stop

    def __post_init__(self) -> None:
        self.program, folder = self.request.program, self.journal.path.parent
        self.path = folder / f"{self.study.name}.nc"
        self.fields_folder = folder / f"{self.study.name}.fields"
        self.repeats = self.options.repeats if self.study.times == "taken" else 0
        axes = frozenset(axis.name for axis in self.study.axes)
        self.settings = RunSettings(self.study.measures, self.options.fields == "kept", axes)
        self.aside: Path | None = None  # the file of another program or scene, until it is compared
        # instant (of ``monotonic``) before which the file is not written again
        self.next_write = 0.0

    @cached_property
    def provenance(self) -> Mapping[str, str]:
        """Versions, machine, command and time."""
        return provenance()

    def key(self, case: str) -> Key:
        """Return the key of a case in the journal."""
        return case, self.program.key

    def missing(self) -> list[str]:
        """Return the keys of the cases to compute."""
        return [key for key in self.request.cases if not self._is_sufficient(key)]

    def _is_sufficient(self, case: str) -> bool:
        """Return whether what is stored of a case is enough for the options."""
        status = self.journal.status(self.key(case))
        if status is None or any(status in RETRIES[name] for name in self.options.retry):
            return False
        if self.options.fields != "kept" or status is not CaseStatus.OK:
            return True
        path = self.fields_path(case)
        if path.is_file() and read_verified(path) is None:
            self.log(f"{path} is damaged: it is set aside as {set_aside(path).name}")
        return path.is_file()

    def timed_tasks(self) -> list[Task]:
        """Return the missing timed runs of all cases: every case once, then every case again."""
        tasks: list[tuple[int, Task]] = []
        for case, computation in self.request.cases.items() if self.repeats else ():
            key, samples = self.key(case), self.samples(case)
            if self.journal.status(key) is CaseStatus.OK and key not in self.journal.untimed:
                task = Task(case, computation, self.journal.cases[key]["seconds"])
                tasks += [(repeat, task) for repeat in range(len(samples), self.repeats)]
        return [task for _, task in sorted(tasks, key=lambda entry: entry[0])]

    def fields_path(self, case: str) -> Path:
        """Return the path of the file of a case's fields."""
        return self.fields_folder / f"{case}-{self.program.key[:8]}.nc"

    def write(self) -> None:
        """Write the file, with a group for every case that has fields if these are to be kept."""
        start, stored = monotonic(), self.journal.outcome
        dataset = assemble(
            self.study.axes, self.request.keys, lambda case: stored(self.key(case)), self.samples, self._attributes()
        )
        write(dataset, self.path, self._groups() if self.options.fields == "kept" else ())
        end = monotonic()
        self.next_write = end + max(MIN_WRITE_INTERVAL, WRITE_INTERVAL_FACTOR * (end - start))

    def _groups(self) -> Iterator[tuple[str, xr.Dataset]]:
        """Yield the fields of every case that has some, read one at a time."""
        for case in self.request.cases:
            if self.fields_path(case).is_file():
                yield f"fields/case_{case}", read(self.fields_path(case), "File of fields")

    def samples(self, case: str) -> Sequence[TimedRun]:
        """Return the timed runs of a case on this machine."""
        return self.journal.samples.get(self.key(case), ())

    def _attributes(self) -> dict[str, str]:
        """Return the attributes of the file."""
        history, digests = self.journal.history[self.study.name], self.program.digests
        notes = {"notes": "\n".join(self.study.notes)} if self.study.notes else {}
        return {
            **notes, **self.study.attributes, **self.provenance,
            "study": self.study.name,
            "title": one_line(self.study.title),
            "first_case": one_line(next(iter(self.request.cases.values()))),
            "history": "\n".join(history),
            "date_created": history[0].split()[0],
            "date_modified": datetime.now(UTC).isoformat(timespec="seconds"),
            "program": self.program.key,
            "versions": ", ".join(f"{name} {of}" for name, of in digests.items() if "." in of),
            "timing": "processor and wall time, each the least of the repeats, on one thread where no axis says more",
        }  # fmt: skip

    def execute(self) -> xr.Dataset:
        """Compute, time and write the missing cases, and return the Dataset."""
        cases, activity = self.request.cases, "solving"
        missing = self.missing()
        self._begin(missing)
        try:
            self._perform([Task(key, cases[key]) for key in missing], activity, "case")
            activity = "timing"
            self._perform(self.timed_tasks(), activity, "run")
        except BaseException as error:
            # the netCDF file has what the journal has, if the disk has room
            with suppress(Exception):
                self.write()
                self._compare_aside()
            if isinstance(error, StopRun):
                stored = sum(self.key(key) in self.journal.cases for key in cases)
                times = len(self.timed_tasks())
                missed = counted(times, "timed run is", "timed runs are")
                untimed = f", {missed} missing" if times else ""
                self.log(
                    f"stopped while {activity}; {stored} of {len(cases)} cases are stored{untimed}; "
                    "run the same command to go on"
                )
            raise
        return self._end()

    def _begin(self, missing: Sequence[str]) -> None:
        """Report what is to be done and why, and begin a run in the journal; keep a file of other numbers."""
        journal, request = self.journal, self.request
        for note in (*journal.notes(), *self.study.notes):
            self.log(note)
        points, cases = (counted(len(request.keys), "point"), counted(len(request.cases), "distinct case"))
        self.log(f"{points}, {cases}")
        first = journal.firsts.get(self.study.name)
        differs = first is not None and request.differs(self.study, first)
        if first is not None and differs:
            self.log(f"the case at {first['point']} was another: what is stored of the old ones is kept, and not used")
        for change, count in self._other_programs(missing).items():
            stored = counted(count, "stored case is", "stored cases are")
            self.log(f"{stored} computed again, since {change} changed")
        if len(missing) < len(request.cases):
            stored = counted(len(request.cases) - len(missing), "case is", "cases are")
            self.log(f"{stored} stored, {len(missing)} to compute")
        check_kind(self.path, "study", self.log)
        is_same = first is not None and not differs and first["program"] == self.program.key
        if self.path.is_file() and not is_same:
            names = (f"{self.study.name}.before{number or ''}.nc" for number in itertools.count())
            self.aside = next(of for of in map(self.path.with_name, names) if not of.exists())
            self.path.replace(self.aside)
        elif self.path.is_file():
            stored_keys = set(read(self.path)["case_key"].values.astype(str).ravel())
            if foreign := len(stored_keys - {"", *request.cases}):
                stay = counted(foreign, "other case, which stays", "other cases, which stay")
                self.log(f"{self.path.name} held {stay} in {journal.path.name}")
        journal.start(
            self.study.name, self.provenance["history"], self.program.key,
            self.program.digests, request.first(),
        )  # fmt: skip
        if "times" in self.options.retry:
            journal.drop_times(map(self.key, request.cases))

    def _compare_aside(self) -> None:
        """Remove the file that was set aside if its results are those of the new one, or else report it."""
        if self.aside is None:
            return
        before, after = (
            dataset.drop_vars([name for name in dataset if is_time(str(name)) or name == "case_key"])
            for dataset in (read(self.aside), read(self.path))
        )
        if before.equals(after):
            self.aside.unlink()
        else:
            self.log(f"{self.path.name} held other results: they are kept in {self.aside.name}")

    def _other_programs(self, missing: Sequence[str]) -> Counter[str]:
        """Return the number of missing cases that are stored of another program, by what differs in it."""
        case_keys, program = set(missing), self.program
        last = {case: of for case, of in self.journal.cases if case in case_keys}
        counts = Counter(of for of in last.values() if of != program.key)
        named = Counter[str]()
        for of, count in counts.items():
            named[differences(self.journal.programs.get(of, {}), program.digests)] += count
        return named

    def _perform(self, tasks: Sequence[Task], activity: str, unit: str) -> None:
        """Compute the cases of tasks, or time them, each in the journal before it counts as done."""
        if not tasks:
            return
        seconds = 0.0
        with (
            closing(self._outcomes(tasks)) as outcomes,
            progress_of(self.study.name, activity, len(tasks), unit, self.log) as progress,
        ):
            for task, outcome in outcomes:
                key = self.key(task.key)
                if task.is_timed:
                    self.journal.add_time(key, outcome)
                    progress.update()
                    continue
                if outcome.fields:
                    write(xr.Dataset(dict(outcome.fields)), self.fields_path(task.key))
                self.journal.add(key, self.study.name, self.request.points[task.key], outcome)
                seconds += outcome.seconds
                if self.repeats:
                    timing = self.repeats * len(tasks) * seconds / (progress.n + 1)
                    progress.set_postfix_str(f"then {two_digits(timing)} s timing", refresh=False)
                progress.update()
                if monotonic() > self.next_write:
                    self.write()
        self.journal.sync()

    def _outcomes(self, tasks: Sequence[Task]) -> Outcomes:
        """Return an iterator over the tasks with their outcomes, as the options ask for."""
        untimed = self.journal.untimed  # the set grows while cases are computed
        timed = (task for task in tasks if self.key(task.key) not in untimed)
        if not (self.options.workers or self.options.scheduler):
            return self._here(timed if tasks[0].is_timed else tasks)
        # what computes is imported where it is needed
        from studies.engine.cluster import perform_on_workers
        from studies.engine.slot import pickled_settings

        settings = pickled_settings(self.settings, self.program)
        if tasks[0].is_timed:
            return self._apart(timed, settings)
        return perform_on_workers(
            tasks, settings, self.options.time_limit,
            self.stop, workers=min(self.options.workers, len(tasks)),
            address=self.options.scheduler, log=self.log,
        )  # fmt: skip

    def _here(self, tasks: Iterable[Task]) -> Outcomes:
        """Yield tasks with their outcomes, performed in this process; a signal is noticed between two.

        What is computed can be another program's only where something was imported, or a file read.
        """
        warm_up()
        program, checked, loaded = self.program, 0.0, len(sys.modules)
        seeds = random.getstate(), np.random.get_state()  # noqa: NPY002
        try:
            with threadpool_limits(1):
                for task in tasks:
                    with self.stop.interruptible():
                        outcome = perform(task, self.settings)
                    if len(sys.modules) != loaded or self.study.depends or monotonic() > checked + CHECK_SECONDS:
                        program.check()
                        checked, loaded = monotonic(), len(sys.modules)
                    yield task, outcome
            program.check()
        finally:
            random.setstate(seeds[0])
            np.random.set_state(seeds[1])  # noqa: NPY002

    def _apart(self, tasks: Iterable[Task], settings: bytes) -> Outcomes:
        """Yield the outcomes of timed runs in one process apart, since a case may die there although it did not before.

        There is no dask meanwhile: an idle one takes 3 % of a core.
        """
        from studies.engine.slot import Slot

        with Slot(settings) as slot:
            for task in tasks:
                # far beyond what a busy machine adds, so that only a case that hangs is given up
                limit = min(5 + 10 * (task.expected or 0.0), self.options.time_limit or float("inf"))
                try:
                    pickled = cloudpickle.dumps([task])
                except Exception as error:  # noqa: BLE001 (a study's class may do anything)
                    yield task, failed(error)
                    continue
                with self.stop.interruptible():
                    (outcome,) = slot.perform(pickled, 1, limit, "")
                yield task, outcome

    def _end(self) -> xr.Dataset:
        """Write the file, report the outcomes, and return the Dataset."""
        self.write()
        self._compare_aside()
        dataset = read(self.path)
        if "left_out" in dataset.attrs:
            self.log(f"left out: {dataset.attrs['left_out']}")
        for sentence in summary_messages(dataset):
            self.log(sentence)
        untimed = (self.journal.untimed.get(self.key(case)) for case in self.request.cases)
        if reasons := [reason for reason in untimed if reason]:
            self.log(
                f"{counted(len(reasons), 'case has', 'cases have')} no times, the first since {reasons[0]}; "
                "--retry times tries again"
            )
        self.log(f"wrote {self.path}")
        return dataset
