"""Drawing of a study: captioned figures, findings and tables, all made from its stored Dataset."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from contactstudy import InvalidInput
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
    axes
        Axes that the functions know by name; of any other axis they get the first value. Empty passes all axes.
    """

    figure: Callable[[xr.Dataset], Sequence[CaptionedFigure]]
    findings: Callable[[xr.Dataset], Sequence[Finding]] = no_items
    tables: Callable[[xr.Dataset], Sequence[Table]] = no_items
    axes: tuple[str, ...] = ()

    def reduced(self) -> Drawing:
        """Return this drawing for datasets with further axes, with the chosen values in captions and findings."""

        def with_note(
            draw: Callable[[xr.Dataset], Sequence[Any]], attribute: str, template: str
        ) -> Callable[[xr.Dataset], Sequence[Any]]:
            """Return `draw` for the known axes, with a note of the other values in an attribute of each item."""

            def noted(dataset: xr.Dataset) -> Sequence[Any]:
                part, values = first_of_unknown_axes(dataset, self.axes)
                items = draw(part)
                if not values:
                    return items
                note = template.format(values)
                return tuple(
                    replace(item, **{attribute: f"{getattr(item, attribute)} {note}"})
                    for item in items
                )

            return noted

        if not self.axes:
            return self
        return Drawing(
            with_note(self.figure, "caption", "Shown at {}."),
            with_note(self.findings, "measured", "(At {}.)"),
            with_note(self.tables, "caption", "Shown at {}."),
        )


def first_of_unknown_axes(dataset: xr.Dataset, axes_known: Sequence[str]) -> tuple[xr.Dataset, str]:
    """Return the dataset at the first value of every axis that is not in `axes_known`, and a text with these values."""
    axes = dataset["case_status"].dims if "case_status" in dataset else ()
    unknown = [str(name) for name in axes if name not in axes_known]
    words = ", ".join(
        f"{name} = {dataset[name].values[0]} (the first of {dataset.sizes[name]})"
        for name in unknown
    )
    return dataset.isel(dict.fromkeys(unknown, 0), drop=True), words
