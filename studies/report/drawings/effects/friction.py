"""What the study of friction shows and says, from its stored data alone."""

from typing import Any

import numpy as np
import xarray as xr

from studies.model.drawing import CaptionedFigure, Finding
from studies.report.formatting import percent
from studies.report.style import LAW_STYLE, add_legend, panels

COLORS = ("#0072B2", "#56B4E9", "#E69F00", "#D55E00", "#009E73", "#CC79A7")


def figure(dataset: xr.Dataset) -> tuple[CaptionedFigure, ...]:
    """Stress over the coefficient, sticking zones over the force, the superposition's error over Poisson's ratio."""
    finest = dataset.isel(grid=-1, rough_grid=-1)
    fig, axes = panels(6, columns=2, width=3.6, height=2.7)
    for ratio, color in zip(finest["poisson_ratio"].values, COLORS, strict=False):
        one = finest.sel(poisson_ratio=ratio)
        style: dict[str, Any] = {"color": color, "marker": "o", "label": f"nu = {float(ratio):g}"}
        axes[0].plot(one["coefficient"], one["von_mises"], **style)
        axes[1].plot(one["coefficient"], one["depth"], **style)
        axes[2].plot(one["share"], one["stick"], **style)
        axes[3].plot(one["share"], one["stick_sphere"], **style)
    share = np.linspace(0, 1, 200)
    axes[2].plot(share, np.sqrt(1 - share), label="Cattaneo, Mindlin", **LAW_STYLE)
    axes[3].plot(share, np.cbrt(1 - share), **LAW_STYLE)
    for ax, variable in ((axes[4], "superposition_error"), (axes[5], "shear_aside")):
        ax.plot(finest["poisson_ratio"], finest[variable], color=COLORS[0], marker="o")
        ax.set_xlabel("Poisson's ratio")
    axes[0].set(xlabel="coefficient of friction", ylabel="highest von Mises / p_H")
    axes[1].set(xlabel="coefficient of friction", ylabel="its depth / a")
    axes[2].set(xlabel="Q / (mu P)", ylabel="stick / contact, cylinder")
    axes[3].set(xlabel="Q / (mu P)", ylabel="stick / contact, sphere")
    axes[4].set(ylabel="L1 error of superposition")
    axes[5].set(ylabel="shear aside / largest")
    add_legend(fig)
    return (
        CaptionedFigure(
            "friction",
            fig,
            "Top: a sliding cylinder, where the highest von Mises stress rises to the surface. Middle: partial slip "
            "under a tangential force Q, half-width or radius of what sticks over that in contact, beside "
            "Cattaneo's sqrt(1 - Q / mu P) for a cylinder and Mindlin's cube root for a sphere. "
            "Bottom: what the superposition of two normal contacts (Ciavarella, Jaeger) misses on a rough "
            "line contact at Q = mu P / 2, and the shear across the force, which it has none of.",
        ),
    )


def findings(dataset: xr.Dataset) -> tuple[Finding, ...]:
    """Where the highest stress lies, and how far the superposition holds."""
    ratios = dataset["poisson_ratio"].values
    if len(ratios) < 2 or 0.3 not in ratios or 0.0 not in ratios:
        return ()
    finest = dataset.isel(grid=-1, rough_grid=-1)
    steel, cork = finest.sel(poisson_ratio=0.3), finest.sel(poisson_ratio=0.0)
    stress, depth = steel["von_mises"], steel["depth"]
    surface = depth.where(depth < 0.01, drop=True)["coefficient"]
    low, most = stress.isel(coefficient=0), stress.isel(coefficient=-1)
    cattaneo = np.sqrt(1 - steel["share"])
    off = float(np.abs(steel["stick"] - cattaneo).max())
    return (
        Finding(
            "Friction brings the highest stress to the surface at a coefficient of about 0.3; sticking zones are "
            "those of Cattaneo, but the superposition that gives them is inexact on rough surfaces.",
            f"At nu = 0.3 the highest von Mises stress is {float(low):.3f} p_H without friction and "
            f"{float(most):.3f} p_H at a coefficient of {float(most['coefficient']):g}; it lies at the surface from "
            f"{float(surface.min()):g} on. A cylinder sticks over a zone within {off:.3f} half-widths of "
            "Cattaneo's. On a rough contact two normal solves make up the shear to "
            f"{percent(cork['superposition_error'])} in L1 at nu = 0, and miss "
            f"{percent(steel['superposition_error'])} of it at nu = 0.3, with a shear across the force of "
            f"{percent(steel['shear_aside'])} of the largest; scenes like that are solved for both components.",
            "What does friction do?",
        ),
    )
