"""Drawing of the study `creep`: figures and findings from its stored data."""

import numpy as np
import xarray as xr

from studies.definitions.effects.creep import CLOSED, END, HALF_WIDTH
from studies.model.drawing import CaptionedFigure, Finding
from studies.report.formatting import percent, power
from studies.report.style import LAW_STYLE, add_legend, panels

COLORS = ("#E69F00", "#009E73", "#0072B2", "#D55E00", "#CC79A7")


def figure(dataset: xr.Dataset) -> tuple[CaptionedFigure, ...]:
    """Half-width and peak pressure beside the closed forms; errors against steps and cost."""
    fig, axes = panels(4, columns=2, width=4.4, height=3.0)
    finest = dataset.isel(steps=-1, grid=-1)
    time = np.linspace(0, END, 100)
    axes[0].plot(time, CLOSED.half_width(time) / HALF_WIDTH, **LAW_STYLE)
    peak = [float(CLOSED.pressure(0.0, one)) / (HALF_WIDTH / 2) for one in time]
    axes[1].plot(time, peak, **LAW_STYLE)
    for ax, name, label in (
        (axes[0], "half_width", "half-width"),
        (axes[1], "peak_pressure", "peak pressure"),
    ):
        ax.plot(finest["time"], finest[name], "o", color="#0072B2")
        ax.set(xlabel="time over that of creep", ylabel=f"{label} over the sudden one")
        ax.set_title("dotted: closed form", loc="right", fontsize="small")
    for cells, color in zip(dataset["grid"].values, COLORS, strict=False):
        one = dataset.sel(grid=cells)
        label = f"{cells} cells"
        axes[2].loglog(one["steps"], one["pressure_error_l1"], "o-", color=color, label=label)
        axes[2].loglog(one["steps"], one["step_error"], "--", color=color)
        axes[3].loglog(
            one["convolutions"] * cells, one["pressure_error_l1"], "o-", color=color, label=label
        )
    axes[2].set(xlabel="steps", ylabel="largest relative L1 error")
    axes[2].set_title("dashed: estimated, by steps", loc="right", fontsize="small")
    axes[3].set(xlabel="transform pairs times cells", ylabel="largest relative L1 error")
    add_legend(fig)
    return (CaptionedFigure("creep", fig, _caption(dataset)),)


def _caption(dataset: xr.Dataset) -> str:
    return (
        "A rigid cylinder pressed suddenly into a viscoelastic half-space, creep 1 + 1.5 (1 - exp(-t)), and held. "
        "Half-width and peak pressure are those of Lee & Radok's closed form, the half-width to a cell. The error "
        "is the largest over time, after the first tenth. It falls with the steps until what the "
        "cells leave is larger; the dashed estimate, from a second march with steps twice as long, sees the "
        "steps alone."
    )


def findings(dataset: xr.Dataset) -> tuple[Finding, ...]:
    """What accuracy in time costs beside that of the grid."""
    if dataset.sizes["steps"] < 3 or dataset.sizes["grid"] < 2:
        return ()
    fine = dataset.isel(grid=-1)
    rate = np.polyfit(np.log(fine["steps"]), np.log(fine["step_error"]), 1)[0]
    coarse, last = dataset.isel(grid=0, steps=-1), dataset.isel(grid=-1, steps=-1)
    timely = (fine["step_error"] > 2 * fine["grid_error"]).values
    ratios = (fine["step_error"] / fine["pressure_error_l1"]).values[timely]
    trust = (
        f" Where the steps leave more than the cells, their estimate is {ratios.min():.2g} to "
        f"{ratios.max():.2g} times the error."
        if ratios.size
        else ""
    )
    return (
        Finding(
            f"The error by the steps falls like {power('N', rate)}, so a digit in time costs "
            f"{10 ** (-1 / rate):.2g} times as many solves.",
            f"With {int(last['steps'])} steps and {int(last['grid'])} cells the pressure is known to "
            f"{percent(last['pressure_error_l1'])} at every instant, in {float(last['convolutions']):.0f} "
            f"transform pairs; with {int(coarse['grid'])} cells the same steps leave "
            f"{percent(coarse['pressure_error_l1'])}.{trust}",
            "How many steps in time?",
        ),
    )
