"""Style of the report: colours and markers, text of numbers and settings."""

from typing import Any, SupportsFloat

import matplotlib as mpl
import matplotlib.style
import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from contactstudy.io.pictures.figure import (
    BLUE,
    COLORS,
    GREEN,
    LAW_STYLE,
    ORANGE,
    PURPLE,
    RED,
    SETTINGS,
    add_legend,
    panels,
)
from studies.model.drawing import CaptionedFigure
from studies.reference.paddings import padding_label, padding_text

__all__ = ["COLORS", "LAW_STYLE", "add_legend", "panels"]

WIDTH = 9.2  # of a figure on a page [in]

mpl.use("Agg")
mpl.style.use(SETTINGS)

PADDING_STYLES = {
    "zero": {"color": "#595959", "marker": "x"},
    "duplicated": {"color": RED, "marker": "s"},
    "superposed": {"color": GREEN, "marker": "^"},
    "circular": {"color": PURPLE, "marker": "v"},
    "exact": {"color": BLUE, "marker": "o"},
}


def padding_style(padding: str) -> dict[str, Any]:
    """Return colour and marker as keywords for matplotlib; a padding without a style is orange."""
    name = padding_text(padding).partition(",")[0]
    return dict(PADDING_STYLES.get(name, {"color": ORANGE, "marker": "D"}))


def setting_label(dataset: xr.Dataset | xr.DataArray) -> str:
    """Return the name of the padding of a dataset that has one padding and one n, with its n where it has one."""
    return padding_label(str(dataset["padding"].values), int(dataset["images"]))


def captioned(name: str, figure: Figure, caption: str) -> CaptionedFigure:
    """Return the figure with its legend, file name and caption."""
    add_legend(figure)
    return CaptionedFigure(name, figure, caption)


def percent(value: SupportsFloat) -> str:
    """Return the size of a fraction in per cent, with two digits or more and a space that does not break."""
    fraction = 100 * abs(float(value))
    if not np.isfinite(fraction):
        return "not known"
    digits = 0 if fraction == 0 else max(0, 1 - int(np.floor(np.log10(fraction))))
    return (f"{fraction:.{digits}f}" if digits < 7 else f"{fraction:.1e}") + "\u00a0%"


def paddings(dataset: xr.Dataset) -> list[str]:
    """Return the paddings of a dataset, in its order."""
    return [str(name) for name in dataset["padding"].values]
