"""Figures as data: what stands on the axes of a figure, drawn by one function from a stored study in one style."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from itertools import cycle
from textwrap import fill
from typing import Any, SupportsFloat

import matplotlib as mpl
import matplotlib.style
import numpy as np
import xarray as xr
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator

from contactstudy.domain.grid import Array
from contactstudy.domain.validation import display_unit_of
from contactstudy.io.pictures import BLUE, COLORS, GREEN, LAW_STYLE, ORANGE, PURPLE, RED, SETTINGS, add_legend, panels
from studies.advice.verdict import pareto_front
from studies.model.drawing import CaptionedFigure
from studies.model.outcome import CaseStatus
from studies.model.plain_text import one_line, two_digits
from studies.reference.line_contact import total_time
from studies.reference.paddings import HAS_IMAGES, padding_text

__all__ = ["COLORS", "LAW_STYLE", "panels"]

mpl.use("Agg")
mpl.style.use(SETTINGS)

WIDTH = 9.2  # of a figure on a page [in]
WIDTHS = {1: 5.6, 2: 4.6}  # of a panel [in], by the number of panels; 3.4 of three or more
DASHES = ("-", "--", "-.", ":")
# Lines that a legend names; of more, as many at equal distances.
MAX_LINES = 8
PADDING_STYLES = {
    "zero": {"color": "#595959", "marker": "x"},
    "duplicated": {"color": RED, "marker": "s"},
    "superposed": {"color": GREEN, "marker": "^"},
    "circular": {"color": PURPLE, "marker": "v"},
    "exact": {"color": BLUE, "marker": "o"},
}
DOUBTFUL: Any = {
    "marker": "o", "mfc": "white", "mec": "0.3", "linestyle": "none",
    "label": "no bound of the error, or one above the requested error",
}  # fmt: skip


@dataclass(frozen=True)
class Law:
    """A closed form beside the measure `y`: a variable of the study, or a function of x and of the part of a line.

    Both are in the units of the file.
    """

    label: str
    y: str
    of: str | Callable[[Array, xr.Dataset], Any]


@dataclass(frozen=True)
class Plot:
    """A figure: a panel for each measure `y`.

    Attributes
    ----------
    name, caption
        File name, and the text below the figure.
    y, x
        Measures; an axis or a measure of the study.
    hue, dash
        Axes with a colour, and with a dash for each value.
    at
        Indices on other axes.
    over
        Axes of which lines are the median, with the range as a band; of others every value is drawn.
    line
        "joined", "none", or "front": the points that no other beats in x and y are joined.
    log
        Logarithmic axes, such as "xy"; None where positive values span more than a decade.
    laws
        Closed forms.
    labels
        Names of axes and measures, where those of the study do not say enough.
    """

    name: str
    y: tuple[str, ...]
    x: str
    hue: str = ""
    dash: str = ""
    at: Mapping[str, int] = field(default_factory=dict)
    over: tuple[str, ...] = ()
    line: str = "joined"
    log: str | None = None
    laws: tuple[Law, ...] = ()
    labels: Mapping[str, str] = field(default_factory=dict)
    caption: str = ""


def draw(dataset: xr.Dataset, plot: Plot) -> CaptionedFigure | None:
    """Draw a figure from a stored study; None where the study lacks one of its measures."""
    good = dataset
    if "case_status" in dataset:
        good = dataset.where(dataset["case_status"] == CaseStatus.OK)
    selected = with_total_time(good)
    measures = [selected.get(name) for name in (plot.x, *plot.y)]
    if not all(measure is not None and bool(measure.notnull().any()) for measure in measures):
        return None
    for name, text in plot.labels.items():
        if name in selected:
            selected[name].attrs["long_name"] = text
    selected = selected.isel({name: place for name, place in plot.at.items() if name in selected.dims})
    count = len(plot.y)
    figure, axes = panels(count, width=WIDTHS.get(count, 3.4), height=3.4)
    for ax, y in zip(axes, plot.y, strict=True):
        panel(ax, selected, y, plot)
    return captioned(plot.name, figure, plot.caption)


def with_total_time(dataset: xr.Dataset) -> xr.Dataset:
    """Return a stored study with the processor time of its cases, where times were taken."""
    return dataset.assign(total_time=total_time(dataset)) if "solve_time_cpu" in dataset else dataset


def panel(ax: Axes, part: xr.Dataset, y: str, plot: Plot) -> None:
    """Draw one measure: its lines with bounds and doubtful values, its laws, the names and scales of the axes."""
    size, label = scaled(part[y])
    across = part[plot.x]
    is_named = across.dtype.kind not in "iuf"
    across_size, across_label = (1.0, _long_name(across)) if is_named else scaled(across)
    if is_named:
        names = [one_line(padding_text(text), 30) for text in across.values]
        part = part.assign_coords({plot.x: (across.dims, np.arange(across.size), across.attrs)})
    span: list[float] = []
    lines = list(_lines(part, y, plot))
    for line, style in lines:
        x, values = xr.broadcast(line[plot.x] / across_size, abs(line[y]) / size if _is_error(y) else line[y] / size)
        joined = "none" if is_named or is_sample(plot.x) else plot.line
        if plot.over:
            _band(ax, x, values, plot, style if joined == "joined" else style | {"linestyle": "none"})
        else:
            _points(ax, x.values.ravel(), values.values.ravel(), joined, style)
        span += x.values[np.isfinite(x.values)].tolist()
    for line, _ in () if plot.over else lines:
        _bounds(ax, line, y, line[plot.x] / across_size, size)
    _set_scales(ax, plot, is_named)
    if any(law.y == y for law in plot.laws) and span:
        limits = ax.get_ylim()
        _draw_laws(ax, part, y, plot, (across_size, size), span)
        ax.set_ylim(limits)
    ax.set(xlabel=across_label, ylabel=label)
    if is_named:
        turned: Any = {"rotation": 30, "ha": "right", "rotation_mode": "anchor"}
        ax.set_xticks(range(len(names)), names, **turned if max(map(len, names)) > 5 else {})
    elif across.ndim == 1 and across.dtype.kind in "iu" and plot.x == "grid":
        ax.set_xticks(across.values, [str(cells) for cells in across.values])
        ax.xaxis.set_minor_locator(NullLocator())


def _lines(part: xr.Dataset, y: str, plot: Plot) -> Iterator[tuple[xr.Dataset, dict[str, Any]]]:
    """Yield the part of each line with its style; of a padding without an n the first of its lines."""
    axes = [name for name in (plot.hue, plot.dash) if name in part.dims]
    hues = part[plot.hue].values.tolist() if plot.hue in axes else [None]
    dashes = part[plot.dash].values.tolist() if plot.dash in axes else [None]
    has_colour_scale, every = len(hues) > len(COLORS), -(-len(hues) // MAX_LINES)
    colors = colormaps["viridis"](np.linspace(0, 0.9, len(hues))) if has_colour_scale else COLORS
    for number, (hue, color) in enumerate(zip(hues, colors, strict=False)):
        has_dashes = plot.hue != "padding" or plot.dash != "images" or hue in HAS_IMAGES
        shown = axes if has_dashes else axes[:1]
        for dash, pattern in zip(dashes if has_dashes else dashes[:1], cycle(DASHES), strict=False):
            at = {name: value for name, value in ((plot.hue, hue), (plot.dash, dash)) if name in axes}
            line = part.sel(at)
            if not line[y].notnull().any():
                continue
            style = {"color": color, "marker": "o", "linestyle": pattern}
            if plot.hue == "padding":
                style |= padding_style(str(hue))
            texts = [value_text(part[name], at[name]) for name in shown]
            label = ", ".join(texts) or "_"
            yield line, style | {"label": f"_{label}" if number % every else label}


def _points(ax: Axes, x: Array, y: Array, line: str, style: dict[str, Any]) -> None:
    """Draw the points of a line; where no x is finite, the largest y as a level."""
    if np.isfinite(y).any() and not np.isfinite(x).any():
        ax.axhline(float(np.nanmax(y)), color=style["color"], linestyle="--", label=style["label"])
        return
    if line == "front":
        best = pareto_front(x, y)
        ax.plot(x, y, **style | {"linestyle": "none", "ms": 3, "alpha": 0.5, "label": "_"})
        x, y = x[best], y[best]
    order = np.argsort(x, kind="stable") if line == "none" else slice(None)
    ax.plot(x[order], y[order], **style | ({"linestyle": "none"} if line == "none" else {}))


def _band(ax: Axes, x: xr.DataArray, values: xr.DataArray, plot: Plot, style: dict[str, Any]) -> None:
    """Draw the median of the samples, and their range."""
    dims = [name for name in plot.over if name in values.dims]
    x = x.isel({name: 0 for name in dims if name in x.dims})
    counts = values.notnull().sum(dims)
    if style["label"] == "_" and dims:
        least, most = int(counts.min()), int(counts.max())
        number = str(most) if least == most else f"{least} to {most}"
        style = style | {"label": f"median of {number}, and their range"}
    ax.fill_between(x, values.min(dims), values.max(dims), color=style["color"], alpha=0.15, lw=0)
    ax.plot(x, values.median(dims), **style)


def _bounds(ax: Axes, line: xr.Dataset, y: str, x: xr.DataArray, size: float) -> None:
    """Draw the finite bounds of a measure as bars, and the values that `doubtful` finds as hollow marks."""
    if (bound := line.get(f"{y}_bound")) is not None and line[y].ndim <= 1:
        bars = bound.where(np.isfinite(bound) & (bound >= 0)) / size
        at, values, lengths = map(np.atleast_1d, (x, line[y] / size, bars))
        ax.errorbar(at, values, yerr=lengths, fmt="none", ecolor="0.6", capsize=2, zorder=1)
    hollow = doubtful(line, y)
    if bool(hollow.notnull().any()):
        ax.plot(np.ravel(x), np.ravel(hollow / size), **DOUBTFUL)


def doubtful(dataset: xr.Dataset, name: str) -> xr.DataArray:
    """Return the values of a measure whose own bound is not known, or above the requested error; else nan."""
    values, bound = dataset[name], dataset.get(f"{name}_bound")
    is_doubtful = xr.zeros_like(values, dtype=bool) if bound is None else ~np.isfinite(bound)
    if (above := dataset.get("above_request")) is not None:
        is_doubtful = is_doubtful | xr.apply_ufunc(
            np.vectorize(lambda names: name in str(names).split(), otypes=[bool]), above
        )
    return values.where(is_doubtful)


def _draw_laws(ax: Axes, part: xr.Dataset, y: str, plot: Plot, sizes: tuple[float, float], span: list[float]) -> None:
    """Draw the laws of a measure: variables at their points, functions for each colour over the span of x."""
    for law, dash in zip((drawn for drawn in plot.laws if drawn.y == y), cycle((":", "--", "-.")), strict=False):
        style = LAW_STYLE | {"linestyle": dash}
        lines = [part.sel({plot.hue: value}) for value in part[plot.hue].values] if plot.hue in part.dims else [part]
        shown: list[Any] = []
        for line in lines:
            x: Array
            values: Array
            if isinstance(law.of, str):
                if law.of not in line:
                    continue
                x, values = line[plot.x].values / sizes[0], line[law.of].values
            else:
                low, high = min(span), max(span)
                x = np.geomspace(low, high, 200) if low > 0 else np.linspace(low, high, 200)
                values = np.broadcast_to(law.of(x * sizes[0], line), x.shape)
            if any(np.array_equal(values, shown_values) for shown_values in shown):
                continue  # a law that does not depend on the colour
            ax.plot(x, values / sizes[1], label="_" if shown else law.label, **style)
            shown.append(values)


def _set_scales(ax: Axes, plot: Plot, is_named: bool) -> None:  # noqa: FBT001
    """Make the axes logarithmic that `plot.log` names; if None, those of positive values over more than a decade."""
    for name in ("x", "y"):
        values = np.concatenate([np.ravel(getattr(line, f"get_{name}data")()) for line in ax.lines] or [np.zeros(0)])
        logarithmic = spans_decade(values) if plot.log is None else name in plot.log
        if logarithmic and not (name == "x" and is_named):
            getattr(ax, f"set_{name}scale")("log")


def spans_decade(values: Array) -> bool:
    """Return whether the finite ones among some values are above zero and span more than a decade."""
    finite = values[np.isfinite(values.astype(float))]
    return bool(finite.size > 1 and finite.min() > 0 and finite.max() > 10 * finite.min())


def is_sample(axis: str) -> bool:
    """Return whether an axis numbers random samples of one surface."""
    return axis.rsplit(".", 1)[-1].rsplit("_", 1)[-1] in ("seed", "tile")


def _is_error(name: str) -> bool:
    """Return whether a measure is a relative error or difference, which is drawn in per cent of its size."""
    return "error" in name or "difference" in name


def scaled(values: xr.DataArray) -> tuple[float, str]:
    """Return the size of the unit that suits the largest value, and the label of an axis with that unit."""
    units = str(values.attrs.get("units", "1"))
    size, unit = (1e-2, "%") if _is_error(str(values.name)) and units == "1" else display_unit_of(values, units)
    if units == "s" and float(abs(values).max()) < 1:
        size, unit = 1e-3, "ms"
    return size, fill(f"{_long_name(values)} [{unit}]" if unit else _long_name(values), 34)


def value_text(axis: xr.DataArray, value: Any) -> str:
    """Return a value of an axis for a legend: names as they are, numbers with the name of the axis and the unit."""
    if isinstance(value, str):
        return one_line(padding_text(value), 30)
    if axis.name == "images":
        return f"n = {value}"
    size, unit = display_unit_of(axis, str(axis.attrs.get("units", "1")))
    return f"{_long_name(axis).split(',')[0]} {value / size:.3g} {unit}".rstrip()


def _long_name(values: xr.DataArray) -> str:
    """Return the name of an axis or measure for people."""
    return str(values.attrs.get("long_name", values.name))


def padding_style(padding: str) -> dict[str, Any]:
    """Return colour and marker as keywords for matplotlib; a padding without a style is orange."""
    name = padding_text(padding).partition(",")[0]
    return dict(PADDING_STYLES.get(name, {"color": ORANGE, "marker": "D"}))


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


def seconds_text(seconds: float) -> str:
    """Return a time with two digits, in ms below a second."""
    if seconds >= 0.9995:
        return f"{two_digits(seconds)} s"
    return f"{two_digits(1000 * seconds)} ms"
