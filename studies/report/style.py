"""Style of the report: markers of paddings, text of numbers and settings, the two marks."""

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
    """Return keywords for matplotlib; a padding without a style is ochre."""
    chosen = PADDING_STYLES.get(padding, MarkerStyle("#E69F00", "D"))
    return {"color": chosen.color, "marker": chosen.marker}


def style_over_images(padding: str) -> dict[str, Any]:
    """Return the style in a figure against n, where a padding without an n is a line without markers."""
    return padding_style(padding) | ({} if padding in COUNTS_IMAGES else {"marker": "none"})


def setting_label(dataset: xr.Dataset | xr.DataArray) -> str:
    """Return the name of the padding and the n of a dataset that is reduced to one of each."""
    return padding_label(str(dataset["padding"].values), int(dataset["images"]))


def select_evenly(values: Iterable[float], most: int = 3) -> list[float]:
    """Return at most ``most`` of ``values``, the first and the last among them: as many as fit on a figure."""
    chosen = list(values)
    if len(chosen) <= most:
        return chosen
    return [chosen[round(k * (len(chosen) - 1) / (most - 1))] for k in range(most)]


def percent(value: SupportsFloat) -> str:
    """Return a share in per cent, with two significant digits; the space before the sign does not break."""
    share = 100 * abs(float(value))
    if not np.isfinite(share):
        return "not known"
    digits = 0 if share == 0 else max(0, 1 - int(np.floor(np.log10(share))))
    return (f"{share:.{digits}f}" if digits < 7 else f"{share:.1e}") + "\u00a0%"


def paddings(dataset: xr.Dataset) -> list[str]:
    """Return the paddings of a dataset, in its order."""
    return [str(name) for name in dataset["padding"].values]


def variation_text(dataset: xr.Dataset) -> str:
    """Return in words by how much the pressure of one setting varies along the length."""
    variation = float(dataset["length_variation"])
    return f"{percent(variation)} of p_{{H}}" if variation > 1e-12 else "rounding only"


MARK = re.compile(r"([_^])\{([^{}]*)\}")  # p_{H} is an index, N^{-1.5} a power


def power(base: str, exponent: float, digits: int = 2) -> str:
    """Return ``base`` to the power of ``exponent``, with the mark for a power."""
    return f"{base}^{{{exponent:.{digits}f}}}".replace("-", "−")


def marked(text: str) -> Markup:
    """Return ``text`` as HTML, with its marks for indices and powers as tags."""

    def tag(mark: re.Match[str]) -> str:
        name = "sub" if mark[1] == "_" else "sup"
        return f"<{name}>{mark[2]}</{name}>"

    return Markup(MARK.sub(tag, str(escape(text))))


def plain(text: str) -> str:
    """Return ``text`` without marks, for places that cannot show them."""
    return MARK.sub(r"\1\2", text)
