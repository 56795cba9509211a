"""Progress of a solve or a march in a terminal, and the state written when it is stopped."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from math import isfinite, log
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING

import click
import numpy as np
from tqdm import tqdm

import contactstudy as cs
from contactstudy import InvalidInput
from contactstudy.domain.fields import Array

if TYPE_CHECKING:
    import xarray as xr


class Progress:
    """Progress of a residual towards ``tolerance``, with the last dimensionless pressure."""

    def __init__(self, tolerance: float, bar: tqdm[None]) -> None:
        self.tolerance, self._bar = tolerance, bar
        self.residual = float("inf")
        self.pressure: Array | None = None
        self.iterations = 0
        self._first: float | None = None

    def see(self, residual: float, pressure: Array) -> None:
        """Record the next residual and pressure, and move the bar."""
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
def progress(name: str, tolerance: float) -> Iterator[Progress]:
    """Show a bar on a terminal, and none elsewhere."""
    from tqdm import tqdm

    layout = "{desc} {percentage:3.0f} %|{bar}| {postfix} [{elapsed}]"
    with tqdm(total=100, desc=name, bar_format=layout, disable=None, leave=False, delay=1) as bar:
        yield Progress(tolerance, bar)


def stopped(seen: Progress, unit: float, like: xr.Dataset) -> xr.Dataset:
    """Return the pressure so far [Pa], with the coordinates and attributes of ``like``."""
    assert seen.pressure is not None
    labels = {"units": "Pa", "long_name": "contact pressure, not converged"}
    values = np.asarray(seen.pressure, dtype=np.float64) * unit
    dataset = like[["x", "y"]].assign(pressure=(("x", "y"), values, labels))
    residual = {"units": "1", "long_name": "residual of the solver"}
    return dataset.assign(residual=((), seen.residual, residual)).assign_attrs(
        title="line contact, stopped before it converged"
    )


def pressure_in(path: Path) -> Array:
    """Return the pressure (x, y) [Pa] in a file that ``contactstudy solve`` wrote."""
    from studies.store.netcdf import read_any

    dataset = read_any(path)
    if "pressure" not in dataset or dataset["pressure"].dims != ("x", "y"):
        raise InvalidInput(
            f"--start is {str(path)!r}, which has no pressure over (x, y): give a file that contactstudy solve wrote."
        )
    return np.asarray(dataset["pressure"].values, dtype=np.float64)


def evolve(scene: Path, described: cs.SceneFile, planned: cs.Plan | None, folder: Path) -> None:
    """March through the scene; write its frames as netCDF and a picture.

    What is found is kept in a folder beside them until the march is complete, so that a command that
    was stopped goes on from there. The exit code is 0 where every step converged, else 1.
    """
    from contactstudy.domain.files import replacing
    from contactstudy.io.pictures.evolution import evolution_picture
    from studies.store.netcdf import write

    march = folder / f"{scene.stem}.march"
    start = perf_counter()
    with tqdm(total=1.0, unit="", desc="time", bar_format=BAR, disable=None) as bar:

        def progress(time: float, end: float) -> None:
            bar.total = end
            bar.n = time
            bar.refresh()

        evolution = described.evolve(planned, folder=march, progress=progress)
    seconds = perf_counter() - start
    dataset = evolution.to_dataset()
    path = folder / f"{scene.stem}.nc"
    write(dataset, path)
    figure = evolution_picture(dataset)
    for suffix in ("png", "pdf"):
        with replacing(folder / f"{scene.stem}.{suffix}") as partial:
            figure.savefig(partial)
    shutil.rmtree(march)
    click.echo(f"{scene}: {evolution.summary()}")
    cells = evolution.grid.cells
    click.echo(f"  {cells[0]} x {cells[1]} cells, {seconds:.2g} s")
    click.echo(f"  wrote {path} and {path.with_suffix('.png')}")
    if evolution.status is not cs.Status.CONVERGED:
        sys.exit(1)


BAR = "{desc} {n:.3g} s of {total:.3g} s |{bar}| {elapsed}<{remaining}"
