"""How figures look: one colour, marker and name per padding, the same in every figure."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib as mpl
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from studies.store import replacing
from studies.study import Plate

mpl.use("Agg")

SETTINGS = {
    "figure.dpi": 100,
    "savefig.dpi": 200,
    "font.size": 9.5,
    "axes.grid": True,
    "grid.alpha": 0.25,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.titlesize": "medium",
    "legend.frameon": False,
    "legend.fontsize": "small",
    "lines.linewidth": 1.4,
    "lines.markersize": 5,
    "pdf.fonttype": 42,
    "svg.fonttype": "none",
}
mpl.rcParams.update(SETTINGS)


@dataclass(frozen=True)
class Look:
    """Colour (Okabe & Ito 2008, safe for colour-blind readers) and marker."""

    color: str
    marker: str


LOOKS = {
    "zero": Look("#595959", "x"),
    "duplicated": Look("#D55E00", "s"),
    "superposed": Look("#009E73", "^"),
    "exact": Look("#0072B2", "o"),
}
LAW = {"color": "black", "linestyle": ":", "linewidth": 1.0, "marker": "none"}


def look(padding: str) -> dict[str, str]:
    """Keywords for matplotlib; a padding without a look of its own is purple."""
    chosen = LOOKS.get(padding, Look("#CC79A7", "D"))
    return {"color": chosen.color, "marker": chosen.marker}


def panels(
    count: int, *, columns: int = 3, width: float = 3.4, height: float = 3.2
) -> tuple[Figure, list[Axes]]:
    """A figure with ``count`` panels."""
    columns = min(columns, count)
    rows = -(-count // columns)
    # not pyplot's: nothing is kept open, nothing needs closing
    figure = Figure(figsize=(max(width * columns, 5), height * rows), layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False).ravel().tolist()
    for spare in axes[count:]:
        spare.set_visible(False)
    return figure, axes[:count]


def some(values: Iterable[float], most: int = 3) -> list[float]:
    """At most ``most`` of ``values``, first and last among them: what fits on a figure."""
    chosen = list(values)
    if len(chosen) <= most:
        return chosen
    return [chosen[round(k * (len(chosen) - 1) / (most - 1))] for k in range(most)]


def text(names: Iterable[object]) -> list[str]:
    """Coordinate labels as plain text."""
    return [str(name) for name in names]


def percent(value: float) -> str:
    """A share as a person writes it: two digits, in per cent."""
    share = 100 * abs(float(value))
    if share == 0:
        return "0 %"
    if share < 1e-3:
        return f"{share:.1e} %".replace("e-0", "e-")
    return f"{share:.2g} %" if share < 10 else f"{share:.0f} %"


def paddings(dataset: xr.Dataset) -> list[str]:
    """The paddings a Dataset holds, in its order."""
    return text(dataset["padding"].values)


def save(plates: Sequence[Plate], folder: Path) -> None:
    """Every plate as PNG and PDF in ``folder``."""
    for plate in plates:
        for suffix in ("png", "pdf"):
            with replacing(folder / f"{plate.name}.{suffix}") as path:
                plate.figure.savefig(path)
