"""The commands for one scene in a file: ``contactstudy plan`` and ``contactstudy solve``."""

from __future__ import annotations

import json
import os
import sys
from dataclasses import asdict, replace
from pathlib import Path
from time import perf_counter

import click
import numpy as np

import contactstudy as cs
from studies.model.plain_text import thread_count

SCENE = click.argument("scene", type=click.Path(path_type=Path))
THREADS = click.option(
    "--threads",
    type=click.IntRange(min=1),
    help="Threads to solve on.  [default: the cores there are]",
)
DEVICE = click.option(
    "--device",
    type=click.Choice(["cpu", "gpu"]),
    default="cpu",
    show_default=True,
    help="What to solve on: this machine's processor, or its graphics processor (extra gpu).",
)
# A plan that takes longer or more memory than this is announced before it runs.
LONG, LARGE = 60.0, 4e9


@click.command()
@SCENE
@THREADS
@DEVICE
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object, for scripts.")
def plan(scene: Path, threads: int | None, device: str, as_json: bool) -> None:  # noqa: FBT001 (click's own way)
    """Print the grid and padding that the scene in the TOML file SCENE needs, and its estimated cost."""
    described = cs.read_scene(scene)
    planned = described.plan(on=_device(device, threads))
    if as_json:
        fields = asdict(planned) | {"padding": repr(planned.padding), "on": repr(planned.on)}
        click.echo(json.dumps(fields))
        return
    cells, extent = planned.grid.cells, planned.grid.extent
    click.echo(f"{scene}: {cells[0]} x {cells[1]} cells over {extent[0]:.4g} m x {extent[1]:.4g} m")
    for reason in planned.reasons:
        click.echo(f"  {reason}")
    click.echo(f"  period: {planned.period_check}")
    on = thread_count(planned.on.threads) if isinstance(planned.on, cs.Cpu) else repr(planned.on)
    click.echo(
        f"  estimated: error {planned.error:.1g}, {planned.seconds:.2g} s on {on}, {planned.bytes / 1e6:.3g} MB"
    )
    for warning in planned.warnings:
        click.echo(f"  warning: {warning}")
    for number, shape in enumerate(described.scene.shapes):
        if isinstance(shape, cs.Roughness) and shape.extent is None and shape.rms:
            width, length = planned.grid.extent
            click.echo(
                f"  note: shapes[{number}] takes its extent from the grid, so that a grid of another width or "
                f"period is another surface: give it extent = [{width:.6g}, {length:.6g}] to keep this one"
            )


def _rolled(described: cs.SceneFile, planned: cs.Plan | None) -> cs.Solution:
    """Of a contact that rolls."""
    rolled = described.roll(planned)
    click.echo(
        f"rolling: {rolled.settled.passes} passes to a change of {rolled.settled.change:.1e}; centroid "
        f"{rolled.shift:.4g} m ahead, resistance {rolled.resistance:.4g} of the load"
    )
    return rolled.solution


@click.command()
@SCENE
@click.option(
    "--out",
    type=click.Path(path_type=Path, file_okay=True),
    default=Path("outputs"),
    show_default=True,
    help="Folder for the netCDF file and the picture.",
)
@THREADS
@DEVICE
@click.option(
    "--start",
    type=click.Path(path_type=Path),
    help="A file with a pressure to go on from, such as one that a stopped solve left.",
)
def solve(scene: Path, out: Path, threads: int | None, device: str, start: Path | None) -> None:
    """Solve the scene in the TOML file SCENE; write its fields as netCDF and a picture of them.

    The exit code is 0 if the solution converged, else 1; the result is written in both cases.
    """
    from contactstudy.domain.files import replacing
    from studies.store.netcdf import check_kind, open_folder, write
    from studies.store.provenance import provenance

    on = _device(device, threads)
    described = cs.read_scene(scene)
    moving = described.scene.rolling is not None or described.scene.changing is not None
    if moving and not isinstance(on, cs.Cpu):
        raise cs.InvalidInput(
            "--device gpu is for a scene that neither changes in time nor rolls: leave it out."
        )
    folder = open_folder(out)
    check_kind(folder / f"{scene.stem}.nc", "solution")
    planned = None if described.scene.hertz is None else described.plan(on=on)
    if planned is not None:
        for warning in planned.warnings:
            click.echo(f"{scene}: warning: {warning}", err=True)
        if planned.seconds > LONG or planned.bytes > LARGE:
            click.echo(
                f"{scene}: estimated cost: {planned.seconds:.2g} s and "
                f"{planned.bytes / 1e9:.2g} GB",
                err=True,
            )
    if described.scene.rolling is None and described.scene.changing is not None:
        from studies.cli.progress import evolve

        evolve(scene, described, planned, folder)
        return
    begin = perf_counter()
    if described.scene.rolling is not None:
        if start is not None:
            raise cs.InvalidInput("--start is for a scene that does not roll: leave it out.")
        solution = _rolled(described, planned)
    else:
        solution = _solved(described, planned, start, scene, folder, on)
    seconds = perf_counter() - begin
    estimate = cs.error_estimate(solution)
    dataset = cs.to_dataset(solution, estimate)
    dataset.attrs.update(provenance())
    path = folder / f"{scene.stem}.nc"
    write(dataset, path)
    from contactstudy.io.pictures.contact import picture

    if np.isfinite(solution.pressure).all():
        figure = picture(dataset)
        for suffix in ("png", "pdf"):
            with replacing(folder / f"{scene.stem}.{suffix}") as partial:
                figure.savefig(partial)
    cells = solution.pressure.shape
    click.echo(f"{scene}: {solution.status}")
    if solution.note:
        click.echo(f"  {solution.note}")
    click.echo(
        f"  {cells[0]} x {cells[1]} cells, {solution.iterations} iterations, "
        f"residual {solution.residual:.1e}, {seconds:.2g} s"
    )
    click.echo(
        f"  peak pressure {solution.pressure.max():.4g} Pa, in contact "
        f"{np.mean(solution.pressure > 0) * solution.problem.grid.extent[0]:.4g} m of the width on the "
        f"mean, approach {solution.approach:.4g} m"
    )
    for what, parts in (
        ("peak pressure", estimate.peak_pressure),
        ("pressure in L1", estimate.l1),
        ("contact area", estimate.contact_area),
        ("mean gap", estimate.mean_gap),
    ):
        click.echo(
            f"  estimated error of the {what} <= {parts.total:.1g}: truncation {parts.truncation:.1g}, "
            f"discretisation {parts.discretisation:.1g}, residual {parts.residual:.1g}"
        )
    for warning in estimate.warnings:
        click.echo(f"  warning: {warning}")
    click.echo(f"  wrote {path} and {path.with_suffix('.png')}")
    if solution.status is not cs.Status.CONVERGED:
        sys.exit(1)


def _device(name: str, threads: int | None) -> cs.Cpu | cs.Gpu:
    """The device of that name."""
    if name == "cpu":
        return cs.Cpu(threads or _cores())
    if threads is not None:
        raise cs.InvalidInput("--threads is for --device cpu: leave one of them out.")
    return cs.Gpu()


def _cores() -> int:
    """The cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _solved(
    described: cs.SceneFile,
    planned: cs.Plan | None,
    start: Path | None,
    scene: Path,
    folder: Path,
    on: cs.Cpu | cs.Gpu,
) -> cs.Solution:
    """The solution, with a bar on the way; where it is stopped, the pressure so far is written."""
    import xarray as xr

    from contactstudy.io.dataset import X, Y
    from contactstudy.solvers.solve import Watched
    from studies.cli.progress import pressure_in, progress, stopped
    from studies.store.netcdf import write

    begin = None if start is None else pressure_in(start)
    settings = described.settings
    with progress(str(scene), settings.tolerance) as seen:
        watched = replace(settings, solver=Watched(seen.see, settings.solver))
        problem = described.problem(planned)
        try:
            solution = watched.solved(problem, begin, on)
        except KeyboardInterrupt:
            if seen.pressure is None:
                raise
            grid = problem.grid
            like = xr.Dataset(coords={"x": ("x", grid.x, X), "y": ("y", grid.y, Y)})
            path = folder / f"{scene.stem}.stopped.nc"
            write(stopped(seen, problem.scales.pressure, like), path)
            click.echo(
                f"contactstudy: stopped at a residual of {seen.residual:.1e} after {seen.iterations} iterations; "
                f"go on with contactstudy solve {scene} --start {path}",
                err=True,
            )
            sys.exit(130)
    return solution
