"""How a study is drawn: captioned figures, findings and tables, all read from its stored Dataset."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from contactstudy import InvalidInput
from studies.model.plain_text import name_problem, one_line

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


Row = tuple[str, ...]


@dataclass(frozen=True)
class Finding:
    """A claim in a few words, what was measured, and the reader's question that this answers, if one does."""

    claim: str
    measured: str
    question: str = ""


@dataclass(frozen=True)
class Table:
    """A head, rows of text, and a caption; a column whose every cell starts with a number is one of numbers."""

    caption: str
    head: Row
    rows: tuple[Row, ...]

    @property
    def kinds(self) -> Row:
        """``number`` or ``text`` for each column."""
        columns = zip(*self.rows, strict=True) if self.rows else [()] * len(self.head)
        return tuple(
            "number" if all(cell.lstrip("-−<> ")[:1].isdigit() for cell in column) else "text"
            for column in columns
        )


@dataclass(frozen=True, eq=False)
class CaptionedFigure:
    """A figure with its file name and the caption that goes under it."""

    name: str
    figure: Figure
    caption: str

    def __post_init__(self) -> None:
        if name_problem(self.name) or self.name.startswith("."):
            raise InvalidInput(
                f"A figure has the name {one_line(repr(self.name), 60)}: give a plain file name without "
                "extension, such as 'peak'."
            )


def nothing(dataset: xr.Dataset) -> tuple[()]:
    """The findings, or the tables, of a drawing that has none."""
    return ()


@dataclass(frozen=True, eq=False)
class Drawing:
    """What the report shows of a study; each function reads the stored Dataset and never solves."""

    figure: Callable[[xr.Dataset], Sequence[CaptionedFigure]]
    findings: Callable[[xr.Dataset], Sequence[Finding]] = nothing
    tables: Callable[[xr.Dataset], Sequence[Table]] = nothing
