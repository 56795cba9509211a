"""Accuracy against the number of cells."""

import numpy as np
import xarray as xr

from contactstudy.analytic import truncation_error
from studies import line_contact
from studies.line_contact import measures, padding_at, scene_at
from studies.style import LAW, look, paddings, panels
from studies.study import Plate

__all__ = ["figure", "measures", "points", "scene_at"]

points = line_contact.axes(grid=(16, 24, 32, 48, 64, 96, 128, 192, 256))

RATES = {
    "peak_pressure_error": ("|peak-pressure error|", None),
    "pressure_error_l1": ("relative L1 error of the pressure", -1.5),
    "pressure_error_max": ("largest pressure error / p_H", -0.5),
    "half_width_error": ("|half-width error|", -1.0),
}


def figure(dataset: xr.Dataset) -> tuple[Plate, ...]:
    """Four errors against the grid, with the rates that theory gives the exact kernel."""
    chosen = dataset.isel(images=-1, period=-1)
    images, period = int(chosen["images"]), float(chosen["period"])
    cells = chosen["grid"].values
    plate, axes = panels(len(RATES), columns=2, width=4.2, height=3.1)
    for ax, (variable, (label, rate)) in zip(axes, RATES.items(), strict=True):
        for name in paddings(dataset):
            error = np.abs(chosen[variable].sel(padding=name))
            legend = f"{name}, n = {images}" if name == "superposed" else name
            ax.loglog(cells, error, label=legend, **look(name))
            reach = padding_at(name, images).reach(period)
            if rate is None and np.isfinite(reach) and name != "zero":
                ax.axhline(truncation_error(1, reach), **LAW)
        if rate is not None and "exact" in paddings(dataset):
            error = np.abs(chosen[variable].sel(padding="exact"))
            anchor = np.exp(np.mean(np.log(error) - rate * np.log(cells)))
            ax.loglog(cells, float(anchor) * cells**rate, **LAW)
            ax.plot([], [], label=f"N^{rate:g}", **LAW)
        else:
            ax.plot([], [], label="law a²/(8D²)", **LAW)
        ax.set(xlabel="cells N across 2.4 a", ylabel=label)
        ax.set_xticks(cells[::2], [str(n) for n in cells[::2]])
        ax.minorticks_off()
    axes[0].legend(loc="best")
    for ax, (_, rate) in zip(axes[1:], list(RATES.values())[1:], strict=True):
        ax.legend(handles=[ax.lines[-1]], loc="best") if rate else None
    return (Plate("grid", plate, _words(chosen)),)


def _words(chosen: xr.Dataset) -> str:
    if "exact" not in paddings(chosen) or chosen.sizes["grid"] < 2:
        return "Error against the number of cells."
    cells = chosen["grid"].values
    error = chosen["pressure_error_l1"].sel(padding="exact").values
    rate = np.polyfit(np.log(cells), np.log(error), 1)[0]
    return (
        f"Error against the number of cells N. With exact periodicity the L1 error falls like N^{rate:.2f}; "
        "the largest error sits in the cells that hold the contact edge, and both it and the half-width "
        "jump with where the edge falls in its cell. A truncated window has an error of its own, which no "
        "grid removes: its curves level off at the law for its reach."
    )
