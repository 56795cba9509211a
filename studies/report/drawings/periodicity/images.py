"""Drawing of the study `images`: figures, findings and tables from its stored data."""

import numpy as np
import xarray as xr

from contactstudy.analytic import truncation_error
from studies.model.drawing import CaptionedFigure, Finding
from studies.reference.line_contact import covers, padding_at
from studies.report.formatting import paddings, percent, select_evenly, variation_text
from studies.report.style import LAW_STYLE, add_legend, padding_style, panels, style_over_images

TARGET = 1e-3  # of the peak pressure
LABEL = "n + ½  (n periods on each side)"


def figure(dataset: xr.Dataset) -> tuple[CaptionedFigure, ...]:
    """Peak-pressure error and variation along the length against n, a panel for each period."""
    finest = dataset.isel(grid=-1)
    return _peak(finest), _variation(finest)


def _peak(dataset: xr.Dataset) -> CaptionedFigure:
    periods = select_evenly(dataset["period"].values)
    fig, axes = panels(len(periods), share="y")
    half = dataset["images"].values + 0.5
    for ax, period in zip(axes, periods, strict=True):
        for name in paddings(dataset):
            error = abs(dataset["axis_pressure_error"].sel(padding=name, period=period))
            ax.loglog(half, error, label=name, **style_over_images(name))
        reach = [padding_at("superposed", int(n)).reach(period) for n in dataset["images"]]
        ax.loglog(half, truncation_error(1, reach), label="law a²/(8D²), D = (n + ½)L", **LAW_STYLE)
        ax.set(title=f"period L = {period:g} a", xlabel=LABEL)
    axes[0].set_ylabel("|axis-pressure error|")
    add_legend(fig)
    return CaptionedFigure("peak_error", fig, _peak_caption(dataset, periods))


def _peak_caption(dataset: xr.Dataset, periods: list[float]) -> str:
    words = (
        "Peak-pressure error against the number of superposed periods. It falls like the square of the "
        "window's reach, down to the discretisation error, which is that of exact periodicity. Where both are "
        "of similar size they may cancel, since truncation raises the peak and the grid may lower it. "
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
    return words + (
        "Superposition is more accurate than duplicated padding " + ", ".join(facts) + "."
        if facts
        else ""
    )


def _variation(dataset: xr.Dataset) -> CaptionedFigure:
    fig, (ax,) = panels(1, width=6, height=3.4)
    half = dataset["images"].values + 0.5
    periods = select_evenly(dataset["period"].values)
    shown = "superposed" in paddings(dataset)
    for period, line in zip(periods if shown else [], ("-", "--", "-."), strict=False):
        variation = dataset["length_variation"].sel(padding="superposed", period=period)
        style = padding_style("superposed") | {"linestyle": line}
        ax.loglog(half, variation, label=f"superposed, L = {period:g} a", **style)
        middle = len(half) // 2
        law = float(variation[middle]) * (half[middle] / half) ** 2
        ax.loglog(half, law, label="slope −2", **LAW_STYLE)
    ax.set(xlabel=LABEL, ylabel="pressure variation along length / p_H")
    add_legend(fig)
    return CaptionedFigure(
        "length_variation",
        fig,
        "With superposition the pressure of a uniform cylinder varies along its length, because the window of "
        "images is centred on the domain and not on the observer. The error of this asymmetric window "
        "falls with the square of its reach. With circular superposition, duplicated padding and exact "
        "periodicity the window moves with the observer: all observers see the same, and the pressure varies "
        "only by rounding.",
    )


def findings(dataset: xr.Dataset) -> tuple[Finding, ...]:
    """What n, and the paper's claim about n = 6."""
    found = []
    if covers(dataset, {"circular", "exact"}) and dataset.sizes["images"] > 2:
        found.append(_what_n(dataset))
    if covers(dataset, {"duplicated", "superposed"}, images={6}, period={2.4}):
        found.append(_six_images(dataset))
    return tuple(found)


def _what_n(dataset: xr.Dataset) -> Finding:
    errors = abs(dataset["axis_pressure_error"].isel(grid=-1))
    facts = []
    for period in select_evenly(dataset["period"].values):
        meets = (errors.sel(padding="circular", period=period) <= TARGET).values
        enough = np.flatnonzero(np.minimum.accumulate(meets[::-1])[::-1])
        said = (
            f"n = {int(dataset['images'][enough[0]])}" if enough.size else "a larger n than stored"
        )
        facts.append(f"{said} at L = {period:g} a")
    exact = errors.sel(padding="exact").max()
    return Finding(
        "No n is needed: exact periodicity sums all images. The error of a window of n images is a²/(8(n + ½)²L²).",
        f"For {percent(TARGET)} of the peak pressure circular superposition needs {', '.join(facts)} (of the "
        f"stored n); the error of exact periodicity is at most {percent(exact)} at all of them.",
        "Which n?",
    )


def _six_images(dataset: xr.Dataset) -> Finding:
    here = dataset.sel(period=2.4).isel(grid=-1)
    copied, six = here.sel(padding="duplicated", images=6), here.sel(padding="superposed", images=6)
    ratio = abs(float(copied["axis_pressure_error"] / six["axis_pressure_error"]))
    return Finding(
        "“n ≥ 6 gives very similar results to duplicated padding”: the computed errors differ.",
        f"At L = 2.4 a the error of the peak pressure (mean along the length) is "
        f"{percent(copied['axis_pressure_error'])} with duplicated padding and "
        f"{percent(six['axis_pressure_error'])} with n = 6, a factor of {ratio:.0f}: a copy of the pressure "
        "reaches one period to each side, as n = ½ would. Superposition has another error, along the "
        f"length: with n = 6 the pressure of a uniform cylinder varies by {variation_text(six)} and exceeds "
        f"p_{{H}} nowhere by more than {percent(six['peak_pressure_error'])}; with duplicated padding it "
        f"varies by {variation_text(copied)}. In a plot of the pressure such as the paper's Fig. 5 these "
        "differences are hardly visible.",
        "The paper's first claim",
    )
