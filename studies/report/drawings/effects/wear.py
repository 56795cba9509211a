"""Drawing of the study `wear`: figures and findings from its stored data."""

import numpy as np
import xarray as xr

from studies.definitions.effects.wear import WORN
from studies.model.drawing import CaptionedFigure, Finding
from studies.report.formatting import percent
from studies.report.style import LAW_STYLE, add_legend, panels

COLORS = {"implicit": "#0072B2", "two-stage": "#009E73", "explicit": "#D55E00"}


def figure(dataset: xr.Dataset) -> tuple[CaptionedFigure, ...]:
    """Half-width against distance beside the rigid law; errors against steps and solves."""
    here = dataset.isel(grid=-1)
    fig, axes = panels(3, columns=3, width=3.8, height=3.0)
    distance = np.linspace(0, 1, 100)
    axes[0].plot(distance, WORN * np.cbrt(distance), **LAW_STYLE)
    axes[0].plot(distance, np.cbrt(1 + WORN**3 * distance), **LAW_STYLE | {"linestyle": "--"})
    for name in here["scheme"].values:
        one = here.sel(scheme=name)
        color = COLORS.get(str(name), "#E69F00")
        axes[0].plot(one["distance"], one["half_width"].isel(steps=-1), "o", color=color)
        error = one["pressure_error_l1"].values
        axes[1].loglog(one["steps"], error, "o-", color=color, label=str(name))
        axes[2].loglog(one["solves"], error, "o-", color=color)
    axes[0].set(xlabel="distance over the whole", ylabel="half-width over Hertz's")
    axes[0].set_title("dotted: rigid; dashed: cubes added", loc="right", fontsize="small")
    axes[1].set(xlabel="steps", ylabel="relative L1 error at the end")
    axes[2].set(xlabel="solves", ylabel="relative L1 error at the end")
    limit = _stable_from(here)
    axes[1].axvline(limit, **LAW_STYLE)
    axes[1].set_title("dotted: explicit limit", loc="right", fontsize="small")
    add_legend(fig)
    return (CaptionedFigure("wear", fig, _caption(here)),)


def _stable_from(here: xr.Dataset) -> float:
    """The number of steps from which explicit ones are shorter than their limit."""
    return float(here["steps"][0] / here["longest_explicit"].isel(steps=0, scheme=0))


def _caption(here: xr.Dataset) -> str:
    return (
        "A cylinder that wears by Archard's law until a rigid one would have a flat of twice Hertz's half-width, "
        f"{int(here['grid'])} cells. The flat grows like the cube root of the distance; a^3 = a_H^3 + 3/2 R k P s "
        "is a fair estimate from the start. Errors are against 512 two-stage steps on the same grid. Implicit "
        "steps are stable at any length, explicit ones below ds = 1.48 dx / (k E*), which is "
        f"{_stable_from(here):.3g} steps here. All keep the worn volume k P s to rounding."
    )


def findings(dataset: xr.Dataset) -> tuple[Finding, ...]:
    """What implicit steps save."""
    here = dataset.isel(grid=-1)
    if (
        not {"implicit", "explicit"} <= set(here["scheme"].values.tolist())
        or here.sizes["steps"] < 3
    ):
        return ()
    limit = _stable_from(here)
    few = here.isel(steps=1)
    implicit, explicit = (
        float(few["pressure_error_l1"].sel(scheme=name)) for name in ("implicit", "explicit")
    )
    return (
        Finding(
            f"{int(few['steps'])} implicit steps of wear are as good as {percent(implicit)}; as many explicit "
            f"ones are out by {percent(explicit)}.",
            f"An explicit march needs {limit:.3g} steps to be stable on this grid, and twice as many on one twice as "
            "fine. An implicit step costs the same solve, with a constant in its spectrum, and the worn "
            "volume is exact either way.",
            "How to step wear?",
        ),
    )
