"""The verdict on a scene's settings, in words for page and command, and the figure and the tables of its page."""

from collections import Counter
from collections.abc import Iterator, Sequence
from math import inf, isfinite
from typing import Any

import numpy as np
import xarray as xr

from contactstudy.domain.grid import cells_text
from studies.advice.verdict import PRESSURE, SETTINGS, TIE, Measured, Verdict, pareto_front
from studies.model.drawing import CaptionedFigure, Finding, Table
from studies.report.chapters import Section
from studies.report.plots import WIDTH, captioned, padding_style, panels, percent, scaled, seconds_text

# Errors for which a page lists the fastest setting, beside the requested one.
DECADES = (0.3, 0.1, 0.03, 0.01, 3e-3, 1e-3, 3e-4, 1e-4)


def padding_name(label: str) -> str:
    """Return the name of a padding in a sentence."""
    if label == "exact":
        return "exact periodicity"
    return f"{label} padding" if label in ("zero", "duplicated") else label


def tolerance_text(tolerance: float) -> str:
    """Return a tolerance, such as "1e-2"."""
    return f"{tolerance:.0e}".replace("e-0", "e-")


def setting_text(result: Measured) -> str:
    """Return a setting in words."""
    padding, cells = padding_name(result.setting.label), cells_text(result.setting.cells)
    return f"{padding}, {cells}, tolerance {tolerance_text(result.setting.tolerance)}"


def bound_text(verdict: Verdict, result: Measured) -> str:
    """Return the bound of a setting with what it is of, and the measured difference."""
    bound = verdict.bound(result)
    where = "in L1" if verdict.measure == PRESSURE else result.worst
    reached = f"error at most {percent(bound)} {where}" if isfinite(bound) else "an error without a bound"
    return f"{reached}, measured difference {percent(result.difference)}"


def claim(verdict: Verdict) -> str:
    """Return the verdict in a sentence."""
    best = verdict.best()
    if best is None:
        nearest = verdict.nearest
        return (
            f"No setting that was tried is shown to keep {percent(verdict.error)} by {verdict.measure}. The nearest is "
            f"{setting_text(nearest)}: {bound_text(verdict, nearest)}, in {seconds_text(nearest.seconds)}."
        )
    return (
        f"Use {setting_text(best)}: {bound_text(verdict, best)}, in {seconds_text(best.seconds)} on one thread; "
        f"{percent(verdict.error)} was requested, and is kept by {verdict.measure}."
    )


def explanation(verdict: Verdict) -> Iterator[str]:
    """Yield sentences on other paddings, and on what the verdict stands on."""
    best, meeting = verdict.best(), verdict.meeting()
    if verdict.measure == PRESSURE:
        error = (best or verdict.nearest).error
        largest_error = f", here up to {percent(error)}" if isfinite(error) else ""
        yield f"Other numbers of the answer may have larger errors{largest_error}."
    along = {result.setting.label: result.setting.cells[1] for result in verdict.settings}
    if min(along.values()) == 1:
        yield "Nothing varies along the length, so that one cell along it is enough."
        if (copied := along.get("duplicated", 1)) > 1:
            yield f"Duplicated padding has {copied}, since its window is off centre on fewer."
            yield "The period is free too: over 100 half-widths every padding has the cells' error alone."
    if best is not None:
        fastest: dict[str, Measured] = {}
        for result in meeting:
            fastest.setdefault(result.setting.label, result)
        ratios = [(padding_name(label), result.seconds / best.seconds) for label, result in fastest.items()]
        ratios = [pair for pair in ratios if pair[0] != padding_name(best.setting.label)]
        if ties := [name for name, ratio in ratios if ratio <= TIE]:
            whose = ", which goes to the scene's own padding" * (best.setting.label == verdict.own)
            yield f"As fast within {percent(TIE - 1)}, or but for the set-up, a tie{whose}: {', '.join(ties)}."
        if slower := [f"{name} ({ratio:.2g} times)" for name, ratio in ratios if ratio > TIE]:
            yield f"Slower: {', '.join(slower)}."
    labels = {result.setting.label for result in meeting}
    bounds: dict[str, float] = {}
    for result in verdict.settings:
        bounds[result.setting.label] = min(verdict.bound(result), bounds.get(result.setting.label, inf))
    if missed := [f"{padding_name(label)} ({percent(of)})" for label, of in bounds.items() if label not in labels]:
        yield f"Not kept on any grid that was tried, with the least bound: {', '.join(missed)}."
    if verdict.own in ("free ends", "repeating across and along"):
        yield f"The scene has {verdict.own}: no other padding is that contact, and none was tried."
    yield f"Differences are against {verdict.reference}."
    yield from verdict.notes


def lines(verdict: Verdict) -> Iterator[str]:
    """Yield the verdict as lines of a terminal, with the tables of a scene file."""
    yield f"{verdict.name}: {claim(verdict)}"
    yield from (f"  {sentence}" for sentence in explanation(verdict))
    yield "  in the scene file, instead of its tables grid, padding, solve and plan:"
    chosen = verdict.best() or verdict.nearest
    yield from (f"    {line}".rstrip() for line in verdict.toml(chosen).strip().splitlines())


def sections(verdict: Verdict) -> Sequence[Section]:
    """Return the price of accuracy, and what each padding does."""
    answer = Finding(claim(verdict), " ".join(explanation(verdict)), "Which padding, at what cost?")
    return [
        Section(SETTINGS, "The price of accuracy", [answer], [_front(verdict)], [_fastest(verdict)], SETTINGS),
        Section("paddings", "What each padding does", [], [], [_paddings(verdict)], SETTINGS),
    ]


def _front(verdict: Verdict) -> CaptionedFigure:
    """Draw the bounds of all settings over their times."""
    of = "bound of the L1 error" if verdict.measure == PRESSURE else "the largest bound of a number"
    seconds = xr.DataArray(
        [result.seconds for result in verdict.settings], name="time",
        attrs={"units": "s", "long_name": "processor time of a solve"},
    )  # fmt: skip
    unit, across = scaled(seconds)
    fig, (ax,) = panels(1, width=WIDTH, height=5.0)
    styles = ("-", "--", ":", "-.", (0, (1, 3)), (0, (5, 1, 1, 1, 1, 1)))
    lines: dict[str, list[Measured]] = {}
    for result in sorted(verdict.settings, key=lambda result: result.setting.cells):
        if isfinite(verdict.bound(result)):
            lines.setdefault(result.setting.label, []).append(result)
    drawn, best = Counter[str](), verdict.best()
    for label, line in lines.items():
        name = label.partition(",")[0]
        style: dict[str, Any] = padding_style(name) | {"ls": styles[drawn[name] % len(styles)]}
        drawn[name] += 1
        width = {"lw": 3.0, "ms": 7, "zorder": 4} if label == verdict.own else {"lw": 1.0, "ms": 4}
        times = np.array([result.seconds for result in line]) / unit
        bounds = 100 * np.array([verdict.bound(result) for result in line])
        shown = {*pareto_front(times, bounds), *(k for k, result in enumerate(line) if result is best)}
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


def _row(verdict: Verdict, result: Measured) -> tuple[str, ...]:
    """Return padding, grid, tolerance, bound, difference and time of a setting."""
    setting = result.setting
    return (
        padding_name(setting.label), cells_text(setting.cells), tolerance_text(setting.tolerance),
        percent(verdict.bound(result)), percent(result.difference), seconds_text(result.seconds),
    )  # fmt: skip


HEAD = ("padding", "grid", "tolerance", "error at most", "difference", "time")


def _fastest(verdict: Verdict) -> Table:
    """Return the fastest setting for the requested error, and for others that settings which were tried keep."""
    errors = sorted({*DECADES, verdict.error}, reverse=True)
    chosen = [(error, result) for error in errors if (result := verdict.best(error)) is not None]
    rows = [
        (percent(error), *_row(verdict, result))
        for k, (error, result) in enumerate(chosen)
        # a setting that also keeps a smaller error stands there alone
        if error == verdict.error or k + 1 == len(chosen) or chosen[k + 1][1] is not result
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
    same_cells = [
        result for result in verdict.settings
        if (result.setting.cells, result.setting.tolerance) == (chosen.cells, chosen.tolerance)
    ] or [result for result in verdict.settings if result.setting.cells == chosen.cells]  # fmt: skip
    rows = sorted(same_cells, key=lambda result: result.seconds)
    return Table(
        f"Every padding on {cells_text(chosen.cells)}: the bound of its error, and the measured L1 difference of its "
        f"pressure to {verdict.reference}.",
        HEAD,
        tuple(_row(verdict, result) for result in rows),
    )
