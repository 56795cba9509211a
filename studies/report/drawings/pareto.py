"""Settings of any scene: errors over the axis that varies, and the price of accuracy where times were taken."""

from collections.abc import Iterator, Sequence

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from studies.advice.front import pareto_front
from studies.model.drawing import CaptionedFigure, Table
from studies.reference.line_contact import COUNTS_IMAGES, total_time
from studies.report.style import captioned, padding_style, panels, percent
from studies.report.wording import DECADES, seconds_text

ERROR = "pressure_error_l1"
LABEL = "L1 error of the pressure"
KNOWN_AXES = ("padding", "images", "period", "grid", "solver_tolerance")
# Axes over which errors are drawn as lines.
OVER = {
    "grid": "cells across the width",
    "images": "n + ½  (n periods on each side)",
    "period": "period over the scene's own",
}


def figure(dataset: xr.Dataset) -> Sequence[CaptionedFigure]:
    """Draw errors over every axis with several values, or as bars, and the front of errors and times."""
    varied = [axis for axis in OVER if dataset.sizes[axis] > 1]
    drawn = [_over(dataset, axis) for axis in varied] or [_bars(dataset)]
    if "solve_time" in dataset and bool(dataset["solve_time"].notnull().any()):
        drawn.append(_front(dataset))
    return drawn


def tables(dataset: xr.Dataset) -> Sequence[Table]:
    """Return the quickest setting of the study for each error."""
    if "solve_time" not in dataset:
        return ()
    flat = _flat(dataset)
    rows = []
    for target in DECADES:
        meets = flat.where(flat[ERROR] <= target, drop=True)
        if not meets.sizes["point"]:
            continue
        best = meets.isel(point=int(np.argmin(meets["time"].values)))
        rows.append(
            (
                percent(target),
                _name(str(best["padding"].values), int(best["images"])),
                str(int(best["grid"])),
                f"{float(best['solver_tolerance']):.0e}",
                percent(best[ERROR]),
                seconds_text(float(best["time"])),
            )
        )
    return (
        Table(
            "The quickest setting of the study for each error, by the least of its repeats; errors that no setting "
            "reaches are left out.",
            ("error at most", "padding", "cells across", "tolerance", "measured", "time"),
            tuple(rows),
        ),
    )


def _lines(dataset: xr.Dataset, over: str) -> Iterator[tuple[str, str, xr.Dataset]]:
    """Yield padding, name and part of a dataset for every padding, and every n that is not the axis itself."""
    for padding in (str(name) for name in dataset["padding"].values):
        part = dataset.sel(padding=padding)
        counts = part["images"].values if padding in COUNTS_IMAGES and over != "images" else [None]
        for n in counts:
            chosen = (
                part if over == "images" else part.sel(images=part["images"][0] if n is None else n)
            )
            yield padding, padding if n is None else _name(padding, int(n)), chosen


def _name(padding: str, images: int) -> str:
    return f"{padding}, n = {images}" if padding in COUNTS_IMAGES else padding


def _at_first(part: xr.Dataset, over: str) -> xr.Dataset:
    """Return a part at the finest grid, the tightest tolerance and the first value of all other axes."""
    others = {
        str(axis): -1 if axis == "grid" else 0 for axis in part["case_status"].dims if axis != over
    }
    return (
        part.sortby("solver_tolerance").isel(others)
        if "solver_tolerance" in part.dims
        else part.isel(others)
    )


def _over(dataset: xr.Dataset, over: str) -> CaptionedFigure:
    fig, (ax,) = panels(1, width=6.5, height=3.8)
    for padding, label, part in _lines(dataset, over):
        shown = _at_first(part, over)
        x = shown[over].values + (0.5 if over == "images" else 0.0)
        style = padding_style(padding)
        if over == "images" and padding not in COUNTS_IMAGES:
            style |= {"marker": "none", "ls": "--"}
        if over == "period":  # three whole numbers are no line
            style |= {"ls": "none"}
        ax.loglog(x, shown[ERROR], label=label, **style)
    ax.set(xlabel=OVER[over], ylabel=LABEL)
    return captioned(
        f"over_{over}",
        fig,
        f"{LABEL} over the {OVER[over].split('  ')[0]}, against a finer solution at the scene's own boundary.",
    )


def _bars(dataset: xr.Dataset) -> CaptionedFigure:
    fig, (ax,) = panels(1, width=6.5, height=3.8)
    rows = [
        (label, padding, float(_at_first(part, "")[ERROR]))
        for padding, label, part in _lines(dataset, "")
    ]
    for place, (_, padding, error) in enumerate(rows):
        ax.plot(error, place, "o", color=padding_style(padding)["color"])
    ax.set(
        xscale="log",
        xlabel=LABEL,
        yticks=range(len(rows)),
        yticklabels=[label for label, *_ in rows],
    )
    return captioned(
        "paddings",
        fig,
        f"{LABEL} of every padding, against a finer solution at the scene's own boundary.",
    )


def _flat(dataset: xr.Dataset) -> xr.Dataset:
    """Return all settings in a row, with their errors and times."""
    both = dataset[[ERROR]].assign(time=total_time(dataset))
    flat = both.stack(point=dataset["case_status"].dims).reset_index("point")
    return flat.where(flat[ERROR].notnull() & flat["time"].notnull(), drop=True)


def _front(dataset: xr.Dataset) -> CaptionedFigure:
    fig, (ax,) = panels(1, width=6.5, height=4.2)
    for padding, label, part in _lines(dataset, ""):
        _front_of(ax, part, padding, label)
    ax.set(xlabel="wall time to set up and solve, on one thread [s]", ylabel=LABEL)
    return captioned(
        "front",
        fig,
        "The price of accuracy: of each padding the settings that no other of it beats in both error and time; small "
        "marks: its other settings.",
    )


def _front_of(ax: Axes, part: xr.Dataset, padding: str, label: str) -> None:
    flat = _flat(part)
    cost, error = flat["time"].values, flat[ERROR].values
    best = pareto_front(np.asarray(cost), np.asarray(error))
    style = padding_style(padding)
    ax.loglog(cost[best], error[best], label=label, **style)
    ax.loglog(
        cost, error, ls="none", ms=3, alpha=0.5, **{k: v for k, v in style.items() if k != "ls"}
    )
