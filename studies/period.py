"""Accuracy against the period length."""

import numpy as np
import xarray as xr

from contactstudy.analytic import truncation_error
from studies import line_contact
from studies.line_contact import measures, padding_at, scene_at
from studies.study import Plate
from studies.style import LAW, finish, label_of, look, paddings, panels, percent

__all__ = ["figure", "measures", "points", "scene_at"]

points = line_contact.axes(period=(0.15, 0.3, 0.6, 1.2, 2.4, 4.8, 9.6))


def figure(dataset: xr.Dataset) -> tuple[Plate, ...]:
    """Peak-pressure error and largest error against the period."""
    chosen = dataset.isel(grid=-1, images=-1)
    periods = chosen["period"].values
    plate, (peak, largest) = panels(2, width=4.4)
    for name in paddings(dataset):
        one = chosen.sel(padding=name)
        peak.loglog(periods, abs(one["peak_pressure_error"]), label=label_of(one), **look(name))
        largest.loglog(periods, one["pressure_error_max"], label=label_of(one), **look(name))
        reach = padding_at(name, int(chosen["images"])).reach(1.0) * periods
        # the law is one for windows beyond the contact; without neighbours the length has ends as well
        beyond = reach > 1
        if np.isfinite(reach).all() and name != "zero":
            law = truncation_error(1, reach[beyond])
            peak.loglog(periods[beyond], law, label="law a²/(8D²)", **LAW)
    peak.set(xlabel="period L / half-width a", ylabel="|peak-pressure error|")
    largest.set(xlabel="period L / half-width a", ylabel="largest pressure error / p_H")
    finish(plate)
    return (Plate("period", plate, _words(chosen)),)


def _words(chosen: xr.Dataset) -> str:
    shortest, longest = float(chosen["period"].min()), float(chosen["period"].max())
    facts = [
        f"{label_of(one)}: {percent(one.sel(period=shortest)['peak_pressure_error'])} at "
        f"L = {shortest:g} a, {percent(one.sel(period=longest)['peak_pressure_error'])} at {longest:g} a"
        for one in (chosen.sel(padding=name) for name in paddings(chosen))
    ]
    return (
        "Error against the period; in the law D = L for duplicated padding and (n + ½)L for "
        f"superposition. Peak-pressure errors: {'; '.join(facts)}."
    )
