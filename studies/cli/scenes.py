"""The commands for one scene in a file: ``contactstudy new``, ``contactstudy plan`` and ``contactstudy solve``."""

from __future__ import annotations

import json
import os
import sys
from dataclasses import asdict, replace
from importlib.resources import files as package_files
from math import inf, isinf
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING

import click

import contactstudy as cs
from contactstudy.answers.answer import surface_notes
from contactstudy.domain.errors import Request
from contactstudy.domain.grid import cells_text
from contactstudy.domain.validation import checked_errors, readable, suggestion
from studies.cli.options import FORMAT, JSON, PICTURES, SCENE, echo, formats_in, out_option
from studies.model.drawing import write_figure
from studies.model.plain_text import counted, two_digits

if TYPE_CHECKING:
    from contactstudy.answers.answer import Answer

THREADS = click.option(
    "--threads", type=click.IntRange(min=1), help="Threads to solve on.  [default: the cores there are]"
)
DEVICE = click.option(
    "--device", type=click.Choice(["cpu", "gpu"]), default="cpu", help="This machine's CPU, or its GPU (extra gpu)."
)
REQUEST = click.option(
    "--error",
    callback=lambda _context, _option, value: value and checked_errors("--error", value),
    help="Relative error of every number, such as '2 %', or of some: 'peak_pressure = 2 %, von_mises = 5 %'.",
)
# A plan that takes longer or more memory than this is announced before it runs.
LONG, LARGE = 60.0, 4e9


@click.command()
@click.argument("kind", required=False)
@click.option("--out", type=click.Path(path_type=Path), help="File to write.  [default: KIND.toml]")
def new(kind: str | None, out: Path | None) -> None:
    """Write a commented scene of a KIND, such as roller, or coating, which is a sweep; without a KIND list all.

    plan, solve and run take it. No file is replaced.
    """
    scenes = templates() | templates("chapters")
    if kind is None:
        width = max(map(len, scenes))
        for name, text in scenes.items():
            click.echo(f"{name:<{width}}  {text.splitlines()[0].removeprefix('# ')}")
        return
    if kind not in scenes:
        raise cs.InvalidInput(f"KIND is {kind!r}: {suggestion(kind, scenes)}.")
    path = out or Path(f"{kind}.toml")
    try:
        with path.open("x", encoding="utf-8") as file:
            file.write(scenes[kind].replace(f"{kind}.toml", path.name))
    except FileExistsError:
        raise cs.InvalidInput(f"{path} exists already: give another file with --out.") from None
    except OSError as error:
        raise cs.InvalidInput(f"{path} cannot be written ({error.strerror}): give another file with --out.") from None
    verb = "run {0} runs its sweep" if "[vary]" in scenes[kind] else "solve {0} solves it"
    click.echo(f"wrote {path}: contactstudy {verb.format(path)}")


def templates(name: str = "templates") -> dict[str, str]:
    """Return the texts of the scenes in a folder of the package by their kinds, in the order of the alphabet."""
    folder = package_files("studies") / name
    names = sorted(entry.name for entry in folder.iterdir() if entry.name.endswith(".toml"))
    return {name.removesuffix(".toml"): (folder / name).read_text(encoding="utf-8") for name in names}


@click.command()
@SCENE
@REQUEST
@THREADS
@DEVICE
@JSON
def plan(scene: Path, error: Request | None, threads: int | None, device: str, form: str) -> None:
    """Print the grid and padding that SCENE needs, and the cost.

    SCENE is a TOML file.
    """
    from studies.cli.solving import SolveProgress

    described = _with_error(cs.read_scene(scene), error)
    with SolveProgress(str(scene)):
        planned = described.plan(device=_device(device, threads))
    if form == "json":
        fields = {name: value for name, value in vars(planned).items() if name not in {"scene", "first_grids"}}
        fields |= {name: repr(fields[name]) for name in ("padding", "device")} | {"grid": asdict(planned.grid)}
        # JSON has no infinity
        click.echo(json.dumps({name: None if value == inf else value for name, value in fields.items()}))
        return
    echo(f"{scene}: {cells_text(planned.grid.cells)} over {' x '.join(map(readable, planned.grid.extent))}")
    for reason in planned.reasons:
        echo(f"  {reason}")
    chosen = planned.device
    processor = counted(chosen.threads, "thread") if isinstance(chosen, cs.Cpu) else repr(chosen)
    is_unknown = isinf(planned.error)
    expected = "the error is known after the solve" if is_unknown else f"error {planned.error:.1g}"
    seconds = "a time not known" if isinf(planned.seconds) else f"{two_digits(planned.seconds)} s"
    echo(f"  estimated: {expected}, {seconds} on {processor} without files and pictures, {planned.bytes / 1e6:.3g} MB")
    for warning in planned.warnings:
        echo(f"  warning: {warning}")
    for note in _rollers(described.scene, planned.grid):
        echo(f"  note: {note}")
    for number, shape in enumerate(described.scene.shapes):
        if isinstance(shape, cs.Roughness) and shape.extent is None and shape.rms:
            placed = planned.scene.shapes[number]
            width, length = getattr(placed, "extent", None) or planned.grid.extent
            echo(
                f"  note: shapes[{number}] has no extent, and gets that of this plan: give "
                f"extent = [{width:.6g}, {length:.6g}] to keep this surface on other grids"
            )


@click.command()
@SCENE
@out_option("Folder for the netCDF file and the picture.")
@THREADS
@DEVICE
@REQUEST
@click.option(
    "--start", type=click.Path(path_type=Path), help="File with a pressure to start from, as of a stopped solve."
)
@FORMAT
@JSON
def solve(
    scene: Path, out: Path, threads: int | None, device: str, error: Request | None, start: Path | None, **shown: str
) -> None:
    """Solve SCENE; write its fields as netCDF and a picture.

    SCENE is a TOML file. The exit code is 0 if the solution converged, else 1; the result is written in both cases.
    """
    from studies.cli.solving import SolveProgress, solve_with_progress
    from studies.store.netcdf import check_kind, open_folder

    chosen = _device(device, threads)
    described = _with_error(cs.read_scene(scene), error)
    text = scene.read_text(encoding="utf-8-sig")
    formats, form = formats_in(shown["formats"], PICTURES), shown["form"]  # refused before anything is solved
    check_kind(out / f"{scene.stem}.nc", "solution")
    with SolveProgress(str(scene)) as show:
        if isinstance(chosen, cs.Cpu):  # the solve reports whether another device can solve the scene
            _announce(scene, described, chosen)
        begin = perf_counter()
        answer = solve_with_progress(described, scene, out, start, chosen, show)
        path = open_folder(out) / f"{scene.stem}.nc"
        files = _stored(answer, path, formats, text)
        seconds = perf_counter() - begin
    if form == "json":
        click.echo(_as_json(scene, answer, seconds, surface_notes(described.scene), files))
    else:
        echo(f"{scene}: {answer.summary()}")
        echo(f"  {cells_text(answer.grid.cells)}, {two_digits(seconds)} s")
        echo(f"  wrote {', '.join(map(str, files))}")
    if answer.status.name != "CONVERGED":
        sys.exit(1)


def _with_error(described: cs.SceneFile, error: Request | None) -> cs.SceneFile:
    """Return a scene file with the error of the command line, if one is given, in place of its own."""
    settings = described.plan_settings
    return replace(described, plan_settings=replace(settings, error=error or settings.error))


def _announce(scene: Path, described: cs.SceneFile, device: cs.Cpu | cs.Gpu) -> None:
    """Print the warnings of the plan, and its cost if that is large; nothing without a curved shape."""
    if described.scene.hertz is None:
        for doubt in described.doubts:
            echo(f"{scene}: warning: {doubt}", err=True)
        return
    planned = described.plan(device=device)
    for warning in planned.warnings:
        echo(f"{scene}: warning: {warning}", err=True)
    if LONG < planned.seconds < inf or planned.bytes > LARGE:
        cost = f"{two_digits(planned.seconds)} s and {planned.bytes / 1e9:.2g} GB"
        echo(f"{scene}: estimated cost: {cost}", err=True)


def _rollers(scene: cs.Scene, grid: cs.Grid) -> list[str]:
    """Return a sentence for each profiled roller that ends inside a grid and is not cut off there."""
    if any(isinstance(shape, cs.FiniteLength) for shape in scene.shapes):
        return []
    notes = []
    for number, shape in enumerate(scene.shapes):
        length = shape.length_scales.roller if hasattr(shape, "length_scales") else 0.0
        if not 0 < length < inf:
            continue
        if length < grid.length * (1 - 1e-9):
            notes.append(
                f"shapes[{number}] is {readable(length)} long on a grid {readable(grid.length)} long, and is not "
                f"cut off at its ends: add the shape FiniteLength(length={length:g}) if the roller ends there"
            )
    return notes


def _stored(answer: Answer, path: Path, formats: list[str], scene: str) -> list[Path]:
    """Write the dataset with the text of its scene, and its picture in each format; return the files."""
    from studies.store.netcdf import write
    from studies.store.provenance import provenance

    dataset = answer.dataset_to_draw()
    dataset.attrs.update({**provenance(), "scene_file": scene})
    write(dataset, path)
    if not answer.quantities or not formats:
        return [path]
    return [path, *write_figure(answer.plot(dataset), path.with_suffix(""), formats)]


def _as_json(scene: Path, answer: Answer, seconds: float, notes: list[str], files: list[Path]) -> str:
    """Return accuracy, quantities, status, time, notes and files as a JSON object."""
    from contactstudy.io.quantities.quantity import as_json as in_si

    report = {
        "scene": str(scene),
        "status": answer.status.name,
        "accuracy": answer.accuracy,
        "met": answer.met,
        "seconds": seconds,
        "cells": list(answer.grid.cells),
        "quantities": in_si(answer.quantities),
        "notes": [*notes, answer.work, *answer.error.warnings],
        "files": [str(path) for path in files],
    }
    return json.dumps(report)


def _device(name: str, threads: int | None) -> cs.Cpu | cs.Gpu:
    """Return the device of a name, with a number of threads."""
    if name == "cpu":
        return cs.Cpu(threads or _cores())
    if threads is not None:
        raise cs.InvalidInput("--threads is for --device cpu: leave one of them out.")
    return cs.Gpu()


def _cores() -> int:
    """Return the number of cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
