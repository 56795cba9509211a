"""Accuracy against the number n of superposed periods."""

import numpy as np
import xarray as xr

from contactstudy.analytic import truncation_error
from studies import line_contact
from studies.line_contact import measures, padding_at, scene_at
from studies.study import Plate
from studies.style import LAW, finish, look, marked, paddings, panels, percent, some

__all__ = ["figure", "measures", "points", "scene_at"]

points = line_contact.axes(
    padding=("superposed", "circular", "duplicated", "exact"),
    images=(0, 1, 2, 3, 4, 6, 8, 10, 20, 50),
    period=(0.6, 2.4, 9.6),
)
LABEL = "n + ½  (n periods on each side)"


def figure(dataset: xr.Dataset) -> tuple[Plate, ...]:
    """Peak-pressure error and variation along the length against n, a panel for each period."""
    finest = dataset.isel(grid=-1)
    return _peak(finest), _variation(finest)


def _peak(dataset: xr.Dataset) -> Plate:
    periods = some(dataset["period"].values)
    plate, axes = panels(len(periods), share="y")
    half = dataset["images"].values + 0.5
    for ax, period in zip(axes, periods, strict=True):
        for name in paddings(dataset):
            error = abs(dataset["peak_pressure_error"].sel(padding=name, period=period))
            ax.loglog(half, error, label=name, **marked(name))
        reach = [padding_at("superposed", int(n)).reach(period) for n in dataset["images"]]
        ax.loglog(half, truncation_error(1, reach), label="law a²/(8D²), D = (n + ½)L", **LAW)
        ax.set(title=f"period L = {period:g} a", xlabel=LABEL)
    axes[0].set_ylabel("|peak-pressure error|")
    finish(plate)
    return Plate("peak_error", plate, _peak_words(dataset, periods))


def _peak_words(dataset: xr.Dataset, periods: list[float]) -> str:
    words = (
        "Peak-pressure error against the number of superposed periods. It falls like the square of the "
        "window's reach until the grid's own error, that of exact periodicity, shows; where the two are "
        "of one size they may cancel, since truncation raises the peak and the grid may lower it. "
    )
    if not {"superposed", "duplicated"} <= set(paddings(dataset)):
        return words
    errors = abs(dataset["peak_pressure_error"])
    facts = []
    for period in periods:
        duplicated = float(errors.sel(padding="duplicated", period=period)[0])
        superposed = errors.sel(padding="superposed", period=period)
        worse = np.flatnonzero((superposed >= duplicated).values)
        better = dataset["images"].values[worse[-1] + 1 if worse.size else 0 :]
        if better.size:
            facts.append(f"at L = {period:g} a from n = {better[0]} on ({percent(duplicated)})")
    return words + (
        "Superposition beats duplicated padding " + ", ".join(facts) + "." if facts else ""
    )


def _variation(dataset: xr.Dataset) -> Plate:
    plate, (ax,) = panels(1, width=6, height=3.4)
    half = dataset["images"].values + 0.5
    periods = some(dataset["period"].values)
    shown = "superposed" in paddings(dataset)
    for period, line in zip(periods if shown else [], ("-", "--", "-."), strict=False):
        variation = dataset["length_variation"].sel(padding="superposed", period=period)
        style = look("superposed") | {"linestyle": line}
        ax.loglog(half, variation, label=f"superposed, L = {period:g} a", **style)
        middle = len(half) // 2
        law = float(variation[middle]) * (half[middle] / half) ** 2
        ax.loglog(half, law, label="slope −2", **LAW)
    ax.set(xlabel=LABEL, ylabel="pressure variation along length / p_H")
    finish(plate)
    return Plate(
        "length_variation",
        plate,
        "A uniform cylinder comes out uneven along its length under superposition, because the window of "
        "images is centred on the domain and not on the observer. The difference a lopsided window makes "
        "falls with the square of its reach. Circular superposition, duplicated padding and exact "
        "periodicity move with the observer: "
        "every observer sees the same, and nothing varies but by rounding.",
    )
