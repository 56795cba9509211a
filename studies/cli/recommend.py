"""The command ``contactstudy recommend``, and the measurement that the report of a scene shares with it."""

from __future__ import annotations

import json
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any

import click

import contactstudy as cs
from contactstudy.domain.checks import checked_relative_error
from studies.cli.options import JSON, out_option
from studies.model.plain_text import Log

if TYPE_CHECKING:
    from studies.advice.comparison import Comparison, MeasuredSetting, Verdict

ERROR = click.option(
    "--error",
    default="1 %",
    show_default=True,
    callback=lambda _context, _option, value: checked_relative_error("--error", value),
    help="Requested relative L1 error of the pressure, such as '3 %' or 0.03.",
)
BUDGET = click.option(
    "--seconds",
    type=click.FloatRange(min=0, min_open=True),
    default=60.0,
    show_default=True,
    help="Wall time that a measurement may take.",
)


@click.command("recommend")
@click.option(
    "--scene",
    type=click.Path(path_type=Path),
    help="TOML file of the contact.  [default: a steel cylinder of R = 10 mm under 100 N/mm]",
)
@ERROR
@BUDGET
@JSON
@out_option(
    "Folder of stored measurements; those of a scene are in its subfolder of the scene's name."
)
def recommendation(
    scene: Path | None,
    error: float,
    seconds: float,
    as_json: bool,  # noqa: FBT001 (click's own way)
    out: Path,
) -> None:
    """Recommend the fastest measured padding, grid and tolerance that meet an error.

    Measurements that an earlier report or recommendation stored are used if they meet the error, or had as many seconds;
    otherwise they are taken now.
    """
    from studies.report.wording import alternatives_text, verdict_text

    comparison, folder = measured_scene(
        scene, error, seconds, out, lambda text: click.echo(text, err=True), kept=0.6
    )
    verdict = comparison.verdict(error)
    if verdict is None:
        raise cs.InvalidInput(
            f"{comparison.name} has no setting to recommend: {' '.join(comparison.notes)}"
        )
    if as_json:
        click.echo(json.dumps(_fields(comparison, verdict)))
        return
    click.echo(f"{comparison.name}: {verdict_text(comparison, verdict)}")
    for sentence in filter(None, (alternatives_text(comparison, verdict), *comparison.notes)):
        click.echo(f"  {sentence}")
    click.echo(f"  from {folder / 'settings.nc'}")
    click.echo("  in the scene file, instead of its tables grid, padding and solve:")
    for line in toml(comparison, verdict.best):
        click.echo(f"    {line}".rstrip())


def measured_scene(
    scene: Path | None,
    error: float,
    seconds: float,
    out: Path,
    log: Log,
    kept: float = 1.0,
) -> tuple[Comparison, Path]:
    """Return the comparison of settings of a scene file, or of the paper's cylinder, and the folder it is stored in.

    `kept` times the duration of the imports is left of the seconds for the start and the end of the command, which take
    longer on a busy machine too.
    """
    start = perf_counter()
    from studies.advice.compared_scene import paper_scene, scene_in
    from studies.advice.nested_answers import Budget
    from studies.advice.stored import comparison_of

    reserved = kept * (perf_counter() - start)
    budget = Budget(seconds, start - min(reserved, 0.75 * seconds))
    described = paper_scene() if scene is None else scene_in(scene)
    folder = out if scene is None else out / scene.stem
    return comparison_of(described, error, budget, folder, log), folder


def toml(comparison: Comparison, chosen: MeasuredSetting) -> list[str]:
    """Return the tables of a scene file that choose a setting."""
    from contactstudy.io.scene_files.scene_writer import settings_text

    grid = cs.Grid(chosen.setting.cells, comparison.extent)
    options = cs.SolveOptions(tolerance=chosen.setting.tolerance)
    return settings_text(grid, chosen.setting.padding, options).strip().splitlines()


def _fields(comparison: Comparison, verdict: Verdict) -> dict[str, Any]:
    """Return a recommendation as values for JSON."""
    return {
        "scene": comparison.name,
        "requested_error": verdict.error,
        "meets_request": verdict.meets,
        "reference_bound": comparison.reference_bound,
        "best": _setting(comparison, verdict.best),
        "alternatives": [
            _setting(comparison, alternative.measured)
            | {
                "time_ratio": alternative.ratio,
                "p_value": alternative.p,
                "is_as_fast": alternative.is_as_fast,
            }
            for alternative in verdict.alternatives
        ],
        "notes": list(comparison.notes),
    }


def _setting(comparison: Comparison, chosen: MeasuredSetting) -> dict[str, Any]:
    """Return a setting as values for JSON."""
    return {
        "padding": repr(chosen.setting.padding),
        "cells": list(chosen.setting.cells),
        "extent": list(comparison.extent),
        "tolerance": chosen.setting.tolerance,
        "error": chosen.error,
        "seconds": chosen.time,
        "toml": toml(comparison, chosen),
    }
