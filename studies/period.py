"""Accuracy against the period length."""

import numpy as np
import xarray as xr

from contactstudy.analytic import truncation_error
from studies import line_contact
from studies.line_contact import measures, padding_at, scene_at
from studies.style import LAW, look, paddings, panels, percent
from studies.study import Plate

__all__ = ["figure", "measures", "points", "scene_at"]

points = line_contact.axes(period=(0.15, 0.3, 0.6, 1.2, 2.4, 4.8, 9.6))


def figure(dataset: xr.Dataset) -> tuple[Plate, ...]:
    """Peak-pressure error and largest error against the period."""
    chosen = dataset.isel(grid=-1, images=-1)
    images = int(chosen["images"])
    periods = chosen["period"].values
    plate, (peak, largest) = panels(2, width=4.4)
    for name in paddings(dataset):
        one = chosen.sel(padding=name)
        label = f"{name}, n = {images}" if name == "superposed" else name
        peak.loglog(periods, np.abs(one["peak_pressure_error"]), label=label, **look(name))
        largest.loglog(periods, one["pressure_error_max"], label=label, **look(name))
        reach = padding_at(name, images).reach(1.0)
        if np.isfinite(reach) and name != "zero":
            law = truncation_error(1, reach * periods)
            peak.loglog(periods, law, label=None, **LAW)
    peak.plot([], [], label="law a²/(8D²)", **LAW)
    peak.set(xlabel="period L / half-width a", ylabel="|peak-pressure error|")
    peak.set_ylim(top=max(2, peak.get_ylim()[1]) if peak.get_ylim()[1] < 1e3 else 1e3)
    largest.set(xlabel="period L / half-width a", ylabel="largest pressure error / p_H")
    peak.legend(loc="best")
    return (Plate("period", plate, _words(chosen)),)


def _words(chosen: xr.Dataset) -> str:
    words = (
        "Error against the period, with D = L for duplicated padding and D = (n + ½)L for superposition "
        "in the law. "
    )
    errors = np.abs(chosen["peak_pressure_error"])
    shortest, longest = float(chosen["period"].min()), float(chosen["period"].max())
    facts = [
        f"{name}: {percent(float(errors.sel(padding=name, period=shortest)))} at L = {shortest:g} a, "
        f"{percent(float(errors.sel(padding=name, period=longest)))} at {longest:g} a"
        for name in paddings(chosen)
    ]
    return words + "; ".join(facts) + "."
