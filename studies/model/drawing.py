"""Drawing of a study: captioned figures, findings and tables, all made from its stored Dataset."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from contactstudy import InvalidInput
from contactstudy.domain.files import replacing
from studies.model.plain_text import name_problem, shortened

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


Row = tuple[str, ...]


@dataclass(frozen=True)
class Finding:
    """A claim, the measurement behind it, and the question of the reader that it answers, if any."""

    claim: str
    measured: str
    question: str = ""


@dataclass(frozen=True)
class Table:
    """A table of texts with a caption.

    Attributes
    ----------
    caption
        Text below the table.
    head
        Names of the columns.
    rows
        Cells of each row.
    """

    caption: str
    head: Row
    rows: tuple[Row, ...]

    @property
    def kinds(self) -> Row:
        """Type of each column, ``number`` if its cells start with a number or are ``none``, else ``text``."""
        columns = zip(*self.rows, strict=True) if self.rows else [()] * len(self.head)
        return tuple(
            "number" if all(cell.lstrip("+-−<> ")[:1].isdigit() for cell in column) else "text"
            for column in ([cell for cell in cells if cell != "none"] for cells in columns)
        )


@dataclass(frozen=True, eq=False)
class CaptionedFigure:
    """A figure with its file name and its caption."""

    name: str
    figure: Figure
    caption: str

    def __post_init__(self) -> None:
        if name_problem(self.name) or self.name.startswith("."):
            raise InvalidInput(
                f"A figure has the name {shortened(self.name)}: give a plain file name without "
                "extension, such as 'peak'."
            )


def no_items(dataset: xr.Dataset) -> tuple[()]:
    """Return no items, for a drawing without findings or tables."""
    return ()


@dataclass(frozen=True, eq=False)
class Drawing:
    """Figures, findings and tables of a study, as functions of its stored Dataset.

    Attributes
    ----------
    figure, findings, tables
        Functions of the Dataset.
    """

    figure: Callable[[xr.Dataset], Sequence[CaptionedFigure]]
    findings: Callable[[xr.Dataset], Sequence[Finding]] = no_items
    tables: Callable[[xr.Dataset], Sequence[Table]] = no_items


def write_figure(figure: Figure, stem: Path, formats: Sequence[str]) -> list[Path]:
    """Write a figure in each format to files with the path `stem` without its ending; return the files."""
    files = [stem.with_name(f"{stem.name}.{suffix}") for suffix in formats]
    for file in files:
        with replacing(file) as partial:
            figure.savefig(partial)
    return files
