"""Figures of any study, chosen by what was varied: curves for one axis, families for two, maps on request."""

import tomllib
from collections.abc import Sequence
from textwrap import fill
from typing import Any

import numpy as np
import xarray as xr
from matplotlib import colormaps
from matplotlib.axes import Axes

from contactstudy import InvalidInput
from studies.model.drawing import CaptionedFigure
from studies.model.outcome import CaseStatus
from studies.report.style import add_legend, panels

# What is drawn of a contact, if it was recorded; of other studies the first six measures.
DRAWN = ("contact_share", "peak_pressure", "mean_pressure", "approach", "stiffness", "mean_gap")
STRESS = ("von_mises_max",)
MOST_PANELS, MOST_LINES, MOST_FIGURES = 6, 8, 12
SIZES: dict[str, Sequence[tuple[float, str]]] = {
    "m": ((1e-9, "nm"), (1e-6, "µm"), (1e-3, "mm"), (1.0, "m")),
    "Pa": ((1e3, "kPa"), (1e6, "MPa"), (1e9, "GPa")),
    "N m-1": ((1.0, "N/m"), (1e3, "N/mm")),
    "N m-2": ((1e6, "N/mm per mm"),),
    "1": ((1.0, ""),),
}


def curves(dataset: xr.Dataset) -> Sequence[CaptionedFigure]:
    """Draw the measures over the longest numeric axis, a line for each value of another, a figure for a third."""
    return _figures(dataset, "curves")


def maps(dataset: xr.Dataset) -> Sequence[CaptionedFigure]:
    """Draw the measures as maps over two numeric axes; as :func:`curves` where there are none."""
    return _figures(dataset, "maps")


def _figures(dataset: xr.Dataset, kind: str) -> Sequence[CaptionedFigure]:
    axes = _by_length(dataset)
    names = _measures(dataset)
    if not names:
        raise InvalidInput(
            "The study has no measure to draw: let measures give a number that is not nan."
        )
    good = dataset.where(dataset["case_status"] == CaseStatus.OK)
    shown, further = axes[:2], axes[2:]
    figures = []
    stacked = good.stack(point=further) if further else None
    count = 1 if stacked is None else stacked.sizes["point"]
    for number in range(min(count, MOST_FIGURES)):
        part, place = good, ""
        if stacked is not None:
            values = stacked["point"].values[number]
            at = dict(zip(further, values, strict=True))
            part, place = (
                good.sel(at),
                ", ".join(f"{_named(dataset[a])} {_short(v)}" for a, v in at.items()),
            )
        numeric = [name for name in shown if _is_numeric(dataset[name]) and dataset.sizes[name] > 1]
        draw = _map if kind == "maps" and len(numeric) == 2 else _curve
        figure, panes = panels(len(names), columns=min(3, len(names)))
        for name, ax in zip(names, panes, strict=True):
            draw(ax, part[name], shown)
        add_legend(figure)
        stem = kind if draw is _map else "curves"
        name = stem if stacked is None else f"{stem}-{number + 1}"
        parts = [str(dataset.attrs.get("title", "Study")), place, _held(dataset, axes)]
        caption = f"{'; '.join(part for part in parts if part)}."
        figures.append(CaptionedFigure(name, figure, caption))
    return figures


def _held(dataset: xr.Dataset, axes: Sequence[str]) -> str:
    """Return what the scene of a sweep holds constant of its hardness, load and speed, as its file has it."""
    try:
        scene = tomllib.loads(str(dataset.attrs.get("scene", "")))
    except tomllib.TOMLDecodeError:  # a scene in Python
        return ""
    held = {"hardness": scene.get("hardness")}
    for table, key in (("load", "total"), ("load", "per_length"), ("rolling", "speed")):
        entries = scene.get(table)
        held[f"{table} {key}"] = entries.get(key) if isinstance(entries, dict) else None
    return ", ".join(
        f"{name.replace('_', ' ')} {value}"
        for name, value in held.items()
        if isinstance(value, str | float | int) and name.replace(" ", "_") not in axes
    )


def _by_length(dataset: xr.Dataset) -> list[str]:
    """Return the axes: numeric ones before names, and of those the longest first; the load before all that vary."""
    names = [str(name) for name in dataset["case_status"].dims]

    def rank(name: str) -> tuple[bool, bool, int]:
        varies = dataset.sizes[name] > 1
        load = name == "load_per_length" and varies
        return not load, not (_is_numeric(dataset[name]) and varies), -dataset.sizes[name]

    return sorted(names, key=rank)


def _measures(dataset: xr.Dataset) -> list[str]:
    dims = dataset["case_status"].dims
    present = [
        str(name)
        for name, variable in dataset.data_vars.items()
        if variable.dims == dims and variable.dtype.kind == "f" and variable.notnull().any()
    ]
    preferred = [name for name in (*DRAWN, *STRESS) if name in present]
    if "stiffness" in preferred and "von_mises_max" in preferred:
        preferred.remove("mean_gap")
    times = [name for name in present if "_time" in name]
    further = [
        name for name in present if name not in times and name not in ("convolutions", "residual")
    ]
    return (preferred or further or times)[:MOST_PANELS]


def _curve(ax: Axes, values: xr.DataArray, shown: Sequence[str]) -> None:
    first, *families = shown or ["point"]
    size, unit = _scale(values)
    if first == "point":
        ax.plot([0], [float(values) / size], marker="o")
        ax.set(ylabel=_label(values, unit), xticks=[])
        return
    x = values[first]
    numeric = _is_numeric(x)
    x_size, x_unit = _scale(x) if numeric else (1.0, "")
    places = x.values / x_size if numeric else np.arange(x.size)
    lines = values / size if not families else (values / size).transpose(families[0], first)
    if not families:
        ax.plot(places, lines, marker="o", color="#0072B2")
    else:
        _family(ax, places, lines, families[0])
    if numeric and _spans(x):
        ax.set_xscale("log")
    if _spans(values):
        ax.set_yscale("log")
    ax.set(xlabel=_label(x, x_unit), ylabel=_label(values, unit))
    if not numeric:
        texts = [str(value)[:24] for value in x.values]
        ax.set_xticks(np.arange(x.size), texts, rotation=30 if max(map(len, texts)) > 5 else 0)


def _family(ax: Axes, places: Any, lines: xr.DataArray, axis: str) -> None:
    """Draw a line for each value; of many values, thin lines and their mean."""
    values = lines[axis].values
    if len(values) > MOST_LINES:
        ax.plot(places, lines.values.T, color="0.6", linewidth=0.7)
        ax.plot([], [], color="0.6", linewidth=0.7, label=f"each {_named(lines[axis])}")
        ax.plot(places, lines.mean(axis), color="#0072B2", marker="o", label="mean")
        return
    tones = colormaps["viridis"](np.linspace(0, 0.85, len(values)))
    size, unit = _scale(lines[axis]) if _is_numeric(lines[axis]) else (1.0, "")
    for value, line, tone in zip(values, lines.values, tones, strict=True):
        text = _short(value / size) if _is_numeric(lines[axis]) else str(value)[:30]
        ax.plot(
            places,
            line,
            marker="o",
            color=tone,
            label=f"{_named(lines[axis])} {text} {unit}".rstrip(),
        )


def _map(ax: Axes, values: xr.DataArray, shown: Sequence[str]) -> None:
    first, second = shown
    size, unit = _scale(values)
    x_size, x_unit = _scale(values[first])
    y_size, y_unit = _scale(values[second])
    plane = (values / size).transpose(second, first)
    mesh = ax.pcolormesh(
        values[first] / x_size, values[second] / y_size, plane, cmap="viridis", shading="nearest"
    )
    for axis, set_scale in ((first, ax.set_xscale), (second, ax.set_yscale)):
        if _spans(values[axis]):
            set_scale("log")
    ax.set(
        xlabel=_label(values[first], x_unit),
        ylabel=_label(values[second], y_unit),
        title=_label(values, unit),
    )
    ax.grid(visible=False)
    ax.figure.colorbar(mesh, ax=ax)


def _is_numeric(values: xr.DataArray) -> bool:
    return bool(values.dtype.kind in "if")


def _spans(values: xr.DataArray) -> bool:
    """Return whether the values are above zero and spread over more than a decade."""
    finite = values.values[np.isfinite(values.values)].ravel()
    return bool(finite.size > 1 and finite.min() > 0 and finite.max() > 10 * finite.min())


def _scale(values: xr.DataArray) -> tuple[float, str]:
    """Return the size and name of the unit in which the largest value is short."""
    units = values.attrs.get("units", "1")
    finite = np.abs(values.values[np.isfinite(values.values)])
    largest = float(finite.max()) if finite.size else 1.0
    sizes: Sequence[tuple[float, str]] = SIZES.get(units, ((1.0, units),))
    fitting = [entry for entry in sizes if largest >= entry[0]] or [sizes[0]]
    return fitting[-1]


def _label(values: xr.DataArray, unit: str) -> str:
    name = (
        str(values.attrs.get("long_name", values.name)).split(", counted")[0].split(", d load")[0]
    )
    return fill(f"{name} [{unit}]" if unit else name, 30)


def _named(values: xr.DataArray) -> str:
    """Return a short name of an axis for a legend."""
    return str(values.attrs.get("long_name", values.name)).split(",")[0]


def _short(value: Any) -> str:
    return f"{value:.3g}" if isinstance(value, int | float | np.number) else str(value)


FIGURES = {"curves": curves, "maps": maps}
