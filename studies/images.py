"""Accuracy against the number n of superposed periods."""

import numpy as np
import xarray as xr

from contactstudy.analytic import truncation_error
from studies import line_contact
from studies.line_contact import measures, padding_at, scene_at
from studies.style import LAW, look, paddings, panels, percent, some
from studies.study import Plate

__all__ = ["figure", "measures", "points", "scene_at"]

points = line_contact.axes(
    padding=("superposed", "duplicated", "exact"),
    images=(*range(11), 20, 50, 100),
    period=(0.6, 2.4, 9.6),
)


def figure(dataset: xr.Dataset) -> tuple[Plate, ...]:
    """Peak-pressure error and variation along the length against n, a panel for each period."""
    finest = dataset.isel(grid=-1)
    return _peak(finest), _variation(finest)


def _peak(dataset: xr.Dataset) -> Plate:
    periods = some(dataset["period"].values)
    plate, axes = panels(len(periods))
    half = dataset["images"].values + 0.5
    for ax, period in zip(axes, periods, strict=True):
        for name in paddings(dataset):
            error = np.abs(dataset["peak_pressure_error"].sel(padding=name, period=period))
            style = look(name) | ({} if name == "superposed" else {"marker": "none"})
            ax.loglog(half, error, label=name, **style)
        if "superposed" in paddings(dataset):
            law = [
                truncation_error(1, padding_at("superposed", int(n)).reach(period))
                for n in dataset["images"]
            ]
            ax.loglog(half, law, label="law a²/(8D²), D = (n + ½)L", **LAW)
        ax.set(title=f"period L = {period:g} a", xlabel="n + ½  (n periods on each side)")
    axes[0].set_ylabel("|peak-pressure error|")
    axes[-1].legend(loc="best")
    return Plate("peak_error", plate, _peak_words(dataset, periods))


def _peak_words(dataset: xr.Dataset, periods: list[float]) -> str:
    words = (
        "Peak-pressure error against the number of superposed periods. It falls like the square of the "
        "window's reach until the grid's own error, that of exact periodicity, shows. "
    )
    if not {"superposed", "duplicated"} <= set(paddings(dataset)):
        return words
    errors = np.abs(dataset["peak_pressure_error"])
    facts = []
    for period in periods:
        duplicated = float(errors.sel(padding="duplicated", period=period)[0])
        superposed = errors.sel(padding="superposed", period=period)
        better = dataset["images"].values[(superposed < duplicated).values]
        if better.size:
            facts.append(
                f"n = {better[0]} already beats duplicated padding ({percent(duplicated)}) at L = {period:g} a"
            )
    return words + ("; ".join(facts) + "." if facts else "")


def _variation(dataset: xr.Dataset) -> Plate:
    plate, (ax,) = panels(1, width=5.5, height=3.6)
    half = dataset["images"].values + 0.5
    lines = ("-", "--", "-.")
    periods = some(dataset["period"].values)
    for period, line in zip(periods, lines, strict=False):
        if "superposed" not in paddings(dataset):
            break
        variation = dataset["length_variation"].sel(padding="superposed", period=period)
        ax.loglog(
            half,
            variation,
            linestyle=line,
            label=f"superposed, L = {period:g} a",
            **look("superposed"),
        )
        anchor = float(variation[len(variation) // 2]) * half[len(half) // 2] ** 2
        ax.loglog(
            half, anchor / half**2, label="slope −2" if period == periods[-1] else None, **LAW
        )
    ax.set(xlabel="n + ½  (n periods on each side)", ylabel="pressure variation along length / p_H")
    ax.legend()
    return Plate(
        "length_variation",
        plate,
        "A uniform cylinder comes out uneven along its length under superposition, because the window of "
        "images is centred on the domain and not on the observer. The unevenness falls with the square of "
        "the window. Duplicated padding and exact periodicity, which are circular, show none "
        "but rounding.",
    )
