"""Drawing of the study `grid`: figures, findings and tables from its stored data."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from contactstudy.analytic import truncation_error
from studies.model.drawing import CaptionedFigure, Finding
from studies.reference.line_contact import WIDTH, covers, padding_at, total_time
from studies.report.formatting import paddings, percent, power, setting_label
from studies.report.style import LAW_STYLE, add_legend, padding_style, panels

PANELS = {
    "axis_pressure_error": "|axis-pressure error|",
    "pressure_error_l1": "relative L1 error of the pressure",
    "pressure_error_max": "largest pressure error / p_H",
    "half_width_error": "|half-width error|",
}
RATES = {"pressure_error_l1": -1.5, "pressure_error_max": -0.5}


def figure(dataset: xr.Dataset) -> tuple[CaptionedFigure, ...]:
    """Four errors against the grid, with the rates that theory gives the exact kernel."""
    chosen = dataset.isel(images=-1, period=-1)
    cells = chosen["grid"].values
    fig, axes = panels(len(PANELS), columns=2, width=4.4, height=3.0)
    for ax, (variable, label) in zip(axes, PANELS.items(), strict=True):
        for name in paddings(dataset):
            one = chosen.sel(padding=name)
            ax.loglog(cells, abs(one[variable]), label=setting_label(one), **padding_style(name))
            if variable == "pressure_error_max" and name == "exact":
                corrected = padding_style(name) | {"linestyle": "--"}
                ax.loglog(cells, one["corrected_error_max"], label="exact, corrected", **corrected)
        _law(ax, variable, chosen)
        ax.set(xlabel=f"cells N across {WIDTH} a", ylabel=label)
        ax.set_xticks(cells[::2], [str(n) for n in cells[::2]])
        ax.minorticks_off()
    add_legend(fig)
    return (CaptionedFigure("grid", fig, _caption(chosen)),)


def _law(ax: Axes, variable: str, chosen: xr.Dataset) -> None:
    """What theory says of one panel, dotted, and named above it."""
    cells = chosen["grid"].values
    if variable == "axis_pressure_error":
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
        ax.loglog(cells, law, **LAW_STYLE)
    ax.set_title(f"dotted: {name}", loc="right", fontsize="small")


def _caption(chosen: xr.Dataset) -> str:
    if "exact" not in paddings(chosen) or chosen.sizes["grid"] < 2:
        return "Error against the number of cells."
    cells = chosen["grid"].values
    error = chosen["pressure_error_l1"].sel(padding="exact").values
    rate = np.polyfit(np.log(cells), np.log(error), 1)[0]
    return (
        "Error against the number of cells N. With exact periodicity the L1 error falls like "
        f"{power('N', rate)}. The largest error is located in the cells that contain the contact edge; it "
        "depends on the position of the edge within its cell, and falls like N^{−1.5} once the discrete edge law "
        "removes it. By that law the half-width is known to the third power of the cell. A truncated window has a "
        "truncation error that no grid removes: its curves level off, for the peak pressure near the law for its "
        "reach. Without neighbours the pressure at the two ends of the length grows with every refinement."
    )


def findings(dataset: xr.Dataset) -> tuple[Finding, ...]:
    """What grid."""
    if not covers(dataset, {"exact"}) or dataset.sizes["grid"] < 3:
        return ()
    return (_which_grid(dataset),)


def _which_grid(dataset: xr.Dataset) -> Finding:
    exact = dataset.sel(padding="exact").isel(images=-1, period=-1).sortby("grid")
    cells = exact["grid"].values
    rates = [
        np.polyfit(np.log(cells), np.log(exact[f"pressure_error_{kind}"].values), 1)[0]
        for kind in ("l1", "max")
    ]
    first, last = exact.isel(grid=0), exact.isel(grid=-1)
    seconds = [float(total_time(one)) for one in (first, last)]
    return Finding(
        f"{_enough(exact)} cells across 2.4 a for 0.1 %: with exact periodicity the grid is the only source of "
        "error.",
        f"The L1 error of the pressure falls like {power('N', rates[0])}, from "
        f"{percent(first['pressure_error_l1'])} at {cells[0]} cells across in {seconds[0]:.1g} s to "
        f"{percent(last['pressure_error_l1'])} at {cells[-1]} in {seconds[1]:.2g} s. The largest "
        f"error, in the cells that contain the contact edge, falls only like {power('N', rates[1])} and not "
        f"monotonically: it is {percent(last['pressure_error_max'])} of p_{{H}} at {cells[-1]}.",
        "Which grid?",
    )


def _enough(exact: xr.Dataset) -> str:
    meets = exact["grid"].values[exact["pressure_error_l1"].values <= 1e-3]
    return f"{meets.min()}" if meets.size else f"More than {int(exact['grid'].max())}"
