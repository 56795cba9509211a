"""Twenty cases, sixteen of them good; without a contact, so that only the running of them takes time."""

import math
import os
import signal
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from studies.engine.cluster import perform_on_workers
from studies.engine.compute import Task
from studies.engine.slot import pickled_settings
from studies.model.axis import Axis
from studies.model.outcome import Outcome, RunSettings
from studies.model.study import Study
from studies.store.program import Program
from studies.store.stop import Stop

RAISES, NAN, HANGS, DIES = 3, 7, 11, 15


@dataclass(frozen=True)
class Square:
    number: float

    def prepare(self) -> float:
        return self.number

    def run(self, prepared: float) -> float:
        return prepared**2

    def record(self, result: float) -> Mapping[str, xr.Variable]:
        return {}


@dataclass(frozen=True)
class Trouble(Square):
    """It may go wrong; ``log`` gets a line for each time it is computed.

    Numbers from ``hangs_from`` on never come to an end.
    """

    log: str = field(default="", compare=False)
    seconds: float = field(default=0.0, compare=False)
    hangs_from: float = field(default=math.inf, compare=False)

    def run(self, prepared: float) -> float:
        if self.log:
            with Path(self.log).open("a", encoding="utf-8") as file:
                file.write(f"{self.number}\n")
        if self.seconds:
            time.sleep(self.seconds)
        if prepared == RAISES:
            raise ArithmeticError("this one")
        if prepared == HANGS or prepared >= self.hangs_from:
            time.sleep(1000)
        if prepared == DIES:
            os.kill(os.getpid(), getattr(signal, "SIGKILL", signal.SIGTERM))
        return super().run(prepared)


def refuse() -> Any:
    raise TypeError("it holds an open file")


@dataclass(frozen=True)
class Unsendable(Trouble):
    """A case that cannot be pickled, or that cannot be read again."""

    where: str = "written"

    def __reduce__(self) -> tuple[object, ...]:
        return (refuse, ()) if self.where == "read" else refuse()


def measures(case: Trouble, result: float) -> Mapping[str, xr.Variable | float]:
    powers = xr.Variable(("power",), result ** np.arange(3) / 7)
    return {"square": np.nan if case.number == NAN else result, "powers": powers}


def study(numbers: Iterable[float] = range(20), log: str = "", **given: Any) -> Study:
    return study_of(lambda number: Trouble(number, log=log, **given), numbers)


def study_of(
    case: Callable[[float], Square],
    numbers: Iterable[float],
    measures: Callable[..., Any] = measures,
    times: str = "taken",
) -> Study:
    axis = Axis("number", tuple(map(float, numbers)), "what is squared")
    return Study("trouble", "Cases.", (axis,), lambda point: case(float(point["number"])), measures, times)


def compute(cases: Sequence[Square], **options: Any) -> list[Outcome]:
    """By dask: here, or at an address."""
    tasks = [Task(f"{place:08x}", case) for place, case in enumerate(cases)]
    with Stop() as stop:
        done = perform_on_workers(tasks, settings_of(measures), None, stop, **options)
        outcomes = {task.key: outcome for task, outcome in done}
    return [outcomes[task.key] for task in tasks]


def settings_of(measures: Callable[..., Any], case: Square | None = None) -> bytes:
    program = Program.of(study([1]), case or Trouble(1.0), {})
    return pickled_settings(RunSettings(measures), program)


def lines(path: Path) -> list[str]:
    """Of the log of cases, or of a journal; none before there is one."""
    return path.read_text(encoding="utf-8").splitlines() if path.exists() else []
