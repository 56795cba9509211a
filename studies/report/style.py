"""How figures look: one colour and marker per padding, the same in every figure."""

from dataclasses import dataclass
from typing import Any

import matplotlib as mpl
import matplotlib.style

from contactstudy.io.pictures.figure import LAW_STYLE, SETTINGS, add_legend, panels
from studies.reference.line_contact import COUNTS_IMAGES

__all__ = [
    "LAW_STYLE",
    "PADDING_STYLES",
    "add_legend",
    "padding_style",
    "panels",
    "style_over_images",
]

mpl.use("Agg")
mpl.style.use(SETTINGS)


@dataclass(frozen=True)
class MarkerStyle:
    """Colour (Okabe & Ito 2008, safe for colour-blind readers) and marker."""

    color: str
    marker: str


PADDING_STYLES = {
    "zero": MarkerStyle("#595959", "x"),
    "duplicated": MarkerStyle("#D55E00", "s"),
    "superposed": MarkerStyle("#009E73", "^"),
    "circular": MarkerStyle("#CC79A7", "v"),
    "exact": MarkerStyle("#0072B2", "o"),
    "line": MarkerStyle("#56B4E9", "*"),
}


def padding_style(padding: str) -> dict[str, Any]:
    """Keywords for matplotlib; a padding without a look of its own is ochre."""
    chosen = PADDING_STYLES.get(padding, MarkerStyle("#E69F00", "D"))
    return {"color": chosen.color, "marker": chosen.marker}


def style_over_images(padding: str) -> dict[str, Any]:
    """:func:`padding_style` for a figure against n, where a padding without an n is a line without markers."""
    return padding_style(padding) | ({} if padding in COUNTS_IMAGES else {"marker": "none"})
