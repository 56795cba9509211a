"""Options that several commands have, and files that they write, each whole or not at all."""

import shutil
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from textwrap import fill
from typing import Any

import click
from click.core import ParameterSource

from contactstudy import InvalidInput
from contactstudy.domain.files import replacing

Decorator = Callable[[Any], Any]

SCENE = click.argument("scene", type=click.Path(path_type=Path))
JSON = click.option("--json", "form", flag_value="json", default="text", help="Print one JSON object, for scripts.")
PICTURES = ("png", "pdf", "svg")
FORMAT = click.option(
    "--format", "formats", default="png", help="png, pdf, svg, with commas; of show also html and vtk (for ParaView)."
)


def formats_in(text: str, known: Sequence[str]) -> list[str]:
    """Return the formats in a text, which commas separate; raise InvalidInput for one that is not known."""
    chosen = [name.lower().lstrip(".") for name in names_in(text)]
    for name in chosen:
        if name not in known:
            raise InvalidInput(f"--format is {name!r}: give one or more of {', '.join(known)}.")
    return chosen


def out_option(text: str, default: str | None = "outputs") -> Decorator:
    """Return the option --out, a folder, with a help text."""
    return click.option("--out", type=click.Path(path_type=Path), default=default, help=text)


OUT = out_option("Folder for netCDF files, figures and report.")
WORKERS = click.option(
    "--workers", type=click.IntRange(min=0, max=1024), default=2, help="Worker processes; 0 computes in this process."
)
PLOT = click.option("--plot", metavar="NAMES", help="Variables of a scene's sweep to draw in place of the main ones.")


def echo(text: str, *, err: bool = False) -> None:
    """Print a text; in a terminal wrap its lines at the width of that."""
    if (sys.stderr if err else sys.stdout).isatty():
        width = shutil.get_terminal_size().columns
        style: Any = {"subsequent_indent": "    ", "break_long_words": False, "break_on_hyphens": False}
        text = "\n".join(fill(line, width, **style) for line in text.splitlines())
    click.echo(text, err=err)


def refuse(context: click.Context, reason: str, *names: str) -> None:
    """Raise InvalidInput, with the reason, for the first of these options that the command line gives."""
    for name in names:
        if is_given(context, name):
            option = next(part for part in context.command.params if part.name == name)
            raise InvalidInput(f"{option.opts[0]} is for {reason}: leave it out.")


def is_given(context: click.Context, name: str) -> bool:
    """Return whether the command line gives the option with this name."""
    return context.get_parameter_source(name) is ParameterSource.COMMANDLINE


def names_in(text: str | None) -> tuple[str, ...]:
    """Return the names in a text, which commas separate."""
    return tuple(filter(None, (name.strip() for name in (text or "").split(","))))


def write_text(text: str, path: Path) -> None:
    """Write a text, and say so."""
    with replacing(path) as partial:
        partial.write_text(text, encoding="utf-8")
    click.echo(f"wrote {path}")
