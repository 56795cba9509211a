"""Drawing of the study `plastic`: figures and findings from its stored data."""

import xarray as xr

from studies.definitions.effects.plastic import CAP, FAR, HARDENING, PRESSURE, REFERENCE
from studies.model.drawing import CaptionedFigure, Finding
from studies.report.formatting import percent
from studies.report.style import LAW_STYLE, add_legend, panels

COLORS = ("#0072B2", "#E69F00", "#009E73", "#D55E00")
LABELS = {
    "peak_pressure": ("peak pressure / p_H", "cap_pressure"),
    "half_width": ("half-width / a", "cap_half_width"),
    "dent": ("dent / (a Y / E)", "cap_dent"),
    "plastic_depth": ("plastic depth / a", None),
}


def figure(dataset: xr.Dataset) -> tuple[CaptionedFigure, ...]:
    """What yields over the load, beside a hardness; errors against steps and cost."""
    fig, axes = panels(6, columns=2, width=4.0, height=2.7)
    finest = dataset.isel(steps=-1, grid=-1)
    for ax, (name, (label, cap)) in zip(axes, LABELS.items(), strict=False):
        for hardening, color in zip(dataset["hardening"].values, COLORS, strict=False):
            one = finest.sel(hardening=hardening)
            text = f"plastic, H = {hardening:g} E"
            ax.plot(one["pressure"], one[name], "o-", color=color, label=text)
        if cap is not None:
            one = finest.isel(hardening=0)
            text = f"hardness {CAP:g} Y"
            ax.plot(one["pressure"], one[cap], "s--", color="#CC79A7", label=text)
        ax.plot([PRESSURE], [REFERENCE[name]], "*", color="black", markersize=10, label="known")
        ax.set(xlabel="p_H / Y", ylabel=label)
    known = _known(dataset)
    for cells, color in zip(dataset["grid"].values, COLORS, strict=False):
        if known is None:
            break
        one = known.sel(grid=cells)
        text = f"{cells} cells, {float(one['layers'][-1]):g} layers"
        wrong = one["peak_pressure_error"]
        axes[4].loglog(one["steps"], wrong, "o-", color=color, label=text)
        axes[5].loglog(one["convolutions"] * cells, wrong, "o-", color=color, label=text)
    if known is not None:
        steps = known["steps"].values
        first = float(known["peak_pressure_error"].isel(steps=0, grid=-1))
        axes[4].loglog(steps, first * steps[0] / steps, **LAW_STYLE)
    axes[4].set(xlabel="steps in load", ylabel="error of the peak pressure")
    axes[4].set_title("dotted: first order", loc="right", fontsize="small")
    axes[5].set(xlabel="transform pairs times cells", ylabel="error of the peak pressure")
    add_legend(fig)
    return (
        CaptionedFigure(
            "plastic",
            fig,
            "A rigid cylinder pressed into a half-space that yields after von Mises, and lifted off, in plane strain, "
            f"over Hertz's peak pressure p_H; a is Hertz's half-width. The dent is measured against the surface at "
            f"{FAR:g} a. Beside it an elastic body whose pressure a hardness of {CAP:g} Y limits. Stars are known "
            f"contacts (finite elements agree to 0.3 %), at p_H = {PRESSURE:g} Y and a hardening modulus "
            f"of {HARDENING:g} E; the last panels are the error there. Layers follow from the cells.",
        ),
    )


def _known(dataset: xr.Dataset) -> xr.Dataset | None:
    """Where the reference is."""
    if PRESSURE not in dataset["pressure"].values or HARDENING not in dataset["hardening"].values:
        return None
    return dataset.sel(pressure=PRESSURE, hardening=HARDENING)


def findings(dataset: xr.Dataset) -> tuple[Finding, ...]:
    """How good a hardness is, and what an accuracy of yielding costs."""
    if dataset.sizes["pressure"] < 2 or dataset.sizes["steps"] < 2:
        return ()
    finest = dataset.isel(steps=-1, grid=-1, hardening=0)
    first, last = finest.isel(pressure=0), finest.isel(pressure=-1)
    found = [
        Finding(
            "A hardness is no substitute for plastic strain below the surface.",
            f"At p_H = {float(last['pressure']):g} Y, where the peak pressure is "
            f"{float(last['peak_pressure'] * last['pressure']):.2f} Y, a hardness of {CAP:g} Y gives a pressure that "
            f"differs by {percent(last['cap_difference'])} in L1, and a depth of yielding of "
            f"{float(last['cap_dent']):.2g} a Y / E in the place of a dent of {float(last['dent']):.2g}. At "
            f"{float(first['pressure']):g} Y it differs by {percent(first['cap_difference'])}. The body yields from "
            "p_H = 1.79 Y on, below the surface, long before any pressure reaches the hardness.",
            "Is a hardness cap enough?",
        )
    ]
    known = _known(dataset)
    if known is not None:
        fine = known.isel(steps=-1, grid=-1)
        wrong = known["peak_pressure_error"].isel(grid=-1)
        steps = known["steps"].values
        found.append(
            Finding(
                f"{steps[-1]} steps in load give the peak pressure on a body that yields to "
                f"{percent(fine['peak_pressure_error'])}.",
                f"With {steps[-1]} steps and {int(dataset['grid'][-1])} cells ({float(fine['layers']):g} layers) "
                f"the peak pressure is within {percent(fine['peak_pressure_error'])} of the known one, the dent "
                f"within {percent(fine['dent_error'])} and the largest plastic strain within "
                f"{percent(fine['plastic_strain_error'])}. From {steps[0]} steps to {steps[-1]} the error of the "
                f"pressure falls by a factor of {float(wrong[0] / wrong[-1]):.1f}: it is of first order in the steps, "
                "and what the cells add does not fall with them.",
                "What does yielding cost?",
            )
        )
    return tuple(found)
