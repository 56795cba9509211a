"""Solution of a scene file in a terminal: progress, and what is kept after a stop."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path
from threading import Event, Thread
from typing import Self

import click
import numpy as np

import contactstudy as cs
from contactstudy.answers.answer import Answer
from contactstudy.domain.validation import readable
from studies.engine.progress import LINE_INTERVAL, bar_of, is_terminal
from studies.store.stop import Stop, StopRun

BAR = "{desc} {percentage:3.0f} %|{bar}|{postfix} [{elapsed}]"
LINE = "{desc}: {percentage:.0f} %{postfix}, {elapsed} so far"
# Seconds before a bar is shown, and between two updates of it.
FIRST, REFRESH = 2.0, 0.5


class SolveProgress:
    """Progress of a command on one scene, in a ``with`` statement: a bar in a terminal, elsewhere a line now and then.

    It is called with a :class:`~contactstudy.Progress`; what takes long without one is named by :attr:`job`.
    """

    def __init__(self, name: str) -> None:
        self.name, self.job = name, "plan"
        self.last: cs.Progress | None = None
        self._ended, self._thread = Event(), Thread(target=self._show, daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *raised: object) -> None:
        self._ended.set()
        self._thread.join()

    def __call__(self, progress: cs.Progress) -> None:
        """Take the progress of the solve."""
        self.last, self.job = progress, progress.text

    def _show(self) -> None:
        """Show the progress on a thread, until the block of the ``with`` statement ends."""
        first, interval = (FIRST, REFRESH) if is_terminal() else (LINE_INTERVAL, LINE_INTERVAL)
        if self._ended.wait(first):
            return
        # without any delay the bar would be shown before its position is set below
        about = {"total": 100, "desc": self.name, "delay": 1e-9, "leave": False}
        with bar_of(BAR, LINE, lambda text: click.echo(text, err=True), **about) as bar:
            bar.start_t -= first
            while True:
                bar.n = round(100 * self.last.fraction) if self.last else 0
                bar.set_postfix_str(self.job, refresh=False)
                bar.refresh()
                if self._ended.wait(interval):
                    return


def solve_with_progress(
    described: cs.SceneFile, scene: Path, folder: Path, start: Path | None, device: cs.Cpu | cs.Gpu, show: SolveProgress
) -> Answer:
    """Solve a scene file and show the progress.

    When the command is stopped, by Ctrl-C or another signal, the frames of a scene in time, or the pressure of a
    contact at rest, stay in `folder`, so that the solve can continue from there.
    """
    frames_folder = folder / f"{scene.stem}.evolution"
    if start is not None and described.scene.lubrication is not None:
        raise cs.InvalidInput(f"--start is {str(start)!r}, and a film does not begin from a pressure: leave it out.")
    first = None if start is None else pressure_in(start, described.grid)
    with Stop() as stop:
        try:
            with stop.interruptible():
                answer = described.solve(
                    start=first,
                    folder=frames_folder if "folder" in described.scene.method.keywords else None,
                    progress=show,
                    device=device,
                )
                show.job = "bounds and files"
                answer.quantities  # noqa: B018 (computed here, where a stop keeps the pressure: bounds take long)
        except StopRun:
            show.__exit__()
            click.echo(f"contactstudy: {_kept(show.last, scene, folder, frames_folder)}", err=True)
            assert stop.signal is not None
            sys.exit(128 + stop.signal)
    shutil.rmtree(frames_folder, ignore_errors=True)
    return answer


def _kept(last: cs.Progress | None, scene: Path, folder: Path, frames: Path) -> str:
    """Keep the frames or the pressure of a stopped solve, and return a sentence on how to go on from there."""
    from studies.store.netcdf import open_folder

    at = "stopped" if last is None else f"stopped at {last.text}"
    if frames.is_dir():
        return f"{at}; the same command goes on from there"
    if last is None or last.pressure is None:
        return f"{at}; nothing of this scene is kept, and the same command begins anew"
    path = _keep_stopped(last, open_folder(folder) / f"{scene.stem}.stopped.nc")
    return f"{at}; the same command with --start {path} goes on from there"


def _keep_stopped(stopped: cs.Progress, path: Path) -> Path:
    """Write the latest pressure [Pa] of a solve that was stopped."""
    import xarray as xr

    from contactstudy.io.dataset import X, Y, labelled
    from studies.store.netcdf import write

    assert stopped.grid is not None
    dataset = xr.Dataset(
        {"pressure": labelled(("x", "y"), stopped.pressure, "Pa", "contact pressure, not converged")},
        {"x": ("x", stopped.grid.x, X), "y": ("y", stopped.grid.y, Y)},
        {"title": "line contact, stopped before it converged", "comment": stopped.text},
    )  # fmt: skip
    write(dataset, path)
    return path


def pressure_in(path: Path, grid: cs.Grid | None) -> cs.Progress:
    """Return the pressure (x, y) [Pa] in a file of ``contactstudy solve``, as wide as a `grid` if one is given.

    It comes with its grid, whose length is that of `grid` where the file has one cell along.
    """
    from studies.store.netcdf import read_any

    dataset = read_any(path)
    if "pressure" not in dataset or dataset["pressure"].dims != ("x", "y"):
        raise cs.InvalidInput(f"--start is {str(path)!r}, which has no pressure over (x, y): give a solution.")
    x = dataset["x"].values
    width = (x[1] - x[0]) * len(x)
    if grid is not None and not np.isclose(width, grid.extent[0], rtol=1e-6, atol=0):
        given_width, widened = readable(grid.extent[0]), readable(width)
        raise cs.InvalidInput(
            f"--start is {str(path)!r}, {widened} wide, and the grid is {given_width}: give one as wide."
        )
    y, pressure = dataset["y"].values, np.asarray(dataset["pressure"].values, dtype=np.float64)
    length = width if grid is None else grid.length
    if len(y) > 1:
        length = (y[1] - y[0]) * len(y)
    return cs.Progress(0.0, str(path), pressure, cs.Grid(pressure.shape, (float(width), float(length))))
