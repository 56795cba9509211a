"""The ``contactstudy`` command with its subcommands `report` and `studies`, and how it ends after an error."""

import sys
from contextlib import suppress
from pathlib import Path
from typing import NoReturn

import click

from contactstudy import InvalidInput, __version__
from contactstudy.domain.errors import Request
from contactstudy.domain.imports import missing_package
from contactstudy.domain.validation import checked_errors
from studies.cli.options import OUT, WORKERS, echo, refuse
from studies.cli.run import run
from studies.cli.scenes import new, plan, solve
from studies.cli.show import compare, show
from studies.model.plain_text import one_line
from studies.registry import BUILT_IN, outline

# Commands import what runs and what draws when they need it, so that help comes at once.

MAX_LISTED = 60  # characters of the values of an axis


@click.group(context_settings={"help_option_names": ["-h", "--help"], "show_default": True})
@click.version_option(__version__)
def cli() -> None:
    """Rough line contacts, periodic along their length: accuracy and cost."""


@cli.command()
@click.argument("chapter", nargs=-1)
@click.option(
    "--scene",
    type=click.Path(path_type=Path),
    help="Compare paddings, grids and tolerances for the scene in this file.",
)
@click.option(
    "--error",
    default="1 %",
    callback=lambda _context, _option, value: checked_errors("--error", value),
    help="With --scene: relative error of every number, such as '3 %', or of some: 'peak_pressure = 2 %'.",
)
@OUT
@WORKERS
@click.pass_context
def report(
    context: click.Context, /, chapter: tuple[str, ...], scene: Path | None, error: Request, out: Path, workers: int
) -> None:
    """Run the studies of each CHAPTER and write its page.

    Without a chapter, the page is report.html. CHAPTER is effects, the name of any study, or all. What is stored is not
    computed again.
    With --scene, the page is about that contact, in a folder of its name.
    """
    if scene is not None:
        if chapter:
            raise InvalidInput(f"Chapter {chapter[0]!r} is given beside --scene: give one of them.")
        refuse(context, "chapters, and not for --scene", "workers")
        from studies.advice.trials import verdict_of
        from studies.advice.verdict import scene_in
        from studies.report.drawings.comparison import lines
        from studies.report.page import write_scene

        folder = out / scene.stem
        verdict = verdict_of(scene_in(scene), error, folder, lambda text: click.echo(text, err=True))
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


for command in (compare, new, plan, run, show, solve):
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
        click.echo("contactstudy: stopped; no file is half-written.", err=True)
        sys.exit(130)  # 128 and the number of SIGINT
    except BrokenPipeError:  # the output pipe is closed
        sys.stdout = None
        sys.exit(141)  # 128 and the number of SIGPIPE
    except ModuleNotFoundError as missing:
        _fail(str(missing_package("this command", missing)))
    except OSError as error:
        _fail(f"{error.strerror or error}{f': {error.filename}' if error.filename else ''}")
    except MemoryError:
        _fail("there is not enough memory: ask for fewer cells, points or workers.")


def _fail(text: str) -> NoReturn:
    """Print a message in one line, if standard error is open, and exit with code 1."""
    with suppress(OSError):
        click.echo(f"contactstudy: {one_line(text)}", err=True)
    sys.exit(1)
