"""The ``contactstudy`` command."""

import sys
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any, NoReturn

import click

from contactstudy import InvalidInput, __version__
from contactstudy.domain.checks import checked_relative_error
from contactstudy.domain.imports import missing_package
from studies.cli.explore import explore
from studies.cli.new import new
from studies.cli.options import FORMAT, PLOT, is_given, names_in, out_option, refuse, with_png
from studies.cli.scenes import plan, solve
from studies.cli.show import REMEDY_IN_CODE, REMEDY_IN_TIMES, compare, drawing, show
from studies.cli.study_help import StudyCommand
from studies.cli.vary import FIGURES, REFERENCE, VARY, load_scene_study, with_reference
from studies.model.axis import MAX_POINTS
from studies.model.plain_text import one_line
from studies.model.study import Study
from studies.registry import BUILT_IN, OPTIONAL, has_own_figures, load, load_drawing
from studies.scene_study.values import MAX_VALUES

# What runs is imported by the commands that run, and what draws by those that draw: help comes at once.

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
    type=click.IntRange(min=1),
    default=2,
    show_default=True,
    help="Timed runs of each case, one at a time on one thread; the least time counts. Pages of the report take at most "
    "one or two, and none of some studies.",
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
    help="Compare paddings, numbers of images n, grids and tolerances for the scene in this TOML file.",
)
@click.option(
    "--error",
    default="1 %",
    show_default=True,
    callback=lambda _context, _option, value: checked_relative_error("--error", value),
    help="With --scene: requested relative error, such as '3 %' or 0.03.",
)
@OUT
@WORKERS
@REPEATS
@FORMAT
@click.pass_context
def report(
    context: click.Context,
    /,
    chapter: tuple[str, ...],
    scene: Path | None,
    error: float,
    out: Path,
    workers: int,
    repeats: int,
    formats: tuple[str, ...],
) -> None:
    """Run the studies of each CHAPTER and write its page.

    Without a chapter, the page is report.html. CHAPTER is effects, lubrication, trust, cost, the name of any study, or
    all. What is stored is not computed again.
    With --scene, the page is about that contact, in a folder of its name.
    """
    if scene is not None:
        if chapter:
            raise InvalidInput(
                f"Chapter {chapter[0]!r} is given beside --scene: give one of them, because chapters are about a "
                "steel cylinder of R = 10 mm under 100 N/mm."
            )
        refuse(context, "chapters, and not for --scene", "workers", "repeats")
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
        click.echo(f"report: wrote {write_scene(verdict, folder, with_png(formats))}")
        return
    refuse(context, "--scene", "error")
    from studies.engine.options import RunOptions
    from studies.report import page as reporting
    from studies.report.chapters import chapters

    chosen = chapters(chapter)
    max_repeats = max(part.max_repeats for page_chapter in chosen for part in page_chapter.parts)
    if is_given(context, "repeats") and repeats > max_repeats:
        raise InvalidInput(
            f"--repeats is {repeats}: pages of {' '.join(chapter) or 'the report'} take at most {max_repeats} timed "
            "runs of a case; leave it out, or time a study with contactstudy run before."
        )
    options = RunOptions(workers=workers, repeats=repeats)
    for page_chapter in chosen:
        path = reporting.run_and_write(
            page_chapter, out, options=options, log=click.echo, formats=with_png(formats)
        )
        click.echo(f"report: wrote {path}")
    for path in reporting.write_outdated(out, chosen, click.echo):
        click.echo(f"report: wrote {path}")


@cli.command(
    cls=StudyCommand,
    context_settings={"ignore_unknown_options": True, "allow_extra_args": True},
    epilog="Every axis of a study is an option, which run STUDY --help lists: contactstudy run period "
    "--period 0.6,2.4 --images 0:10 (a range has both its ends; lengths are in half-widths).",
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
@click.option("--no-times", is_flag=True, help="Do not time the cases.")
@click.option(
    "--time-limit",
    type=click.FloatRange(min=0, min_open=True),
    metavar="SECONDS",
    help="Longest time of one case; a longer case is stopped.  [default: none]",
)
@click.option(
    "--retry",
    type=click.Choice(["failed", "timeout", "killed"]),
    multiple=True,
    help="Compute again the cases that failed (in any way), timed out, or were killed.",
)
@click.option(
    "--fail-fast",
    "after_failure",
    flag_value="stop",
    default="continue",
    help="Stop at the first case that fails.",
)
@click.option(
    "--fields",
    flag_value="kept",
    default="none",
    help="Store the fields of every case, such as pressure and gap, as groups of the netCDF file.",
)
@click.option(
    "--retime",
    "old_times",
    flag_value="dropped",
    default="kept",
    help="Time the cases again, even if their times are stored.",
)
@click.option("--yes", is_flag=True, help="Run even more than a million points.")
@click.option(
    "--scene",
    type=click.Path(path_type=Path),
    help="For padding, period, images, grid, pareto and paper: the contact in this TOML file, in a folder of its name.",
)
@VARY
@REFERENCE
@FIGURES
@PLOT
@FORMAT
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
    no_times: bool,  # noqa: FBT001 (click gives it by name)
    retry: tuple[str, ...],
    vary: tuple[str, ...],
    figures: str,
    plot: str,
    formats: tuple[str, ...],
    yes: bool,  # noqa: FBT001
    dry_run: bool,  # noqa: FBT001
    scene: Path | None,
    reference: str | None,
    **settings: Any,  # further options of a run
) -> None:
    """Run STUDY over its axes, or a scene over those given.

    STUDY is a built-in name, a .py file or a scene in a .toml file. What is stored in the folder is not computed again.
    """
    from studies.engine.cost import estimate_cost
    from studies.engine.options import RETRIES, RunOptions
    from studies.engine.run import run as run_study
    from studies.model.outcome import CaseStatus

    max_points = None if yes else MAX_POINTS
    chosen = load_scene_study(study, vary, context.args)
    if chosen is None:
        chosen = _named(study, scene).override(_axes(context.args), max_count=max_points)
    elif scene is not None:
        raise InvalidInput(f"--scene is given beside the scene {study!r}: leave it out.")
    else:
        # cases of a scene are timed on request
        if is_given(context, "repeats") or settings["old_times"] == "dropped":
            chosen = replace(chosen, times="taken")
    if reference is not None:
        chosen = with_reference(chosen, study, reference)
    if chosen.times != "taken":
        reason = f"studies whose cases are timed, which {chosen.name} does not do"
        refuse(context, reason, "repeats", "old_times")
    if no_times:
        refuse(context, "timed runs, and not beside --no-times", "repeats", "old_times")
    if study.endswith(".toml"):
        refuse(context, f"a study, and a scene has at most {MAX_VALUES} points", "yes")
    if has_own_figures(study):
        refuse(context, "a scene or a study without figures of its own", "figures", "plot")
    out = out if scene is None else out / scene.stem
    statuses_again = frozenset(status for name in retry for status in RETRIES[name])
    options = RunOptions(
        repeats=0 if no_times else repeats, retry=statuses_again, max_points=max_points, **settings
    )
    if dry_run:
        estimate_cost(chosen, out, options=options, log=click.echo)
        return
    dataset = run_study(chosen, out, options=options, log=click.echo)
    statuses = dataset["case_status"]
    if not (statuses == CaseStatus.OK).any():
        click.echo(f"{chosen.name}: no case gave numbers, so there is nothing to draw.", err=True)
        sys.exit(1)
    if options.after_failure == "stop" and not (statuses == CaseStatus.OK).all():
        sys.exit(1)
    from studies.report import page as reporting

    with drawing(chosen.name, REMEDY_IN_TIMES if no_times else REMEDY_IN_CODE):
        figures_of = load_drawing(study, figures, names_in(plot))
        reporting.draw_figures(chosen, figures_of, out, with_png(formats))
    click.echo(f"{chosen.name}: drew {out / chosen.name}")


@cli.command()
@click.argument("study", nargs=-1)
@OUT
@FORMAT
def draw(study: tuple[str, ...], out: Path, formats: tuple[str, ...]) -> None:
    """Draw the figures of STUDY, or the pages of stored chapters.

    They are drawn from the netCDF files in the folder; nothing is solved. STUDY is a built-in name or a .py file.
    """
    from studies.report import page as reporting
    from studies.report.chapters import MAIN

    for name in study:
        if name.endswith(".toml"):
            raise InvalidInput(
                f"STUDY is {name!r}: draw the stored sweep of a scene with contactstudy show "
                f"{out / Path(name).stem}-sweep.nc."
            )
        chosen = load(name)
        with drawing(chosen.name):
            reporting.draw_figures(chosen, load_drawing(name), out, with_png(formats))
        click.echo(f"{name}: drew {out / chosen.name}")
    if not study:
        with drawing("report"):
            page = reporting.draw_and_write(MAIN, out, with_png(formats))
            pages = [page, *reporting.write_outdated(out, [MAIN], click.echo)]
        for path in pages:
            click.echo(f"report: wrote {path}")


for command in (compare, explore, new, plan, show, solve):
    cli.add_command(command)


@cli.command()
def studies() -> None:
    """List the built-in studies with the lengths of their axes."""
    for name in (*BUILT_IN, *OPTIONAL):
        study = load(name)
        axes = ", ".join(f"{axis.name} ({len(axis.values)})" for axis in study.axes)
        click.echo(f"{name:<12} {study.title} Axes: {axes}.")


def _named(name: str, scene: Path | None) -> Study:
    """Return the built-in study of a name, or for a scene the study of its settings."""
    if scene is None:
        return load(name)
    from studies.advice.compared_scene import scene_in
    from studies.definitions.settings import preset

    return preset(name, scene_in(scene).subject())


def _axes(arguments: list[str]) -> Mapping[str, str]:
    """Return the values of ``--name value`` and ``--name=value`` pairs by name."""
    axes: dict[str, str] = {}
    words = iter(arguments)
    for word in words:
        if not word.startswith("--"):
            raise InvalidInput(f"Argument {word!r} is not expected: write --AXIS VALUES.")
        name, equals, value = word[2:].partition("=")
        text = value if equals else next(words, None)
        if text is None:
            raise InvalidInput(f"Axis {name!r} has no values: write --{name} VALUES.")
        if name in axes:
            raise InvalidInput(f"Axis {name!r} is given twice: write all its values in one list.")
        axes[name] = text
    return axes


def main() -> None:
    """Run the command; report invalid input in one sentence with exit code 2, and Ctrl-C with exit code 130."""
    try:
        cli.main(standalone_mode=False)
    except InvalidInput as error:
        click.echo(f"contactstudy: {error}", err=True)
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
