"""Drawing of the study `padding`: figures, findings and tables from its stored data."""

from typing import Any

import numpy as np
import xarray as xr

from contactstudy.analytic import truncation_error
from studies.advice.settings_table import pareto_front
from studies.model.drawing import CaptionedFigure, Finding, Table
from studies.reference.line_contact import (
    COUNTS_IMAGES,
    covers,
    padding_at,
    total_time,
)
from studies.report.formatting import (
    paddings,
    percent,
    select_evenly,
    setting_label,
    variation_text,
)
from studies.report.style import LAW_STYLE, add_legend, padding_style, panels

TARGETS = (1e-1, 1e-2, 1e-3, 2e-4)  # of the L1 error


def figure(dataset: xr.Dataset) -> tuple[CaptionedFigure, ...]:
    """Error against wall time with the Pareto front, and against the window's reach."""
    return _price(dataset), _reach(dataset.isel(grid=-1))


def _reach(dataset: xr.Dataset) -> CaptionedFigure:
    fig, (ax,) = panels(1, width=6, height=3.8)
    spans: list[float] = []
    for name in paddings(dataset):
        errors, reaches = [], []
        for images in (
            dataset["images"].values if name in COUNTS_IMAGES else dataset["images"].values[:1]
        ):
            for period in dataset["period"].values:
                chosen = dataset["axis_pressure_error"].sel(
                    padding=name, images=images, period=period
                )
                errors.append(abs(float(chosen)))
                reaches.append(padding_at(name, int(images)).reach(float(period)))
        if np.isfinite(reaches).all():
            ax.loglog(reaches, errors, linestyle="none", label=name, **padding_style(name))
            spans += reaches
        else:
            floor = {"color": padding_style(name)["color"], "linestyle": "--"}
            ax.axhline(max(errors), label=f"{name} (grid error alone)", **floor)
    if spans:
        reach = np.geomspace(min(spans), max(spans))
        ax.loglog(reach, truncation_error(1, reach), label="law a²/(8D²)", **LAW_STYLE)
    ax.set(xlabel="reach of the window D / half-width a", ylabel="|axis-pressure error|")
    add_legend(fig)
    return CaptionedFigure(
        "reach",
        fig,
        "Peak-pressure error of every setting against its reach, the distance to each side within which a point "
        "sees pressure (D = L/2 without neighbours, L duplicated, (n + ½)L superposed). The truncated part "
        "causes an error of a²/(8D²) once D exceeds about 3a, for every kind of window. Zero padding does not "
        "follow this law, since its pressure ends with the domain. Exact periodicity has the discretisation "
        "error alone.",
    )


def _price(dataset: xr.Dataset) -> CaptionedFigure:
    periods = select_evenly(dataset["period"].values, most=2)
    fig, axes = panels(len(periods), width=4.4, height=3.6, share="both")
    words = []
    for ax, period in zip(axes, periods, strict=True):
        points = settings(dataset.sel(period=period))
        cost, error, labels = (points[name].values for name in ("cost", "error", "padding"))
        front = pareto_front(cost, error)
        shade: dict[str, Any] = {"color": "black", "alpha": 0.12, "linewidth": 7}
        ax.loglog(cost[front], error[front], label="Pareto front", **shade)
        for name in paddings(dataset):
            own = np.flatnonzero(labels == name)
            line = own[pareto_front(cost[own], error[own])]
            ax.loglog(cost[line], error[line], label=name, **padding_style(name))
            faint = padding_style(name) | {"markersize": 3, "alpha": 0.5, "linestyle": "none"}
            ax.loglog(cost[own], error[own], **faint)
        ax.set(title=f"period L = {period:g} a", xlabel="wall time, set-up and solve [s]")
        best = points.isel(point=front[-1])
        words.append(
            f"L = {period:g} a: {setting_label(best)} at {int(best['grid'])} cells, L1 error "
            f"{percent(best['error'])} in {float(best['cost']):.2g} s"
        )
    axes[0].set_ylabel("relative L1 error of the pressure")
    add_legend(fig)
    return CaptionedFigure(
        "price",
        fig,
        "Price of accuracy: L1 error of the pressure against wall time on one thread. Each line is the Pareto "
        "front of the settings of one padding, over all n and grids; the small marks are its other settings. "
        "Settings of one window lie in a row: a finer grid does not remove the truncation error. "
        "The most accurate settings: " + "; ".join(words) + ".",
    )


def settings(dataset: xr.Dataset) -> xr.Dataset:
    """Every setting at one period as a flat list of ``cost`` [s] and L1 ``error``."""
    flat = dataset[["setup_time", "solve_time", "pressure_error_l1"]].stack(
        point=("padding", "images", "grid")
    )
    return xr.Dataset({"cost": total_time(flat), "error": flat["pressure_error_l1"]}).reset_index(
        "point"
    )


def findings(dataset: xr.Dataset) -> tuple[Finding, ...]:
    """Which padding, and what it costs."""
    if not covers(dataset, {"duplicated", "superposed", "circular", "exact"}):
        return ()
    return _which_padding(dataset), _what_it_costs(dataset)


def _which_padding(dataset: xr.Dataset) -> Finding:
    here = dataset.isel(period=-1, grid=-1, images=-1)
    exact = here.sel(padding="exact")
    others = (here.sel(padding=name) for name in ("duplicated", "superposed", "circular"))
    costs = "; ".join(
        f"{setting_label(one)}: {percent(one['axis_pressure_error'])} in {float(total_time(one)):.2g} s"
        for one in others
    )
    return Finding(
        "Use exact periodicity: it has no n to choose and no truncation error, at any period.",
        f"At {int(here['grid'])} x {int(here['grid'])} cells and L = {float(here['period']):g} a the error of its "
        f"peak pressure is {percent(exact['axis_pressure_error'])}, which is the discretisation error; the pressure "
        f"varies along the length by {variation_text(exact)}; the time is {float(total_time(exact)):.2g} s. "
        f"Error of the peak pressure and time of the others: {costs}.",
        "Which padding?",
    )


def _what_it_costs(dataset: xr.Dataset) -> Finding:
    exact = settings(dataset.isel(period=-1, images=[-1]).sel(padding=["exact"]))
    exact = exact.sortby("error", ascending=False)
    steps = [
        f"{percent(one['error'])} at {int(one['grid'])} cells across in {float(one['cost']):.2g} s"
        for one in (exact.isel(point=k) for k in range(exact.sizes["point"]))
    ]
    cost, error = exact["cost"].values, exact["error"].values
    dearer = ""
    if error[-1] < error[0]:
        growth = 10 ** (np.log(cost[-1] / cost[0]) / np.log(error[0] / error[-1]))
        dearer = f", and one tenth of the error takes {growth:.0f} times as long"
    return Finding(
        f"With exact periodicity an L1 error of {percent(error[-1])} costs {cost[-1]:.2g} s on one "
        f"thread{dearer}.",
        f"Measured: {'; '.join(steps)}. The L1 error falls like N^{{−3/2}} and an iteration takes N² log N "
        "operations, so that on large grids one tenth of the error takes 10^{4/3} ≈ 22 times as long; on small "
        "grids it takes less, since much of the time is set-up, which hardly grows.",
        "What does it cost?",
    )


def tables(dataset: xr.Dataset) -> tuple[Table, ...]:
    """What each step of accuracy costs."""
    return (price_table(dataset),)


def price_table(dataset: xr.Dataset) -> Table:
    """The cheapest stored setting for each step of accuracy, at every period."""
    rows = []
    for period in dataset["period"].values:
        points = settings(dataset.sel(period=period))
        cost, error = points["cost"].values, points["error"].values
        front = pareto_front(cost, error)
        for target in TARGETS:
            meets = front[error[front] <= target]
            if not meets.size:
                best = points.isel(point=front[-1])
                said = f"none stored; the most accurate is {setting_label(best)}"
            else:
                best = points.isel(point=meets[0])
                said = setting_label(best)
            numbers = (str(int(best["grid"])), percent(best["error"]), f"{float(best['cost']):.2g}")
            rows.append((f"{period:g} a", percent(target), said, *numbers))
    return Table(
        "Cost of accuracy: the cheapest stored setting whose L1 pressure error is at most the target.",
        ("period", "target L1 error", "cheapest padding", "cells across", "reached", "time [s]"),
        tuple(rows),
    )
