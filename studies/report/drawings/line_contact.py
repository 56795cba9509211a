"""Drawings of the sweeps of the smooth line contact: padding, period, n, grid and coefficients."""

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from contactstudy.analytic import truncation_error
from contactstudy.domain.fields import Array
from studies.advice.front import pareto_front
from studies.model.drawing import CaptionedFigure, Drawing, Finding, Table
from studies.reference.line_contact import COUNTS_IMAGES, WIDTH, covers, padding_at, total_time
from studies.report.style import (
    LAW_STYLE,
    captioned,
    padding_style,
    paddings,
    panels,
    percent,
    power,
    select_evenly,
    setting_label,
    style_over_images,
    tick_cells,
    variation_text,
)

AXES = ("padding", "images", "period", "grid")
PERIOD_LABEL = "period L / half-width a"
IMAGES_LABEL = "n + ½  (n periods on each side)"
LABELS = {
    "axis_pressure_error": "|axis-pressure error|",
    "pressure_error_l1": "L1 error of pressure",
    "pressure_error_max": "largest error / p_H",
    "half_width_error": "|half-width error|",
}
TARGETS = (1e-1, 1e-2, 1e-3, 2e-4)  # of the L1 error
ENOUGH = 1e-3  # of the peak pressure
RATES = {"pressure_error_l1": -1.5, "pressure_error_max": -0.5}


def _each(dataset: xr.Dataset) -> Iterator[tuple[str, xr.Dataset]]:
    """Yield the name of each padding with its part of the sweep."""
    for name in paddings(dataset):
        yield name, dataset.sel(padding=name)


def _errors(ax: Axes, over: str, chosen: xr.Dataset, variable: str) -> None:
    """Plot the absolute value of an error against one axis, a line for each padding."""
    for name, part in _each(chosen):
        ax.loglog(
            chosen[over], abs(part[variable]), label=setting_label(part), **padding_style(name)
        )


def _over_images(
    dataset: xr.Dataset,
    variable: str,
    label: str,
    law: Callable[[float, Array], Any],
    law_label: str,
) -> tuple[Any, Sequence[float]]:
    """Draw an error against n + 1/2, a panel for each of three periods, beside `law(period, n + 1/2)`."""
    periods = select_evenly(dataset["period"].values)
    fig, axes = panels(len(periods), share="y", height=2.9)
    half = dataset["images"].values + 0.5
    for ax, period in zip(axes, periods, strict=True):
        for name, part in _each(dataset.sel(period=period)):
            if (error := abs(part[variable])).all():
                ax.loglog(half, error, label=name, **style_over_images(name))
        ax.loglog(half, law(period, half), label=law_label, **LAW_STYLE)
        ax.set(title=f"period L = {period:g} a", xlabel=IMAGES_LABEL)
    axes[0].set_ylabel(label)
    return fig, periods


def _rate(dataset: xr.Dataset, variable: str) -> float:
    """Return the exponent of the number of cells that fits an error best."""
    return float(np.polyfit(np.log(dataset["grid"]), np.log(dataset[variable]), 1)[0])


# Padding: which one, and the price of accuracy


def _padding_figures(dataset: xr.Dataset) -> tuple[CaptionedFigure, ...]:
    is_timed = bool(dataset["solve_time"].notnull().any())
    return (*([_price(dataset)] if is_timed else []), _reach(dataset.isel(grid=-1)))


def _price(dataset: xr.Dataset) -> CaptionedFigure:
    periods = select_evenly(dataset["period"].values, most=2)
    fig, axes = panels(len(periods), width=4.4, height=3.6, share="both")
    words = []
    for ax, period in zip(axes, periods, strict=True):
        points = settings(dataset.sel(period=period))
        cost, error, labels = (points[name].values for name in ("cost", "error", "padding"))
        front = pareto_front(cost, error)
        ax.loglog(cost[front], error[front], "k", alpha=0.12, lw=7, label="Pareto front")
        for name in paddings(dataset):
            chosen, style = np.flatnonzero(labels == name), padding_style(name)
            line = chosen[pareto_front(cost[chosen], error[chosen])]
            ax.loglog(cost[line], error[line], label=name, **style)
            ax.loglog(cost[chosen], error[chosen], ls="none", ms=3, alpha=0.5, **style)
        ax.set(title=f"period L = {period:g} a", xlabel="wall time, set-up and solve [s]")
        best = points.isel(point=front[-1])
        words.append(
            f"L = {period:g} a: {setting_label(best)} at {int(best['grid'])} cells, L1 error "
            f"{percent(best['error'])} in {float(best['cost']):.2g} s"
        )
    axes[0].set_ylabel(LABELS["pressure_error_l1"])
    return captioned(
        "price",
        fig,
        "Price of accuracy: L1 error of the pressure against wall time on one thread. Each line is the Pareto "
        "front of the settings of one padding, over all n and grids; the small marks are its other settings. "
        "Settings of one window lie in a row: a finer grid does not remove the truncation error. "
        "The most accurate settings: " + "; ".join(words) + ".",
    )


def _reach(dataset: xr.Dataset) -> CaptionedFigure:
    fig, (ax,) = panels(1, width=6, height=3.4)
    spans: list[float] = []
    for name, part in _each(dataset):
        counted = part if name in COUNTS_IMAGES else part.isel(images=[0])
        settings_ = counted["axis_pressure_error"].stack(setting=("images", "period"))
        reaches = [padding_at(name, n).reach(period) for n, period in settings_["setting"].values]
        if np.isfinite(reaches).all():
            ax.loglog(reaches, abs(settings_), linestyle="none", label=name, **padding_style(name))
            spans += reaches
        else:
            floor = {"color": padding_style(name)["color"], "linestyle": "--"}
            ax.axhline(float(abs(settings_).max()), label=f"{name} (grid error alone)", **floor)
    if spans:
        reach = np.geomspace(min(spans), max(spans))
        ax.loglog(reach, truncation_error(1, reach), label="law a²/(8D²)", **LAW_STYLE)
    ax.set(xlabel="reach of the window D / half-width a", ylabel=LABELS["axis_pressure_error"])
    return captioned(
        "reach",
        fig,
        "Axis-pressure error of every setting against its reach, the distance to each side within which a point "
        "sees pressure (D = L/2 without neighbours, L duplicated, (n + ½)L superposed). The truncated part "
        "causes an error of a²/(8D²) once D exceeds about 3a, for every kind of window. Zero padding does not "
        "follow this law, since its pressure ends with the domain. Exact periodicity has the discretisation "
        "error alone.",
    )


def settings(dataset: xr.Dataset) -> xr.Dataset:
    """Return every setting at one period as a flat list of ``cost`` [s] and L1 ``error``."""
    flat = dataset[["setup_time", "solve_time", "pressure_error_l1"]].stack(
        point=("padding", "images", "grid")
    )
    return xr.Dataset({"cost": total_time(flat), "error": flat["pressure_error_l1"]}).reset_index(
        "point"
    )


PERIODIC = {"duplicated", "superposed", "circular", "exact"}


def _padding_findings(dataset: xr.Dataset) -> tuple[Finding, ...]:
    if not covers(dataset, PERIODIC):
        return ()
    return _which_padding(dataset), _what_it_costs(dataset)


def _which_padding(dataset: xr.Dataset) -> Finding:
    finest = dataset.isel(period=-1, grid=-1, images=-1)
    exact = finest.sel(padding="exact")
    costs = "; ".join(
        f"{setting_label(part)}: {percent(part['axis_pressure_error'])} in {float(total_time(part)):.2g} s"
        for name, part in _each(finest)
        if name in PERIODIC - {"exact"}
    )
    return Finding(
        "Use exact periodicity: it has no n to choose and no truncation error at any period; an L1 error of "
        f"{percent(exact['pressure_error_l1'])} costs {float(total_time(exact)):.2g} s.",
        f"At {int(finest['grid'])} x {int(finest['grid'])} cells and L = {float(finest['period']):g} a its "
        f"axis-pressure error is {percent(exact['axis_pressure_error'])}, which is the discretisation error; "
        f"the pressure varies along the length by {variation_text(exact)}; the time is "
        f"{float(total_time(exact)):.2g} s. Axis-pressure error and time of the others: {costs}.",
        "Which padding?",
    )


def _what_it_costs(dataset: xr.Dataset) -> Finding:
    exact = settings(dataset.isel(period=-1, images=[-1]).sel(padding=["exact"]))
    exact = exact.sortby("error", ascending=False)
    cost, error = exact["cost"].values, exact["error"].values
    steps = "; ".join(
        f"{percent(error[k])} at {int(exact['grid'][k])} cells across in {cost[k]:.2g} s"
        for k in range(cost.size)
    )
    growth = ""
    if error[-1] < error[0]:
        factor = 10 ** (np.log(cost[-1] / cost[0]) / np.log(error[0] / error[-1]))
        growth = (
            f" On these grids one tenth of the error takes {factor:.0f} times as long, since much of the time is "
            "set-up, which hardly grows; where the iterations dominate it takes 10^{4/3} ≈ 22 times as long, since "
            "the error falls like N^{−3/2} and an iteration takes N² log N operations."
        )
    return Finding(
        f"With exact periodicity an L1 error of {percent(error[-1])} costs {cost[-1]:.2g} s on one thread.",
        f"Measured: {steps}.{growth}",
        "The price of accuracy",
    )


def price_table(dataset: xr.Dataset) -> Table:
    """Return the cheapest stored setting for each step of accuracy, at every period."""
    rows = []
    for period in dataset["period"].values:
        points = settings(dataset.sel(period=period))
        front = points.isel(point=pareto_front(points["cost"].values, points["error"].values))
        for target in TARGETS:
            meets = np.flatnonzero(front["error"].values <= target)
            best = front.isel(point=meets[0] if meets.size else -1)
            what = "" if meets.size else "none stored; the most accurate is "
            accuracy = percent(target), what + setting_label(best), str(int(best["grid"]))
            cost = percent(best["error"]), f"{float(best['cost']):.2g}"
            rows.append((f"{period:g} a", *accuracy, *cost))
    return Table(
        "Cost of accuracy: the cheapest stored setting whose L1 pressure error is at most the target.",
        ("period", "target L1 error", "cheapest padding", "cells across", "reached", "time [s]"),
        tuple(rows),
    )


padding = Drawing(
    _padding_figures, _padding_findings, lambda dataset: (price_table(dataset),), AXES
)


# Period


def _period_figures(dataset: xr.Dataset) -> tuple[CaptionedFigure, ...]:
    chosen = dataset.isel(grid=-1, images=-1)
    periods = chosen["period"].values
    fig, axes = panels(2, width=4.4, height=2.9)
    for ax, variable in zip(axes, ("axis_pressure_error", "pressure_error_max"), strict=True):
        _errors(ax, "period", chosen, variable)
        ax.set(xlabel=PERIOD_LABEL, ylabel=LABELS[variable])
    for name in paddings(dataset):
        reach = padding_at(name, int(chosen["images"])).reach(1.0) * periods
        # the law holds for windows beyond the contact; zero padding also cuts off the length
        beyond = reach > 1
        if np.isfinite(reach).all() and name != "zero":
            law = truncation_error(1, reach[beyond])
            axes[0].loglog(periods[beyond], law, label="law a²/(8D²)", **LAW_STYLE)
    ends = float(periods.min()), float(periods.max())
    facts = "; ".join(
        f"{setting_label(part)}: {percent(part.sel(period=ends[0])['axis_pressure_error'])} at "
        f"L = {ends[0]:g} a, {percent(part.sel(period=ends[1])['axis_pressure_error'])} at {ends[1]:g} a"
        for _, part in _each(chosen)
    )
    caption = (
        "Error against the period; in the law D = L for duplicated padding and (n + ½)L for "
        f"superposition. Axis-pressure errors: {facts}."
    )
    return (captioned("period", fig, caption),)


def _period_findings(dataset: xr.Dataset) -> tuple[Finding, ...]:
    if not covers(dataset, PERIODIC) or dataset.sizes["period"] < 2:
        return ()
    errors = dataset["axis_pressure_error"].isel(grid=-1, images=-1)
    signed = errors.sel(padding="exact")
    copied, exact = abs(errors.sel(padding="duplicated")), abs(signed)
    short, long = float(errors["period"].min()), float(errors["period"].max())
    facts = " and ".join(
        f"from {percent(part.sel(period=short))} to {percent(part.sel(period=long))} with {setting_label(part)}"
        for part in (errors.sel(padding=name) for name in ("duplicated", "superposed"))
    )
    return (
        Finding(
            "With exact periodicity any period is accurate: use that of the surface, and no longer one.",
            f"A smooth cylinder may have a period of {short:g} a, or a single row of cells, "
            f"with an error of {percent(exact.max())}; the error of duplicated padding is {percent(copied.max())} at "
            f"L = {float(copied.idxmax('period')):g} a. The number of cells is proportional to the period. A longer "
            "period does not make a smooth contact more accurate; for a rough contact it includes more of the surface.",
            "Which period?",
        ),
        Finding(
            "“Independent of the domain extent in the length direction”: true only for exact periodicity.",
            f"Between L = {short:g} a and L = {long:g} a the axis-pressure error goes {facts}; "
            f"with exact periodicity it changes by {percent(signed.max() - signed.min())}. "
            "A window that reaches D to each side has an error of a²/(8D²), so a period of a few half-widths is "
            "too short for a truncated window.",
            "The paper's second claim",
        ),
    )


period = Drawing(_period_figures, _period_findings, axes=AXES)


# Number of images


def _images_figures(dataset: xr.Dataset) -> tuple[CaptionedFigure, ...]:
    finest = dataset.isel(grid=-1)
    fig, periods = _over_images(
        finest,
        "axis_pressure_error",
        LABELS["axis_pressure_error"],
        lambda period, half: truncation_error(1, half * period),
        "law a²/(8D²), D = (n + ½)L",
    )
    peak = captioned("peak_error", fig, _images_caption(finest, periods))
    return peak, _variation(finest)


def _images_caption(dataset: xr.Dataset, periods: Sequence[float]) -> str:
    words = (
        "Error of the pressure on the axis (mean along the length) against the number of superposed "
        "periods. It falls like the square of the "
        "window's reach, down to the discretisation error, which is that of exact periodicity. Where both are "
        "of similar size they may cancel, since truncation raises the pressure and the grid may lower it."
    )
    if not {"superposed", "duplicated"} <= set(paddings(dataset)):
        return words
    errors = abs(dataset["axis_pressure_error"])
    facts = []
    for period in periods:
        duplicated = float(errors.sel(padding="duplicated", period=period)[0])
        superposed = errors.sel(padding="superposed", period=period)
        worse = np.flatnonzero((superposed >= duplicated).values)
        better = dataset["images"].values[worse[-1] + 1 if worse.size else 0 :]
        if better.size:
            facts.append(f"at L = {period:g} a from n = {better[0]} on ({percent(duplicated)})")
    comparison = f" Superposition is more accurate than duplicated padding {', '.join(facts)}."
    return words + comparison * bool(facts)


def _variation(dataset: xr.Dataset) -> CaptionedFigure:
    fig, (ax,) = panels(1, width=6, height=3.0)
    half = dataset["images"].values + 0.5
    periods = select_evenly(dataset["period"].values)
    if "superposed" in paddings(dataset):
        for period, line in zip(periods, ("-", "--", "-."), strict=False):
            curve = dataset["length_variation"].sel(padding="superposed", period=period)
            style = padding_style("superposed") | {"linestyle": line}
            ax.loglog(half, curve, label=f"superposed, L = {period:g} a", **style)
            middle = len(half) // 2
            law = float(curve[middle]) * (half[middle] / half) ** 2
            ax.loglog(half, law, label="slope −2", **LAW_STYLE)
    ax.set(xlabel=IMAGES_LABEL, ylabel="pressure variation along length / p_H")
    return captioned(
        "length_variation",
        fig,
        "With superposition the pressure of a uniform cylinder varies along its length, because the window of "
        "images is centred on the domain and not on the observer. The error of this asymmetric window "
        "falls with the square of its reach. With circular superposition, duplicated padding and exact "
        "periodicity the window moves with the observer: all observers see the same, and the pressure varies "
        "only by rounding.",
    )


def _images_findings(dataset: xr.Dataset) -> tuple[Finding, ...]:
    findings_ = []
    if covers(dataset, {"circular", "exact"}) and dataset.sizes["images"] > 2:
        findings_.append(_what_n(dataset))
    if covers(dataset, {"duplicated", "superposed"}, images={6}, period={2.4}):
        findings_.append(_six_images(dataset))
    return tuple(findings_)


def _what_n(dataset: xr.Dataset) -> Finding:
    errors = abs(dataset["axis_pressure_error"].isel(grid=-1))
    facts = []
    for period in select_evenly(dataset["period"].values):
        meets = (errors.sel(padding="circular", period=period) <= ENOUGH).values
        enough = np.flatnonzero(np.minimum.accumulate(meets[::-1])[::-1])
        least = (
            f"n = {int(dataset['images'][enough[0]])}" if enough.size else "a larger n than stored"
        )
        facts.append(f"{least} at L = {period:g} a")
    exact = errors.sel(padding="exact").max()
    return Finding(
        "No n is needed: exact periodicity sums all images. The error of a window of n images is a²/(8(n + ½)²L²).",
        f"For an axis-pressure error of {percent(ENOUGH)} circular superposition needs {', '.join(facts)} (of the "
        f"stored n); the error of exact periodicity is at most {percent(exact)} at all of them.",
        "Which n?",
    )


def _six_images(dataset: xr.Dataset) -> Finding:
    finest = dataset.sel(period=2.4, images=6).isel(grid=-1)
    copied, six = finest.sel(padding="duplicated"), finest.sel(padding="superposed")
    ratio = abs(float(copied["axis_pressure_error"] / six["axis_pressure_error"]))
    return Finding(
        "“n ≥ 6 gives very similar results to duplicated padding”: the computed errors differ.",
        f"At L = 2.4 a the axis-pressure error is "
        f"{percent(copied['axis_pressure_error'])} with duplicated padding and "
        f"{percent(six['axis_pressure_error'])} with n = 6, a factor of {ratio:.0f}: a copy of the pressure "
        "reaches one period to each side, as n = ½ would. Superposition has another error, along the "
        f"length: with n = 6 the pressure of a uniform cylinder varies by {variation_text(six)} and exceeds "
        f"p_{{H}} nowhere by more than {percent(six['peak_pressure_error'])}; with duplicated padding it "
        f"varies by {variation_text(copied)}. In a plot of the pressure such as the paper's Fig. 5 these "
        "differences are hardly visible.",
        "The paper's first claim",
    )


images = Drawing(_images_figures, _images_findings, axes=AXES)


# Grid


def _grid_figures(dataset: xr.Dataset) -> tuple[CaptionedFigure, ...]:
    chosen = dataset.isel(images=-1, period=-1)
    cells = chosen["grid"].values
    fig, axes = panels(len(LABELS), columns=2, width=4.4, height=2.2)
    for ax, (variable, label) in zip(axes, LABELS.items(), strict=True):
        _errors(ax, "grid", chosen, variable)
        if variable == "pressure_error_max" and "exact" in paddings(dataset):
            corrected = padding_style("exact") | {"linestyle": "--"}
            error = chosen["corrected_error_max"].sel(padding="exact")
            ax.loglog(cells, error, label="exact, corrected", **corrected)
        name, laws = _grid_laws(variable, chosen)
        for law in laws:
            ax.loglog(cells, law, **LAW_STYLE)
        ax.set_title(f"dotted: {name}" if name else "", loc="right", fontsize="small")
        ax.set(xlabel=f"cells N across {WIDTH} a", ylabel=label)
        tick_cells(ax, cells[::2])
    return (captioned("grid", fig, _grid_caption(chosen)),)


def _grid_laws(variable: str, chosen: xr.Dataset) -> tuple[str, Sequence[Array]]:
    """Return the name of the theoretical law of an error over the grid, and its values."""
    cells = chosen["grid"].values
    if variable == "axis_pressure_error":
        reaches = [
            padding_at(name, int(chosen["images"])).reach(float(chosen["period"]))
            for name in paddings(chosen)
            if name != "zero"
        ]
        laws = [np.full(len(cells), truncation_error(1, d)) for d in reaches if d < np.inf]
        return "a²/(8D²)", laws
    if variable == "half_width_error":
        return "(dx/a)³/50", [(WIDTH / cells) ** 3 / 50]
    if "exact" not in paddings(chosen):
        return "", []
    rate = RATES[variable]
    error = chosen[variable].sel(padding="exact").values
    law = np.exp(np.mean(np.log(error / cells**rate))) * cells**rate
    return f"N^({rate:g})", [law]


def _grid_caption(chosen: xr.Dataset) -> str:
    if "exact" not in paddings(chosen) or chosen.sizes["grid"] < 2:
        return "Error against the number of cells."
    rate = _rate(chosen.sel(padding="exact"), "pressure_error_l1")
    return (
        "Error against the number of cells N. With exact periodicity the L1 error falls like "
        f"{power('N', rate)}. The largest error is located in the cells that contain the contact edge; it "
        "depends on the position of the edge within its cell, and falls like N^{−1.5} once the discrete edge law "
        "removes it. By that law the half-width is known to the third power of the cell. A truncated window has a "
        "truncation error that no grid removes: its curves level off, for the pressure on the axis near the law for its "
        "reach. Without neighbours the pressure at the two ends of the length grows with every refinement."
    )


def _grid_findings(dataset: xr.Dataset) -> tuple[Finding, ...]:
    if not covers(dataset, {"exact"}) or dataset.sizes["grid"] < 3:
        return ()
    exact = dataset.sel(padding="exact").isel(images=-1, period=-1).sortby("grid")
    cells = exact["grid"].values
    first, last = exact.isel(grid=0), exact.isel(grid=-1)
    meets = cells[exact["pressure_error_l1"].values <= 1e-3]
    enough = f"{meets.min()}" if meets.size else f"More than {cells[-1]}"
    return (
        Finding(
            f"{enough} cells across 2.4 a for 0.1 %: with exact periodicity the grid is the only source of error.",
            f"The L1 error of the pressure falls like {power('N', _rate(exact, 'pressure_error_l1'))}, from "
            f"{percent(first['pressure_error_l1'])} at {cells[0]} cells across in {float(total_time(first)):.1g} s to "
            f"{percent(last['pressure_error_l1'])} at {cells[-1]} in {float(total_time(last)):.2g} s. The largest "
            "error, in the cells that contain the contact edge, falls only like "
            f"{power('N', _rate(exact, 'pressure_error_max'))} and not monotonically: it is "
            f"{percent(last['pressure_error_max'])} of p_{{H}} at {cells[-1]}.",
            "Which grid?",
        ),
    )


grid = Drawing(_grid_figures, _grid_findings, axes=AXES)


# Influence coefficients


def _kernel_figures(dataset: xr.Dataset) -> tuple[CaptionedFigure, ...]:
    finest = dataset.isel(grid=-1)
    fig, _ = _over_images(
        finest,
        "kernel_error",
        "error of the logarithm in the coefficients",
        _kernel_law,
        "law (x²/4 + L²/8)/(2D²), circular",
    )
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
    for name, part in _each(longest):
        ax.loglog(half, part["setup_time"], label=name, **style_over_images(name))
    words = ""
    if "superposed" in paddings(longest):
        superposed = longest.sel(padding="superposed")
        last = float(superposed["setup_time"][-1])
        ax.loglog(half, last * half / half[-1], label="proportional to n + ½", **LAW_STYLE)
        if "exact" in paddings(longest):
            six = superposed.sel(images=6, method="nearest")
            ratio = float(six["setup_time"] / longest["setup_time"].sel(padding="exact")[0])
            words = f" {setting_label(six).capitalize()}, takes {ratio:.2g} times as long as exact periodicity."
    ax.set(xlabel=IMAGES_LABEL, ylabel="time to build the operator [s]")
    return captioned(
        "build_time",
        fig,
        f"Time to build the operator (coefficients and transform) for {int(longest['grid'])} x "
        f"{int(longest['grid'])} cells and L = {float(longest['period']):g} a. Beyond a few images the cost of a sum "
        f"is proportional to their number; exact periodicity has no such number.{words}",
    )


kernels = Drawing(_kernel_figures, axes=AXES)
