"""Solution of a scene file in a terminal: progress, and what is kept after a stop."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

import click
import numpy as np
from tqdm import tqdm

import contactstudy as cs
from contactstudy.answers.answer import Answer
from contactstudy.domain.fields import Array

BAR = "{desc} {percentage:3.0f} %|{bar}| {postfix} [{elapsed}]"


def solve_with_progress(
    described: cs.SceneFile, scene: Path, folder: Path, start: Path | None, device: cs.Cpu | cs.Gpu
) -> Answer:
    """Solve a scene file and show the progress.

    When the command is stopped, the frames of a scene in time, or the pressure of a contact at rest, stay in `folder`,
    so that the solve can continue from there.
    """
    frames_folder = folder / f"{scene.stem}.evolution"
    last: list[cs.Progress] = []
    with tqdm(
        total=100, desc=str(scene), bar_format=BAR, disable=None, leave=False, delay=1
    ) as bar:

        def show(progress: cs.Progress) -> None:
            last[:] = [progress]
            bar.n = round(100 * progress.fraction)
            bar.set_postfix_str(progress.text, refresh=False)
            bar.update(0)

        try:
            answer = described.solve(
                start=None if start is None else pressure_in(start),
                folder=frames_folder if described.scene.supports_checkpoints else None,
                progress=show,
                device=device,
            )
        except KeyboardInterrupt:
            from studies.store.netcdf import open_folder

            if last and frames_folder.is_dir():
                click.echo(
                    f"contactstudy: stopped at {last[0].text}; the same command goes on from there",
                    err=True,
                )
                sys.exit(130)
            if not last or last[0].pressure is None:
                raise
            path = _keep_stopped(last[0], open_folder(folder) / f"{scene.stem}.stopped.nc")
            click.echo(
                f"contactstudy: stopped at {last[0].text}; go on with contactstudy solve {scene} --start {path}",
                err=True,
            )
            sys.exit(130)
    shutil.rmtree(frames_folder, ignore_errors=True)
    return answer


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


def pressure_in(path: Path) -> Array:
    """Return the pressure (x, y) [Pa] in a file that ``contactstudy solve`` wrote."""
    from studies.store.netcdf import read_any

    dataset = read_any(path)
    if "pressure" not in dataset or dataset["pressure"].dims != ("x", "y"):
        raise cs.InvalidInput(
            f"--start is {str(path)!r}, which has no pressure over (x, y): give a file that contactstudy solve wrote."
        )
    return np.asarray(dataset["pressure"].values, dtype=np.float64)
