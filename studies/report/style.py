"""How figures look: one colour and marker per padding, the same in every figure."""

from dataclasses import dataclass
from typing import Any

import matplotlib as mpl
import matplotlib.style

from contactstudy.io.figure import LAW, SETTINGS, finish, panels
from studies.reference.line_contact import COUNTED

__all__ = ["LAW", "LOOKS", "finish", "look", "marked", "panels"]

mpl.use("Agg")
mpl.style.use(SETTINGS)


@dataclass(frozen=True)
class Look:
    """Colour (Okabe & Ito 2008, safe for colour-blind readers) and marker."""

    color: str
    marker: str


LOOKS = {
    "zero": Look("#595959", "x"),
    "duplicated": Look("#D55E00", "s"),
    "superposed": Look("#009E73", "^"),
    "circular": Look("#CC79A7", "v"),
    "exact": Look("#0072B2", "o"),
    "line": Look("#56B4E9", "*"),
}


def look(padding: str) -> dict[str, Any]:
    """Keywords for matplotlib; a padding without a look of its own is ochre."""
    chosen = LOOKS.get(padding, Look("#E69F00", "D"))
    return {"color": chosen.color, "marker": chosen.marker}


def marked(padding: str) -> dict[str, Any]:
    """:func:`look` for a figure against n, where a padding without an n is a line without markers."""
    return look(padding) | ({} if padding in COUNTED else {"marker": "none"})
