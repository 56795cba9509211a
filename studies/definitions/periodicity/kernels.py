"""Influence coefficients of every padding: how far from exact, and how long to build."""

from collections.abc import Mapping

import numpy as np
import xarray as xr

import contactstudy as cs
from contactstudy.domain.padding import across_and_along
from contactstudy.elasticity.coefficients import Displacement, kernel
from studies.model.case import Operator, number
from studies.model.study import Plate, Point
from studies.reference import line_contact
from studies.reference.line_contact import WIDTH
from studies.report.formatting import label_of, paddings, some
from studies.report.style import LAW, finish, marked, panels

__all__ = ["figure", "measures", "points", "scene_at"]

points = line_contact.axes(
    images=(0, 1, 2, 4, 6, 10, 30), period=(0.15, 0.6, 2.4, 9.6), grid=(128,)
)


def scene_at(point: Point) -> Operator:
    """The operator of the sweeps' line contact."""
    case = line_contact.scene_at(point)
    half_width = line_contact.HERTZ.half_width
    return Operator(case.scene.contact_modulus, case.grid, case.padding, half_width)


def measures(case: Operator, result: cs.Convolution) -> Mapping[str, xr.Variable]:
    """The largest error of a coefficient that the convolution uses, but for a rigid shift of all.

    In units of ``2 dx dy / L``, the weight of the logarithm: so it is the error of that logarithm.
    """
    window, exact = (
        kernel(case.grid, across_and_along(padding), Displacement(case.datum))
        for padding in (case.padding, cs.ExactPeriodicity())
    )
    cells = case.grid.cells[1]
    offsets = np.arange(window.shape[1])
    mirrored = exact[:, np.minimum(offsets, cells - offsets)]
    difference = (window - mirrored) * case.grid.period / (2 * case.grid.cell_area)
    spread = float(np.ptp(difference)) / 2
    return {"kernel_error": number(spread, "largest error of the logarithm in the coefficients")}


def figure(dataset: xr.Dataset) -> tuple[Plate, ...]:
    """Error and build time against n, a panel of errors for each period."""
    finest = dataset.isel(grid=-1)
    return _errors(finest), _times(finest)


def _errors(dataset: xr.Dataset) -> Plate:
    periods = some(dataset["period"].values)
    plate, axes = panels(len(periods), share="y")
    half = dataset["images"].values + 0.5
    for ax, period in zip(axes, periods, strict=True):
        for name in paddings(dataset):
            error = dataset["kernel_error"].sel(padding=name, period=period)
            if (error > 0).all():
                ax.loglog(half, error, label=name, **marked(name))
        # ln r gains x^2 / (4 D^2) from what lies beyond D, and loses y^2 / (2 D^2) to an observer y off
        # the window's centre, up to L / 2 between two images: half of that span to either side
        law = (WIDTH**2 / 4 + period**2 / 8) / (2 * (half * period) ** 2)
        ax.loglog(half, law, label="law (x²/4 + L²/8)/(2D²), circular", **LAW)
        ax.set(title=f"period L = {period:g} a", xlabel="n + ½  (n periods on each side)")
    axes[0].set_ylabel("error of the logarithm in the coefficients")
    finish(plate)
    return Plate(
        "error",
        plate,
        "Far from a line load the influence coefficients follow -(2 dx dy/L) ln r. Shown is the largest error "
        "of that ln r among the coefficients a convolution uses, a rigid shift of all of them taken off. "
        "A window that moves with the "
        "observer (circular) errs by the curvature of what it leaves out; one fixed to the domain "
        "(superposed) errs as well by leaving out more on one side than on the other. Exact periodicity "
        "is the reference here; the project's tests hold it to 1e-13 against computations with fifty digits. "
        "In the law x is the width of the domain, 2.4 a.",
    )


def _times(dataset: xr.Dataset) -> Plate:
    plate, (ax,) = panels(1, width=6, height=3.4)
    here = dataset.isel(period=-1)
    half = here["images"].values + 0.5
    for name in paddings(here):
        ax.loglog(half, here["setup_time"].sel(padding=name), label=name, **marked(name))
    if "superposed" in paddings(here):
        last = float(here["setup_time"].sel(padding="superposed")[-1])
        ax.loglog(half, last * half / half[-1], label="proportional to n + ½", **LAW)
    ax.set(xlabel="n + ½  (n periods on each side)", ylabel="time to build the operator [s]")
    finish(plate)
    words = ""
    if {"exact", "superposed"} <= set(paddings(here)):
        superposed = here.sel(padding="superposed").sel(images=6, method="nearest")
        ratio = float(superposed["setup_time"] / here["setup_time"].sel(padding="exact")[0])
        words = f" {label_of(superposed).capitalize()}, takes {ratio:.2g} times as long as exact periodicity."
    return Plate(
        "build_time",
        plate,
        f"Time to build the operator, coefficients and transform, for {int(here['grid'])} x "
        f"{int(here['grid'])} cells and L = {float(here['period']):g} a. From a few images on a sum costs in "
        f"proportion to their number; exact periodicity has no number to choose.{words}",
    )
