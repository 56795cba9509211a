"""The ``contactstudy`` command."""

import sys
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any, NoReturn

import click

from contactstudy import InvalidInput, __version__
from contactstudy.domain.errors import Request
from contactstudy.domain.imports import missing_package
from contactstudy.domain.validation import checked_errors
from studies.cli.new import new
from studies.cli.options import PLOT, echo, is_given, names_in, out_option, refuse
from studies.cli.scenes import plan, solve
from studies.cli.show import compare, drawing, show
from studies.cli.vary import (
    REFERENCE,
    SENSITIVITY,
    VARY,
    load_varied,
    sensitivity_of,
    with_reference,
    write_sensitivity,
)
from studies.model.plain_text import one_line
from studies.registry import BUILT_IN, has_own_figures, load_drawing, outline

# What runs is imported by the commands that run, and what draws by those that draw: help comes at once.

MAX_LISTED = 60  # characters of the values of an axis
OUT = out_option("Folder for netCDF files, figures and report.")
WORKERS = click.option(
    "--workers",
    type=click.IntRange(min=0, max=1024),
    default=2,
    show_default=True,
    help="Worker processes, driven by threads of dask; 0 computes in this process alone.",
)
REPEATS = click.option(
    "--repeats",
    type=click.IntRange(min=0),
    default=2,
    show_default=True,
    help="Timed runs of each case, one at a time on one thread; the least time counts. 0 takes no times.",
)


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__)
def cli() -> None:
    """Rough line contacts, periodic along their length: accuracy and cost."""


@cli.command()
@click.argument("chapter", nargs=-1)
@click.option(
    "--scene",
    type=click.Path(path_type=Path),
    help="Compare paddings, numbers of images n, grids and tolerances for the scene in this TOML file, in "
    "one process: --workers is for chapters.",
)
@click.option(
    "--error",
    default="1 %",
    show_default=True,
    callback=lambda _context, _option, value: checked_errors("--error", value),
    help="With --scene: relative error of every number, such as '3 %', or of some: 'peak_pressure = 2 %'.",
)
@OUT
@WORKERS
@click.pass_context
def report(
    context: click.Context,
    /,
    chapter: tuple[str, ...],
    scene: Path | None,
    error: Request,
    out: Path,
    workers: int,
) -> None:
    """Run the studies of each CHAPTER and write its page.

    Without a chapter, the page is report.html. CHAPTER is effects, the name of any study, or
    all. What is stored is not computed again.
    With --scene, the page is about that contact, in a folder of its name.
    """
    if scene is not None:
        if chapter:
            raise InvalidInput(
                f"Chapter {chapter[0]!r} is given beside --scene: give one of them, because chapters are about a "
                "steel cylinder of R = 10 mm under 100 N/mm."
            )
        refuse(context, "chapters, and not for --scene", "workers")
        from studies.advice.stored import verdict_of
        from studies.advice.verdict import scene_in
        from studies.report.page import write_scene
        from studies.report.wording import lines

        folder = out / scene.stem
        verdict = verdict_of(
            scene_in(scene), error, folder, lambda text: click.echo(text, err=True)
        )
        for line in lines(verdict):
            click.echo(line)
        click.echo(f"report: wrote {write_scene(verdict, folder)}")
        return
    refuse(context, "--scene", "error")
    from studies.engine.options import RunOptions
    from studies.report import page as reporting
    from studies.report.chapters import chapters

    chosen = chapters(chapter)
    options = RunOptions(workers=workers)
    for page_chapter in chosen:
        path = reporting.run_and_write(page_chapter, out, options=options, log=click.echo)
        click.echo(f"report: wrote {path}")


@cli.command(
    epilog="contactstudy studies lists the axes of each study: contactstudy run period --vary period=0.6,2.4 --vary "
    "images=0:10 (a range has both its ends; lengths are in half-widths).",
)
@click.argument("study")
@OUT
@WORKERS
@REPEATS
@click.option(
    "--scheduler",
    metavar="ADDRESS",
    help="dask scheduler whose workers compute the cases, such as tcp://127.0.0.1:8786, instead of --workers.",
)
@click.option(
    "--time-limit",
    type=click.FloatRange(min=0, min_open=True),
    metavar="SECONDS",
    help="Longest time of one case; a longer case is stopped.  [default: none]",
)
@click.option(
    "--retry",
    type=click.Choice(["failed", "timeout", "killed", "times"]),
    multiple=True,
    help="Compute again the cases that failed (in any way), timed out, or were killed; take all times again.",
)
@click.option(
    "--fields",
    flag_value="kept",
    default="none",
    help="Store the fields of every case, such as pressure and gap, as groups of the netCDF file.",
)
@VARY
@SENSITIVITY
@REFERENCE
@PLOT
@click.option(
    "--dry-run",
    is_flag=True,
    help="Print the number of cases and their estimated cost; compute nothing.",
)
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
    plot: str,
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
        refuse(
            context,
            "a sweep, and not for --sensitivity, which varies each number alone",
            "vary",
            "reference",
        )
    chosen = sensitivity_of(study) if vary_every else load_varied(study, vary)
    is_timed = (is_given(context, "repeats") and repeats) or "times" in retry
    if is_timed and study.endswith(".toml"):
        chosen = replace(chosen, times="taken")  # cases of a scene are timed on request
    if reference is not None:
        chosen = with_reference(chosen, study, reference)
    if chosen.times != "taken" and repeats:
        refuse(
            context, f"studies whose cases are timed, which {chosen.name} does not do", "repeats"
        )
    if has_own_figures(study):
        refuse(context, "a scene or a study without figures of its own", "plot")
    if "times" in retry and not repeats:
        raise InvalidInput("--retry has times, and --repeats 0 takes none: leave one of them out.")
    options = RunOptions(repeats=repeats, retry=retry, **settings)
    if dry_run:
        estimate_cost(chosen, out, options=options, log=click.echo)
        return
    if plot:
        from studies.scene_study.measures import check_names

        check_names(chosen, names_in(plot))
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


for command in (compare, new, plan, show, solve):
    cli.add_command(command)


@cli.command()
def studies() -> None:
    """List the built-in studies with their axes and the values of these."""
    for name in BUILT_IN:
        title, axes = outline(name)
        click.echo(f"{name}: {title}")
        for axis in axes:
            units = "" if axis.units == "1" else f" [{axis.units}]"
            values = one_line(", ".join(map(str, axis.values)), MAX_LISTED)
            click.echo(f"  {axis.name}: {axis.long_name}{units}: {values}")


def main() -> None:
    """Run the command; report invalid input in one sentence with exit code 2, and Ctrl-C with exit code 130."""
    try:
        cli.main(standalone_mode=False)
    except InvalidInput as error:
        echo(f"contactstudy: {error}", err=True)
        sys.exit(2)
    except click.ClickException as error:
        error.show()
        sys.exit(error.exit_code)
    except (KeyboardInterrupt, click.Abort):
        click.echo("contactstudy: stopped; files that are complete are kept.", err=True)
        sys.exit(130)
    except BrokenPipeError:  # the output pipe is closed
        sys.stdout = None
        sys.exit(141)
    except ModuleNotFoundError as missing:
        _fail(str(missing_package("this command", missing)))
    except OSError as error:
        _fail(f"{error.strerror or error}{f': {error.filename}' if error.filename else ''}")
    except MemoryError:
        _fail("there is not enough memory: ask for fewer cells, points or workers.")


def _fail(text: str) -> NoReturn:
    """Print a message in one line, if it can be printed, and exit with code 1."""
    with suppress(OSError):
        click.echo(f"contactstudy: {one_line(text)}", err=True)
    sys.exit(1)
