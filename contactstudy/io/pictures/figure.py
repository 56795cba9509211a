"""Figures with panels, in one style."""

from math import ceil, log10
from typing import Any, Literal

import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogFormatterSciNotation, LogLocator, NullFormatter, NullLocator

from contactstudy.domain.units import display_unit_of

SETTINGS: Any = {
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
}
Share = Literal["none", "y", "both"]

LAW_STYLE: dict[str, Any] = {"color": "black", "linestyle": ":", "linewidth": 1.0, "marker": "none"}


def panels(
    count: int, *, columns: int = 3, width: float = 3.4, height: float = 3.2, share: Share = "none"
) -> tuple[Figure, list[Axes]]:
    """Return a figure with `count` panels, and the panels.

    A panel is `width` by `height` in inches. Panels share no scale ("none"), that of y ("y"), or both ("both").
    """
    columns = min(columns, count)
    rows = -(-count // columns)
    # not pyplot's: no figure stays open
    figure = Figure(figsize=(width * columns, height * rows), layout="constrained")
    axes = (
        figure.subplots(
            rows, columns, squeeze=False, sharex=share == "both", sharey=share != "none"
        )
        .ravel()
        .tolist()
    )
    for spare in axes[count:]:
        spare.set_visible(False)
    return figure, axes[:count]


def in_display_unit(values: xr.DataArray, unit: str, name: str) -> tuple[xr.DataArray, str]:
    """Return `values` of an SI `unit` in the unit for display, and the label `name` with that unit."""
    scale, symbol = display_unit_of(values, unit)
    return values / scale, f"{name} [{symbol}]"


def name_axes(ax: Axes, across: str, up: str, title: str) -> None:
    """Name both axes, and the panel by its title."""
    ax.set(xlabel=across, ylabel=up, title=title)


def add_legend(figure: Figure) -> None:
    """Add one legend for all panels, outside them, and label logarithmic axes so that labels do not overlap.

    Where two decades are shown, only decades are labelled; where one is, also twice and five times a decade. An axis
    whose ticks are set, without minor ones, is left as it is.
    """
    entries: dict[str, Any] = {}
    for ax in figure.axes:
        for axis in (ax.xaxis, ax.yaxis):
            if axis.get_scale() == "log":
                low, high = axis.get_view_interval()
                if high < 1.001 * low:  # one value, and its law within rounding of it
                    axis.set_view_interval(low / 2, 2 * high, ignore=True)
                decade = 10.0 ** ceil(log10(low))  # the first that is shown, if one is
                if high >= 10 * decade or isinstance(axis.get_minor_locator(), NullLocator):
                    axis.set_minor_formatter(NullFormatter())
                elif high >= decade:  # the labels between would lie on each other
                    axis.set_minor_locator(LogLocator(subs=(2, 5)))
                    axis.set_minor_formatter(LogFormatterSciNotation(minor_thresholds=(2, 2)))
        for handle, label in zip(*ax.get_legend_handles_labels(), strict=True):
            entries.setdefault(label, handle)
    if not entries:
        return
    width = max(1.7, 0.7 + 0.075 * max(map(len, entries)))  # of an entry [in]
    rows = -(-len(entries) // max(1, int(figure.get_figwidth() / width)))
    columns = -(-len(entries) // rows)
    figure.legend(entries.values(), entries.keys(), loc="outside lower center", ncols=columns)
