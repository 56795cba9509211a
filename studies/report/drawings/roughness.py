"""Drawing of the study `roughness`: figures and findings from its stored data."""

from itertools import cycle
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from contactstudy.analytic import image_error
from studies.model.drawing import CaptionedFigure, Finding
from studies.reference.line_contact import padding_at
from studies.report.style import (
    COLORS,
    WIDTH,
    captioned,
    padding_style,
    paddings,
    panels,
    percent,
    setting_label,
)


def figure(dataset: xr.Dataset) -> tuple[CaptionedFigure, ...]:
    """Draw the effect of roughness, and the error of each padding."""
    finest = dataset.isel(images=-1, period=-1, grid=-1)
    return _shift(finest.sel(padding="exact")), _paddings(finest)


LINES = ("-", "--", "-.", ":")


def _shift(dataset: xr.Dataset) -> CaptionedFigure:
    labels = {
        "contact_area": "contact area / Hertz's",
        "half_width": "effective half-width / a",
        "contact_extent": "farthest contact / a",
        "peak_pressure": "peak pressure / $p_H$",
        "load_spread": "spread of the load along",
        "smooth_difference": "L1 difference from smooth",
    }
    fig, axes = panels(len(labels), columns=2, width=3.6, height=2.7)
    for ax, (variable, label) in zip(axes, labels.items(), strict=True):
        for peklenik, color in zip(dataset["peklenik"].values, cycle(COLORS), strict=False):
            for hurst, line in zip(dataset["hurst"].values, cycle(LINES), strict=False):
                part = dataset[variable].sel(peklenik=peklenik, hurst=hurst)
                style = {"color": color, "linestyle": line}
                _over_rms(ax, part, f"Peklenik {peklenik:g}, H = {hurst:g}", **style)
        ax.set_ylabel(label)
    rough = dataset.isel(rms=-1)
    facts = "; ".join(
        f"Peklenik {float(number):g}: area {float(part['contact_area'].mean()):.2f}, peak pressure "
        f"{float(part['peak_pressure'].mean()):.1f} p_{{H}}"
        for number, part in rough.groupby("peklenik")
    )
    return captioned(
        "shift",
        fig,
        "Effect of roughness on a line contact with exact periodicity; lines are the median over the surfaces, "
        "bands their range. Heights are relative to a²/(2R). Peklenik is the correlation length across the contact over "
        "that along it (below 1 the lay runs along the length), H the Hurst exponent. The effective half-width "
        "is that of Hertz's pressure with the same second moment; the spread is the standard deviation of "
        f"the load along the length over its mean. At an rms of {float(rough['rms']):g}: {facts}.",
    )


def _paddings(dataset: xr.Dataset) -> CaptionedFigure:
    labels = {
        "pressure_error_l1": "relative L1 error",
        "pressure_error_max": "largest error of a cell / $p_H$",
    }
    fig, axes = panels(len(labels), width=WIDTH / 2, height=3.2)
    for ax, (variable, label) in zip(axes, labels.items(), strict=True):
        for name in (name for name in paddings(dataset) if name != "exact"):
            part = dataset.sel(padding=name)
            _over_rms(ax, abs(part[variable]), setting_label(part), **padding_style(name))
        if variable == "pressure_error_l1":
            shift = dataset["smooth_difference"].sel(padding="exact")
            style = {"color": "black", "linestyle": "--"}
            _over_rms(ax, shift.where(shift.rms > 0), "effect of the roughness itself", **style)
        ax.set(ylabel=label, yscale="log")
    return captioned(
        "paddings",
        fig,
        "Error of each padding relative to exact periodicity on the same surface and grid; lines are the "
        "median over Peklenik numbers, Hurst exponents and seeds, bands their range. "
        f"L = {float(dataset['period']):g} a. The dashed line is the difference between the rough and the smooth "
        "contact's pressure: a padding is accurate enough if its error is well below this line. The "
        "largest error grows with the roughness, since asperities in light contact appear and disappear.",
    )


def _over_rms(ax: Axes, values: xr.DataArray, label: str, **style: Any) -> None:
    """Draw the median and the span of all surfaces at each rms, at equal distances, since one rms may be zero."""
    surfaces = [name for name in values.dims if name != "rms"]
    positions = np.arange(values.sizes["rms"])
    ax.plot(positions, values.median(surfaces), label=label, **style)
    low, high = values.min(surfaces), values.max(surfaces)
    ax.fill_between(positions, low, high, color=style["color"], alpha=0.15, linewidth=0)
    ax.set_xticks(positions, [f"{rms:g}" if rms else "smooth" for rms in values["rms"].values])
    ax.set_xlabel("rms height / (a²/2R)")


def findings(dataset: xr.Dataset) -> tuple[Finding, ...]:
    """Return the effect of roughness on the error of a padding."""
    needed: dict[str, set[Any]] = {
        "padding": {"duplicated", "circular", "exact"}, "rms": {0.0}, "images": {6},
    }  # fmt: skip
    is_covered = all(part <= set(dataset[axis].values.tolist()) for axis, part in needed.items())
    if not is_covered or dataset.sizes["rms"] < 2 or not (dataset["converged"] == 1).all():
        return ()
    sweep = dataset.sel(images=6).isel(period=-1, grid=-1)
    surfaces = ("hurst", "peklenik", "seed")
    middle, largest_rms = sweep.median(surfaces), float(sweep["rms"].max())
    smooth, rough = middle.sel(rms=0), middle.sel(rms=largest_rms)
    l1_errors, cells, highest, remaining, ratios = [], [], [], [], []
    for name in ("duplicated", "circular"):
        before, after = smooth.sel(padding=name), rough.sel(padding=name)
        label = setting_label(sweep.sel(padding=name))
        l1_errors.append(
            f"{percent(before['pressure_error_l1'])} smooth and {percent(after['pressure_error_l1'])} "
            f"rough with {label}"
        )
        cells.append(
            f"{percent(before['pressure_error_max'])} to {percent(after['pressure_error_max'])} of p_{{H}}"
        )
        highest.append(
            f"{percent(before['peak_pressure_error'])} to {percent(after['peak_pressure_error'])}"
        )
        remaining.append(percent(after["curved_difference"] / after["pressure_error_l1"]))
        reach = padding_at(name, 6).reach(float(sweep["period"]))
        half_width_error = sweep["half_width_error"].sel(padding=name).values
        ratios.append(half_width_error / -float(image_error(1, reach)))
    low, high = np.min(ratios), np.max(ratios)
    shift = middle["smooth_difference"].sel(padding="exact").isel(rms=1)
    systematic = "; unlike that, the error of a window has one sign on every surface and does not average out"
    finding = Finding(
        "Hardly: on a rough surface a padding has the same L1 error as on a smooth one, but it lies elsewhere.",
        f"At L = {float(sweep['period']):g} a the L1 error is {' and '.join(l1_errors)}, at an rms height of "
        f"{largest_rms:g} a²/(2R). The effective half-width is too small by {low:.2f} to {high:.2f} times a²/(8D²) on "
        "every surface, since a window that reaches D makes the cylinder more curved by a²/(4D²), whatever its "
        f"roughness: compared with exact periodicity on a cylinder of that curvature, {' and '.join(remaining)} of "
        f"those L1 errors remain. The largest error of any cell grows from {' and from '.join(cells)}, since "
        "asperities in light contact appear and disappear; the error of the peak, now under an asperity, falls from "
        f"{' and from '.join(highest)}. Roughness itself changes the pressure by {percent(shift)} (L1) at an rms of "
        f"{float(shift['rms']):g}{systematic if low > 0 else ''}.",
        "Does roughness change the error of a padding?",
    )
    return (finding,)
