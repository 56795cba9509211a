"""How a study is drawn: captioned figures, findings and tables, all read from its stored Dataset."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
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
    """Return nothing: the findings, or the tables, of a drawing that has none."""
    return ()


@dataclass(frozen=True, eq=False)
class Drawing:
    """What the report shows of a study; each function reads the stored Dataset and never solves.

    ``axes`` are those that the functions know by name; of any other axis they are given one value. Without
    ``axes`` they are given all.
    """

    figure: Callable[[xr.Dataset], Sequence[CaptionedFigure]]
    findings: Callable[[xr.Dataset], Sequence[Finding]] = nothing
    tables: Callable[[xr.Dataset], Sequence[Table]] = nothing
    axes: tuple[str, ...] = ()

    def reduced(self) -> Drawing:
        """Return this drawing for datasets with further axes: captions and findings name the value chosen."""

        def figures(dataset: xr.Dataset) -> Sequence[CaptionedFigure]:
            part, words = at_known_axes(dataset, self.axes)
            drawn = self.figure(part)
            if not words:
                return drawn
            return tuple(replace(one, caption=f"{one.caption} Shown at {words}.") for one in drawn)

        def findings(dataset: xr.Dataset) -> Sequence[Finding]:
            part, words = at_known_axes(dataset, self.axes)
            drawn = self.findings(part)
            if not words:
                return drawn
            return tuple(replace(one, measured=f"{one.measured} (At {words}.)") for one in drawn)

        def tables(dataset: xr.Dataset) -> Sequence[Table]:
            part, words = at_known_axes(dataset, self.axes)
            drawn = self.tables(part)
            if not words:
                return drawn
            return tuple(replace(one, caption=f"{one.caption} Shown at {words}.") for one in drawn)

        return Drawing(figures, findings, tables) if self.axes else self


def at_known_axes(dataset: xr.Dataset, known: Sequence[str]) -> tuple[xr.Dataset, str]:
    """Return the dataset at the first value of every axis that is not ``known``, and words that say which."""
    axes = dataset["case_status"].dims if "case_status" in dataset else ()
    other = [str(name) for name in axes if name not in known]
    words = ", ".join(
        f"{name} = {dataset[name].values[0]} (the first of {dataset.sizes[name]})" for name in other
    )
    return dataset.isel(dict.fromkeys(other, 0), drop=True), words
