"""The verdict on a scene's settings: the price of accuracy, the fastest setting for each error, all paddings."""

from collections.abc import Sequence
from math import isfinite
from typing import Any

import numpy as np
import xarray as xr

from contactstudy.domain.grid import cells_text
from studies.advice.verdict import PRESSURE, SETTINGS, TIE, Measured, Verdict, pareto_front
from studies.model.drawing import CaptionedFigure, Finding, Table
from studies.report.plots import scaled
from studies.report.section import Section
from studies.report.style import WIDTH, captioned, padding_style, panels, percent
from studies.report.wording import (
    DECADES,
    claim,
    explanation,
    padding_name,
    seconds_text,
    setting_text,
    tolerance_text,
)


def sections(verdict: Verdict) -> Sequence[Section]:
    """Return the price of accuracy, and what each padding does."""
    answer = Finding(claim(verdict), " ".join(explanation(verdict)), "Which padding, at what cost?")
    price = Section(SETTINGS, "The price of accuracy", [answer], [_front(verdict)], [_fastest(verdict)])
    return [
        price,
        Section("paddings", "What each padding does", [], [], [_paddings(verdict)], file=SETTINGS),
    ]


def _lines(verdict: Verdict) -> dict[str, list[Measured]]:
    """Return the settings of each padding that have a bound, by their time."""
    found: dict[str, list[Measured]] = {}
    for one in sorted(verdict.settings, key=lambda one: one.setting.cells):
        if isfinite(verdict.bound(one)):
            found.setdefault(one.setting.label, []).append(one)
    return found


def _front(verdict: Verdict) -> CaptionedFigure:
    """Draw the bounds of all settings over their times."""
    of = "bound of the L1 error" if verdict.measure == PRESSURE else "the largest bound of a number"
    seconds = xr.DataArray(
        [one.seconds for one in verdict.settings], name="time",
        attrs={"units": "s", "long_name": "processor time of a solve"},
    )  # fmt: skip
    unit, across = scaled(seconds)
    fig, (ax,) = panels(1, width=WIDTH, height=5.0)
    styles = ("-", "--", ":", "-.", (0, (1, 3)), (0, (5, 1, 1, 1, 1, 1)))
    seen: dict[str, int] = {}
    best = verdict.best()
    for label, line in _lines(verdict).items():
        name = label.partition(",")[0]
        style: dict[str, Any] = padding_style(name) | {"ls": styles[seen.get(name, 0) % len(styles)]}
        seen[name] = seen.get(name, 0) + 1
        width = {"lw": 1.0, "ms": 4}
        if label == verdict.own:
            width = {"lw": 3.0, "ms": 7, "zorder": 4}
        times = np.array([one.seconds for one in line]) / unit
        bounds = 100 * np.array([verdict.bound(one) for one in line])
        shown = {*pareto_front(times, bounds), *(k for k, one in enumerate(line) if one is best)}
        front = sorted(shown, key=times.__getitem__)
        ax.loglog(times[front], bounds[front], label=padding_name(label), **style | width)
        if images := label.partition("n = ")[2]:
            end = times[front[-1]], bounds[front[-1]]
            ax.annotate(images, end, (3, 2), textcoords="offset points", fontsize="x-small")
    ax.axhline(100 * verdict.error, color="k", ls="--", lw=1.2)
    ax.text(
        0.99, 104 * verdict.error, f"requested {percent(verdict.error)}",
        transform=ax.get_yaxis_transform(), ha="right", va="bottom", fontsize="small",
    )  # fmt: skip
    if best is not None:
        ring: Any = {"ms": 19, "mfc": "none", "mec": "k", "mew": 1.8, "zorder": 6}
        ax.plot(best.seconds / unit, 100 * verdict.bound(best), "o", **ring)
        ax.set_title(setting_text(best), loc="left")
    ax.set(xlabel=across, ylabel=f"{of} [%]")
    return captioned(
        "front",
        fig,
        f"The price of accuracy for {verdict.name}: each line is one padding on the grids that are worth their time, "
        "the thick one the scene's own. A line that ends horizontally has the error of its padding, which no grid "
        "reduces. Small numbers are the n of the windows. The ring is the verdict.",
    )


def _row(verdict: Verdict, one: Measured) -> tuple[str, ...]:
    """Return padding, grid, tolerance, bound, difference and time of a setting."""
    setting = one.setting
    return (
        padding_name(setting.label), cells_text(setting.cells), tolerance_text(setting.tolerance),
        percent(verdict.bound(one)), percent(one.difference), seconds_text(one.seconds),
    )  # fmt: skip


HEAD = ("padding", "grid", "tolerance", "error at most", "difference", "time")


def _fastest(verdict: Verdict) -> Table:
    """Return the fastest setting for the requested error, and for others that settings which were tried keep."""
    errors = sorted({*DECADES, verdict.error}, reverse=True)
    chosen = [(error, one) for error in errors if (one := verdict.best(error)) is not None]
    rows = [
        (percent(error), *_row(verdict, one))
        for k, (error, one) in enumerate(chosen)
        # a setting that also keeps a smaller error stands there alone
        if error == verdict.error or k + 1 == len(chosen) or chosen[k + 1][1] is not one
    ]
    return Table(
        "The fastest setting for each error, of those that were tried. Times are the least processor times of a solve "
        f"on one thread; a tie within {percent(TIE - 1)}, or but for the set-up, goes to the scene's own padding and to "
        "more cells.",
        ("request", *HEAD),
        tuple(rows),
    )


def _paddings(verdict: Verdict) -> Table:
    """Return every padding on the grid of the verdict."""
    chosen = (verdict.best() or verdict.nearest).setting
    same = [
        one for one in verdict.settings
        if (one.setting.cells, one.setting.tolerance) == (chosen.cells, chosen.tolerance)
    ] or [one for one in verdict.settings if one.setting.cells == chosen.cells]  # fmt: skip
    rows = sorted(same, key=lambda one: one.seconds)
    return Table(
        f"Every padding on {cells_text(chosen.cells)}: the bound of its error, and the measured L1 difference of its "
        f"pressure to {verdict.reference}.",
        HEAD,
        tuple(_row(verdict, one) for one in rows),
    )
