"""Drawings of the studies of effects: coating, friction, creep, wear and yielding."""

from itertools import cycle
from typing import Any

import numpy as np
import xarray as xr

from studies.definitions.creep import CLOSED, END, HALF_WIDTH
from studies.definitions.plastic import CAP, FAR, HARDENING, PRESSURE, REFERENCE
from studies.definitions.wear import WORN
from studies.model.drawing import CaptionedFigure, Drawing, Finding
from studies.report.style import COLORS, LAW_STYLE, add_legend, panels, percent, power

# coating


def _coating_figures(dataset: xr.Dataset) -> tuple[CaptionedFigure, ...]:
    """Draw the contact, the stress at the interface and what a single image would cost, over the thickness."""
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
        for ratio, color in zip(finest["ratio"].values, cycle(COLORS), strict=False):
            curve = finest[variable].sel(ratio=ratio)
            ax.plot(curve["thickness"], curve, color=color, marker="o", label=f"E1/E2 = {ratio:g}")
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


def _coating_findings(dataset: xr.Dataset) -> tuple[Finding, ...]:
    """Return the effect of a coating by its thickness, and the error against known contacts."""
    if dataset.sizes["thickness"] < 3:
        return ()
    finest = dataset.isel(grid=-1)
    thin, thick = finest.isel(thickness=0), finest.isel(thickness=-1)
    from_substrate = abs(thin["half_width"] - 1).max()
    from_coating = abs(thick["half_width"] * np.sqrt(thick["ratio"]) - 1).max()
    error = float(finest["reference_error"].max(skipna=True))
    reference = "Known contacts (a collocation of the layered problem) are met "
    reference = f"{reference}to {error:.1e} in the peak pressure. " if np.isfinite(error) else ""
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
            f"coating. {reference}The image alone would be off by up to {percent(worst)} in L1 (E1/E2 = "
            f"{float(place['ratio'][0]):g}, thickness {float(place['thickness'][0]):g} a). The shear at the "
            f"interface is largest, {float(shear):.2f} of the peak pressure, at E1/E2 = "
            f"{float(where['ratio'][0]):g} and a thickness of {float(where['thickness'][0]):g} a.",
            "What does a coating do?",
        ),
    )


coating = Drawing(_coating_figures, _coating_findings, axes=("ratio", "thickness", "grid"))


# friction


def _friction_figures(dataset: xr.Dataset) -> tuple[CaptionedFigure, ...]:
    """Draw stress over the coefficient, sticking zones over the force, errors of the superposition."""
    finest = dataset.isel(grid=-1, rough_grid=-1)
    fig, axes = panels(6, columns=2, width=3.6, height=2.7)
    for ratio, color in zip(finest["poisson_ratio"].values, cycle(COLORS), strict=False):
        part = finest.sel(poisson_ratio=ratio)
        style: dict[str, Any] = {"color": color, "marker": "o", "label": f"nu = {float(ratio):g}"}
        axes[0].plot(part["coefficient"], part["von_mises"], **style)
        axes[1].plot(part["coefficient"], part["depth"], **style)
        axes[2].plot(part["share"], part["stick"], **style)
        axes[3].plot(part["share"], part["stick_sphere"], **style)
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


def _friction_findings(dataset: xr.Dataset) -> tuple[Finding, ...]:
    """Return the place of the highest stress and the error of the superposition."""
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


friction = Drawing(
    _friction_figures, _friction_findings, axes=("poisson_ratio", "grid", "rough_grid")
)


# creep


def _creep_figures(dataset: xr.Dataset) -> tuple[CaptionedFigure, ...]:
    """Draw half-width and peak pressure beside the closed forms; errors against steps and cost."""
    fig, axes = panels(4, columns=2, width=4.4, height=3.0)
    finest = dataset.isel(steps=-1, grid=-1)
    time = np.linspace(0, END, 100)
    axes[0].plot(time, CLOSED.half_width(time) / HALF_WIDTH, **LAW_STYLE)
    peak = [float(CLOSED.pressure(0.0, part)) / (HALF_WIDTH / 2) for part in time]
    axes[1].plot(time, peak, **LAW_STYLE)
    for ax, name, label in (
        (axes[0], "half_width", "half-width"),
        (axes[1], "peak_pressure", "peak pressure"),
    ):
        ax.plot(finest["time"], finest[name], "o", color="#0072B2")
        ax.set(xlabel="time over that of creep", ylabel=f"{label} over the sudden one")
        ax.set_title("dotted: closed form", loc="right", fontsize="small")
    for cells, color in zip(dataset["grid"].values, cycle(COLORS), strict=False):
        part = dataset.sel(grid=cells)
        label = f"{cells} cells"
        axes[2].loglog(part["steps"], part["pressure_error_l1"], "o-", color=color, label=label)
        axes[2].loglog(part["steps"], part["step_error"], "--", color=color)
        axes[3].loglog(
            part["convolutions"] * cells, part["pressure_error_l1"], "o-", color=color, label=label
        )
    axes[2].set(xlabel="steps", ylabel="largest relative L1 error")
    axes[2].set_title("dashed: estimated, by steps", loc="right", fontsize="small")
    axes[3].set(xlabel="transform pairs times cells", ylabel="largest relative L1 error")
    add_legend(fig)
    return (CaptionedFigure("creep", fig, _creep_caption(dataset)),)


def _creep_caption(dataset: xr.Dataset) -> str:
    return (
        "A rigid cylinder pressed suddenly into a viscoelastic half-space, creep 1 + 1.5 (1 - exp(-t)), and held. "
        "Half-width and peak pressure are those of Lee & Radok's closed form, the half-width to a cell. The error "
        "is the largest over time, after the first tenth. It falls with the steps until what the "
        "cells leave is larger; the dashed estimate, from a second march with steps twice as long, sees the "
        "steps alone."
    )


def _creep_findings(dataset: xr.Dataset) -> tuple[Finding, ...]:
    """Return the cost of accuracy in time beside that of the grid."""
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


creep = Drawing(_creep_figures, _creep_findings, axes=("steps", "grid"))


# wear


WEAR_COLORS = {"implicit": "#0072B2", "two-stage": "#009E73", "explicit": "#D55E00"}


def _wear_figures(dataset: xr.Dataset) -> tuple[CaptionedFigure, ...]:
    """Draw the half-width against distance beside the rigid law; errors against steps and solves."""
    finest = dataset.isel(grid=-1)
    fig, axes = panels(3, columns=3, width=3.8, height=3.0)
    distance = np.linspace(0, 1, 100)
    axes[0].plot(distance, WORN * np.cbrt(distance), **LAW_STYLE)
    axes[0].plot(distance, np.cbrt(1 + WORN**3 * distance), **LAW_STYLE | {"linestyle": "--"})
    for name in finest["scheme"].values:
        part = finest.sel(scheme=name)
        color = WEAR_COLORS.get(str(name), "#E69F00")
        axes[0].plot(part["distance"], part["half_width"].isel(steps=-1), "o", color=color)
        error = part["pressure_error_l1"].values
        axes[1].loglog(part["steps"], error, "o-", color=color, label=str(name))
        axes[2].loglog(part["solves"], error, "o-", color=color)
    axes[0].set(xlabel="distance over the whole", ylabel="half-width over Hertz's")
    axes[0].set_title("dotted: rigid; dashed: cubes added", loc="right", fontsize="small")
    axes[1].set(xlabel="steps", ylabel="relative L1 error at the end")
    axes[2].set(xlabel="solves", ylabel="relative L1 error at the end")
    limit = _stable_from(finest)
    axes[1].axvline(limit, **LAW_STYLE)
    axes[1].set_title("dotted: explicit limit", loc="right", fontsize="small")
    add_legend(fig)
    return (CaptionedFigure("wear", fig, _wear_caption(finest)),)


def _stable_from(here: xr.Dataset) -> float:
    """Return the number of steps from which explicit ones are shorter than their limit."""
    return float(here["steps"][0] / here["longest_explicit"].isel(steps=0, scheme=0))


def _wear_caption(here: xr.Dataset) -> str:
    return (
        "A cylinder that wears by Archard's law until a rigid one would have a flat of twice Hertz's half-width, "
        f"{int(here['grid'])} cells. The flat grows like the cube root of the distance; a^3 = a_H^3 + 3/2 R k P s "
        "is a fair estimate from the start. Errors are against 512 two-stage steps on the same grid. Implicit "
        "steps are stable at any length, explicit ones below ds = 1.48 dx / (k E*), which is "
        f"{_stable_from(here):.3g} steps here. All keep the worn volume k P s to rounding."
    )


def _wear_findings(dataset: xr.Dataset) -> tuple[Finding, ...]:
    """Return the number of steps that implicit wear saves."""
    finest = dataset.isel(grid=-1)
    if (
        not {"implicit", "explicit"} <= set(finest["scheme"].values.tolist())
        or finest.sizes["steps"] < 3
    ):
        return ()
    limit = _stable_from(finest)
    coarse = finest.isel(steps=1)
    implicit, explicit = (
        float(coarse["pressure_error_l1"].sel(scheme=name)) for name in ("implicit", "explicit")
    )
    return (
        Finding(
            f"{int(coarse['steps'])} implicit steps of wear are as good as {percent(implicit)}; as many explicit "
            f"ones are out by {percent(explicit)}.",
            f"An explicit march needs {limit:.3g} steps to be stable on this grid, and twice as many on one twice as "
            "fine. An implicit step costs the same solve, with a constant in its spectrum, and the worn "
            "volume is exact either way.",
            "How to step wear?",
        ),
    )


wear = Drawing(_wear_figures, _wear_findings, axes=("scheme", "steps", "grid"))


# plastic


LABELS = {
    "peak_pressure": ("peak pressure / p_H", "cap_pressure"),
    "half_width": ("half-width / a", "cap_half_width"),
    "dent": ("dent / (a Y / E)", "cap_dent"),
    "plastic_depth": ("plastic depth / a", None),
}


def _plastic_figures(dataset: xr.Dataset) -> tuple[CaptionedFigure, ...]:
    """Draw the yielding contact over the load, beside a hardness; errors against steps and cost."""
    fig, axes = panels(6, columns=2, width=4.0, height=2.7)
    finest = dataset.isel(steps=-1, grid=-1)
    for ax, (name, (label, cap)) in zip(axes, LABELS.items(), strict=False):
        for hardening, color in zip(dataset["hardening"].values, cycle(COLORS), strict=False):
            part = finest.sel(hardening=hardening)
            text = f"plastic, H = {hardening:g} E"
            ax.plot(part["pressure"], part[name], "o-", color=color, label=text)
        if cap is not None:
            part = finest.isel(hardening=0)
            text = f"hardness {CAP:g} Y"
            ax.plot(part["pressure"], part[cap], "s--", color="#CC79A7", label=text)
        ax.plot([PRESSURE], [REFERENCE[name]], "*", color="black", markersize=10, label="known")
        ax.set(xlabel="p_H / Y", ylabel=label)
    reference = _known(dataset)
    for cells, color in zip(dataset["grid"].values, cycle(COLORS), strict=False):
        if reference is None:
            break
        part = reference.sel(grid=cells)
        text = f"{cells} cells, {float(part['layers'][-1]):g} layers"
        error = part["peak_pressure_error"]
        axes[4].loglog(part["steps"], error, "o-", color=color, label=text)
        axes[5].loglog(part["convolutions"] * cells, error, "o-", color=color, label=text)
    if reference is not None:
        steps = reference["steps"].values
        first = float(reference["peak_pressure_error"].isel(steps=0, grid=-1))
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
    """Return the part of the sweep for which a reference is known."""
    if PRESSURE not in dataset["pressure"].values or HARDENING not in dataset["hardening"].values:
        return None
    return dataset.sel(pressure=PRESSURE, hardening=HARDENING)


def _plastic_findings(dataset: xr.Dataset) -> tuple[Finding, ...]:
    """Return the error of a hardness in place of yield, and the cost of an accuracy of yielding."""
    if dataset.sizes["pressure"] < 2 or dataset.sizes["steps"] < 2:
        return ()
    finest = dataset.isel(steps=-1, grid=-1, hardening=0)
    first, last = finest.isel(pressure=0), finest.isel(pressure=-1)
    findings = [
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
    reference = _known(dataset)
    if reference is not None:
        fine = reference.isel(steps=-1, grid=-1)
        error = reference["peak_pressure_error"].isel(grid=-1)
        steps = reference["steps"].values
        findings.append(
            Finding(
                f"{steps[-1]} steps in load give the peak pressure on a body that yields to "
                f"{percent(fine['peak_pressure_error'])}.",
                f"With {steps[-1]} steps and {int(dataset['grid'][-1])} cells ({float(fine['layers']):g} layers) "
                f"the peak pressure is within {percent(fine['peak_pressure_error'])} of the known one, the dent "
                f"within {percent(fine['dent_error'])} and the largest plastic strain within "
                f"{percent(fine['plastic_strain_error'])}. From {steps[0]} steps to {steps[-1]} the error of the "
                f"pressure falls by a factor of {float(error[0] / error[-1]):.1f}: it is of first order in the steps, "
                "and what the cells add does not fall with them.",
                "What does yielding cost?",
            )
        )
    return tuple(findings)


plastic = Drawing(
    _plastic_figures, _plastic_findings, axes=("pressure", "hardening", "steps", "grid")
)
