"""Figures with panels, in one style, and the picture of a measured surface as it enters a contact."""

from collections.abc import Sequence
from io import BytesIO
from math import floor, log10
from pathlib import Path
from textwrap import fill
from typing import Any, Literal, TypeVar

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullFormatter, NullLocator
from numpy.typing import ArrayLike

from contactstudy.domain.grid import Array
from contactstudy.domain.validation import display_unit_of
from contactstudy.io.quantities.contact_quantities import parameters_text, surface_parameters
from contactstudy.scene.surfaces.measured_surface import MeasuredSurface

SETTINGS: Any = mpl.rc_params_from_file(Path(__file__).with_name("contactstudy.mplstyle"), use_default_template=False)
# Okabe & Ito (2008), safe for colour-blind readers.
BLUE, RED, GREEN, PURPLE, ORANGE, SKY = COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
LAW_STYLE: dict[str, Any] = {"color": "black", "linestyle": ":", "linewidth": 1.0, "marker": "none"}


Fields = TypeVar("Fields", xr.Dataset, xr.DataArray)


class Picture(Figure):
    """Figure that a notebook shows once, with or without pyplot."""

    def _repr_png_(self) -> bytes:
        file = BytesIO()
        self.savefig(file, format="png", dpi=SETTINGS["figure.dpi"])
        return file.getvalue()


def panels(count: int, *, columns: int = 3, width: float = 3.4, height: float = 3.2) -> tuple[Figure, list[Axes]]:
    """Return a figure with `count` panels of `width` by `height` in inches, and the panels."""
    columns = min(columns, count)
    rows = -(-count // columns)
    # not pyplot's: no figure stays open
    figure = Picture(figsize=(width * columns, height * rows), layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False).ravel().tolist()
    for spare in axes[count:]:
        spare.set_visible(False)
    return figure, axes[:count]


def second_axis(ax: Axes, label: str, color: str, right: float = 1.0) -> Axes:
    """Return further axes of `ax` with the same x, whose y axis stands at `right`, in widths of `ax`, in one `color`."""
    beside = ax.twinx()
    beside.set_ylabel(label, color=color)
    beside.spines["right"].set(visible=True, position=("axes", right))
    beside.grid(visible=False)
    return beside


def in_the_middle(fields: Fields) -> Fields:
    """Return `fields` at the middle of the length."""
    return fields.isel(y=fields.sizes["y"] // 2)


def in_display_unit(values: xr.DataArray, unit: str, name: str) -> tuple[xr.DataArray, str]:
    """Return `values` of an SI `unit` in the unit for display, and the label `name` with that unit."""
    scale, symbol = display_unit_of(values, unit)
    return values / scale, f"{name} [{symbol}]"


def name_axes(ax: Axes, across: str, up: str, title: str) -> None:
    """Name both axes, and the panel by its title."""
    ax.set(xlabel=across, ylabel=up, title=title)


def draw_map(ax: Axes, x: ArrayLike, y: ArrayLike, values: Any, names: tuple[str, str, str], **look: Any) -> None:
    """Draw `values` (y, x) as colours with their bar, and name both axes and the panel."""
    style: dict[str, Any] = {"cmap": "viridis", "shading": "nearest", "rasterized": True}
    mesh = ax.pcolormesh(x, y, values, **(style | look))
    name_axes(ax, *names)
    ax.grid(visible=False)
    ax.figure.colorbar(mesh, ax=ax)


def number_text(value: float, *others: float) -> str:
    """Return a number for an axis: as it is if it and all `others` there are from 0.001 to 10000, else as a power."""
    if value == 0 or all(1e-3 <= abs(number) < 1e5 for number in (value, *others)):
        return f"{value:g}"
    exponent = floor(log10(abs(value)) + 1e-9)
    digits = f"{value / 10.0**exponent:.3g}"
    return f"$10^{{{exponent}}}$" if digits == "1" else f"${digits}\\cdot10^{{{exponent}}}$"


def label_logarithmic(axis: Axis) -> None:
    """Label a logarithmic axis in one way: decades, with 2 and 5 times these below two of them, evenly below a third.

    The numbers are plain, unless the axis has texts of its own. Ticks that are set, without minor ones, stay.
    """
    low, high = sorted(axis.get_view_interval())
    if high < 1.001 * low:  # one value, and its law within rounding of it
        axis.set_view_interval(low / 2, 2 * high, ignore=True)
        low, high = low / 2, 2 * high
    if isinstance(axis.get_minor_locator(), NullLocator):
        return
    own = axis.get_major_formatter()
    text = own if isinstance(own, FuncFormatter) else FuncFormatter(lambda x, _: number_text(x, low, high))
    axis.set_major_formatter(text)
    if high < 5 * low:
        axis.set_major_locator(MaxNLocator(4, steps=[1, 2, 5, 10]))
        axis.set_minor_locator(NullLocator())
    elif high < 100 * low:
        axis.set_minor_locator(LogLocator(subs=(2, 5)))
        axis.set_minor_formatter(text)
    else:
        axis.set_minor_formatter(NullFormatter())


LEGEND_WIDTH = 5.4  # [in], which a telephone shows of a figure without scrolling


def label_axes(figure: Figure) -> None:
    """Label all logarithmic axes in one way."""
    for axis in (axis for ax in figure.axes for axis in (ax.xaxis, ax.yaxis)):
        if axis.get_scale() == "log":
            label_logarithmic(axis)
        elif axis.get_scale() == "symlog":
            axis.set_major_formatter(lambda value, _: number_text(value))


def finish(figure: Figure, dataset: xr.Dataset) -> Figure:
    """Return a figure with its legend, its warnings above, and below what error was asked and is met."""
    letters = int(14 * figure.get_figwidth())
    add_legend(figure, fill(str(dataset.attrs.get("accuracy", "")), letters))
    if "warnings" in dataset.attrs:
        warning = fill(f"warning: {dataset.attrs['warnings']}", letters)
        figure.suptitle(warning, color=RED, fontsize="small")
    return figure


def add_legend(figure: Figure, title: str = "") -> None:
    """Add one legend with a `title` for all panels below them, at the left, and label logarithmic axes."""
    label_axes(figure)
    entries: dict[str, Any] = {}
    for ax in (ax for ax in figure.axes if ax.get_legend() is None):
        for handle, label in zip(*ax.get_legend_handles_labels(), strict=True):
            entries.setdefault(label, handle)
    if not entries:
        figure.supxlabel(title, fontsize="small", x=0.01, ha="left")
        return
    width = max(1.3, 0.55 + 0.065 * max(map(len, entries)))  # of an entry [in]
    rows = -(-len(entries) // max(1, int(min(figure.get_figwidth(), LEGEND_WIDTH) / width)))
    columns = -(-len(entries) // rows)
    figure.set_figheight(figure.get_figheight() + 0.2 * (rows - 1))
    style = {"title": title or None, "title_fontsize": "small", "alignment": "left"}
    figure.legend(entries.values(), entries.keys(), loc="outside lower left", ncols=columns, **style)


# What of a measured surface is drawn.
Heights = Literal["prepared", "as measured"]


def surface_picture(surface: MeasuredSurface, shown: Sequence[Heights] = ("prepared",)) -> Figure:
    """Draw the heights of a surface that are `shown`, its prepared profiles through the middle, and its parameters."""
    heights = {"prepared": surface.prepared, "as measured": surface.heights}
    extent = surface.extent or surface.heights.shape
    scale, unit = display_unit_of(extent, "m")
    places = [
        (np.arange(count) + 0.5 - count / 2) * size / count / scale
        for count, size in zip(surface.heights.shape, extent, strict=True)
    ]
    with mpl.rc_context(SETTINGS):
        figure, axes = panels(len(shown) + 1, columns=len(shown) + 1, width=4.6, height=4.0)
        for title, ax in zip(shown, axes, strict=False):
            _heights(ax, places, unit, heights[title], title)
        middle, (size, name) = [count // 2 for count in surface.prepared.shape], display_unit_of(surface.prepared, "m")
        profiles = {"across": surface.prepared[:, middle[1]], "along": surface.prepared[middle[0]]}
        for at, (label, profile) in zip(places, profiles.items(), strict=True):
            if len(at) > 1:
                axes[-1].plot(at, profile / size, label=label, linewidth=0.9)
        axes[-1].legend()
        name_axes(axes[-1], f"place [{unit}]", f"height [{name}]", "in the middle")
        figure.suptitle(fill(surface.description, 75 * len(axes)), fontsize="small")
        lines = "\n".join(parameters_text(surface_parameters(surface)))
        axes[-1].text(1.03, 1, lines, transform=axes[-1].transAxes, va="top", family="monospace", size="small")
    return figure


def _heights(ax: Axes, places: Sequence[Array], unit: str, heights: Array, title: str) -> None:
    """Draw heights over their places across and along, in a `unit` of display; those of a profile as a line."""
    size, name = display_unit_of(heights, "m")
    if 1 in heights.shape:
        ax.plot(max(places, key=len), heights.ravel() / size)
        name_axes(ax, f"place [{unit}]", f"height [{name}]", title)
    else:
        names = f"along [{unit}]", f"across [{unit}]", f"height [{name}], {title}"
        draw_map(ax, places[1], places[0], heights / size, names)
