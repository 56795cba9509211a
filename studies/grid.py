"""Accuracy against the number of cells."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from contactstudy.analytic import truncation_error
from studies import line_contact
from studies.line_contact import WIDTH, measures, padding_at, scene_at
from studies.study import Plate
from studies.style import LAW, finish, label_of, look, paddings, panels

__all__ = ["figure", "measures", "points", "scene_at"]

points = line_contact.axes(grid=(16, 24, 32, 48, 64, 96, 128, 192, 256))

PANELS = {
    "peak_pressure_error": "|peak-pressure error|",
    "pressure_error_l1": "relative L1 error of the pressure",
    "pressure_error_max": "largest pressure error / p_H",
    "half_width_error": "|half-width error|",
}
RATES = {"pressure_error_l1": -1.5, "pressure_error_max": -0.5}


def figure(dataset: xr.Dataset) -> tuple[Plate, ...]:
    """Four errors against the grid, with the rates that theory gives the exact kernel."""
    chosen = dataset.isel(images=-1, period=-1)
    cells = chosen["grid"].values
    plate, axes = panels(len(PANELS), columns=2, width=4.4, height=3.0)
    for ax, (variable, label) in zip(axes, PANELS.items(), strict=True):
        for name in paddings(dataset):
            one = chosen.sel(padding=name)
            ax.loglog(cells, abs(one[variable]), label=label_of(one), **look(name))
            if variable == "pressure_error_max" and name == "exact":
                corrected = look(name) | {"linestyle": "--"}
                ax.loglog(cells, one["corrected_error_max"], label="exact, corrected", **corrected)
        _law(ax, variable, chosen)
        ax.set(xlabel=f"cells N across {WIDTH} a", ylabel=label)
        ax.set_xticks(cells[::2], [str(n) for n in cells[::2]])
        ax.minorticks_off()
    finish(plate)
    return (Plate("grid", plate, _words(chosen)),)


def _law(ax: Axes, variable: str, chosen: xr.Dataset) -> None:
    """What theory says of one panel, dotted, and named above it."""
    cells = chosen["grid"].values
    if variable == "peak_pressure_error":
        name = "a²/(8D²)"
        reaches = (
            padding_at(padding, int(chosen["images"])).reach(float(chosen["period"]))
            for padding in paddings(chosen)
            if padding != "zero"
        )
        laws = [
            np.full(len(cells), truncation_error(1, reach)) for reach in reaches if reach < np.inf
        ]
    elif variable == "half_width_error":
        name, laws = "(dx/a)³/50", [(WIDTH / cells) ** 3 / 50]
    elif "exact" in paddings(chosen):
        rate = RATES[variable]
        error = chosen[variable].sel(padding="exact").values
        laws = [np.exp(np.mean(np.log(error / cells**rate))) * cells**rate]
        name = f"N^({rate:g})"
    else:
        return
    for law in laws:
        ax.loglog(cells, law, **LAW)
    ax.set_title(f"dotted: {name}", loc="right", fontsize="small")


def _words(chosen: xr.Dataset) -> str:
    if "exact" not in paddings(chosen) or chosen.sizes["grid"] < 2:
        return "Error against the number of cells."
    cells = chosen["grid"].values
    error = chosen["pressure_error_l1"].sel(padding="exact").values
    rate = np.polyfit(np.log(cells), np.log(error), 1)[0]
    return (
        f"Error against the number of cells N. With exact periodicity the L1 error falls like N^({rate:.2f}); "
        "the largest error sits in the cells that hold the contact edge, jumps with where the edge falls in "
        "its cell, and falls like N^(-1.5) once the discrete edge law has taken it off; by that law the "
        "half-width is known to the cell cubed. A truncated window has an error of its own, which no "
        "grid removes: its curves level off, for the peak pressure near the law for its reach. Without "
        "neighbours the pressure at the two ends of the length grows with every refinement."
    )
