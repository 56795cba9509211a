"""How the report looks and reads: markers of paddings, text of numbers and settings, the two marks."""

import re
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, SupportsFloat

import matplotlib as mpl
import matplotlib.style
import numpy as np
import xarray as xr
from markupsafe import Markup, escape

from contactstudy.io.pictures.figure import LAW_STYLE, SETTINGS, add_legend, panels
from studies.reference.line_contact import COUNTS_IMAGES, padding_label

__all__ = ["LAW_STYLE", "add_legend", "panels"]

# Okabe & Ito (2008), safe for colour-blind readers.
COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")

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


def setting_label(dataset: xr.Dataset | xr.DataArray) -> str:
    """:func:`padding_label` of a Dataset reduced to one padding and one n."""
    return padding_label(str(dataset["padding"].values), int(dataset["images"]))


def select_evenly(values: Iterable[float], most: int = 3) -> list[float]:
    """At most ``most`` of ``values``, first and last among them: what fits on a figure."""
    chosen = list(values)
    if len(chosen) <= most:
        return chosen
    return [chosen[round(k * (len(chosen) - 1) / (most - 1))] for k in range(most)]


def percent(value: SupportsFloat) -> str:
    """A share in per cent, with two significant digits; the space before the sign does not break."""
    share = 100 * abs(float(value))
    if not np.isfinite(share):
        return "not known"
    digits = 0 if share == 0 else max(0, 1 - int(np.floor(np.log10(share))))
    return (f"{share:.{digits}f}" if digits < 7 else f"{share:.1e}") + "\u00a0%"


def paddings(dataset: xr.Dataset) -> list[str]:
    """The paddings a Dataset holds, in its order."""
    return [str(name) for name in dataset["padding"].values]


def variation_text(dataset: xr.Dataset) -> str:
    """How much the pressure of one setting varies along the length."""
    variation = float(dataset["length_variation"])
    return f"{percent(variation)} of p_{{H}}" if variation > 1e-12 else "rounding only"


MARK = re.compile(r"([_^])\{([^{}]*)\}")  # p_{H} is an index, N^{-1.5} a power


def power(base: str, exponent: float, digits: int = 2) -> str:
    """``base`` to the power of ``exponent``, with the mark for a power."""
    return f"{base}^{{{exponent:.{digits}f}}}".replace("-", "−")


def marked(text: str) -> Markup:
    """``text`` as HTML, with its marks for indices and powers as tags."""

    def tag(mark: re.Match[str]) -> str:
        name = "sub" if mark[1] == "_" else "sup"
        return f"<{name}>{mark[2]}</{name}>"

    return Markup(MARK.sub(tag, str(escape(text))))


def plain(text: str) -> str:
    """``text`` without marks, for what cannot show them."""
    return MARK.sub(r"\1\2", text)
