"""What the stored studies say, in sentences and tables; every number is read from them."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import xarray as xr

from studies.front import pareto_front
from studies.style import paddings, percent

Row = tuple[str, ...]


@dataclass(frozen=True)
class Table:
    """A head, rows of text, and a caption."""

    caption: str
    head: Row
    rows: tuple[Row, ...]


@dataclass(frozen=True)
class Finding:
    """A claim in a few words, and what was measured."""

    claim: str
    measured: str


def findings(stored: Mapping[str, xr.Dataset]) -> tuple[Finding, ...]:
    """The answers to the questions the studies ask."""
    return (
        _which_padding(stored["padding"]),
        _six_images(stored["images"]),
        _any_period(stored["period"]),
        _which_grid(stored["grid"]),
    )


def _which_padding(dataset: xr.Dataset) -> Finding:
    here = dataset.isel(period=dataset.sizes["period"] // 2, grid=-1, images=-1)
    time = here["setup_time"] + here["solve_time"]
    exact = here.sel(padding="exact")
    others = [name for name in paddings(dataset) if name not in ("exact", "zero")]
    costs = ", ".join(
        f"{float(time.sel(padding=name) / time.sel(padding='exact')):.2g} times as long with {name} padding"
        for name in others
    )
    return Finding(
        "Use exact periodicity: it is the most accurate at every setting, and never needs a choice of n.",
        f"At {int(here['grid'])} x {int(here['grid'])} cells and L = {float(here['period']):g} a its "
        f"peak pressure is off by {percent(exact['peak_pressure_error'])}, the same at every period, and it "
        f"varies along the length by {float(exact['length_variation']):.1e} p_H. It took "
        f"{float(time.sel(padding='exact')):.2g} s; the same case took {costs} "
        f"(n = {int(here['images'])}).",
    )


def _six_images(dataset: xr.Dataset) -> Finding:
    here = dataset.sel(period=2.4, method="nearest").isel(grid=-1)
    peak, largest = np.abs(here["peak_pressure_error"]), here["length_variation"]
    duplicated = float(peak.sel(padding="duplicated")[0])
    superposed = {
        int(n): float(peak.sel(padding="superposed", images=n)) for n in here["images"].values
    }
    six = min(superposed, key=lambda n: abs(n - 6))
    closest = min(superposed, key=lambda n: abs(np.log(superposed[n] / duplicated)))
    variation = float(largest.sel(padding="superposed", images=six))
    return Finding(
        "“n ≥ 6 gives very similar results to duplicated padding” does not hold.",
        f"At L = {float(here['period']):g} a the peak pressure is off by {percent(duplicated)} with "
        f"duplicated padding and by {percent(superposed[six])} with n = {six}: "
        f"{duplicated / superposed[six]:.0f} times less. A copy of the pressure reaches as far as about "
        f"half a superposed period more than none, and the n closest to it is {closest}. What superposition "
        f"costs instead is evenness: with n = {six} the pressure of a uniform cylinder varies along "
        f"the length by {percent(variation)} of p_H, with duplicated padding by rounding only. The two "
        "look alike in the paper's Figure 5 because both lie within the width of a line.",
    )


def _any_period(dataset: xr.Dataset) -> Finding:
    here = np.abs(dataset["peak_pressure_error"].isel(grid=-1, images=-1))
    short, long = float(here["period"].min()), float(here["period"].max())
    facts = ", ".join(
        f"{percent(here.sel(padding=name, period=short))} to {percent(here.sel(padding=name, period=long))} "
        f"with {name} padding"
        for name in ("duplicated", "superposed")
        if name in paddings(dataset)
    )
    exact = dataset["peak_pressure_error"].sel(padding="exact").isel(grid=-1, images=-1)
    spread = float(exact.max() - exact.min())
    return Finding(
        "“Independent of the domain extent in the length direction” holds only for exact periodicity.",
        f"Between L = {short:g} a and L = {long:g} a the peak-pressure error goes from {facts} "
        f"(n = {int(dataset['images'][-1])}); with exact periodicity it moves by {spread:.1e}. A window that "
        "reaches D to each side leaves a²/(8D²).",
    )


def _which_grid(dataset: xr.Dataset) -> Finding:
    exact = dataset.sel(padding="exact").isel(images=-1, period=-1)
    cells = exact["grid"].values
    rate = np.polyfit(np.log(cells), np.log(exact["pressure_error_l1"].values), 1)[0]
    time = exact["setup_time"] + exact["solve_time"]
    first, last = exact.isel(grid=0), exact.isel(grid=-1)
    return Finding(
        "With the images out of the way, the grid is all that is left to pay for.",
        f"The L1 error of the pressure falls like N^{rate:.2f}, from "
        f"{percent(first['pressure_error_l1'])} at {cells[0]} cells across to "
        f"{percent(last['pressure_error_l1'])} at {cells[-1]}, for {float(time[0]):.1e} s and "
        f"{float(time[-1]):.2g} s. The largest error, at the contact edge, falls far more slowly: "
        f"{percent(last['pressure_error_max'])} of p_H is still there at {cells[-1]}.",
    )


def accuracy_table(dataset: xr.Dataset) -> Table:
    """Errors and cost of every mode at the paper's setting."""
    rows = []
    for name in ("exact", "duplicated", "superposed", "zero"):
        if name not in paddings(dataset):
            continue
        for images in (
            dataset["images"].values if name == "superposed" else dataset["images"].values[-1:]
        ):
            one = dataset.sel(padding=name, images=images)
            label = {"superposed": f"superposed, n = {images}", "zero": "zero (not periodic)"}.get(
                name, name
            )
            variation = float(one["length_variation"])
            rows.append(
                (
                    label,
                    percent(one["peak_pressure_error"]),
                    percent(one["pressure_error_max"]),
                    percent(variation) if variation > 1e-9 else "none but rounding",
                    percent(one["half_width_error"]),
                    str(int(one["iterations"])),
                    f"{float(one['setup_time']):.3f}",
                    f"{float(one['solve_time']):.3f}",
                )
            )
    return Table(
        "A smooth line contact on the paper's grid, 128 x 128 cells over 2.4 a x 2.4 a, against Hertz. "
        "Pressures over p_H; times on one thread.",
        (
            "padding", "peak error", "largest error", "variation along length", "half-width error",
            "iterations", "set-up [s]", "solve [s]",
        ),
        tuple(rows),
    )  # fmt: skip


def price_table(dataset: xr.Dataset) -> Table:
    """The cheapest stored setting for each step of accuracy, at every period."""
    rows = []
    for period in dataset["period"].values:
        points = dataset.sel(period=period).stack(point=("padding", "images", "grid"))
        cost = (points["setup_time"] + points["solve_time"]).values
        error = points["pressure_error_l1"].values
        front = pareto_front(cost, error)
        for target in (0.1, 0.03, 0.01, 3e-3, 1e-3, 3e-4):
            meets = front[error[front] <= target]
            if not meets.size:
                rows.append((f"{period:g} a", percent(target), "none stored", "–", "–", "–"))
                break
            best = points.isel(point=int(meets[0]))
            name = str(best["padding"].values)
            label = f"superposed, n = {int(best['images'])}" if name == "superposed" else name
            rows.append(
                (
                    f"{period:g} a",
                    percent(target),
                    label,
                    str(int(best["grid"])),
                    percent(error[meets[0]]),
                    f"{cost[meets[0]]:.2g}",
                )
            )
    return Table(
        "What accuracy costs: the cheapest stored setting whose L1 pressure error meets each target.",
        ("period", "asked", "cheapest padding", "cells across", "reached", "time [s]"),
        tuple(rows),
    )
