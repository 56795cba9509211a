"""Twenty cases, sixteen of them good; without a contact, so that only the running of them takes time."""

import math
import os
import signal
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import xarray as xr

from studies.model.axis import Axis
from studies.model.study import Point, Study

RAISES, NAN, HANGS, DIES = 3, 7, 11, 15
SAYS = "this one"


@dataclass(frozen=True)
class Trouble:
    """A number to square, which may go wrong; ``log`` gets a line for each time it is computed.

    Numbers from ``hangs_from`` on never come to an end.
    """

    number: float
    offset: float = 0.0
    log: str = field(default="", compare=False)
    seconds: float = field(default=0.0, compare=False)
    hangs_from: float = field(default=math.inf, compare=False)

    def prepare(self) -> float:
        return self.number

    def run(self, prepared: float) -> float:
        if self.log:
            with Path(self.log).open("a", encoding="utf-8") as file:
                file.write(f"{self.number}\n")
        if self.seconds:
            time.sleep(self.seconds)
        if prepared == RAISES:
            raise ArithmeticError(SAYS)
        if prepared == HANGS or prepared >= self.hangs_from:
            time.sleep(1000)
        if prepared == DIES:
            os.kill(os.getpid(), getattr(signal, "SIGKILL", signal.SIGTERM))
        return prepared**2 + self.offset

    def record(self, result: float) -> Mapping[str, xr.Variable]:
        return {}


def _refuse(where: str) -> "Unsendable":
    raise TypeError("it holds an open file")


@dataclass(frozen=True)
class Unsendable(Trouble):
    """A case that cannot be pickled, or that cannot be read again."""

    where: str = "written"

    def __reduce__(self) -> tuple[object, ...]:
        if self.where == "written":
            _refuse(self.where)
        return _refuse, (self.where,)


def measures(case: Trouble, result: float) -> Mapping[str, xr.Variable | float]:
    label = {"units": "1", "long_name": "its powers"}
    return {
        "square": np.nan if case.number == NAN else result,
        "third": result / 3,
        "powers": xr.Variable(("power",), result ** np.arange(3) / 7, label),
    }


def process(case: Trouble, result: float) -> dict[str, float]:
    """In which process it was computed."""
    return {"process": os.getpid()}


def parent_process(case: Trouble, result: float) -> dict[str, float]:
    """In which process it was computed, or of which that one is a fork."""
    with Path(f"/proc/{os.getpid()}/cmdline").open("rb") as file:
        is_fork = Path(f"/proc/{os.getppid()}/cmdline").read_bytes() == file.read()
    return {"process": os.getppid() if is_fork else os.getpid()}


def study(
    numbers: object = range(20), log: str = "", seconds: float = 0.0, hangs_from: float = math.inf
) -> Study:
    def case_at(point: Point) -> Trouble:
        return Trouble(float(point["number"]), log=log, seconds=seconds, hangs_from=hangs_from)

    axis = Axis("number", tuple(float(n) for n in numbers), "what is squared")  # type: ignore[attr-defined]
    return Study("trouble", "Twenty cases.", (axis,), case_at, measures)


RAISING_LINE = 1 + Path(__file__).read_text(encoding="utf-8").split("\n").index(
    "            raise ArithmeticError(SAYS)"
)
