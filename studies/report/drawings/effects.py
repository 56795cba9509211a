"""Drawings of the studies of effects: coating, friction, creep, wear and yielding."""

import numpy as np
import xarray as xr

from studies.definitions.creep import END, HALF_WIDTH, LEE_RADOK
from studies.definitions.plastic import DATUM, HARDENING, HARDNESS_OVER_YIELD, PRESSURE, REFERENCE
from studies.definitions.wear import WORN_HALF_WIDTH
from studies.model.drawing import CaptionedFigure, Drawing, Finding
from studies.report.style import (
    COLORS,
    LAW_STYLE,
    by_color,
    captioned,
    label_panels,
    panels,
    percent,
    power,
)

# coating


def _coating_figures(dataset: xr.Dataset) -> tuple[CaptionedFigure, ...]:
    """Draw half-width and peak pressure over the thickness, beside those of bodies of the coating alone."""
    # half-width and peak pressure of a body of the coating alone, as powers of the ratio of moduli
    labels = {
        "half_width": ("half-width / a", -0.5),
        "peak_pressure": ("peak pressure / $p_H$", 0.5),
    }
    fig, axes = panels(len(labels), width=3.6, height=2.7)
    for ax, (variable, (label, exponent)) in zip(axes, labels.items(), strict=True):
        for part, style in by_color(dataset.isel(grid=-1), "ratio", "E1/E2 = {:g}"):
            ax.plot(part["thickness"], part[variable], **style)
            thin = LAW_STYLE | {"color": style["color"], "linewidth": 0.7}
            ax.axhline(float(part["ratio"]) ** exponent, **thin)
        ax.set(xscale="log", xlabel="thickness / a", ylabel=label)
    caption = (
        "A rigid cylinder on a coated half-space, nu = 0.3 in both, over the thickness of the coating; a and p_{H} "
        "are Hertz's on the substrate alone, and thin lines those on the coating alone."
    )
    return (captioned("coating", fig, caption),)


def _coating_findings(dataset: xr.Dataset) -> tuple[Finding, ...]:
    """Return the effect of a coating by its thickness, and the error against known contacts."""
    if dataset.sizes["thickness"] < 3:
        return ()
    finest = dataset.isel(grid=-1)
    thin, thick = finest.isel(thickness=0), finest.isel(thickness=-1)
    from_substrate = abs(thin["half_width"] - 1).max()
    from_coating = abs(thick["half_width"] * np.sqrt(thick["ratio"]) - 1).max()
    error = float(finest["reference_error"].max(skipna=True))
    reference = f" Known contacts (a collocation of the layered problem) are met to {error:.1e} in the peak pressure."
    return (
        Finding(
            "A coating acts by its thickness over the half-width.",
            f"At a thickness of {float(thin['thickness']):g} a the half-width is within {percent(from_substrate)} of "
            f"that on the substrate, at {float(thick['thickness']):g} a within {percent(from_coating)} of that on the "
            f"coating.{reference * bool(np.isfinite(error))}",
            "What does a coating do?",
        ),
    )


coating = Drawing(_coating_figures, _coating_findings)


# friction


def _friction_figures(dataset: xr.Dataset) -> tuple[CaptionedFigure, ...]:
    """Draw stress over the coefficient, stick zone over the force, and errors of the superposition."""
    finest = dataset.isel(grid=-1, rough_grid=-1)
    fig, axes = panels(6, columns=2, width=3.6, height=2.7)
    for part, style in by_color(finest, "poisson_ratio", "nu = {:g}"):
        variables = ("von_mises", "depth", "stick", "stick_sphere")
        for ax, variable in zip(axes, variables, strict=False):
            ax.plot(part[part[variable].dims[0]], part[variable], **style)
    fraction = np.linspace(0, 1, 200)
    axes[2].plot(fraction, np.sqrt(1 - fraction), label="Cattaneo, Mindlin", **LAW_STYLE)
    axes[3].plot(fraction, np.cbrt(1 - fraction), **LAW_STYLE)
    for ax, variable in ((axes[4], "superposition_error"), (axes[5], "transverse_traction")):
        ax.plot(finest["poisson_ratio"], finest[variable], color=COLORS[0], marker="o")
    label_panels(
        axes,
        ("coefficient of friction", "highest von Mises / $p_H$", ""),
        ("coefficient of friction", "depth of that stress / a", ""),
        ("Q / (mu P)", "stick / contact, cylinder", ""),
        ("Q / (mu P)", "stick / contact, sphere", ""),
        ("Poisson's ratio", "L1 error of superposition", ""),
        ("Poisson's ratio", "transverse traction / largest", ""),
    )
    caption = (
        "Top: a sliding cylinder, where the highest von Mises stress rises to the surface. Middle: partial slip "
        "under a tangential force Q, half-width or radius of the stick zone over that of the contact, beside "
        "Cattaneo's sqrt(1 - Q / mu P) for a cylinder and Mindlin's cube root for a sphere. "
        "Bottom: what the superposition of two normal contacts (Ciavarella, Jäger) misses on a rough "
        "line contact at Q = mu P / 2, and the transverse traction, which it does not contain."
    )
    return (captioned("friction", fig, caption),)


def _friction_findings(dataset: xr.Dataset) -> tuple[Finding, ...]:
    """Return the place of the highest stress and the error of the superposition."""
    if dataset.sizes["poisson_ratio"] < 2 or not {0.0, 0.3} <= set(dataset["poisson_ratio"].values):
        return ()
    finest = dataset.isel(grid=-1, rough_grid=-1)
    steel, cork = finest.sel(poisson_ratio=0.3), finest.sel(poisson_ratio=0.0)
    stress, depth = steel["von_mises"], steel["depth"]
    surface = depth.where(depth < 0.01, drop=True)["coefficient"]
    low, high = stress.isel(coefficient=0), stress.isel(coefficient=-1)
    deviation = float(abs(steel["stick"] - np.sqrt(1 - steel["fraction"])).max())
    return (
        Finding(
            "Friction brings the highest stress to the surface at a coefficient of about 0.3; stick zones are "
            "those of Cattaneo, but the superposition that gives them is inexact on rough surfaces.",
            f"At nu = 0.3 the highest von Mises stress is {float(low):.3f} p_{{H}} without friction and "
            f"{float(high):.3f} p_{{H}} at a coefficient of {float(high['coefficient']):g}; it lies at the surface from "
            f"{float(surface.min()):g} on. A cylinder sticks over a zone within {deviation:.3f} half-widths of "
            "Cattaneo's. On a rough contact two normal solves make up the tangential traction to "
            f"{percent(cork['superposition_error'])} in L1 at nu = 0, and miss "
            f"{percent(steel['superposition_error'])} of it at nu = 0.3, with a transverse traction of "
            f"{percent(steel['transverse_traction'])} of the largest; scenes like that are solved for both components.",
            "What does friction do?",
        ),
    )


friction = Drawing(_friction_figures, _friction_findings)


# creep


def _creep_figures(dataset: xr.Dataset) -> tuple[CaptionedFigure, ...]:
    """Draw half-width and peak pressure beside the closed forms, and errors against steps and cost."""
    fig, (width, peak, errors, cost) = panels(4, columns=2, width=4.4, height=3.0)
    finest = dataset.isel(steps=-1, grid=-1)
    time = np.linspace(0, END, 100)
    width.plot(time, LEE_RADOK.half_width(time) / HALF_WIDTH, **LAW_STYLE)
    peaks = [float(LEE_RADOK.pressure(0.0, part)) / (HALF_WIDTH / 2) for part in time]
    peak.plot(time, peaks, **LAW_STYLE)
    for ax, name in ((width, "half_width"), (peak, "peak_pressure")):
        ax.plot(finest["time"], finest[name], "o", color=COLORS[0])
    for part, style in by_color(dataset, "grid", "{} cells"):
        errors.loglog(part["steps"], part["pressure_error_l1"], **style)
        errors.loglog(part["steps"], part["time_discretisation_error"], "--", color=style["color"])
        cost.loglog(part["convolutions"] * part["grid"], part["pressure_error_l1"], **style)
    label_panels(
        (width, peak, errors, cost),
        ("time over the retardation time", "half-width over the sudden one", "dotted: closed form"),
        (
            "time over the retardation time",
            "peak pressure over the sudden one",
            "dotted: closed form",
        ),
        ("steps", "largest relative L1 error", "dashed: estimated, by steps"),
        ("FFT convolutions times cells", "largest relative L1 error", ""),
    )
    caption = (
        "A rigid cylinder pressed suddenly into a viscoelastic half-space and held; the creep compliance is 1 + 1.5 (1 "
        "- exp(-t)) times the instantaneous one. Half-width and peak pressure are compared with Lee & Radok's closed "
        "form, the half-width to a cell. The error is the largest over time, after the first tenth. It falls with the "
        "steps until the error of the cells is larger; the dashed estimate, from a second evolution with steps twice "
        "as long, contains the error of the steps alone."
    )
    return (captioned("creep", fig, caption),)


def _creep_findings(dataset: xr.Dataset) -> tuple[Finding, ...]:
    """Return the cost of accuracy in time beside that of the grid."""
    if dataset.sizes["steps"] < 3 or dataset.sizes["grid"] < 2:
        return ()
    fine = dataset.isel(grid=-1)
    rate = np.polyfit(np.log(fine["steps"]), np.log(fine["time_discretisation_error"]), 1)[0]
    coarse, last = dataset.isel(grid=0, steps=-1), dataset.isel(grid=-1, steps=-1)
    by_steps = fine.where(fine["time_discretisation_error"] > 2 * fine["grid_error"], drop=True)
    ratios = (by_steps["time_discretisation_error"] / by_steps["pressure_error_l1"]).values
    trust = ""
    if ratios.size:
        span = f"{ratios.min():.2g} to {ratios.max():.2g}"
        trust = (
            f" Where the steps leave more than the cells, their estimate is {span} times the error."
        )
    return (
        Finding(
            f"The error by the steps falls like {power('N', rate)}, so a digit in time costs "
            f"{10 ** (-1 / rate):.2g} times as many solves.",
            f"With {int(last['steps'])} steps and {int(last['grid'])} cells the pressure is known to "
            f"{percent(last['pressure_error_l1'])} at every instant, in {float(last['convolutions']):.0f} "
            f"FFT convolutions; with {int(coarse['grid'])} cells the same steps leave "
            f"{percent(coarse['pressure_error_l1'])}.{trust}",
            "How many steps in time?",
        ),
    )


creep = Drawing(_creep_figures, _creep_findings)


# wear


def _wear_figures(dataset: xr.Dataset) -> tuple[CaptionedFigure, ...]:
    """Draw the half-width over distance beside the rigid law, and errors against steps and solves."""
    finest = dataset.isel(grid=-1)
    fig, (width, errors, cost) = panels(3, columns=3, width=3.8, height=3.0)
    distance = np.linspace(0, 1, 100)
    width.plot(distance, WORN_HALF_WIDTH * np.cbrt(distance), **LAW_STYLE)
    added = np.cbrt(1 + WORN_HALF_WIDTH**3 * distance)
    width.plot(distance, added, **LAW_STYLE | {"linestyle": "--"})
    for part, style in by_color(finest, "scheme", "{}"):
        width.plot(part["distance"], part["half_width"].isel(steps=-1), "o", color=style["color"])
        errors.loglog(part["steps"], part["pressure_error_l1"], **style)
        cost.loglog(part["solves"], part["pressure_error_l1"], **style)
    errors.axvline(_stable_from(finest), **LAW_STYLE)
    label_panels(
        (width, errors, cost),
        ("distance over the whole", "half-width over Hertz's", "dotted: rigid; dashed: cubes added"),
        ("steps", "relative L1 error at the end", "dotted: explicit limit"),
        ("solves", "relative L1 error at the end", ""),
    )  # fmt: skip
    caption = (
        "A cylinder that wears by Archard's law until a rigid one would have a flat of twice Hertz's half-width, "
        f"{int(finest['grid'])} cells. The flat grows like the cube root of the distance; a^3 = a_H^3 + 3/2 R k P s "
        "is a fair estimate from the start. Errors are against 512 two-stage steps on the same grid. Implicit "
        "steps are stable at any length, explicit ones below ds = 1.48 dx / (k E*), which is "
        f"{_stable_from(finest):.3g} steps here. All keep the wear volume k P s to rounding."
    )
    return (captioned("wear", fig, caption),)


def _stable_from(dataset: xr.Dataset) -> float:
    """Return the number of steps from which explicit steps are shorter than their limit."""
    return float(dataset["steps"][0] / dataset["longest_explicit"].isel(steps=0, scheme=0))


def _wear_findings(dataset: xr.Dataset) -> tuple[Finding, ...]:
    """Return the number of steps that implicit wear saves."""
    finest = dataset.isel(grid=-1)
    schemes = set(finest["scheme"].values.tolist())
    if not {"implicit", "explicit"} <= schemes or finest.sizes["steps"] < 3:
        return ()
    coarse = finest.isel(steps=1)
    errors = (coarse["pressure_error_l1"].sel(scheme=name) for name in ("implicit", "explicit"))
    implicit, explicit = map(percent, errors)
    return (
        Finding(
            f"With {int(coarse['steps'])} steps of wear the error is {implicit} (implicit) and {explicit} (explicit).",
            f"An explicit evolution needs {_stable_from(finest):.3g} steps to be stable on this grid, and twice as "
            "many on one twice as fine. An implicit step costs the same solve, with a constant in its spectrum, and "
            "the wear volume is exact either way.",
            "How to step wear?",
        ),
    )


wear = Drawing(_wear_figures, _wear_findings)


# plastic

LABELS = {
    "peak_pressure": ("peak pressure / $p_H$", "hardness_limited_pressure"),
    "half_width": ("half-width / a", "hardness_limited_half_width"),
    "dent": ("dent / (a Y / E)", "hardness_limited_dent"),
    "plastic_depth": ("plastic depth / a", None),
}


def _plastic_figures(dataset: xr.Dataset) -> tuple[CaptionedFigure, ...]:
    """Draw the yielding contact over the load, beside a hardness, and errors against steps and cost."""
    fig, axes = panels(6, columns=2, width=4.0, height=2.7)
    finest = dataset.isel(steps=-1, grid=-1)
    for ax, (name, (label, cap)) in zip(axes, LABELS.items(), strict=False):
        for part, style in by_color(finest, "hardening", "plastic, H = {:g} E"):
            ax.plot(part["pressure"], part[name], **style)
        if cap is not None:
            capped, text = finest.isel(hardening=0), f"hardness {HARDNESS_OVER_YIELD:g} Y"
            ax.plot(capped["pressure"], capped[cap], "s--", color="#CC79A7", label=text)
        ax.plot([PRESSURE], [REFERENCE[name]], "*", color="black", markersize=10, label="reference")
        ax.set(xlabel="$p_H$ / Y", ylabel=label)
    if (compared := _known(dataset)) is not None:
        for part, style in by_color(compared, "grid", "{} cells, "):
            style["label"] += f"{float(part['layers'][-1]):g} layers"
            axes[4].loglog(part["steps"], part["peak_pressure_error"], **style)
            work = part["convolutions"] * part["grid"]
            axes[5].loglog(work, part["peak_pressure_error"], **style)
        steps = compared["steps"].values
        first = float(compared["peak_pressure_error"].isel(steps=0, grid=-1))
        axes[4].loglog(steps, first * steps[0] / steps, **LAW_STYLE)
    label_panels(
        axes[4:],
        ("steps in load", "error of the peak pressure", "dotted: first order"),
        ("FFT convolutions times cells", "error of the peak pressure", ""),
    )
    caption = (
        "A rigid cylinder pressed into a half-space that yields after von Mises, then unloaded, in plane strain, "
        f"over Hertz's peak pressure p_{{H}}; a is Hertz's half-width. The dent is measured against the surface at "
        f"{DATUM:g} a. Squares: an elastic contact limited by a hardness of {HARDNESS_OVER_YIELD:g} Y. Stars are "
        f"converged references (finite elements agree to 0.3 %), at p_{{H}} = {PRESSURE:g} Y and a hardening modulus "
        f"of {HARDENING:g} E; the last panels are the error there. Layers follow from the cells."
    )
    return (captioned("plastic", fig, caption),)


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
    cap = Finding(
        "A hardness is no substitute for plastic strain below the surface.",
        f"At p_{{H}} = {float(last['pressure']):g} Y, where the peak pressure is "
        f"{float(last['peak_pressure'] * last['pressure']):.2f} Y, a hardness of {HARDNESS_OVER_YIELD:g} Y gives a "
        f"pressure that differs by {percent(last['hardness_limited_difference'])} in L1, and a largest depth of "
        f"{float(last['hardness_limited_dent']):.2g} a Y / E in the place of a dent of {float(last['dent']):.2g}. At "
        f"{float(first['pressure']):g} Y it differs by {percent(first['hardness_limited_difference'])}. The body "
        "yields from p_{H} = 1.79 Y on, below the surface, long before any pressure reaches the hardness.",
        "Is a hardness cap enough?",
    )
    if (compared := _known(dataset)) is None:
        return (cap,)
    fine, steps = compared.isel(steps=-1, grid=-1), compared["steps"].values
    error = compared["peak_pressure_error"].isel(grid=-1)
    cost = Finding(
        f"With {steps[-1]} load steps the peak pressure on a yielding body is accurate to "
        f"{percent(fine['peak_pressure_error'])}.",
        f"With {steps[-1]} steps and {int(fine['grid'])} cells ({float(fine['layers']):g} layers) "
        f"the peak pressure is within {percent(fine['peak_pressure_error'])} of the known one, the dent "
        f"within {percent(fine['dent_error'])} and the largest plastic strain within "
        f"{percent(fine['plastic_strain_error'])}. From {steps[0]} steps to {steps[-1]} the error of the "
        f"pressure falls by a factor of {float(error[0] / error[-1]):.1f}: it is of first order in the steps, "
        "and what the cells add does not fall with them.",
        "What does yielding cost?",
    )
    return cap, cost


plastic = Drawing(_plastic_figures, _plastic_findings)
