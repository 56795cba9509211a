"""Pictures of any answer, by what its dataset holds, and of a measured surface as it enters a contact."""

import re
from collections.abc import Callable, Sequence
from io import BytesIO
from math import floor, inf, log10
from pathlib import Path
from textwrap import fill
from typing import Any, Literal, NamedTuple, TypeVar

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullFormatter, NullLocator
from numpy.typing import ArrayLike

from contactstudy.domain.grid import Array
from contactstudy.domain.validation import display_unit_of, readable
from contactstudy.io.quantities.surface_parameters import parameters_text, surface_parameters
from contactstudy.scene.surfaces.measured_surface import MeasuredSurface

# Style of all pictures, such as fonts, sizes and resolution.
SETTINGS: Any = mpl.rc_params_from_file(Path(__file__).with_name("contactstudy.mplstyle"), use_default_template=False)
# Colours of Okabe & Ito (2008), safe for colour-blind readers, in the order in which they are taken.
BLUE, RED, GREEN, PURPLE, ORANGE, SKY = COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
GREY = "#595959"
# Style of the line of a law or a closed form beside what was computed.
LAW_STYLE: dict[str, Any] = {"color": "black", "linestyle": ":", "linewidth": 1.0, "marker": "none"}
# Width of a legend at most [in], which a telephone shows of a figure without scrolling.
LEGEND_WIDTH = 5.4
# Width of an entry of a legend [in]: that of its line, and that of a letter. Letters of a text in an inch.
LINE_WIDTH, LETTER_WIDTH, LETTERS_PER_INCH = 0.55, 0.065, 14
# Either of a dataset and one of its variables.
Fields = TypeVar("Fields", xr.Dataset, xr.DataArray)


class Picture(Figure):
    """Figure that a notebook shows once, with or without pyplot."""

    def _repr_png_(self) -> bytes:
        """Return the figure as a PNG file, which a notebook asks for."""
        file = BytesIO()
        self.savefig(file, format="png", dpi=SETTINGS["figure.dpi"])
        return file.getvalue()


def panels(count: int, *, columns: int = 3, width: float = 3.4, height: float = 3.2) -> tuple[Figure, list[Axes]]:
    """Return a figure with `count` panels of `width` by `height` [in] in at most so many `columns`, and the panels."""
    columns = min(columns, count)
    rows = -(-count // columns)
    # not pyplot's: no figure stays open
    figure = Picture(figsize=(width * columns, height * rows), layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False).ravel().tolist()
    for spare in axes[count:]:
        spare.set_visible(False)
    return figure, axes[:count]


def second_axis(ax: Axes, label: str, color: str, right: float = 1.0) -> Axes:
    """Return axes with the x axis of `ax` and a y axis of their own, which stands at `right`, in widths of `ax`.

    That axis has a `label` in one `color`.
    """
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
    """Name the x axis by `across` and the y axis by `up`, and give the panel a `title`."""
    ax.set(xlabel=across, ylabel=up, title=title)


def draw_map(ax: Axes, x: ArrayLike, y: ArrayLike, values: Any, names: tuple[str, str, str], **look: Any) -> None:
    """Draw `values` (y, x) as colours with their bar; the `names` are those of the x axis, the y axis and the panel.

    Further keywords `look` are those of ``pcolormesh``.
    """
    style: dict[str, Any] = {"cmap": "viridis", "shading": "nearest", "rasterized": True}
    mesh = ax.pcolormesh(x, y, values, **(style | look))
    name_axes(ax, *names)
    ax.grid(visible=False)
    ax.figure.colorbar(mesh, ax=ax)


def number_text(value: float, *others: float) -> str:
    """Return a `value` as text for an axis: plain if it and all `others` are from 0.001 to 1e5, else as a power."""
    if value == 0 or all(1e-3 <= abs(number) < 1e5 for number in (value, *others)):
        return f"{value:g}"
    exponent = floor(log10(abs(value)) + 1e-9)
    digits = f"{value / 10.0**exponent:.3g}"
    return f"$10^{{{exponent}}}$" if digits == "1" else f"${digits}\\cdot10^{{{exponent}}}$"


def label_logarithmic(axis: Axis) -> None:
    """Label a logarithmic axis in one way, by the range that it shows.

    Over two decades and more there are decades, below that also 2 and 5 times these, and below a factor of five evenly
    spaced numbers. Texts of ticks that an axis has of its own stay, and so do ticks that are set without minor ones.
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


def label_axes(figure: Figure) -> None:
    """Label all logarithmic axes of a `figure` in one way."""
    for axis in (axis for ax in figure.axes for axis in (ax.xaxis, ax.yaxis)):
        if axis.get_scale() == "log":
            label_logarithmic(axis)
        elif axis.get_scale() == "symlog":
            axis.set_major_formatter(lambda value, _: number_text(value))


def finish(figure: Figure, dataset: xr.Dataset) -> Figure:
    """Return a figure with its legend, the warnings of its `dataset` above, and the error asked and met below."""
    letters = int(LETTERS_PER_INCH * figure.get_figwidth())
    add_legend(figure, fill(str(dataset.attrs.get("accuracy", "")), letters))
    if "warnings" in dataset.attrs:
        warning = fill(f"warning: {dataset.attrs['warnings']}", letters)
        figure.suptitle(warning, color=RED, fontsize="small")
    return figure


def add_legend(figure: Figure, title: str = "") -> None:
    """Add one legend with a `title` for all panels of a `figure`, below them at the left, and label logarithmic axes."""
    label_axes(figure)
    entries: dict[str, Any] = {}
    for ax in (ax for ax in figure.axes if ax.get_legend() is None):
        for handle, label in zip(*ax.get_legend_handles_labels(), strict=True):
            entries.setdefault(label, handle)
    if not entries:
        figure.supxlabel(title, fontsize="small", x=0.01, ha="left")
        return
    width = max(1.3, LINE_WIDTH + LETTER_WIDTH * max(map(len, entries)))
    rows = -(-len(entries) // max(1, int(min(figure.get_figwidth(), LEGEND_WIDTH) / width)))
    columns = -(-len(entries) // rows)
    figure.set_figheight(figure.get_figheight() + 0.2 * (rows - 1))
    style = {"title": title or None, "title_fontsize": "small", "alignment": "left"}
    figure.legend(entries.values(), entries.keys(), loc="outside lower left", ncols=columns, **style)


# Heights of a measured surface that are drawn: as they enter a contact, or as they were measured.
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
    """Draw `heights` (x, y) [m] over `places` (across, along) in a `unit` of display; those of a profile as a line.

    The panel has the `title`.
    """
    size, name = display_unit_of(heights, "m")
    if 1 in heights.shape:
        ax.plot(max(places, key=len), heights.ravel() / size)
        name_axes(ax, f"place [{unit}]", f"height [{name}]", title)
    else:
        names = f"along [{unit}]", f"across [{unit}]", f"height [{name}], {title}"
        draw_map(ax, places[1], places[0], heights / size, names)


# Fraction of half a roller's length that is drawn at each end.
END_FRACTION = 0.4
# Half-width of what is drawn of a film, steady and in time, in Hertz's half-widths: the inlet is several times as wide.
FILM_WIDTH, FILM_WIDTH_IN_TIME = 2.0, 1.5
# Film thickness over the least one up to which a film is drawn on a linear axis.
THICKEST_FILM = 8.0
# Largest number of instants, or passes, whose profiles are drawn: more colours are not told apart.
MAX_PROFILES = 6
# Decades that a logarithmic axis of errors has at the most.
DECADES = 6
# Place of the legend of a panel, beside it.
BESIDE: Any = {"loc": "upper left", "bbox_to_anchor": (1.0, 1.0)}
# Draws one panel of a dataset: the variable of this name, and what belongs to it.
Panel = Callable[[Axes, xr.Dataset, str], None]
# Variables whose panel is drawn even if all of their values are zero.
ALWAYS_DRAWN = "pressure", "gap", "load"
# Variables that are drawn together with one, on its panel, itself first.
TOGETHER = {
    "shear_x": ("shear_x", "shear_y"),
    "a": ("a", "b"),
    "load": ("load", "peak_pressure", "contact_area"),
    "central_film": ("central_film", "minimum_film"),
}
# Variables on a logarithmic axis: a film is a hundred times as thick beside the contact as in it.
LOGARITHMIC = ("film",)


class Kind(NamedTuple):
    """A kind of dataset and its picture.

    Attributes
    ----------
    needed
        Variables and dimensions that such a dataset has.
    panels
        Names of variables, each with what draws its panel. Variables of each body, which end with an underscore and its
        number, are drawn by the name without that.
    width
        Width of a panel [in].
    reach
        Half-width of what is drawn, in Hertz's half-widths.
    """

    needed: set[str]
    panels: Sequence[tuple[str, Panel]]
    width: float = 4.6
    reach: float = inf


def picture_of(dataset: xr.Dataset) -> Figure | None:
    """Return the picture of a contact or a film, of either in time, or of passes; None of another dataset."""
    names = {*map(str, dataset.variables), *map(str, dataset.dims)}
    kind = next((kind for kind in KINDS if kind.needed <= names), None)
    return None if kind is None else _picture(dataset, kind)


def _picture(dataset: xr.Dataset, kind: Kind) -> Figure:
    """Return a figure with a panel for each variable of the `kind` that has values in `dataset`; for all if none has."""
    if kind.reach < inf:
        dataset = _inside(dataset, kind.reach)
    named = [
        (draw, str(name))
        for variable, draw in kind.panels
        for name in dataset
        if re.fullmatch(rf"{variable}(_\d+)?", str(name))
        if draw not in (_map, _along) or dataset.sizes["y"] > 1
    ]
    has_values = ((np.isfinite(dataset[name]) & (dataset[name] != 0)).any() for _, name in named)
    drawn = [panel for panel, has in zip(named, has_values, strict=True) if has or panel[1] in ALWAYS_DRAWN] or named
    with mpl.rc_context(SETTINGS):
        columns = 3 if len(drawn) > 4 and kind.width < 5 else 2
        figure, axes = panels(len(drawn), columns=columns, width=kind.width, height=3.4)
        for (draw, name), ax in zip(drawn, axes, strict=True):
            draw(ax, dataset, name)
        return finish(figure, dataset)


def _inside(dataset: xr.Dataset, reach: float) -> xr.Dataset:
    """Return a dataset within `reach` half-widths of Hertz of the axis."""
    distance = reach * float(dataset["hertz_half_width"].max())
    return dataset.sel(x=slice(-distance, distance))


def _section(ax: Axes, dataset: xr.Dataset, name: str) -> None:
    """Draw the variable `name` across the middle of the length, with those that are drawn `TOGETHER` with it."""
    names = [other for other in TOGETHER.get(name, (name,)) if dataset[other].any() or other == name]
    scale, unit = _unit(dataset, names)
    x, across = in_display_unit(dataset["x"], "m", "across")
    for other, color in zip(names, (GREEN, RED), strict=False):
        label = str(dataset[other].attrs["long_name"]) if len(names) > 1 else ""
        ax.plot(x, in_the_middle(dataset[other]) / scale, label=label, color=color)
    # without its direction, such as "along x", which the legend names
    what = str(dataset[name].attrs["long_name"]).partition(" along ")[0]
    name_axes(ax, across, f"{what} [{unit}]", "in the middle")
    if name in LOGARITHMIC:
        ax.set_yscale("log")


def _unit(dataset: xr.Dataset, names: Sequence[str]) -> tuple[float, str]:
    """Return the unit for display of the variables `names` together: its size in their SI unit, and its name.

    It suits the largest value, or the mean where an axis is logarithmic.
    """
    sizes = abs(dataset[list(names)]).to_array()
    return display_unit_of(sizes.mean() if names[0] in LOGARITHMIC else sizes, dataset[names[0]].attrs["units"])


def _map(ax: Axes, dataset: xr.Dataset, name: str) -> None:
    """Draw a variable over the grid, one with values of both signs in colours of both signs."""
    x, across = in_display_unit(dataset["x"], "m", "across")
    y, along = in_display_unit(dataset["y"], "m", "along")
    scale, unit = _unit(dataset, [name])
    values = dataset[name] / scale
    largest = float(np.abs(values).max()) or 1.0
    look = {"cmap": "RdBu_r", "vmin": -largest, "vmax": largest} if (values < 0).any() else {}
    draw_map(ax, y, x, values, (along, across, f"{dataset[name].attrs['long_name']} [{unit}]"), **look)
    if "half_length" in dataset:  # a point contact is drawn to equal scale
        ax.set_aspect(display_unit_of(dataset["x"], "m")[0] / display_unit_of(dataset["y"], "m")[0])


def _along(ax: Axes, dataset: xr.Dataset, name: str) -> None:
    """Draw the pressure along the middle of the contact, and Hertz's peak pressure."""
    y, along = in_display_unit(dataset["y"], "m", "along")
    scale, unit = display_unit_of(dataset[name], "Pa")
    axis = np.abs(dataset["x"]) <= np.abs(dataset["x"]).min() * (1 + 1e-9)
    middle = dataset[name].where(axis, drop=True).mean("x")
    ax.plot(y, middle / scale, label="in the middle", color=BLUE)
    if "hertz_peak_pressure" in dataset:
        ax.axhline(float(dataset["hertz_peak_pressure"]) / scale, **LAW_STYLE)
    name_axes(ax, along, f"pressure [{unit}]", "along the contact")


def _across(ax: Axes, dataset: xr.Dataset, name: str) -> None:
    """Draw the pressure across, with its range along the length, the attraction and Hertz's pressure."""
    x, across = in_display_unit(dataset["x"], "m", "across")
    pressure = dataset[name]
    scale, unit = display_unit_of(pressure, "Pa")
    if dataset.sizes["y"] > 1:
        look: Any = {"color": BLUE, "alpha": 0.18, "linewidth": 0, "label": "lowest to highest"}
        ax.fill_between(x, pressure.min("y") / scale, pressure.max("y") / scale, **look)
    ax.plot(x, in_the_middle(pressure) / scale, label="in the middle", color=BLUE)
    if "attraction" in dataset:
        ax.plot(x, -in_the_middle(dataset["attraction"]) / scale, label="attraction, downwards", color=RED)
    if "hertz_half_width" in dataset:
        t = dataset["x"] / float(dataset["hertz_half_width"])
        hertz = float(dataset["hertz_peak_pressure"]) * np.sqrt(np.clip(1 - t**2, 0, None))
        ax.plot(x, hertz / scale, label="Hertz", **LAW_STYLE)
    name_axes(ax, across, f"pressure [{unit}]", "across the contact")


def _ends(ax: Axes, dataset: xr.Dataset, name: str) -> None:
    """Draw the largest pressure across, and the drop, against the distance from the end of a roller."""
    drop = dataset[name].dropna("y")
    y = drop["y"]
    middle, half = float(y[[0, -1]].mean()), float(y[-1] - y[0]) * (0.5 + 0.5 / max(len(y) - 1, 1))
    pressure, up = in_display_unit(dataset["pressure"].max("x").sel(y=y), "Pa", "pressure")
    depth, down = in_display_unit(drop, "m", "drop")
    beside = second_axis(ax, down, RED)
    symmetric = np.allclose(pressure, pressure[::-1], atol=1e-3 * float(pressure.max()))
    for side, style in ((1, "-"), (-1, "--"))[: 1 if symmetric else 2]:
        shown = side * (y - middle) >= (1 - END_FRACTION) * half
        distance, along = in_display_unit((half - side * (y - middle))[shown], "m", "from the end")
        end = "" if symmetric else f"end at {'larger' if side > 0 else 'smaller'} y"
        ax.plot(distance, pressure[shown], style, label=end, color=BLUE)
        beside.plot(distance, depth[shown], style, color=RED)
    name_axes(ax, along, up, "at the ends")
    ax.yaxis.label.set_color(BLUE)
    beside.invert_yaxis()


def _fretting_loop(ax: Axes, dataset: xr.Dataset, name: str) -> None:
    """Draw the tangential force over the slip in a cycle."""
    slid, slip = in_display_unit(dataset["loop_slip"], "m", "slip")
    force, up = in_display_unit(dataset[name], dataset[name].attrs["units"], "tangential force")
    ax.plot(slid, force, ".-", color=BLUE)
    name_axes(ax, slip, up, "loop of a cycle")


def _stress(ax: Axes, dataset: xr.Dataset, name: str) -> None:
    """Draw the von Mises stress below the middle of the length, over the depth where there are several."""
    middle = in_the_middle(dataset[name])
    x, across = in_display_unit(dataset["x"], "m", "across")
    z, down = in_display_unit(dataset["z"], "m", "depth")
    stress, up = in_display_unit(middle, "Pa", "von Mises")
    if middle.sizes["z"] == 1:
        ax.plot(x, stress.isel(z=0), color=RED)
    else:
        filled = ax.contourf(x, z, stress, 24, cmap="magma")
        # the interface of a coating, where depths stand twice
        for interface in z.values[1:][np.diff(z) < 1e-6 * float(z[-1])]:
            ax.axhline(interface, color="white", linestyle="--", linewidth=0.8)
        ax.invert_yaxis()
        ax.figure.colorbar(filled, ax=ax)
    title = up.replace("von Mises", "von Mises stress in the middle")
    name_axes(ax, across, up if middle.sizes["z"] == 1 else down, title)
    ax.grid(visible=False)


def comparison_picture(fields: xr.Dataset, at: tuple[float, float]) -> Figure:
    """Draw the difference of two contacts as a map, and both pressures across the place `at` (x, y) [m].

    The `fields` (x, y) [Pa] are the pressures ``a`` and ``b``, and ``difference``, that of b less that of a.
    """

    def where_they_differ_most(ax: Axes, fields: xr.Dataset, name: str) -> None:
        """Draw both pressures across the place `at`."""
        _section(ax, fields.sel(y=[at[1]], method="nearest"), name)
        ax.set_title("where they differ most")
        ax.lines[-1].set_linestyle("--")

    return _picture(fields, Kind(set(), [("difference", _map), ("a", where_they_differ_most)]))


def _film(ax: Axes, contact: xr.Dataset, name: str) -> None:
    """Draw pressure, film and temperature across the middle of a film, each on a scale of its own.

    The film is drawn up to `THICKEST_FILM` times its least thickness; beside the contact it is far thicker.
    """
    inside = _inside(contact, FILM_WIDTH)
    _across(ax, inside, "pressure")
    ax.yaxis.label.set_color(BLUE)
    middle = in_the_middle(inside)
    scales = [(middle[name].where(middle[name] < THICKEST_FILM * middle[name].min()), "m", "film", GREEN)]
    if "film_temperature_rise" in middle:
        scales.append((middle["film_temperature_rise"], "K", "temperature rise", PURPLE))
    x, _ = in_display_unit(middle["x"], "m", "across")
    for number, (shown, unit, label, color) in enumerate(scales):
        values, up = in_display_unit(shown, unit, label)
        beside = second_axis(ax, up, color, 1 + 0.2 * number)
        beside.plot(x, values, label=label, color=color)
        beside.set_ylim(bottom=0)
    ax.set_title("pressure and film" if len(scales) == 1 else "pressure, film and temperature")


def _lines(ax: Axes, evolved: xr.Dataset, name: str) -> None:
    """Draw a variable across the middle of the length at some instants, the first dark, the last bright."""
    scale, unit = _unit(evolved, [name])
    middle = in_the_middle(evolved[name])
    x, across = in_display_unit(evolved["x"], "m", "across")
    chosen = _instants(middle.values)
    for number, color in zip(chosen, _dark_to_bright(len(chosen)), strict=True):
        instant = middle.isel(time=number)
        ax.plot(x, instant / scale, color=color, label=f"{float(instant['time']):.3g} s")
    ax.set(xlabel=across, ylabel=f"{evolved[name].attrs['long_name']} [{unit}]")
    ax.legend(**BESIDE)
    if name in LOGARITHMIC:
        ax.set_yscale("log")


def _passes(ax: Axes, rolled: xr.Dataset, name: str) -> None:
    """Draw a residual stress in the rolling direction, or a strain, against the depth after some passes.

    The first pass is dark, the last one bright.
    """
    chosen = np.unique(np.linspace(0, rolled.sizes["pass_number"] - 1, MAX_PROFILES).round().astype(int))
    depth, down = in_display_unit(rolled["z"], "m", "depth")
    if name == "residual_stress":
        scale, unit = display_unit_of(abs(rolled[name]), "Pa")
        values, across = rolled[name].sel(component="xx") / scale, f"residual stress in the rolling direction [{unit}]"
    else:
        values, across = rolled[name] * 100, f"{rolled[name].attrs['long_name']} [%]"
    for profile, color in zip(values.isel(pass_number=chosen), _dark_to_bright(len(chosen)), strict=True):
        ax.plot(profile, depth, color=color, label=f"pass {int(profile['pass_number'])}")
    ax.set(xlabel=across, ylabel=down)
    ax.invert_yaxis()


def _dark_to_bright(count: int) -> Any:
    """Return colours (count, RGBA) of profiles, from the first to the last."""
    return mpl.colormaps["viridis"](np.linspace(0, 0.9, count))


def _instants(values: Any) -> list[int]:
    """Return the numbers of the instants to draw of values (time, x), evenly spaced without those that are all zero."""
    drawn = np.flatnonzero(values.any(axis=1)) if values.any() else np.array([len(values) - 1])
    return sorted(set(drawn[np.linspace(0, len(drawn) - 1, MAX_PROFILES).round().astype(int)].tolist()))


def _dent(ax: Axes, evolved: xr.Dataset, name: str) -> None:
    """Draw the residual displacement of a body at some instants, downwards into the body."""
    _lines(ax, evolved, name)
    ax.set_ylabel(f"{ax.get_ylabel()}, into the bodies")
    ax.invert_yaxis()


def _plastic(ax: Axes, evolved: xr.Dataset, name: str) -> None:
    """Draw the equivalent plastic strain below the middle of the length at the last instant."""
    strain = in_the_middle(evolved[name]).isel(time=-1)
    depth = next(str(dimension) for dimension in strain.dims if str(dimension).startswith("z"))
    scale, unit = display_unit_of(evolved["x"], "m")
    x, z = evolved["x"] / scale, evolved[depth] / scale
    title = f"{strain.attrs['long_name']} at the end [%]"
    draw_map(ax, x, z, strain * 100, (f"across [{unit}]", f"depth [{unit}]", title))
    ax.set_aspect("equal")
    ax.invert_yaxis()


def _residual(ax: Axes, evolved: xr.Dataset, name: str) -> None:
    """Draw the residual stress below the middle of the contact against the depth, at the last instant."""
    stress = in_the_middle(evolved[name]).isel(time=-1, x=evolved.sizes["x"] // 2)
    depth = next(str(dimension) for dimension in stress.dims if str(dimension).startswith("z"))
    length, length_unit = display_unit_of(evolved["x"], "m")
    factor, pressure_unit = display_unit_of(abs(stress), "Pa")
    for component, direction, color in (("xx", "across", BLUE), ("yy", "along", GREEN), ("zz", "in depth", RED)):
        ax.plot(stress.sel(component=component) / factor, evolved[depth] / length, color=color, label=direction)
    title = f"{str(stress.attrs['long_name']).partition(',')[0]} at the end"
    across = f"residual stress below the middle, tension positive [{pressure_unit}]"
    name_axes(ax, across, f"depth [{length_unit}]", title)
    ax.invert_yaxis()
    ax.legend(**BESIDE)


def _map_over_time(ax: Axes, evolved: xr.Dataset, name: str) -> None:
    """Draw the mean of a variable along the length over time and width."""
    scale, unit = _unit(evolved, [name])
    x, across = in_display_unit(evolved["x"], "m", "across")
    # an instant given twice is a jump: the map has room for one
    time = evolved["time"].values
    distinct = np.append(np.diff(time) > 0, [True])
    values = (evolved[name].mean("y") / scale).values[distinct].T
    look = {"shading": "nearest" if distinct.sum() > 1 else "auto", "norm": "log" if name in LOGARITHMIC else None}
    draw_map(
        ax, time[distinct], x, values, ("time [s]", across, f"mean {evolved[name].attrs['long_name']} [{unit}]"), **look
    )
    if distinct.sum() > 1:
        ax.set_xlim(time[0], time[-1])


def _numbers(ax: Axes, evolved: xr.Dataset, name: str) -> None:
    """Draw a number, and those that are drawn together with it, each over its largest value, against time."""
    lowest = 0.0
    for number, color in zip(TOGETHER[name], (GREY, BLUE, GREEN), strict=False):
        values = evolved[number]
        largest = float(values.max()) or 1.0
        label = f"{values.attrs['long_name']} over {readable(largest, values.attrs['units'], 3)}"
        ax.plot(evolved["time"], values / largest, color=color, label=label)
        lowest = min(lowest, float(values.min()) / largest)
    ax.set(xlabel="time [s]", ylabel="relative to the maximum")
    ax.set_ylim(bottom=lowest)
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.2))


def _loop(ax: Axes, evolved: xr.Dataset, name: str) -> None:
    """Draw the load of bodies with an attraction against the approach, where they touch."""
    touching = ((evolved["pressure"] > 0) & (evolved[name] > 0)).any(("x", "y"))
    approach, across = in_display_unit(evolved["approach"].where(touching), "m", "approach")
    ax.plot(approach, evolved["load"].where(touching), ".-", color=BLUE)
    ax.axhline(0.0, **LAW_STYLE)
    name_axes(ax, across, "load [N/m]", "approach and separation")


def _errors(ax: Axes, evolved: xr.Dataset, name: str) -> None:
    """Draw an estimated error against time, where it is known and not zero."""
    values = evolved[name].values
    shown = np.isfinite(values) & (values > 0)
    ax.semilogy(evolved["time"].values[shown], values[shown], ".-", color=RED)
    ax.set(xlabel="time [s]", ylabel="relative error", title=evolved[name].attrs["long_name"])
    ax.set_ylim(bottom=max(ax.get_ylim()[0], ax.get_ylim()[1] * 10.0**-DECADES))


# Kinds of datasets with their pictures; that of a dataset is the first whose needs it has.
KINDS = (
    Kind(
        {"film", "time"},
        [("pressure", _lines), ("film", _lines), ("film", _map_over_time), ("central_film", _numbers)],
        width=5.4,
        reach=FILM_WIDTH_IN_TIME,
    ),
    Kind({"film"}, [("film", _film), ("film", _section), ("pressure", _map)]),
    Kind({"pass_number"}, [("residual_stress", _passes), ("equivalent_plastic_strain", _passes)]),
    Kind(
        {"gap", "time"},
        [
            ("pressure", _lines), ("pressure", _map_over_time), ("load", _numbers), ("attraction", _loop),
            ("time_discretisation_error", _errors), ("grid_error", _errors), ("wear_depth", _lines), ("shear_x",
            _lines), ("residual_displacement", _dent), ("equivalent_plastic_strain", _plastic), ("residual_stress",
            _residual),
        ],
        width=5.4,
    ),
    Kind(
        {"gap"},
        [
            ("pressure", _map), ("pressure", _along), ("pressure", _across), ("gap", _section), ("drop", _ends),
            ("shear_x", _section), ("loop_force", _fretting_loop), ("von_mises", _stress),
        ],
    ),
)  # fmt: skip
