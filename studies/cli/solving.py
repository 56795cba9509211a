"""Solution of a scene file in a terminal: progress, the pressure kept after a stop, and the outcome."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from math import isfinite, log
from pathlib import Path
from typing import TYPE_CHECKING

import click
import numpy as np
from tqdm import tqdm

import contactstudy as cs
from contactstudy.domain.fields import Array

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from contactstudy.io.summary import Quantity

TIME_BAR = "{desc} {n:.3g} s of {total:.3g} s |{bar}| {elapsed}<{remaining}"
RESIDUAL_BAR = "{desc} {percentage:3.0f} %|{bar}| {postfix} [{elapsed}]"


@dataclass(frozen=True)
class SceneOutcome:
    """Result of a scene: status, numbers to print, notes, the dataset to store and its picture.

    ``done`` is called when the dataset is stored.
    """

    status: cs.Status | cs.FilmStatus
    numbers: list[Quantity]
    notes: list[str]
    dataset: xr.Dataset
    picture: Callable[[], Figure] | None
    done: Callable[[], object] = bool


class SolveProgress:
    """Progress of a solve: its residual beside the tolerance, and its latest pressure, dimensionless."""

    def __init__(self, tolerance: float, bar: tqdm[None]) -> None:
        self.tolerance, self._bar = tolerance, bar
        self.residual = float("inf")
        self.pressure: Array | None = None
        self.iterations = 0
        self._first: float | None = None

    def see(self, residual: float, pressure: Array) -> None:
        """Take the residual and the pressure after an iteration."""
        self.pressure = pressure
        self.residual, self.iterations = residual, self.iterations + 1
        if not isfinite(residual) or residual <= 0:
            return
        if self._first is None:
            self._first = max(residual, 10 * self.tolerance)
        share = log(self._first / residual) / log(self._first / self.tolerance)
        self._bar.n = round(100 * min(max(share, 0.0), 1.0))
        self._bar.set_postfix_str(f"residual {residual:.1e} of {self.tolerance:.1e}", refresh=False)
        self._bar.update(0)


@contextmanager
def progress(name: str, tolerance: float) -> Iterator[SolveProgress]:
    """Show the progress of a solve as a bar if the output is a terminal."""
    with tqdm(
        total=100, desc=name, bar_format=RESIDUAL_BAR, disable=None, leave=False, delay=1
    ) as bar:
        yield SolveProgress(tolerance, bar)


def still(
    described: cs.SceneFile,
    planned: cs.Plan | None,
    scene: Path,
    folder: Path,
    *,
    start: Path | None,
    on: cs.Cpu | cs.Gpu,
) -> SceneOutcome:
    """Solve a scene that neither changes nor rolls; a solve that is stopped leaves its pressure in the folder."""
    from contactstudy.solvers.solve import Watched

    begin = None if start is None else pressure_in(start)
    with progress(str(scene), described.settings.tolerance) as watch:
        options = replace(described.settings, solver=Watched(watch.see, described.settings.solver))
        problem = described.problem(planned)
        try:
            solution = options.solved(problem, begin, on)
        except KeyboardInterrupt:
            if watch.pressure is None:
                raise
            path = _keep_stopped(watch, problem, folder / f"{scene.stem}.stopped.nc")
            click.echo(
                f"contactstudy: stopped at a residual of {watch.residual:.1e} after {watch.iterations} iterations; "
                f"go on with contactstudy solve {scene} --start {path}",
                err=True,
            )
            sys.exit(130)
    return _of_solution(solution)


def rolled(described: cs.SceneFile, planned: cs.Plan | None) -> SceneOutcome:
    """Solve a scene that rolls steadily."""
    from contactstudy.io.summary import rolling_quantities

    rolling = described.roll(planned)
    outcome = _of_solution(rolling.solution, rolling_quantities(rolling))
    settled = rolling.settled
    note = f"rolling: {settled.passes} passes to a change of {settled.change:.1e}"
    return replace(outcome, notes=[note, *outcome.notes])


def flooded(described: cs.SceneFile, planned: cs.Plan | None) -> SceneOutcome:
    """Solve a lubricated scene."""
    from contactstudy.io.summary import film_quantities

    contact = described.lubricate(planned)
    nx, ny = contact.grid.cells
    notes = [f"{nx} x {ny} cells, {contact.iterations} iterations, residual {contact.residual:.1e}"]
    if contact.error is not None and contact.error.reason:
        notes.append(f"warning: {contact.error.reason}")
    return SceneOutcome(
        contact.status, film_quantities(contact), notes, contact.to_dataset(), contact.plot
    )


def _of_solution(solution: cs.Solution, others: list[Quantity] | None = None) -> SceneOutcome:
    """Return the outcome of a solution, with the numbers of `others` in its dataset."""
    from contactstudy.io.dataset import with_numbers
    from contactstudy.io.pictures.contact import picture
    from contactstudy.io.summary import quantities

    estimate = cs.error_estimate(solution)
    dataset = cs.to_dataset(solution, estimate)
    numbers = quantities(solution, estimate, dataset.get("von_mises")) + (others or [])
    dataset = with_numbers(dataset, numbers)
    cells = solution.pressure.shape
    notes = [
        f"{cells[0]} x {cells[1]} cells, {solution.iterations} iterations, residual {solution.residual:.1e}",
        *([solution.note] if solution.note else []),
        *(
            f"error of the {what} <= {parts.total:.1g}: truncation {parts.truncation:.1g}, discretisation "
            f"{parts.discretisation:.1g}, residual {parts.residual:.1g}"
            for what, parts in (
                ("peak pressure", estimate.peak_pressure),
                ("pressure in L1", estimate.l1),
            )
        ),
        *(f"warning: {warning}" for warning in estimate.warnings),
    ]
    finite = np.isfinite(solution.pressure).all()
    return SceneOutcome(
        solution.status, numbers, notes, dataset, (lambda: picture(dataset)) if finite else None
    )


def _keep_stopped(seen: SolveProgress, problem: cs.Problem, path: Path) -> Path:
    """Write the latest pressure [Pa] of a solve that was stopped."""
    import xarray as xr

    from contactstudy.io.dataset import X, Y, labelled
    from studies.store.netcdf import write

    pressure = np.asarray(seen.pressure, dtype=np.float64) * problem.scales.pressure
    stopped = xr.Dataset(
        {
            "pressure": labelled(("x", "y"), pressure, "Pa", "contact pressure, not converged"),
            "residual": labelled((), seen.residual, "1", "residual of the solver"),
        },
        {"x": ("x", problem.grid.x, X), "y": ("y", problem.grid.y, Y)},
        {"title": "line contact, stopped before it converged"},
    )
    write(stopped, path)
    return path


def pressure_in(path: Path) -> Array:
    """Return the pressure (x, y) [Pa] in a file that ``contactstudy solve`` wrote."""
    from studies.store.netcdf import read_any

    dataset = read_any(path)
    if "pressure" not in dataset or dataset["pressure"].dims != ("x", "y"):
        raise cs.InvalidInput(
            f"--start is {str(path)!r}, which has no pressure over (x, y): give a file that contactstudy solve wrote."
        )
    return np.asarray(dataset["pressure"].values, dtype=np.float64)


@contextmanager
def _time_bar() -> Iterator[Callable[[float, float], None]]:
    """Show a bar over time in a terminal, and give what moves it."""
    with tqdm(total=1.0, unit="", desc="time", bar_format=TIME_BAR, disable=None) as bar:

        def show(time: float, end: float) -> None:
            bar.total = end
            bar.n = time
            bar.refresh()

        yield show


def flooded_march(described: cs.SceneFile, planned: cs.Plan | None) -> SceneOutcome:
    """March through a lubricated scene that changes in time."""
    from contactstudy.io.pictures.evolution import film_evolution_picture
    from contactstudy.io.summary import film_march_quantities

    with _time_bar() as show:
        evolution = described.evolve(planned, progress=show)
    assert isinstance(evolution, cs.FilmEvolution)
    dataset = evolution.to_dataset()
    nx, ny = evolution.contacts[0].grid.cells
    notes = [
        f"{nx} x {ny} cells, {len(evolution.times)} instants, {evolution.steps} steps, {evolution.iterations} iterations"
    ]
    return SceneOutcome(
        evolution.status,
        film_march_quantities(evolution),
        notes,
        dataset,
        lambda: film_evolution_picture(dataset),
    )


def marched(
    described: cs.SceneFile, planned: cs.Plan | None, scene: Path, folder: Path
) -> SceneOutcome:
    """March through a scene that changes in time.

    Frames are kept in a folder until the outcome is stored, so that a command that was stopped goes on from there.
    """
    from contactstudy.io.pictures.evolution import evolution_picture
    from contactstudy.io.summary import march_quantities

    march = folder / f"{scene.stem}.march"
    with _time_bar() as show:
        evolution = described.evolve(planned, folder=march, progress=show)
    dataset = evolution.to_dataset()
    summary = evolution.summary().splitlines()[1:]
    cells = f"{evolution.grid.cells[0]} x {evolution.grid.cells[1]} cells"
    return SceneOutcome(
        evolution.status,
        march_quantities(evolution),
        [cells, *(line.strip() for line in summary if "at the end" not in line)],
        dataset,
        lambda: evolution_picture(dataset),
        lambda: shutil.rmtree(march),
    )
