"""Figures of any study by its varied axes: curves for one axis, families of curves for two, maps on request."""

import tomllib
from collections.abc import Sequence
from itertools import islice, product
from math import prod
from textwrap import fill
from typing import Any

import numpy as np
import xarray as xr
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm, Normalize
from matplotlib.ticker import MaxNLocator

from contactstudy import InvalidInput
from contactstudy.domain.units import display_unit_of
from studies.model.axis import is_geometric, one_of
from studies.model.drawing import CaptionedFigure
from studies.model.outcome import CaseStatus, is_time
from studies.model.plain_text import one_line
from studies.report.drawings import against_reference
from studies.report.style import COLORS, captioned, panels, percent, write_powers

# Measures that are drawn first where a study has more than there is room for.
DRAWN = (
    "central_film", "minimum_film", "friction_coefficient", "lambda_ratio", "contact_load_fraction", "pull_off",
    "traction_coefficient", "stick_fraction", "frictional_power", "energy_per_cycle", "friction_energy", "largest_slip",
    "rolling_resistance", "wear_volume", "largest_wear_depth", "dent_depth", "final_peak_pressure", "contact_fraction",
    "peak_pressure", "largest_von_mises", "mean_pressure", "approach", "stiffness", "mean_gap",
)  # fmt: skip
# What a case records of its solve, which is no measure.
RECORDED = (
    "accuracy_met", "solver_status", "iterations", "linear_iterations", "convolutions", "residual",
    "outer_iterations", "passes", "solves", "instants", "steps", "rejected", "restarts",
)  # fmt: skip
# Relative difference of values that are constant.
CONSTANT = 1e-6
# Formulas that are drawn beside a measure over one axis.
FORMULAS = {
    "central_film": ("moes_film", "Moes", ":"),
    "minimum_film": ("dowson_higginson_film", "Dowson & Higginson", "--"),
}
DOUBTFUL: Any = {
    "marker": "o",
    "mfc": "white",
    "mec": "0.3",
    "ls": "none",
    "label": "no bound of the error, or one above the requested error",
}
# Axes that number samples.
SAMPLES = ("seed", "tile")
KINDS = ("curves", "maps")
MAX_PANELS, MAX_LINES, MAX_FIGURES = 6, 8, 12


def figures(
    dataset: xr.Dataset, kind: str = "curves", plot: Sequence[str] = ()
) -> Sequence[CaptionedFigure]:
    """Draw the measures of a stored study over its first two axes, a figure for each point on the others.

    Parameters
    ----------
    dataset
        Stored study.
    kind
        "curves" over a varied load or else the longest numeric axis, with a line for each value of another, or "maps"
        over two numeric axes, which are curves where there are not two.
    plot
        Names of the measures to draw; those of a contact if empty.

    Raises
    ------
    InvalidInput
        For a name that the study does not have, or a study without numbers.
    """
    axes = _by_length(dataset)
    measures = _measures(dataset)
    names = [one_of("plot", name, _numbers(dataset)) for name in plot] or _first(measures)
    if not names:
        raise InvalidInput(
            "The study has no measure to draw: let measures give a number that is not nan."
        )
    good = dataset.where(dataset["case_status"] == CaseStatus.OK)
    shown, further = axes[:2], axes[2:]
    is_map = kind == "maps" and len(shown) == 2 and all(_varies(dataset[axis]) for axis in shown)
    stem = "maps" if is_map else "curves"
    drawn = []
    omitted = [name for name in measures if name not in names and not plot]
    points = product(*(dataset[axis].values for axis in further))
    count = prod(dataset.sizes[axis] for axis in further)
    for number, point in enumerate(islice(points, MAX_FIGURES), 1):
        at = dict(zip(further, point, strict=True))
        selection_text = ", ".join(
            f"{_name(dataset[axis])} {_short(value)}" for axis, value in at.items()
        )
        figure, panes = panels(len(names), columns=min(3, len(names)))
        is_hollow = False
        selected = good.sel(at)
        for name, ax in zip(names, panes, strict=True):
            doubtful = _doubtful(selected, name)
            is_hollow |= bool(doubtful.notnull().any())
            (_map if is_map else _curve)(ax, selected, name, shown, doubtful)
            formula, author, dashes = FORMULAS.get(name, ("", "", ""))
            if formula in good and len(shown) == 1 and _varies(dataset[shown[0]]):
                x, _ = _scaled(dataset[shown[0]])
                law = selected[formula] / _scale(selected[name])[0]
                ax.plot(x, law, color="black", linestyle=dashes, label=author)
        parts = [
            str(dataset.attrs.get("title", "Study")),
            selection_text,
            _constants(dataset, axes),
            f"hollow points: {DOUBTFUL['label']}" * is_hollow,
            f"--plot draws {len(omitted)} more, such as {omitted[0]}" if omitted else "",
            f"the first {MAX_FIGURES} of {count} points have a figure" * (count > MAX_FIGURES),
        ]
        caption = f"{'; '.join(part for part in parts if part)}."
        drawn.append(captioned(f"{stem}-{number}" if further else stem, figure, caption))
    return [*drawn, *against_reference.figures(dataset, names)]


def _constants(dataset: xr.Dataset, axes: Sequence[str]) -> str:
    """Return hardness, load and speed of the scene of a sweep that are not varied, as written in its file."""
    try:
        scene = tomllib.loads(str(dataset.attrs.get("scene", "")))
    except tomllib.TOMLDecodeError:  # a scene in Python
        return ""
    constants = {"hardness": scene.get("hardness")}
    for table, key in (("load", "total"), ("load", "per_length"), ("rolling", "speed")):
        entries = scene.get(table)
        constants[f"{table} {key}"] = entries.get(key) if isinstance(entries, dict) else None
    # notes name the fields that change along the axis of another
    notes = str(dataset.attrs.get("notes", ""))
    return ", ".join(
        f"{name.replace('_', ' ')} {value}"
        for name, value in constants.items()
        if isinstance(value, str | float | int)
        and not {name.replace(" ", "_"), name.split()[0], f"{name.split()[0]}_case"} & set(axes)
        and f"{name.replace(' ', '.')} = " not in notes
    )


def _by_length(dataset: xr.Dataset) -> list[str]:
    """Return the axes: a varied load first, then other numbers, samples and names, and of these the longest first."""

    def rank(name: str) -> tuple[bool, bool, bool, int]:
        varies = _varies(dataset[name])
        is_load = name == "load_per_length" and varies
        return not is_load, not varies, _is_sample(name), -dataset.sizes[name]

    return sorted(map(str, dataset["case_status"].dims), key=rank)


def _numbers(dataset: xr.Dataset) -> list[str]:
    """Return the names of the variables over all axes that have numbers, flags left out."""
    dims = dataset["case_status"].dims
    return [
        str(name)
        for name, variable in dataset.data_vars.items()
        if variable.dims == dims and variable.dtype.kind in "iuf" and variable.notnull().any()
        if name != "case_status" and "flag_meanings" not in variable.attrs
    ]


def _measures(dataset: xr.Dataset) -> list[str]:
    """Return the names of the measures that change, or all where none does; times only where there is nothing else."""
    present = [
        name
        for name in _numbers(dataset)
        if "_bound" not in name and "_estimate" not in name and name not in RECORDED
    ]
    times = [name for name in present if is_time(name)]
    measures = [name for name in present if name not in times]
    return [name for name in measures if _changes(dataset[name])] or measures or times


def _first(measures: Sequence[str]) -> Sequence[str]:
    """Return the measures to draw: where there are more than there is room for, those of a contact."""
    preferred = [name for name in DRAWN if name in measures]
    return (preferred if len(measures) > MAX_PANELS and preferred else measures)[:MAX_PANELS]


def _changes(values: xr.DataArray) -> bool:
    """Return whether a measure is not the same at all points, within the residual of a solver."""
    largest, least = float(values.max()), float(values.min())
    return largest - least > CONSTANT * max(abs(largest), abs(least))


def _doubtful(dataset: xr.Dataset, name: str) -> xr.DataArray:
    """Return the values of a measure whose bound is infinite, or whose answer misses its accuracy; else nan."""
    values, bound = dataset[name], dataset.get(f"{name}_bound")
    is_doubtful = xr.zeros_like(values, dtype=bool) if bound is None else np.isinf(bound)
    if "accuracy_met" in dataset:
        is_doubtful = is_doubtful | (dataset["accuracy_met"] == 0)
    return values.where(is_doubtful)


def _curve(
    ax: Axes, dataset: xr.Dataset, name: str, shown: Sequence[str], doubtful: xr.DataArray
) -> None:
    """Draw a measure over the first axis, with a line for each value of the second, and its bounds as bars.

    Names and samples are points side by side, which no line joins. Values that are `doubtful` are hollow.
    """
    values, bound = dataset[name], dataset.get(f"{name}_bound")
    y, label = _scaled(values)
    bars = (
        None
        if bound is None
        else bound.where(np.isfinite(bound) & (bound >= 0)) / _scale(values)[0]
    )
    if not shown:
        ax.plot([0], [float(y)], marker="o")
        if doubtful.notnull():
            ax.plot([0], [float(y)], **DOUBTFUL)
        ax.set(ylabel=label, xticks=[])
        return
    first, *families = shown
    numbers, is_numeric = values[first], _is_numeric(values[first])
    joins = is_numeric and not _is_sample(first)
    x, x_label = _scaled(numbers) if is_numeric else (np.arange(numbers.size), _label(numbers))
    line_style = "-" if joins else "none"
    if families:
        _family(ax, x, y.transpose(families[0], first), families[0], line_style)
    else:
        ax.plot(x, y, marker="o", ls=line_style, color=COLORS[0])

    def lines(field: xr.DataArray) -> np.ndarray:
        return np.asarray(field.transpose(*families, first).values.reshape(-1, numbers.size))

    is_mean = any(_is_sample(axis) and values.sizes[axis] > 1 for axis in families)
    if bars is not None and not is_mean and values.size <= MAX_LINES * numbers.size:
        for line, bar in zip(lines(y), lines(bars), strict=True):
            ax.errorbar(x, line, yerr=bar, fmt="none", ecolor="0.6", capsize=2, zorder=1)
    if is_mean:  # as good as the least of its samples
        of_samples = doubtful.notnull().any(families[0])
        doubtful = values.mean(families[0]).where(of_samples).expand_dims(families)
    for line in lines(doubtful / _scale(values)[0]):
        if np.isfinite(line).any():
            ax.plot(x, line, **DOUBTFUL)
    if joins and (_spans_decade(numbers) or is_geometric(numbers.values)):
        ax.set_xscale("log")
        write_powers(ax.xaxis, "{:g}".format)
    if _spans_decade(values):
        ax.set_yscale("log")
        write_powers(ax.yaxis, "{:g}".format)
    ax.set(xlabel=x_label, ylabel=label)
    if not is_numeric:
        texts = [one_line(value, 30) for value in numbers.values]
        rotated: Any = {"rotation": 30, "ha": "right", "rotation_mode": "anchor"}
        ax.set_xticks(x, texts, **rotated if max(map(len, texts)) > 5 else {})


def _family(ax: Axes, x: Any, lines: xr.DataArray, axis: str, line_style: str) -> None:
    """Draw a line for each value of an axis: samples as their mean and std, many numbers with a colour bar."""
    values, name = lines[axis], _name(lines[axis])
    size, unit = _scale(values) if _is_numeric(values) else (1.0, "")
    marked: Any = {"marker": "o", "ls": line_style}
    if _is_sample(axis) and values.size > 1:
        mean, std = lines.mean(axis), lines.std(axis, ddof=1)
        ax.fill_between(x, mean - std, mean + std, color=COLORS[0], alpha=0.2, lw=0)
        counts = lines.notnull().sum(axis)
        several = f"{int(counts.min())} to " * (int(counts.min()) < values.size)
        text = f"mean of {several}{values.size}, ± standard deviation"
        ax.plot(x, mean, color=COLORS[0], label=text, **marked)
        return
    if values.size > MAX_LINES and _is_numeric(values):
        scale = LogNorm if is_geometric(values.values) else Normalize
        ends = float(values.min()) / size, float(values.max()) / size
        colors = ScalarMappable(scale(*ends), "viridis")
        marked["marker"] = "." if line_style == "none" else "none"
        for value, line in zip(values.values, lines.values, strict=True):
            ax.plot(x, line, color=colors.to_rgba(value / size), **marked)
        ax.figure.colorbar(colors, ax=ax, label=f"{name} {f'[{unit}]' * bool(unit)}".rstrip())
        return
    if values.size > MAX_LINES:
        ax.plot(x, lines.values.T, color="0.6", linewidth=0.7, ls=line_style)
        ax.plot([], [], color="0.6", linewidth=0.7, label=f"each {name}")
        ax.plot(x, lines.mean(axis), color=COLORS[0], label="mean", **marked)
        return
    line_colors = colormaps["viridis"](np.linspace(0, 0.85, values.size))
    for value, line, color in zip(values.values, lines.values, line_colors, strict=True):
        text = _short(value / size) if _is_numeric(values) else one_line(value, 30)
        ax.plot(x, line, color=color, label=f"{name} {text} {unit}".rstrip(), **marked)


def _map(
    ax: Axes, dataset: xr.Dataset, name: str, shown: Sequence[str], doubtful: xr.DataArray
) -> None:
    """Draw a measure as a map over two axes with its largest bound, and hollow points on values that are `doubtful`."""
    values, bound = dataset[name], dataset.get(f"{name}_bound")
    (x, x_label), (y, y_label) = (_scaled(values[axis]) for axis in shown)
    plane, title = _scaled(values.transpose(*reversed(shown)))
    mesh = ax.pcolormesh(x, y, plane, cmap="viridis", shading="nearest")
    if bound is not None and np.isfinite(bound).any():
        largest = (bound.where(np.isfinite(bound)) / abs(values)).max()
        title = f"{title}\nbounds up to {percent(largest)}"
    across, along = np.nonzero(doubtful.transpose(*shown).notnull().values)
    if across.size:
        ax.plot(x.values[across], y.values[along], **DOUBTFUL)
    for axis, set_scale in zip(shown, (ax.set_xscale, ax.set_yscale), strict=True):
        set_scale("log" if _spans_decade(values[axis]) else "linear")
    if _is_sample(shown[1]):
        ax.yaxis.set_major_locator(MaxNLocator(integer=True))
    ax.set(xlabel=x_label, ylabel=y_label, title=title)
    ax.grid(visible=False)
    ax.figure.colorbar(mesh, ax=ax)


def _is_numeric(values: xr.DataArray) -> bool:
    """Return whether an axis has numbers."""
    return values.dtype.kind in "if"


def _varies(values: xr.DataArray) -> bool:
    """Return whether an axis has several numbers."""
    return _is_numeric(values) and values.size > 1


def _spans_decade(values: xr.DataArray) -> bool:
    """Return whether the values are above zero and span more than a decade."""
    finite = values.values[np.isfinite(values.values)].ravel()
    return bool(finite.size > 1 and finite.min() > 0 and finite.max() > 10 * finite.min())


def _is_sample(axis: str) -> bool:
    """Return whether an axis numbers random samples of one surface."""
    return axis.rsplit(".", 1)[-1].rsplit("_", 1)[-1] in SAMPLES


def _scale(values: xr.DataArray) -> tuple[float, str]:
    """Return the size and name of the unit in which the largest value is read best."""
    return display_unit_of(values, values.attrs.get("units", "1"))


def _scaled(values: xr.DataArray) -> tuple[xr.DataArray, str]:
    """Return numbers in the unit in which the largest is read best, and the label of their axis."""
    size, unit = _scale(values)
    return values / size, _label(values, unit)


def _label(values: xr.DataArray, unit: str = "") -> str:
    """Return the label of an axis of a panel: the long name and the unit."""
    name = str(values.attrs.get("long_name", values.name))
    return fill(f"{name} [{unit}]" if unit else name, 30)


def _name(values: xr.DataArray) -> str:
    """Return a short name of an axis for a legend."""
    return str(values.attrs.get("long_name", values.name)).split(",")[0]


def _short(value: Any) -> str:
    """Return a value of an axis in few digits."""
    return f"{value:.3g}" if isinstance(value, int | float | np.number) else str(value)
