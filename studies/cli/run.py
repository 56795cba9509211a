"""``contactstudy run``: a study over its axes, or a scene over fields of it."""

import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from contactstudy import InvalidInput
from studies.cli.options import OUT, PLOT, WORKERS, is_given, names_in, refuse, write_text
from studies.cli.show import drawing
from studies.registry import has_own_figures, load, load_drawing

if TYPE_CHECKING:
    from studies.model.study import Study

EXAMPLE = '--vary "load.per_length=50 N/mm,100 N/mm"'
VARY = click.option(
    "--vary",
    multiple=True,
    metavar="FIELD=VALUES",
    help="An axis of the study and its values, such as period=0.6,2.4 or images=0:10; or a field of the scene file, "
    "such as load.per_length=50:400:8 N/mm (8 values), 50:400:8:log N/mm (in equal ratios) or surfaces=measured/*.x3p.",
)
REFERENCE = click.option(
    "--reference", metavar="FIELD=VALUE", help="Varied value that errors are drawn against: padding=ExactPeriodicity."
)
REPEATS = click.option(
    "--repeats", type=click.IntRange(min=0), default=2, help="Timed runs of each case, one at a time; 0 takes no times."
)
SENSITIVITY = click.option(
    "--sensitivity", "vary_every", is_flag=True, help="Vary each number by its tolerance, as 10 mm +- 50 um, or by 1 %."
)


def write_sensitivity(study: "Study", plot: Sequence[str], out: Path) -> str:
    """Write the table of a stored sensitivity as CSV, and return it as text with aligned columns."""
    import pandas as pd

    from studies.report.drawings import default, sensitivity
    from studies.report.page import stored

    dataset = stored(study, out)
    changes = sensitivity.table(dataset, default.chosen(dataset, plot))
    table = pd.DataFrame(list(changes.rows), columns=list(changes.head))
    write_text(table.to_csv(index=False), out / f"{study.name}.csv")
    return str(table.to_string(index=False))


def load_varied(name: str, vary: Sequence[str]) -> "Study":
    """Return the study of a name, or of the scene in a file, over the values `vary` and its own of other fields.

    Raises :class:`~contactstudy.InvalidInput` for what cannot be varied.
    """
    fields: dict[str, str] = {}
    for text in vary:
        field, equals, values = text.partition("=")
        field = field.strip()
        if not equals or not field or not values.strip():
            raise InvalidInput(f"--vary is {text!r}: give a field and its values, such as {EXAMPLE}.")
        if field in fields:
            raise InvalidInput(f"--vary names {field} twice: write all its values in one list.")
        fields[field] = values.strip()
    if not name.endswith(".toml"):
        return load(name).override(fields)
    from studies.scene_study.study_of import study_of

    return study_of(name, fields)


def with_reference(study: "Study", name: str, reference: str) -> "Study":
    """Return the `study` of the scene file `name`, whose errors are drawn against the `reference`, "field=value".

    Raises :class:`~contactstudy.InvalidInput` for a value that the study does not have.
    """
    from studies.advice.reference_error import against
    from studies.scene_study.study_of import axes_of

    field, equals, value = (part.strip() for part in reference.partition("="))
    if not name.endswith(".toml") or not equals or not field or not value:
        raise InvalidInput(f"--reference is {reference!r}: give a varied field of a scene file and its value.")
    (axis,) = axes_of(Path(name), {field: value})
    values = {varied.name: varied.values for varied in study.axes}.get(axis.name, ())
    if len(axis.values) != 1 or axis.values[0] not in values:
        raise InvalidInput(f"--reference is {reference!r}, not one of the values that are varied: add it to --vary.")
    return against(study, axis.name, axis.values[0])


@click.command(
    epilog="contactstudy studies lists the axes of each study: contactstudy run period --vary period=0.6,2.4 --vary "
    "images=0:10 (a range has both its ends; lengths are in half-widths)."
)
@click.argument("study")
@OUT
@WORKERS
@REPEATS
@click.option(
    "--scheduler", metavar="ADDRESS", help="dask scheduler in place of --workers, such as tcp://127.0.0.1:8786."
)
@click.option(
    "--time-limit", type=click.FloatRange(min=0, min_open=True), metavar="SECONDS", help="Longest time of a case."
)
@click.option(
    "--retry",
    type=click.Choice(["failed", "timeout", "killed", "times"]),
    multiple=True,
    help="Compute again the cases that failed (in any way), timed out or were killed; take all times again.",
)
@click.option(
    "--fields", flag_value="kept", default="none", help="Store the fields of every case, such as pressure and gap."
)
@VARY
@SENSITIVITY
@REFERENCE
@PLOT
@click.option("--dry-run", is_flag=True, help="Print the number of cases and their estimated cost; compute nothing.")
@click.pass_context
def run(
    context: click.Context,
    /,
    study: str,
    out: Path,
    repeats: int,
    retry: tuple[Any, ...],
    vary: tuple[str, ...],
    vary_every: bool,  # noqa: FBT001 (click gives it by name)
    plot: str | None,
    dry_run: bool,  # noqa: FBT001 (click gives it by name)
    reference: str | None,
    **settings: Any,  # further options of a run
) -> None:
    """Run STUDY over its axes, or a scene over those given.

    STUDY is a built-in name, a .py file or a scene in a .toml file. What is stored in the folder is not computed again.
    """
    from studies.engine.cost import estimate_cost
    from studies.engine.options import RunOptions
    from studies.engine.run import run as run_study
    from studies.model.outcome import CaseStatus

    if vary_every:
        from studies.scene_study.sensitivity import sensitivity_study

        refuse(context, "a sweep, and not for --sensitivity, which varies each number alone", "vary", "reference")
        if not study.endswith(".toml"):
            raise InvalidInput(f"--sensitivity is for a scene in a .toml file, and {study!r} is a study: leave it out.")
        chosen = sensitivity_study(study)
    else:
        chosen = load_varied(study, vary)
    is_timed = (is_given(context, "repeats") and repeats) or "times" in retry
    if is_timed and study.endswith(".toml"):
        chosen = replace(chosen, times="taken")  # cases of a scene are timed on request
    if reference is not None:
        chosen = with_reference(chosen, study, reference)
    if chosen.times != "taken" and repeats:
        refuse(context, f"studies whose cases are timed, which {chosen.name} does not do", "repeats")
    if has_own_figures(study):
        refuse(context, "a scene or a study without figures of its own", "plot")
    if "times" in retry and not repeats:
        raise InvalidInput("--retry has times, and --repeats 0 takes none: leave one of them out.")
    options = RunOptions(repeats=repeats, retry=retry, **settings)
    if dry_run:
        estimate_cost(chosen, out, options=options, log=click.echo)
        return
    dataset = run_study(chosen, out, options=options, log=click.echo)
    statuses = dataset["case_status"]
    if not (statuses == CaseStatus.OK).any():
        click.echo(f"{chosen.name}: no case gave numbers, so there is nothing to draw.", err=True)
        sys.exit(1)
    from studies.report import page as reporting

    with drawing(chosen.name):
        figures_of = load_drawing(study, names_in(plot))
        reporting.draw_figures(chosen, figures_of, out)
    if vary_every:
        click.echo(write_sensitivity(chosen, names_in(plot), out))
    click.echo(f"{chosen.name}: drew {out / chosen.name}")
