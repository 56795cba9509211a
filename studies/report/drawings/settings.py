"""Drawing of the studies of settings: errors over the axis that varies, what n and cells are needed, and the price."""

from collections.abc import Iterator, Sequence

import numpy as np
import xarray as xr

from studies.advice.front import pareto_front
from studies.model.drawing import CaptionedFigure, Drawing, Finding, Table
from studies.model.outcome import CaseStatus
from studies.reference.line_contact import HAS_IMAGES, padding_at, padding_label, total_time
from studies.report.style import (
    LAW_STYLE,
    WIDTH,
    captioned,
    in_percent,
    padding_style,
    paddings,
    panels,
    percent,
    power,
    tick_cells,
    write_powers,
)
from studies.report.wording import DECADES, seconds_text

ERROR = "pressure_error_l1"
LABEL = "L1 error of the pressure"
# Axes over which errors are drawn as lines.
OVER = {
    "images": "n + ½  (n periods on each side)",
    "grid": "cells across the width",
    "period": "period over the scene's own",
}
HERTZ = "Hertz's contact"
# Errors by the padding for which the least n is listed.
TARGETS = (1e-2, 1e-3, 1e-4)


def _figure(dataset: xr.Dataset) -> Sequence[CaptionedFigure]:
    """Draw errors over every axis with several values, or as points, and the front of errors and times."""
    dataset = _on_one_tolerance(dataset) if not is_timed(dataset) else dataset
    untimed = _on_one_tolerance(dataset)
    if dataset.sizes["period"] > 1 and is_of_hertz(dataset):
        # exact periodicity alone has no window
        drawn = [_over_reach(untimed)] if set(paddings(dataset)) - {"exact"} else []
        varied = ["grid"]
    else:
        drawn, varied = [], list(OVER)
    drawn += [_over(untimed, axis) for axis in varied if dataset.sizes[axis] > 1]
    if not drawn:
        drawn = [_points(untimed)]
    return [*drawn, *([_front(dataset)] if is_timed(dataset) else [])]


def is_of_hertz(dataset: xr.Dataset) -> bool:
    """Return whether the errors are against Hertz's contact, for which the law of a window is known."""
    return str(dataset.attrs.get("against", "")) == HERTZ


def is_timed(dataset: xr.Dataset) -> bool:
    """Return whether times were taken."""
    return "solve_time" in dataset and bool(dataset["solve_time"].notnull().any())


def _on_one_tolerance(dataset: xr.Dataset) -> xr.Dataset:
    """Return a dataset at its smallest tolerance, where it has several."""
    if "solver_tolerance" not in dataset.dims:
        return dataset
    return dataset.sel(solver_tolerance=dataset["solver_tolerance"].min(), drop=True)


def _lines(dataset: xr.Dataset, over: str) -> Iterator[tuple[str, str, xr.Dataset]]:
    """Yield padding, name and part of a dataset for every padding, and every n that is not the axis itself."""
    for padding in paddings(dataset):
        part = dataset.sel(padding=padding)
        if over == "images":
            yield padding, padding, part
            continue
        for n in part["images"].values[: None if padding in HAS_IMAGES else 1]:
            yield padding, padding_label(padding, int(n)), part.sel(images=n)


def _finest(part: xr.Dataset, over: str) -> xr.Dataset:
    """Return a part at the finest grid, the longest period and the largest n, but for the axis `over`."""
    axes = {"images", "period", "grid"} & set(part.dims) - {over}
    return part.isel(dict.fromkeys(axes, -1))


def shown_at(part: xr.Dataset, over: str) -> str:
    """Return the values of the axes at which a figure is drawn."""
    words = {"grid": "{} cells across", "period": "L = {:g} a" if is_of_hertz(part) else ""}
    shown = _finest(part, over)
    texts = [words[axis].format(shown[axis].item()) for axis in words if shown[axis].ndim == 0]
    return ", ".join(text for text in texts if text)


def against(dataset: xr.Dataset) -> str:
    """Return what the errors are against."""
    return f"against {dataset.attrs.get('against', 'a finer solution')}"


def _over_reach(dataset: xr.Dataset) -> CaptionedFigure:
    """Draw the errors of all n and periods over the distance within which a point sees pressure."""
    finest = dataset.isel(grid=-1)
    fig, (ax,) = panels(1, width=WIDTH, height=4.2)
    spans: list[float] = []
    for name in paddings(dataset):
        part = finest.sel(padding=name)
        counted = part if name in HAS_IMAGES else part.isel(images=[0])
        flat = counted[ERROR].stack(setting=("images", "period"))
        reach = [padding_at(name, int(n)).reach(float(L)) for n, L in flat["setting"].values]
        style = padding_style(name)
        if np.isfinite(reach).all():
            ax.loglog(reach, flat, ls="none", label=name, **style)
            spans += reach
        else:
            ax.axhline(
                float(flat.max()),
                color=style["color"],
                ls="--",
                label=f"{name}: the error by the cells",
            )
    beyond = np.geomspace(max(1.0, min(spans)), max(spans))
    # L1 error of a window with a reach of so many half-widths
    ax.loglog(beyond, 1 / (2 * np.pi * beyond**2), label="law a²/(2πD²)", **LAW_STYLE)
    ax.set(xlabel="reach D of the window over the half-width a", ylabel=LABEL)
    write_powers(ax.yaxis, in_percent)
    write_powers(ax.xaxis, "{:g}".format)
    return captioned(
        "reach",
        fig,
        f"{LABEL} over the reach D of the window: the distance to each side within which a point sees pressure (L/2 "
        "without neighbours, L with one copy, (n + ½)L with n periods). Each mark is a padding at one n and one period "
        f"L, on {int(finest['grid'])} cells across. All windows that move with the point follow one law; one that is "
        f"fixed to the domain also makes the load vary along the length. Dashed: no image is left out.",
    )


def _over(dataset: xr.Dataset, over: str) -> CaptionedFigure:
    fig, (ax,) = panels(1, width=WIDTH, height=4.2)
    for padding, label, part in _lines(dataset, over):
        shown = _finest(part, over)
        x = shown[over].values + (0.5 if over == "images" else 0.0)
        style = padding_style(padding)
        if over == "images" and padding not in HAS_IMAGES:
            style |= {"marker": "none", "ls": "--"}
        if over == "period":  # some whole numbers are no line
            style |= {"ls": "none"}
        ax.loglog(x, shown[ERROR], label=label, **style)
    ax.set(xlabel=OVER[over], ylabel=LABEL)
    write_powers(ax.yaxis, in_percent)
    if over == "grid":
        tick_cells(ax, dataset["grid"].values)
    place = shown_at(dataset, over)
    ends = " A line ends horizontally at the error of its padding, which finer grids do not reduce."
    return captioned(
        f"over_{over}",
        fig,
        f"{LABEL} over the {OVER[over].split('  ')[0]}, {against(dataset)}{'; ' * bool(place)}{place}."
        + ends * (over == "grid"),
    )


def _points(dataset: xr.Dataset) -> CaptionedFigure:
    """Draw the error of every padding as a point."""
    lines = list(_lines(dataset, ""))
    fig, (ax,) = panels(1, width=WIDTH, height=1.0 + 0.3 * len(lines))
    for row, (padding, _, part) in enumerate(lines):
        error = float(_finest(part, "")[ERROR])
        ax.plot(error, row, "o", color=padding_style(padding)["color"])
    names = [label for _, label, _ in lines]
    ax.set(xscale="log", xlabel=LABEL, yticks=range(len(lines)), yticklabels=names)
    write_powers(ax.xaxis, in_percent)
    ax.invert_yaxis()
    caption = f"{LABEL} of every padding, {against(dataset)}; {shown_at(dataset, '')}."
    return captioned("paddings", fig, caption)


def _front(dataset: xr.Dataset) -> CaptionedFigure:
    """Draw errors over times, a panel for at most two periods."""
    periods = dataset["period"].values[[0, -1] if dataset.sizes["period"] > 1 else [0]]
    fig, axes = panels(len(periods), width=WIDTH / len(periods), height=4.2, share="both")
    for ax, period in zip(axes, periods, strict=True):
        part = dataset.sel(period=period)
        for padding in paddings(dataset):
            settings, style = part.sel(padding=padding), padding_style(padding)
            cost = total_time(settings).values.ravel()
            error = settings[ERROR].values.ravel()
            best = pareto_front(cost, error)
            ax.loglog(cost[best], error[best], label=padding, **style)
            ax.loglog(cost, error, **style | {"ls": "none", "ms": 3, "alpha": 0.5})
        period_text = f"period L = {period:g} a" if is_of_hertz(dataset) else ""
        ax.set(xlabel="wall time to set up and solve, on one thread", title=period_text)
        write_powers(ax.xaxis, seconds_text)
        write_powers(ax.yaxis, in_percent)
    axes[0].set_ylabel(LABEL)
    caption = (
        "The price of accuracy: the Pareto front of each padding; small marks: its other settings."
    )
    return captioned("front", fig, caption)


def _tables(dataset: xr.Dataset) -> Sequence[Table]:
    """Return the n or the cells that are needed, where several are stored."""
    if dataset.sizes["images"] > 2 and "circular" in paddings(dataset):
        return [_needed(_on_one_tolerance(dataset))]
    if dataset.sizes["grid"] > 2 and "solver_tolerance" not in dataset.dims:
        return [_cells(dataset)]
    return []


def _from_then_on(meets: np.ndarray, values: np.ndarray) -> str:
    """Return the least of some rising values from which on all meet a condition, or that none does."""
    enough = np.flatnonzero(np.minimum.accumulate(meets[::-1])[::-1])
    return str(values[enough[0]]) if enough.size else f"> {values[-1]}"


def _cells(dataset: xr.Dataset) -> Table:
    """Return the least number of cells across from which on each padding stays below some errors."""
    lines = [
        (label, _finest(part, "grid")[ERROR].values) for _, label, part in _lines(dataset, "grid")
    ]
    cells = dataset["grid"].values
    rows = tuple(
        (percent(target), *(_from_then_on(errors <= target, cells) for _, errors in lines))
        for target in DECADES
        if min(errors[-1] for _, errors in lines) <= target
    )
    return Table(
        f"Cells across from which on the error stays below a target, {shown_at(dataset, 'grid')}; > {cells[-1]}: "
        "on no grid that was tried.",
        ("error at most", *(label for label, _ in lines)),
        rows,
    )


def _needed(dataset: xr.Dataset) -> Table:
    """Return the least n of a moving window from which on its own error stays below some errors, for each period."""
    finest, rows = dataset.isel(grid=-1), []
    single = [name for name in ("duplicated", "exact") if name in paddings(dataset)]
    for period in dataset["period"].values:
        part = finest.sel(period=period)
        period_text = f"{period:g} a" if is_of_hertz(dataset) else f"{period:g}"
        errors = [percent(part[ERROR].sel(padding=name).isel(images=0)) for name in single]
        window = part[ERROR].sel(padding="circular").values
        cells = float(part[ERROR].sel(padding="exact").min()) if "exact" in single else 0.0
        enough = (
            _from_then_on(window <= cells + target, part["images"].values) for target in TARGETS
        )
        rows.append((period_text, *errors, *enough))
    return Table(
        f"Error of the paddings without an n, and the least n of a circular window whose error does not exceed that "
        f"of exact periodicity by more than a target, on {int(finest['grid'])} cells across. The n are those stored: "
        f"{', '.join(str(n) for n in dataset['images'].values)}.",
        ("period", *single, *(f"n for {percent(target)} more" for target in TARGETS)),
        tuple(rows),
    )


def _findings(dataset: xr.Dataset) -> Sequence[Finding]:
    """Return findings on n, on the period and on the grid; none where a case has no numbers."""
    good = bool((dataset["case_status"] == CaseStatus.OK).all())
    if not good or "exact" not in paddings(dataset) or not is_of_hertz(dataset):
        return ()
    chosen, findings = _on_one_tolerance(dataset), []
    if {"circular", "duplicated"} <= set(paddings(dataset)) and dataset.sizes["period"] > 1:
        if dataset.sizes["images"] > 2:
            findings.append(_which_n(chosen))
        findings.append(_which_period(chosen))
    if dataset.sizes["grid"] > 2:
        findings.append(_which_grid(chosen))
    return findings


def _which_n(dataset: xr.Dataset) -> Finding:
    errors = dataset[ERROR].isel(grid=-1)
    exact = float(errors.sel(padding="exact").max())
    n = int(dataset["images"][-1])
    worst = float(errors.sel(padding="circular").isel(images=-1).max())
    return Finding(
        "No n is needed: exact periodicity sums all images in closed form.",
        f"Its error is that of the cells, at most {percent(exact)} here at any period. A window of n periods leaves "
        f"out an error of a²/(2π(n + ½)²L²): on a short period many n are needed (the table). With "
        f"n = {n} the largest error of a circular window is {percent(worst)}. More n cannot do better than exact "
        "periodicity; one copy (duplicated) is as n = ½.",
        "Which n?",
    )


def _which_period(dataset: xr.Dataset) -> Finding:
    errors = dataset["axis_pressure_error"].isel(grid=-1, images=-1)
    short, long = float(errors["period"].min()), float(errors["period"].max())
    facts = "; ".join(
        f"{padding_label(name, int(errors['images']))} ({percent(part.sel(period=short))}, "
        f"{percent(part.sel(period=long))})"
        for name in ("duplicated", "circular", "exact")
        for part in [errors.sel(padding=name)]
    )
    return Finding(
        "“Independent of the domain extent in the length direction”: true only for exact periodicity.",
        f"Error of the pressure on the axis at L = {short:g} a and at L = {long:g} a: {facts}.",
        "The paper's second claim",
    )


def _which_grid(dataset: xr.Dataset) -> Finding:
    exact = dataset.sel(padding="exact").isel(images=-1, period=-1).sortby("grid")
    cells, errors = exact["grid"].values, exact[ERROR].values
    rate = float(np.polyfit(np.log(cells), np.log(errors), 1)[0])
    enough = _from_then_on(errors <= 1e-2, cells)
    largest = exact["pressure_error_max"].values
    return Finding(
        f"{enough} cells across the width of 2.4 a for 1 %: with exact periodicity the grid is the only source of "
        f"error.",
        f"The L1 error falls like {power('N', rate)}, from {percent(errors[0])} at {cells[0]} cells to "
        f"{percent(errors[-1])} at {cells[-1]}. The largest error of a cell, at the edge of the contact, falls "
        f"slowly and not monotonically: {percent(largest[-1])} of p_{{H}} at {cells[-1]} cells.",
        "Which grid?",
    )


padding = period = images = grid = pareto = Drawing(_figure, _findings, _tables)
