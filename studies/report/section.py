"""Sections of a page: findings, figures and tables of a study, with the figures saved beside the page."""

import base64
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from studies.model.drawing import CaptionedFigure, Finding, Table, write_figure


@dataclass(frozen=True, eq=False)
class Section:
    """The part of a page that shows a study or answers a question.

    `name` is its anchor on the page, and `axes_text` names the axes that vary with their values. `file` is the netCDF
    file beside the page, without its ending, and the folder of the figures; the `name` if it is empty.
    """

    name: str
    title: str
    findings: Sequence[Finding]
    figures: Sequence[CaptionedFigure]
    tables: Sequence[Table]
    axes_text: str = ""
    file: str = ""

    @property
    def data(self) -> str:
        """Name of the netCDF file beside the page, without its ending."""
        return self.file or self.name

    @property
    def answers(self) -> Sequence[Finding]:
        """Findings that answer a question of the reader."""
        return [item for item in self.findings if item.question]


def embedded(drawn: CaptionedFigure, folder: str, out: Path) -> Mapping[str, str]:
    """Save a figure into ``<out>/<folder>``, and return what a page shows of it as texts.

    They are ``png`` in base64, the path of its ``file``, ``caption``, and ``width`` and ``height`` in pixels.
    """
    [path] = write_figure(drawn.figure, out / folder / drawn.name, ["png"])
    return {
        "png": base64.b64encode(path.read_bytes()).decode(),
        "file": f"{folder}/{drawn.name}.png",
        "caption": drawn.caption,
        "width": f"{100 * drawn.figure.get_figwidth():.0f}",
        "height": f"{100 * drawn.figure.get_figheight():.0f}",
    }
