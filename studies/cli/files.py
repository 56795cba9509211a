"""Files that commands write, each whole or not at all."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from contactstudy.domain.storage.files import replacing

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def write_text(text: str, path: Path) -> None:
    """Write a text, and say so."""
    with replacing(path) as partial:
        partial.write_text(text, encoding="utf-8")
    click.echo(f"wrote {path}")


def write_figure(figure: "Figure", stem: Path, formats: Sequence[str]) -> list[Path]:
    """Write a figure in each format to files with the path `stem` without its ending; return the files."""
    files = [stem.with_name(f"{stem.name}.{suffix}") for suffix in formats]
    for file in files:
        with replacing(file) as partial:
            figure.savefig(partial)
    return files
