"""The command ``contactstudy recommend``."""

from __future__ import annotations

import json
from dataclasses import asdict
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

import contactstudy as cs
from contactstudy.accuracy.expected_error import Edges, Metric
from contactstudy.domain.checks import positive
from contactstudy.domain.units import BYTES, SECONDS
from contactstudy.io.structuring import quantity
from studies.cli.options import JSON, out_option
from studies.model.axis import one_of

if TYPE_CHECKING:
    from contactstudy.planning.cost import CostModel
    from studies.advice.recommendation import Recommendation, Setting

METRICS = {metric.name.lower(): metric for metric in Metric}


ERROR_OF = {
    Edges.AS_SOLVED: "the error is against the pressure at the cell centres or its means in cells, the larger of both",
    Edges.CORRECTED: "the error is against the pressure at the cell centres, not its means in cells",
}


@click.command("recommend")
@click.argument("scene", type=click.Path(path_type=Path), required=False)
@click.option(
    "--error", type=float, default=1e-3, show_default=True, help="Requested relative error."
)
@click.option(
    "--metric",
    default="l1",
    show_default=True,
    help=f"Quantity the error is of: {', '.join(METRICS)}.",
)
@click.option("--memory", default="inf", help="Memory limit, such as 4GB.")
@click.option("--seconds", default="inf", help="Time limit, such as 10 or 2min.")
@click.option(
    "--period",
    type=float,
    default=2.4,
    show_default=True,
    help="Period in half-widths, if no SCENE is given.",
)
@JSON
@out_option("Folder with pareto.nc, measured on this machine; without it a small case is timed.")
def recommendation(
    scene: Path | None,
    error: float,
    metric: str,
    memory: str,
    seconds: str,
    period: float,
    as_json: bool,  # noqa: FBT001 (click's own way)
    out: Path,
) -> None:
    """Recommend the cheapest setting that meets an error, for the contact in the TOML file SCENE.

    Without SCENE it is the smooth line contact of the sweeps.
    """
    from contactstudy.planning.cost import CostModel
    from studies.advice.recommendation import Limits, contact_of, recommend
    from studies.advice.settings_table import stored_timings
    from studies.reference.line_contact import HERTZ, SCENE
    from studies.store.netcdf import read
    from studies.store.provenance import cpu

    limits = Limits(
        error=error,
        metric=METRICS[one_of("metric", metric, METRICS)],
        memory=quantity("memory", _with_unit(memory), BYTES),
        seconds=quantity("seconds", _number(seconds), SECONDS),
    )
    if scene is None:
        period = positive("period", period, "give a period above 0 half-widths")
        contact = contact_of(SCENE, period * HERTZ.half_width, limits)
    else:
        described = cs.read_scene(scene)
        length = described.grid.period if described.grid else described.plan_settings.period
        contact = contact_of(described.scene, length, limits)
    stored = out / "pareto.nc"
    costs = CostModel(stored_timings(read(stored) if stored.is_file() else None, cpu()))
    recommended = recommend(contact, limits, costs)
    if as_json:
        click.echo(json.dumps(_fields(recommended, scene, costs)))
        return
    name = str(scene) if scene else f"smooth line contact, period {period:g} half-widths"
    for line in _report_lines(recommended, name, scene, costs):
        click.echo(line)


def _with_unit(text: str) -> str | float:
    """Return a memory limit; raise InvalidInput for a finite number without a unit."""
    number = _number(text)
    if isinstance(number, float) and isfinite(number):
        raise cs.InvalidInput(f"memory is {text!r}: give its unit too, such as 4GB or 500MB.")
    return number


def _number(text: str) -> str | float:
    """Return a text without a unit as a number, which is taken in the SI unit, and any other text unchanged."""
    try:
        return float(text)
    except ValueError:
        return text


def _source(costs: CostModel) -> str:
    """Return a text on the origin of the predicted times."""
    return "fitted to the times in pareto.nc" if costs.timings else "measured on a small case now"


def _fields(recommended: Recommendation, scene: Path | None, costs: CostModel) -> dict[str, Any]:
    """Return a recommendation as values for JSON."""
    limits = recommended.limits
    finite = {name: getattr(limits, name) for name in ("memory", "seconds")}
    return {
        "asked": {"error": limits.error, "metric": limits.metric.name.lower()}
        | {name: value for name, value in finite.items() if isfinite(value)},
        "meets": recommended.meets,
        "affordable": recommended.affordable,
        "seconds_from": _source(costs),
        "best": _setting(recommended.best, scene),
        "runner_up": _setting(recommended.runner_up, scene) if recommended.runner_up else None,
    }


def _setting(setting: Setting, scene: Path | None) -> dict[str, Any]:
    """Return a setting as values for JSON."""
    return {
        "mode": setting.mode,
        "padding": repr(setting.padding),
        "grid": asdict(setting.grid),
        "tolerance": setting.tolerance,
        "edges": setting.edges.value,
        "python": python(setting, scene),
        "toml": toml(setting),
        "error": setting.error.total,
        "error_parts": asdict(setting.error),
        "seconds": setting.seconds,
        "bytes": setting.bytes,
    }


def _report_lines(
    recommended: Recommendation, name: str, scene: Path | None, costs: CostModel
) -> list[str]:
    """Return the lines that a terminal shows of a recommendation."""
    limits = recommended.limits
    request = f"{limits.metric.value} to {limits.error:.2g}"
    if isfinite(limits.memory):
        request += f" in {limits.memory / 1e6:.3g} MB"
    if isfinite(limits.seconds):
        request += f" in {limits.seconds:.3g} s"
    lines = [f"{name}: {request}"]
    if recommended.meets:
        first, second = "use", "runner-up"
    elif recommended.affordable:
        first, second = "no setting meets the requested error; the most accurate setting", "next"
    else:
        first, second = "no setting fits the time and memory limits; the fastest setting", "next"
    for words, setting in ((first, recommended.best), (second, recommended.runner_up)):
        if setting is not None:
            lines += [f"  {words}: {_setting_text(setting)}", f"    {_cost_text(setting)}"]
    lines.append(f"  seconds are {_source(costs)}")
    lines.append(f"  {ERROR_OF[recommended.best.edges]}")
    lines += ["  in Python:", *(f"    {line}" for line in python(recommended.best, scene))]
    return [
        *lines,
        "  in the scene file:",
        *(f"    {line}".rstrip() for line in toml(recommended.best)),
    ]


def toml(setting: Setting) -> list[str]:
    """Return the tables of a scene file that choose the setting."""
    from contactstudy.io.scene_writer import settings_text

    options = cs.SolveOptions(tolerance=setting.tolerance)
    return settings_text(setting.grid, setting.padding, options).strip().splitlines()


def python(setting: Setting, scene: Path | None) -> list[str]:
    """Return lines of Python that solve the contact in the file `scene`, or that of the sweeps, with the setting."""
    where = "from studies.reference.line_contact import SCENE as scene"
    if scene is not None:
        where = f"scene = cs.read_scene({str(scene)!r}).scene"
    paddings = setting.padding if isinstance(setting.padding, tuple) else (setting.padding,)
    named = ", ".join(f"cs.{padding!r}" for padding in paddings)
    padding = f"({named})" if len(paddings) > 1 else named
    lines = [
        "import contactstudy as cs",
        where,
        f"grid = cs.Grid({setting.grid.cells!r}, {setting.grid.extent!r})",
        f"problem = scene.problem(grid, {padding})",
        f"solution = cs.solve(problem, tolerance={setting.tolerance!r})",
        "pressure = solution.pressure",
    ]
    if setting.edges is Edges.CORRECTED:
        lines[1:1] = ["from contactstudy.accuracy.contact_edge import corrected_pressure"]
        lines[-1] = "pressure = corrected_pressure(solution.pressure)"
    return lines


def _setting_text(setting: Setting) -> str:
    """Return a text with mode, cells, extent and tolerance of a setting."""
    cells, extent = setting.grid.cells, setting.grid.extent
    mode = {"line": "exact, one cell along the length", "free": "zero padding along both axes"}
    named = mode.get(setting.mode, setting.mode)
    if (images := getattr(setting.padding, "images", None)) is not None:
        named += f", n = {images}"
    text = f"{named}; {cells[0]} x {cells[1]} cells "
    text += f"over {extent[0]:.4g} m x {extent[1]:.4g} m, tolerance {setting.tolerance:.0e}"
    return text + ", pressure corrected at its edges" * (setting.edges is Edges.CORRECTED)


def _cost_text(setting: Setting) -> str:
    """Return a text with estimated error, time and memory of a setting."""
    parts = setting.error
    return (
        f"estimated error <= {parts.total:.2g} (truncation {parts.truncation:.1g}, discretisation "
        f"{parts.discretisation:.1g}, residual {parts.residual:.1g}), {setting.seconds:.2g} s on one thread, "
        f"{setting.bytes / 1e6:.3g} MB"
    )
