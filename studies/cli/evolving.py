"""What ``contactstudy solve`` does with a scene that changes in time."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path
from time import perf_counter

import click
from tqdm import tqdm

import contactstudy as cs


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
