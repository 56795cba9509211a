"""Drawing of the study `kernels`: figures, findings and tables from its stored data."""

import xarray as xr

from studies.model.drawing import CaptionedFigure
from studies.reference.line_contact import WIDTH
from studies.report.formatting import paddings, select_evenly, setting_label
from studies.report.style import LAW_STYLE, add_legend, panels, style_over_images


def figure(dataset: xr.Dataset) -> tuple[CaptionedFigure, ...]:
    """Error and build time against n, a panel of errors for each period."""
    finest = dataset.isel(grid=-1)
    return _errors(finest), _times(finest)


def _errors(dataset: xr.Dataset) -> CaptionedFigure:
    periods = select_evenly(dataset["period"].values)
    fig, axes = panels(len(periods), share="y")
    half = dataset["images"].values + 0.5
    for ax, period in zip(axes, periods, strict=True):
        for name in paddings(dataset):
            error = dataset["kernel_error"].sel(padding=name, period=period)
            if (error > 0).all():
                ax.loglog(half, error, label=name, **style_over_images(name))
        # ln r gains x^2 / (4 D^2) from what lies beyond D, and loses y^2 / (2 D^2) to an observer y off
        # the window's centre, up to L / 2 between two images: half of that span to either side
        law = (WIDTH**2 / 4 + period**2 / 8) / (2 * (half * period) ** 2)
        ax.loglog(half, law, label="law (x²/4 + L²/8)/(2D²), circular", **LAW_STYLE)
        ax.set(title=f"period L = {period:g} a", xlabel="n + ½  (n periods on each side)")
    axes[0].set_ylabel("error of the logarithm in the coefficients")
    add_legend(fig)
    return CaptionedFigure(
        "error",
        fig,
        "Far from a line load the influence coefficients follow -(2 dx dy/L) ln r. The figure shows the largest "
        "error of this ln r among the coefficients used in a convolution, without the part that is a rigid shift "
        "of all of them. A window that moves with the observer (circular) errs by the curvature of what it "
        "truncates; a window fixed to the domain (superposed) also truncates more on one side than on the "
        "other. Exact periodicity is the reference; the project's tests compare it to 1e-13 with computations in "
        "fifty digits. In the law x is the width of the domain, 2.4 a.",
    )


def _times(dataset: xr.Dataset) -> CaptionedFigure:
    fig, (ax,) = panels(1, width=6, height=3.4)
    here = dataset.isel(period=-1)
    half = here["images"].values + 0.5
    for name in paddings(here):
        ax.loglog(half, here["setup_time"].sel(padding=name), label=name, **style_over_images(name))
    if "superposed" in paddings(here):
        last = float(here["setup_time"].sel(padding="superposed")[-1])
        ax.loglog(half, last * half / half[-1], label="proportional to n + ½", **LAW_STYLE)
    ax.set(xlabel="n + ½  (n periods on each side)", ylabel="time to build the operator [s]")
    add_legend(fig)
    words = ""
    if {"exact", "superposed"} <= set(paddings(here)):
        superposed = here.sel(padding="superposed").sel(images=6, method="nearest")
        ratio = float(superposed["setup_time"] / here["setup_time"].sel(padding="exact")[0])
        words = f" {setting_label(superposed).capitalize()}, takes {ratio:.2g} times as long as exact periodicity."
    return CaptionedFigure(
        "build_time",
        fig,
        f"Time to build the operator (coefficients and transform) for {int(here['grid'])} x "
        f"{int(here['grid'])} cells and L = {float(here['period']):g} a. Beyond a few images the cost of a sum "
        f"is proportional to their number; exact periodicity has no such number.{words}",
    )
