"""Drawing of the study `period`: figures, findings and tables from its stored data."""

import numpy as np
import xarray as xr

from contactstudy.analytic import truncation_error
from studies.model.drawing import CaptionedFigure, Finding
from studies.reference.line_contact import covers, padding_at
from studies.report.formatting import paddings, percent, setting_label
from studies.report.style import LAW_STYLE, add_legend, padding_style, panels


def figure(dataset: xr.Dataset) -> tuple[CaptionedFigure, ...]:
    """Peak-pressure error and largest error against the period."""
    chosen = dataset.isel(grid=-1, images=-1)
    periods = chosen["period"].values
    fig, (peak, largest) = panels(2, width=4.4)
    for name in paddings(dataset):
        one = chosen.sel(padding=name)
        peak.loglog(
            periods,
            abs(one["axis_pressure_error"]),
            label=setting_label(one),
            **padding_style(name),
        )
        largest.loglog(
            periods, one["pressure_error_max"], label=setting_label(one), **padding_style(name)
        )
        reach = padding_at(name, int(chosen["images"])).reach(1.0) * periods
        # the law is one for windows beyond the contact; without neighbours the length has ends as well
        beyond = reach > 1
        if np.isfinite(reach).all() and name != "zero":
            law = truncation_error(1, reach[beyond])
            peak.loglog(periods[beyond], law, label="law a²/(8D²)", **LAW_STYLE)
    peak.set(xlabel="period L / half-width a", ylabel="|axis-pressure error|")
    largest.set(xlabel="period L / half-width a", ylabel="largest pressure error / p_H")
    add_legend(fig)
    return (CaptionedFigure("period", fig, _caption(chosen)),)


def _caption(chosen: xr.Dataset) -> str:
    shortest, longest = float(chosen["period"].min()), float(chosen["period"].max())
    facts = [
        f"{setting_label(one)}: {percent(one.sel(period=shortest)['axis_pressure_error'])} at "
        f"L = {shortest:g} a, {percent(one.sel(period=longest)['axis_pressure_error'])} at {longest:g} a"
        for one in (chosen.sel(padding=name) for name in paddings(chosen))
    ]
    return (
        "Error against the period; in the law D = L for duplicated padding and (n + ½)L for "
        f"superposition. Peak-pressure errors: {'; '.join(facts)}."
    )


def findings(dataset: xr.Dataset) -> tuple[Finding, ...]:
    """What period, and the paper's claim that it does not matter."""
    sweeps_with_estimates = {"duplicated", "superposed", "circular", "exact"}
    if not covers(dataset, sweeps_with_estimates) or dataset.sizes["period"] < 2:
        return ()
    return _what_period(dataset), _any_period(dataset)


def _what_period(dataset: xr.Dataset) -> Finding:
    here = dataset["axis_pressure_error"].isel(grid=-1, images=-1)
    copied, exact = (abs(here.sel(padding=name)) for name in ("duplicated", "exact"))
    worst = copied.idxmax("period")
    return Finding(
        "With exact periodicity any period is accurate: use that of the surface, and no longer one.",
        f"A smooth cylinder may have a period of {float(here['period'].min()):g} a, or a single row of cells, "
        f"with an error of {percent(exact.max())}; the error of duplicated padding is {percent(copied.max())} at "
        f"L = {float(worst):g} a. The number of cells is proportional to the period. A longer period does not make a "
        "smooth contact more accurate; for a rough contact it includes more of the surface.",
        "Which period?",
    )


def _any_period(dataset: xr.Dataset) -> Finding:
    here = dataset.isel(grid=-1, images=-1)
    short, long = float(here["period"].min()), float(here["period"].max())
    facts = " and ".join(
        f"from {percent(one.sel(period=short)['axis_pressure_error'])} to "
        f"{percent(one.sel(period=long)['axis_pressure_error'])} with {setting_label(one)}"
        for one in (here.sel(padding=name) for name in ("duplicated", "superposed"))
    )
    exact = here["axis_pressure_error"].sel(padding="exact")
    return Finding(
        "“Independent of the domain extent in the length direction”: true only for exact periodicity.",
        f"Between L = {short:g} a and L = {long:g} a the peak-pressure error goes {facts}; "
        f"with exact periodicity it changes by {percent(exact.max() - exact.min())}. "
        "A window that reaches D to each side has an error of a²/(8D²), so a period of a few half-widths is "
        "too short for a truncated window.",
        "The paper's second claim",
    )
