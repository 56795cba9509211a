"""What the stored studies say, in sentences and tables; every number is read from them."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import xarray as xr

from studies.front import pareto_front
from studies.line_contact import COUNTED
from studies.outcome import Fate
from studies.padding import settings
from studies.style import label_of, paddings, percent
from studies.worth import DECADES, decades, kept, never_worth

Row = tuple[str, ...]
TARGETS = (1e-1, 1e-2, 1e-3, 2e-4)


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
    """The answers to the questions the studies ask, where what is stored can answer them.

    A sweep over other axes may lack a padding, the n or the period that a question is about: then it is
    silent, since a sentence that fits any numbers says nothing.
    """
    compared = {"duplicated", "superposed", "circular", "exact"}
    found = []
    if _holds(stored["padding"], compared):
        found.append(_which_padding(stored["padding"]))
    if _holds(stored["images"], {"duplicated", "superposed"}, images={6}, period={2.4}):
        found.append(_six_images(stored["images"]))
    if _holds(stored["period"], compared) and stored["period"].sizes["period"] > 1:
        found.append(_any_period(stored["period"]))
    if _holds(stored["grid"], {"exact"}) and stored["grid"].sizes["grid"] > 2:
        found.append(_which_grid(stored["grid"]))
    if "pareto" in stored and _holds(stored["pareto"], compared):
        found += [
            Finding(*said) for said in (never_worth(stored["pareto"]), kept(stored["pareto"]))
        ]
    return tuple(found)


def _holds(dataset: xr.Dataset, names: set[str], **values: set[float]) -> bool:
    """Whether a sweep has these paddings and values, and all its cases came to an end."""
    there = all(wanted <= set(dataset[axis].values.tolist()) for axis, wanted in values.items())
    return there and names <= set(paddings(dataset)) and bool((dataset["status"] == Fate.OK).all())


def _which_padding(dataset: xr.Dataset) -> Finding:
    here = dataset.isel(period=-1, grid=-1, images=-1)
    exact = here.sel(padding="exact")
    others = (here.sel(padding=name) for name in ("duplicated", "superposed", "circular"))
    costs = "; ".join(
        f"{label_of(one)}: {percent(one['peak_pressure_error'])} in {float(_time(one)):.2g} s"
        for one in others
    )
    return Finding(
        "Use exact periodicity: no choice of n, no error of its own, at every period.",
        f"At {int(here['grid'])} x {int(here['grid'])} cells and L = {float(here['period']):g} a its "
        f"peak pressure is off by {percent(exact['peak_pressure_error'])}, which is the grid's error, and "
        f"varies along the length by {_variation(exact)}. It took {float(_time(exact)):.2g} s. "
        f"The others, error of the peak pressure and time: {costs}.",
    )


def _variation(dataset: xr.Dataset) -> str:
    variation = float(dataset["length_variation"])
    return f"{percent(variation)} of p_H" if variation > 1e-12 else "nothing but rounding"


def _time(dataset: xr.Dataset) -> xr.DataArray:
    return dataset["setup_time"] + dataset["solve_time"]


def _six_images(dataset: xr.Dataset) -> Finding:
    here = dataset.sel(period=2.4).isel(grid=-1)
    copied, six = here.sel(padding="duplicated", images=6), here.sel(padding="superposed", images=6)
    ratio = abs(float(copied["peak_pressure_error"] / six["peak_pressure_error"]))
    return Finding(
        "“n ≥ 6 gives very similar results to duplicated padding”: the numbers say otherwise.",
        f"At L = 2.4 a the peak pressure, as a mean along the length, is off by "
        f"{percent(copied['peak_pressure_error'])} with duplicated padding and by "
        f"{percent(six['peak_pressure_error'])} with n = 6, a factor of {ratio:.0f}: a copy of the pressure "
        "reaches one period to each side, as n = ½ would. Superposition errs in another way, along the "
        f"length: with n = 6 the pressure of a uniform cylinder varies by {_variation(six)} and is nowhere "
        f"higher than p_H by more than {percent(six['highest_pressure_error'])}; with duplicated padding it "
        f"varies by {_variation(copied)}. In a plot of the pressure such as the paper's Fig. 5 little of "
        "this meets the eye.",
    )


def _any_period(dataset: xr.Dataset) -> Finding:
    here = dataset.isel(grid=-1, images=-1)
    short, long = float(here["period"].min()), float(here["period"].max())
    facts = " and ".join(
        f"from {percent(one.sel(period=short)['peak_pressure_error'])} to "
        f"{percent(one.sel(period=long)['peak_pressure_error'])} with {label_of(one)}"
        for one in (here.sel(padding=name) for name in ("duplicated", "superposed"))
    )
    exact = here["peak_pressure_error"].sel(padding="exact")
    return Finding(
        "“Independent of the domain extent in the length direction”: true of exact periodicity alone.",
        f"Between L = {short:g} a and L = {long:g} a the peak-pressure error goes {facts}; "
        f"with exact periodicity it moves by {percent(exact.max() - exact.min())}. "
        "A window that reaches D to each side leaves a²/(8D²), so a period of a few half-widths is "
        "not long enough for a truncated one.",
    )


def _which_grid(dataset: xr.Dataset) -> Finding:
    exact = dataset.sel(padding="exact").isel(images=-1, period=-1).sortby("grid")
    cells = exact["grid"].values
    rates = [
        np.polyfit(np.log(cells), np.log(exact[f"pressure_error_{kind}"].values), 1)[0]
        for kind in ("l1", "max")
    ]
    first, last = exact.isel(grid=0), exact.isel(grid=-1)
    return Finding(
        "With the images out of the way, the grid is all that is left to pay for.",
        f"The L1 error of the pressure falls like N^({rates[0]:.2f}), from "
        f"{percent(first['pressure_error_l1'])} at {cells[0]} cells across in {float(_time(first)):.1g} s to "
        f"{percent(last['pressure_error_l1'])} at {cells[-1]} in {float(_time(last)):.2g} s. The largest "
        f"error, in the cells that hold the contact edge, falls like N^({rates[1]:.2f}) only, by leaps: it "
        f"is {percent(last['pressure_error_max'])} of p_H at {cells[-1]}.",
    )


def accuracy_table(dataset: xr.Dataset) -> Table:
    """Errors and cost of every mode at the paper's setting."""
    rows = []
    order = ("exact", "duplicated", "circular", "superposed", "zero")
    for name in (name for name in order if name in paddings(dataset)):
        counted = dataset["images"].values if name in COUNTED else dataset["images"].values[-1:]
        for images in counted:
            one = dataset.sel(padding=name, images=images)
            errors = (
                "peak_pressure_error",
                "highest_pressure_error",
                "pressure_error_max",
                "length_variation",
                "half_width_error",
            )
            rows.append(
                (
                    "zero (not periodic)" if name == "zero" else label_of(one),
                    *(percent(one[error]) for error in errors),
                    str(int(one["iterations"])),
                    f"{float(one['setup_time']):.3f}",
                    f"{float(one['solve_time']):.3f}",
                )
            )
    return Table(
        "A smooth line contact on the paper's grid, 128 x 128 cells over 2.4 a x 2.4 a, against Hertz. "
        "Pressures over p_H: the peak as the mean along the length beside the axis, the highest anywhere, "
        "the largest error of any cell. That error sits at the contact edge and jumps with where the edge "
        "falls in its cell, so on one grid a truncated window may come out ahead by chance. "
        "Times on one thread.",
        (
            "padding", "peak error",
            "highest pressure", "largest error", "variation along length", "half-width error",
            "iterations", "set-up [s]", "solve [s]",
        ),
        tuple(rows),
    )  # fmt: skip


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
                said = f"none stored; the best is {label_of(best)}"
            else:
                best = points.isel(point=meets[0])
                said = label_of(best)
            numbers = (str(int(best["grid"])), percent(best["error"]), f"{float(best['cost']):.2g}")
            rows.append((f"{period:g} a", percent(target), said, *numbers))
    return Table(
        "What accuracy costs: the cheapest stored setting whose L1 pressure error meets each target.",
        ("period", "L1 error asked", "cheapest padding", "cells across", "reached", "time [s]"),
        tuple(rows),
    )


def decade_table(dataset: xr.Dataset) -> Table:
    """The least time in which each mode meets each decade of the L1 error, at every period."""
    rows = []
    for (mode, period), seconds in decades(dataset).items():
        times = (f"{second:.2g}" if np.isfinite(second) else "none" for second in seconds)
        rows.append((mode, period, *times))
    return Table(
        "What each decade costs: the least time [s] on one thread in which each mode meets an L1 error of the "
        "pressure, its edges corrected or not, over all n, grids, tolerances and solvers of the study. "
        "“line” is exact periodicity with one cell along a length where nothing varies.",
        ("padding", "period", *(f"error {target:.0e}" for target in DECADES)),
        tuple(rows),
    )
