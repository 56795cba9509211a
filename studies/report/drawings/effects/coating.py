"""What the study of coated bodies shows and says, from its stored data alone."""

import numpy as np
import xarray as xr

from studies.model.drawing import CaptionedFigure, Finding
from studies.report.formatting import percent
from studies.report.style import LAW_STYLE, add_legend, panels

COLORS = ("#0072B2", "#56B4E9", "#E69F00", "#D55E00", "#009E73", "#CC79A7")


def figure(dataset: xr.Dataset) -> tuple[CaptionedFigure, ...]:
    """The contact, the stress at the interface and what a single image would cost, over the thickness."""
    finest = dataset.isel(grid=-1)
    labels = {
        "half_width": "half-width / a",
        "peak_pressure": "peak pressure / p_H",
        "interface_shear": "shear at the interface / p_max",
        "interface_tension": "tension there / p_max",
        "image_error": "L1 error of the image alone",
    }
    fig, axes = panels(len(labels), columns=2, width=3.6, height=2.7)
    for ax, (variable, label) in zip(axes, labels.items(), strict=True):
        for ratio, color in zip(finest["ratio"].values, COLORS, strict=False):
            one = finest[variable].sel(ratio=ratio)
            ax.plot(one["thickness"], one, color=color, marker="o", label=f"E1/E2 = {ratio:g}")
            if variable in ("half_width", "peak_pressure"):
                # the coating alone, at the same load
                power = -0.5 if variable == "half_width" else 0.5
                ax.axhline(ratio**power, **{**LAW_STYLE, "color": color, "linewidth": 0.7})
        ax.set(xscale="log", xlabel="thickness / a", ylabel=label)
        if variable == "image_error":
            ax.set_yscale("log")
    add_legend(fig)
    return (
        CaptionedFigure(
            "coating",
            fig,
            "A rigid cylinder on a coated half-space, nu = 0.3 in both, over the thickness of the coating; a and p_H "
            "are Hertz's on the substrate alone, and thin lines those on the coating alone. The stress at "
            "the interface is that in the coating. The last panel is how far the pressure is off when "
            "the coating is no more than an image of the load two thicknesses below the surface.",
        ),
    )


def findings(dataset: xr.Dataset) -> tuple[Finding, ...]:
    """How a coating matters by its thickness, and how well known contacts are met."""
    if dataset.sizes["thickness"] < 3:
        return ()
    finest = dataset.isel(grid=-1)
    thin, thick = finest.isel(thickness=0), finest.isel(thickness=-1)
    from_substrate = abs(thin["half_width"] - 1).max()
    from_coating = abs(thick["half_width"] * np.sqrt(thick["ratio"]) - 1).max()
    error = float(finest["reference_error"].max(skipna=True))
    known = "Known contacts (a collocation of the layered problem) are met "
    known = f"{known}to {error:.1e} in the peak pressure. " if np.isfinite(error) else ""
    worst = finest["image_error"].max(("thickness", "ratio"))
    place = finest["image_error"].where(finest["image_error"] == worst, drop=True)
    shear = finest["interface_shear"].max(("thickness", "ratio"))
    where = finest["interface_shear"].where(finest["interface_shear"] == shear, drop=True)
    return (
        Finding(
            "A coating acts by its thickness over the half-width, and an image of the load below the surface alone "
            "does not describe it.",
            f"At a thickness of {float(thin['thickness']):g} a the half-width is within {percent(from_substrate)} of "
            f"that on the substrate, at {float(thick['thickness']):g} a within {percent(from_coating)} of that on the "
            f"coating. {known}The image alone would be off by up to {percent(worst)} in L1 (E1/E2 = "
            f"{float(place['ratio'][0]):g}, thickness {float(place['thickness'][0]):g} a). The shear at the "
            f"interface is largest, {float(shear):.2f} of the peak pressure, at E1/E2 = "
            f"{float(where['ratio'][0]):g} and a thickness of {float(where['thickness'][0]):g} a.",
            "What does a coating do?",
        ),
    )
