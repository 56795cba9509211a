"""Sections of a page: findings, figures and tables of a study, with the figures saved beside the page."""

import base64
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path

from contactstudy.domain.files import replacing
from studies.model.drawing import CaptionedFigure, Finding, Table

FORMATS = ("png",)


@dataclass(frozen=True, eq=False)
class Section:
    """The part of a page that shows a study or answers a question.

    `name` is its anchor on the page and `axes_text` names axes with their values. `file` is the netCDF file, without
    its ending, and the folder of the figures; `name` if empty.
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


def saved(drawn: CaptionedFigure, folder: Path, formats: Sequence[str]) -> bytes:
    """Save a figure in these formats; return its PNG."""
    # laid out once for all files: each would do it again
    if engine := drawn.figure.get_layout_engine():
        engine.execute(drawn.figure)
        drawn.figure.set_layout_engine("none")
    picture = BytesIO()
    for suffix in formats:
        data = BytesIO()
        drawn.figure.savefig(data, format=suffix)
        with replacing(folder / f"{drawn.name}.{suffix}") as path:
            path.write_bytes(data.getvalue())
        picture = data if suffix == "png" else picture
    return picture.getvalue()


def embedded(
    drawn: CaptionedFigure, folder: str, out: Path, formats: Sequence[str]
) -> Mapping[str, str]:
    """Save a figure into ``<out>/<folder>``, and return what a page shows of it as texts.

    They are ``png`` in base64, the paths of its ``files``, ``caption``, and ``width`` and ``height`` in pixels.
    """
    return {
        "png": base64.b64encode(saved(drawn, out / folder, formats)).decode(),
        "files": " ".join(f"{folder}/{drawn.name}.{suffix}" for suffix in formats),
        "caption": drawn.caption,
        "width": f"{100 * drawn.figure.get_figwidth():.0f}",
        "height": f"{100 * drawn.figure.get_figheight():.0f}",
    }
