"""Drawing of the influence coefficients of the smooth line contact: their errors, and the time to build them."""

from typing import Any

import xarray as xr

from contactstudy.domain.fields import Array
from studies.model.drawing import CaptionedFigure, Drawing
from studies.reference.line_contact import WIDTH
from studies.report.style import (
    LAW_STYLE,
    captioned,
    paddings,
    panels,
    select_evenly,
    setting_label,
    style_over_images,
)

AXES = ("padding", "images", "period", "grid")
IMAGES_LABEL = "n + ½  (n periods on each side)"


def _kernel_figures(dataset: xr.Dataset) -> tuple[CaptionedFigure, ...]:
    finest = dataset.isel(grid=-1)
    periods = select_evenly(dataset["period"].values)
    fig, axes = panels(len(periods), share="y", height=2.9)
    half = dataset["images"].values + 0.5
    for ax, period in zip(axes, periods, strict=True):
        for name in paddings(dataset):
            part = abs(finest["kernel_error"].sel(period=period, padding=name))
            if part.all():
                ax.loglog(half, part, label=name, **style_over_images(name))
        law = _kernel_law(period, half)
        ax.loglog(half, law, label="law (x²/4 + L²/8)/(2D²), circular", **LAW_STYLE)
        ax.set(title=f"period L = {period:g} a", xlabel=IMAGES_LABEL)
    axes[0].set_ylabel("error of the logarithm")
    error = captioned(
        "error",
        fig,
        "Far from a line load the influence coefficients follow -(2 dx dy/L) ln r. The figure shows the largest "
        "error of this ln r among the coefficients used in a convolution, without the part that is a rigid shift "
        "of all of them. A window that moves with the observer (circular) has the curvature of what it truncates as "
        "its error; a window fixed to the domain (superposed) also truncates more on one side than on the "
        "other. Exact periodicity is the reference; the project's tests compare it to 1e-13 with computations in "
        "fifty digits. In the law x is the width of the domain, 2.4 a.",
    )
    return error, _build_time(finest)


def _kernel_law(period: float, half: Array) -> Any:
    """Return the error of the logarithm for a window of n + 1/2 = `half` periods.

    The part beyond the reach D changes ln r by x^2 / (4 D^2), and by -y^2 / (2 D^2) for an observer at the distance y
    from the centre of the window, which is at most L / 2 between two images. The error is half of that span.
    """
    return (WIDTH**2 / 4 + period**2 / 8) / (2 * (half * period) ** 2)


def _build_time(dataset: xr.Dataset) -> CaptionedFigure:
    fig, (ax,) = panels(1, width=6, height=3.0)
    longest = dataset.isel(period=-1)
    half = longest["images"].values + 0.5
    for name in paddings(longest):
        ax.loglog(
            half, longest["setup_time"].sel(padding=name), label=name, **style_over_images(name)
        )
    text = ""
    if "superposed" in paddings(longest):
        superposed = longest.sel(padding="superposed")
        last = float(superposed["setup_time"][-1])
        ax.loglog(half, last * half / half[-1], label="proportional to n + ½", **LAW_STYLE)
        if "exact" in paddings(longest):
            six = superposed.sel(images=6, method="nearest")
            ratio = float(six["setup_time"] / longest["setup_time"].sel(padding="exact")[0])
            text = f" {setting_label(six).capitalize()}, takes {ratio:.2g} times as long as exact periodicity."
    ax.set(xlabel=IMAGES_LABEL, ylabel="time to build the operator [s]")
    return captioned(
        "build_time",
        fig,
        f"Time to build the operator (coefficients and transform) for {int(longest['grid'])} x "
        f"{int(longest['grid'])} cells and L = {float(longest['period']):g} a. Beyond a few images the cost of a sum "
        f"is proportional to their number; exact periodicity has no such number.{text}",
    )


kernels = Drawing(_kernel_figures, axes=AXES)
