"""Errors of a sweep against one value of a varied field, and their front over the times where these were taken."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from studies.advice.front import pareto_front
from studies.model.drawing import CaptionedFigure
from studies.model.outcome import CaseStatus
from studies.model.plain_text import one_line
from studies.reference.line_contact import total_time
from studies.report.style import (
    COLORS,
    WIDTH,
    captioned,
    in_percent,
    panels,
    percent,
    write_powers,
)
from studies.report.wording import seconds_text

MARKERS = "osv^Dx"
L1 = "pressure_error_l1"
NOT_NESTED = " No error of the pressure in L1: the grids differ in extent, or do not nest in the reference's."


def figures(dataset: xr.Dataset, names: Sequence[str]) -> Sequence[CaptionedFigure]:
    """Draw the relative errors of some measures against the sweep's reference, and over the times of its cases.

    The attribute ``reference`` of the dataset names an axis and the value on it, such as ``load_per_length=10000.0``;
    without it, or where the axis lacks such a name, nothing is drawn. Of the other axes the largest error counts, and
    the median time.
    """
    axis, _, value = str(dataset.attrs.get("reference", "")).partition("=")
    if axis not in dataset["case_status"].dims or dataset.sizes[axis] < 2:
        return ()
    good = dataset.where(dataset["case_status"] == CaseStatus.OK)
    coordinate = dataset[axis].values
    # a stored number may differ from the one that was named by rounding
    is_number = coordinate.dtype.kind in "iuf"
    if not is_number and value not in coordinate:
        return ()
    place = int((-abs(coordinate - float(value)) if is_number else coordinate == value).argmax())
    true = good.isel({axis: place})
    compared = good.isel({axis: [k for k in range(coordinate.size) if k != place]})
    other_axes = [name for name in dataset["case_status"].dims if name != axis]
    # the datum of an approach, for one, may differ between paddings
    bounded = [name for name in names if np.isfinite(true.get(f"{name}_bound", np.inf)).all()]
    names = bounded or names
    errors = {
        name: abs(compared[name] / true[name] - 1).max(other_axes)
        for name in names
        if bool((true[name] != 0).all())
    }
    has_l1 = L1 in compared and bool(compared[L1].notnull().any())
    if has_l1:
        errors = {"pressure in L1": compared[L1].max(other_axes), **errors}
    if not errors:
        return ()
    labels = [_text(value) for value in compared[axis].values]
    reference = f"{axis.replace('_', ' ')} {_text(true[axis].item())}"
    bounds_text = _known(true, list(errors)) + NOT_NESTED * (not has_l1)
    drawn = [_over_axis(errors, labels, reference, bounds_text)]
    if "solve_time" in dataset and bool(dataset["solve_time"].notnull().any()):
        times = total_time(compared).median(other_axes)
        drawn.append(_front(*next(iter(errors.items())), times, labels, reference))
    return drawn


def _text(value: object) -> str:
    return f"{value:.4g}" if isinstance(value, float) else one_line(value, 30)


def _known(true: xr.Dataset, names: Sequence[str]) -> str:
    """Return a sentence with the bounds of the reference itself, below which errors are not resolved."""
    bounds = {
        name: float((true[f"{name}_bound"] / abs(true[name])).max())
        for name in names
        if f"{name}_bound" in true
    }
    if "pressure_l1_estimate" in true:
        bounds = {"pressure in L1": float(true["pressure_l1_estimate"].max()), **bounds}
    finite = [
        f"{name.replace('_', ' ')} {percent(bound)}"
        for name, bound in bounds.items()
        if 0 < bound < np.inf
    ]
    return f" Bounds of the reference itself: {', '.join(finite)}." if finite else ""


def _over_axis(
    errors: dict[str, xr.DataArray], labels: Sequence[str], reference: str, bounds_text: str
) -> CaptionedFigure:
    fig, (ax,) = panels(1, width=WIDTH, height=1.6 + 0.3 * len(labels))
    for number, (name, error) in enumerate(errors.items()):
        color, marker = COLORS[number % len(COLORS)], MARKERS[number % len(MARKERS)]
        style: Any = {"ls": "none", "marker": marker, "color": color}
        positions = np.arange(len(labels))
        ax.plot(error.where(error > 0), positions, label=name.replace("_", " "), **style)
    ax.set(xscale="log", xlabel="relative error", yticks=range(len(labels)), yticklabels=labels)
    write_powers(ax.xaxis, in_percent)
    ax.invert_yaxis()
    has_missing = any(bool(error.isnull().any()) for error in errors.values())
    unmarked = "a quantity without a mark agrees exactly" + ", or has no number" * has_missing
    return captioned(
        "errors",
        fig,
        f"Relative errors against {reference}; {unmarked}.{bounds_text}",
    )


def _front(
    name: str, error: xr.DataArray, seconds: xr.DataArray, labels: Sequence[str], reference: str
) -> CaptionedFigure:
    """Draw an error over the time of a case, with a line through the Pareto front."""
    fig, (ax,) = panels(1, width=WIDTH, height=4.2)
    best = pareto_front(seconds.values, error.values)
    ax.loglog(seconds.values[best], error.values[best], color=COLORS[0])
    ax.loglog(seconds.values, error.values, "o", color=COLORS[0])
    for x, y, label in zip(seconds.values, error.values, labels, strict=True):
        ax.annotate(label, (x, y), (5, 3), textcoords="offset points", fontsize="small")
    name = name.replace("_", " ")
    ax.set_xlabel("wall time to set up and solve, on one thread")
    ax.set_ylabel(f"relative error of the {name}")
    write_powers(ax.xaxis, seconds_text)
    write_powers(ax.yaxis, in_percent)
    return captioned(
        "front",
        fig,
        f"Relative error of the {name} against {reference}, over the time of a case; of several cases at one value the "
        "largest error and the median time. The line joins the Pareto front.",
    )
