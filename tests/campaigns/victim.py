"""A run of plain numbers that is killed once: ``victim OUT TARGET SIGNAL PHASE COUNT WORKERS``.

At the ``COUNT``-th event of the ``PHASE`` the ``TARGET`` gets the signal, from the process that is at it, so
that nothing is left to chance. A marker on disk says that it was done: the next run goes through.
"""

import os
import sys
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import psutil
import xarray as xr

from studies.model.axis import Axis
from studies.model.drawing import CaptionedFigure, Drawing
from studies.model.study import Point, Study

CASES = 24


@dataclass(frozen=True)
class Kill:
    """When, whom, and with which signal; ``folder`` holds a line for each event, and the marker."""

    folder: str
    target: str
    signal: int
    phase: str
    count: int
    scheduler: int = 0

    def event(self, phase: str) -> None:
        """Something of this phase happens."""
        if phase != self.phase:
            return
        marker = Path(self.folder) / "killed"
        with (Path(self.folder) / phase).open("a") as file:
            file.write(".")
        if (Path(self.folder) / phase).stat().st_size < self.count:
            return
        try:
            marker.touch(exist_ok=False)
        except FileExistsError:
            return
        victims = {
            "parent": parent(),
            "worker": os.getpid(),
            "server": os.getppid(),
            "scheduler": self.scheduler,
        }
        os.kill(victims[self.target], self.signal)


def parent() -> int:
    """The process that drives the one that computes: this one itself in a run without workers."""
    line = (psutil.Process(), *psutil.Process().parents())
    return next(one.pid for one in line if "multiprocessing.forkserver" not in str(one.cmdline()))


@dataclass(frozen=True)
class Number:
    """A number to square; its second run is the one that is timed."""

    number: int
    kill: Kill = field(compare=False)

    def prepare(self) -> int:
        return self.number

    def run(self, prepared: int) -> int:
        log = Path(self.kill.folder) / f"case{prepared}"
        with log.open("a") as file:
            file.write(".")
        self.kill.event("solving" if log.stat().st_size == 1 else "timing")
        return prepared**2

    def record(self, result: int) -> Mapping[str, xr.Variable]:
        return {}


def measures(case: Number, result: int) -> Mapping[str, xr.Variable | float]:
    return {
        "square": float(result),
        "powers": xr.Variable(("power",), case.number ** np.arange(3.0), {"units": "1"}),
    }


def study(kill: Kill, numbers: object = range(CASES)) -> Study:
    def case_at(point: Point) -> Number:
        return Number(int(point["number"]), kill)

    axis = Axis("number", tuple(numbers), "what is squared")  # type: ignore[arg-type]
    return Study("victim", "Plain numbers.", (axis,), case_at, measures)


def main() -> None:
    """Run it, and draw it."""
    from studies.engine.options import RunOptions
    from studies.engine.run import run
    from studies.report import page
    from studies.store import netcdf

    out, target, signal, phase, count, workers, *rest = sys.argv[1:]
    folder = Path(out) / "events"
    folder.mkdir(parents=True, exist_ok=True)
    scheduler = rest[0] if rest else None
    pid = int(rest[1]) if rest else 0
    kill = Kill(str(folder), target, int(signal), phase, int(count), pid)
    write = netcdf.replacing

    def replacing(path: Path) -> object:
        kill.event("writing")
        return write(path)

    def figure(dataset: xr.Dataset) -> tuple[CaptionedFigure, ...]:
        from studies.report.style import panels

        shown, (ax,) = panels(1)
        ax.plot(dataset["number"], dataset["square"])
        kill.event("drawing")
        return (CaptionedFigure("squares", shown, "Squares."),)

    netcdf.replacing = replacing  # type: ignore[assignment]
    options = RunOptions(workers=int(workers), repeats=1, scheduler=scheduler)
    run(study(kill), Path(out), options=options)
    page.draw_figures(study(kill), Drawing(figure), Path(out))


if __name__ == "__main__":
    main()
