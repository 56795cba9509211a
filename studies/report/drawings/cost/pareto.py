"""Drawing of the study `pareto`: figures, findings and tables from its stored data."""

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from studies.advice.settings_table import STORED_ERRORS, Settings, pareto_front, settings
from studies.model.drawing import CaptionedFigure
from studies.reference.line_contact import LINE
from studies.report.drawings.cost.pareto_findings import findings, tables
from studies.report.formatting import paddings, percent, select_evenly
from studies.report.style import add_legend, padding_style, panels

__all__ = ["figure", "findings", "tables"]


def figure(dataset: xr.Dataset) -> tuple[CaptionedFigure, ...]:
    """Error against runtime with the front at every period, and what each decade costs."""
    return _fronts(dataset), _decades(dataset)


def _fronts(dataset: xr.Dataset) -> CaptionedFigure:
    periods = select_evenly(dataset["period"].values)
    rows = {"pressure_error_l1": "L1 error as solved", "corrected_error_l1": "L1 error, corrected"}
    fig, axes = panels(len(rows) * len(periods), columns=len(periods), height=3.0, share="both")
    for index, ax in enumerate(axes):
        row, column = divmod(index, len(periods))
        variable, label = list(rows.items())[row]
        _front(ax, settings(dataset.sel(period=periods[column]), variable))
        if row == 0:
            ax.set_title(f"period L = {periods[column]:g} a")
        if row == len(rows) - 1:
            ax.set_xlabel("wall time, set-up and solve [s]")
        if column == 0:
            ax.set_ylabel(label)
    add_legend(fig)
    return CaptionedFigure(
        "front",
        fig,
        "Accuracy against wall time on one thread, for every mode, n, grid, tolerance and solver. Filled marks: "
        "preconditioned solver; open marks: Polonsky & Keer. The solid black line is the Pareto front of all "
        "settings; the dashed line is the front of settings with cells along the length, for contacts that vary "
        "there. Grey bars extend to the slowest repeat. “line” is exact periodicity with one cell along a "
        "length on which nothing varies. Points far above the others stopped at a tolerance of 1e-4, before "
        "the contact set was found. In the lower row the edge law removes the discretisation error of the "
        "contact edge, for a few operations per cell; the truncation error of a window remains.",
    )


def _front(ax: Axes, every: Settings) -> None:
    for name in dict.fromkeys(every.modes.tolist()):
        for solver in dict.fromkeys(every.axes["solver"].tolist()):
            own = (every.modes == name) & (every.axes["solver"] == solver)
            hollow = solver == "polonsky_keer"
            face = {"markerfacecolor": "none"} if hollow else {"label": name}
            ax.loglog(
                every.cost[own], every.error[own], linestyle="none", alpha=0.6, markersize=4,
                **padding_style(name) | face,
            )  # fmt: skip
    for chosen, style, label in (
        (every, "-", "front"),
        (every.where(every.modes != LINE), "--", "front, cells along the length"),
    ):
        best = chosen.where(pareto_front(chosen.cost, chosen.error))
        line: dict[str, Any] = {"color": "black", "linewidth": 0.9, "linestyle": style}
        ax.step(best.cost, best.error, where="post", label=label, **line)
        bars = np.clip([best.cost - best.spread[0], best.spread[1] - best.cost], 0, None)
        ax.errorbar(
            best.cost, best.error, xerr=bars, fmt="none", ecolor="grey", elinewidth=1.5, alpha=0.6,
            zorder=1,
        )  # fmt: skip


def _decades(dataset: xr.Dataset) -> CaptionedFigure:
    period = select_evenly(dataset["period"].values)[
        len(select_evenly(dataset["period"].values)) // 2
    ]
    here = dataset.sel(period=period)
    fig, axes = panels(len(STORED_ERRORS), share="y")
    words = []
    for ax, (metric, errors) in zip(axes, STORED_ERRORS.items(), strict=True):
        every = settings(here, *errors)
        targets = 10.0 ** np.arange(-1, np.floor(np.log10(every.error.min())) - 1, -0.02)
        for name in paddings(dataset):
            own = every.where(every.modes == name)
            best = [(target, own.cheapest(target)) for target in targets]
            met = [(target, index) for target, index in best if index is not None]
            if met:
                asked, chosen = map(list, zip(*met, strict=True))
                style = padding_style(name) | {"markevery": 25}
                ax.loglog(asked, own.cost[chosen], label=name, **style)
                ax.fill_between(
                    asked, *own.spread[:, chosen], color=style["color"], alpha=0.2, lw=0
                )
        ax.invert_xaxis()
        ax.set(title=f"of the {metric}", xlabel="requested error")
        least = every.where(np.array([int(np.argmin(every.error))]))
        words.append(f"{metric} {percent(least.error[0])} ({least.name(0)})")
    axes[0].set_ylabel("shortest wall time that reaches it [s]")
    add_legend(fig)
    return CaptionedFigure(
        "decades",
        fig,
        f"Cost of each decade of accuracy by mode, at L = {period:g} a: the cheapest stored setting that "
        "reaches the requested error, corrected or not, with the spread of its "
        "repeats. Errors with a sign may cancel by chance. A line ends where no stored setting "
        "of the mode is more accurate: for a truncated window this is its truncation error, for the others the "
        f"error of the finest grid. Smallest errors: {'; '.join(words)}.",
    )
