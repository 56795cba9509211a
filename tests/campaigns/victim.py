"""A run of plain numbers that is killed once: ``victim OUT TARGET SIGNAL PHASE COUNT WORKERS``.

At the ``COUNT``-th event of the ``PHASE`` the ``TARGET`` gets the signal, from the process that is at it, so
that nothing is left to chance. A marker on disk says that it was done: the next run goes through.
"""

import os
import sys
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import psutil
import xarray as xr

from studies.model.drawing import CaptionedFigure, Drawing
from studies.model.study import Study
from tests.studies.engine.trouble import Square, study_of

CASES = 24


@dataclass(frozen=True)
class Kill:
    """When, whom, and with which signal; ``folder`` holds a line for each event, and the marker."""

    folder: str
    target: str
    signal: int
    phase: str
    count: int

    def event(self, phase: str) -> None:
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
        victims = {"parent": parent(), "worker": os.getpid(), "server": os.getppid()}
        os.kill(victims[self.target], self.signal)


def parent() -> int:
    """The process that drives the one that computes: this one itself in a run without workers."""
    line = (psutil.Process(), *psutil.Process().parents())
    return next(one.pid for one in line if "multiprocessing.forkserver" not in str(one.cmdline()))


@dataclass(frozen=True)
class Number(Square):
    """A number to square; its second run is the one that is timed."""

    kill: Kill = field(compare=False)

    def run(self, prepared: float) -> float:
        log = Path(self.kill.folder) / f"case{prepared:g}"
        with log.open("a") as file:
            file.write(".")
        self.kill.event("solving" if log.stat().st_size == 1 else "timing")
        return super().run(prepared)


def measures(case: Number, result: float) -> Mapping[str, xr.Variable | float]:
    powers = case.number ** np.arange(3.0)
    return {"square": result, "powers": xr.Variable(("power",), powers, {"units": "1"})}


def study(kill: Kill, numbers: Iterable[float] = range(CASES)) -> Study:
    return replace(study_of(lambda number: Number(number, kill), numbers, measures), name="victim")


def main() -> None:
    from studies.engine.options import RunOptions
    from studies.engine.run import run
    from studies.report import page
    from studies.store import netcdf

    out, target, signal, phase, count, workers = sys.argv[1:]
    folder = Path(out) / "events"
    folder.mkdir(parents=True, exist_ok=True)
    kill = Kill(str(folder), target, int(signal), phase, int(count))
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
    options = RunOptions(workers=int(workers), repeats=1)
    run(study(kill), Path(out), options=options)
    page.draw_figures(study(kill), Drawing(figure), Path(out))


if __name__ == "__main__":
    main()
