"""The comparison of a scene's settings: the price of accuracy, what each padding does, and what each grid does."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf, isfinite
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from studies.advice.comparison import LINE, Comparison, Measured, Verdict, label_of, mode_of
from studies.advice.subject import REPORTED
from studies.model.drawing import CaptionedFigure, Finding, Table
from studies.report.style import (
    WIDTH,
    captioned,
    in_percent,
    padding_style,
    panels,
    percent,
    tick_cells,
    write_powers,
)
from studies.report.wording import (
    DECADES,
    cells_text,
    enumerated,
    error_text,
    padding_name,
    reported_quantities,
    rivals_text,
    seconds_text,
    title_text,
    tolerance_text,
    verdict_text,
)

# Relative changes below this count as zero.
ZERO_CHANGE = 5e-7
# Difference of two labels over the height of the axes, below which they would touch.
LABEL_DISTANCE = 0.04


@dataclass(frozen=True, eq=False)
class Part:
    """A question with its answer: what is drawn, said and listed of it."""

    name: str
    title: str
    findings: Sequence[Finding]
    figures: Sequence[CaptionedFigure]
    tables: Sequence[Table]


def parts(measured: Comparison) -> Sequence[Part]:
    """Return the price of accuracy, what each padding and each grid does, and what errors are against."""
    verdict = measured.verdict()
    if verdict is None:
        return ()
    claim = Finding(
        verdict_text(measured, verdict), rivals_text(measured, verdict), "Which setting?"
    )
    costs = _costs(measured)
    price = Part(
        "settings",
        "The price of accuracy",
        [claim],
        [_front(measured, verdict)],
        [costs] if costs.rows else [],
    )
    about = Part("reference", "What the errors are against", [_reference(measured)], [], [])
    if not measured.paddings:
        return price, about
    causes = Part(
        "paddings",
        "What each padding does, and what each grid does",
        [_which_n(measured, verdict)],
        [_causes(measured, verdict)],
        [_changes(measured)],
    )
    return price, causes, about


def _style(label: str) -> dict[str, Any]:
    """Return colour and marker of a padding; n changes the shade of a line by its width alone."""
    return padding_style("line" if label == LINE else label.partition(",")[0])


def _front(measured: Comparison, verdict: Verdict) -> CaptionedFigure:
    """Draw errors over times, with the verdict as the title."""
    fig, (ax,) = panels(1, width=WIDTH, height=5.2)
    best = verdict.best
    ends: list[tuple[float, float, str]] = []
    for label in reversed(measured.labels):
        line = measured.of(label)
        if not line:
            continue
        is_own = label == measured.own_label
        style = _style(label) | ({"lw": 3.0, "ms": 7, "zorder": 4} if is_own else {"lw": 1.0})
        front = measured.front(label) or line
        times, errors = [setting.time for setting in front], [setting.error for setting in front]
        ax.loglog(times, errors, **style, markevery=[setting.is_bounded for setting in front])
        beaten = [setting for setting in line if setting.is_bounded and setting not in front]
        ax.loglog(
            [setting.time for setting in beaten], [setting.error for setting in beaten],
            **style | {"ls": "none", "ms": 3, "alpha": 0.5},
        )  # fmt: skip
        hollow = [setting for setting in line if not setting.is_bounded]
        ax.loglog(
            [setting.time for setting in hollow], [setting.error for setting in hollow],
            **style | {"ls": "none", "markerfacecolor": "white"},
        )  # fmt: skip
        ends.append((times[-1], errors[-1], label))
        if is_own:
            _label_cells(ax, front, style["color"])
    errors = [setting.error for setting in measured.settings]
    lowest = min(min(errors), verdict.error) / 2
    if isfinite(measured.floor) and measured.floor > 0:
        lowest = min(lowest, measured.floor / 1.8)
        ax.axhspan(lowest, measured.floor, color="0.87", zorder=0)
        ax.text(
            0.01, measured.floor / 1.06, "bound on the error of the reference: not decidable below",
            transform=ax.get_yaxis_transform(), va="top", fontsize="small", color="0.35",
        )  # fmt: skip
    ax.axhline(verdict.error, color="k", ls="--", lw=1.2)
    ax.text(
        0.99, verdict.error * 1.04, f"requested {percent(verdict.error)}",
        transform=ax.get_yaxis_transform(), ha="right", va="bottom", fontsize="small",
    )  # fmt: skip
    ax.plot(best.time, best.error, "o", ms=19, mfc="none", mec="k", mew=1.8, zorder=6)
    ax.set_ylim(lowest, 1.6 * max(errors))
    _label_ends(ax, ends, measured.own_label)
    ax.set(
        xlabel="processor time to pose and solve, on one thread", ylabel="L1 error of the pressure"
    )
    write_powers(ax.xaxis, seconds_text)
    write_powers(ax.yaxis, in_percent)
    ax.set_title(title_text(measured, verdict), loc="left")
    scene_padding = padding_name(measured.own_label)
    return captioned(
        "front",
        fig,
        f"The price of accuracy for {measured.name}. Each line is one padding on ever finer grids; the thick one is "
        f"{scene_padding}, the boundary of the scene itself, with its cells. Small marks: settings that another of the "
        f"line beats. A line that becomes horizontal has reached the "
        "error of its padding, which no grid removes. The ring is the verdict. "
        + (
            "Hollow marks: the solution itself gives no bound on its error, and is never recommended. "
            if not all(setting.is_bounded for setting in measured.settings)
            else ""
        )
        + "Errors are the largest of this and any finer grid.",
    )


def _label_cells(ax: Axes, line: Sequence[Measured], color: str) -> None:
    """Write the cells beside every second mark of the own boundary, from the finest."""
    for setting in line[::-2]:
        across, along = setting.setting.cells
        ax.annotate(
            f"{across} x {along}", (setting.time, setting.error), (-7, -4), textcoords="offset points",
            ha="right", va="top", fontsize="small", color=color, zorder=5,
            bbox={"facecolor": "white", "alpha": 0.7, "linewidth": 0, "pad": 0.5},
        )  # fmt: skip


def _label_ends(ax: Axes, ends: Sequence[tuple[float, float, str]], scene_padding: str) -> None:
    """Write the names of the lines at the right, in their colours, without overlap."""
    ends = sorted(ends, key=lambda end: (end[1], end[2]))
    low, high = np.log(ax.get_ylim())
    heights = [(np.log(error) - low) / (high - low) for _, error, _ in ends]
    for _ in range(200):  # push overlapping labels apart
        for k in range(len(ends) - 1):
            lacking = max(0.0, LABEL_DISTANCE - (heights[k + 1] - heights[k]))
            heights[k] -= lacking / 2
            heights[k + 1] += lacking / 2
    for (time, error, label), height in zip(ends, heights, strict=True):
        color = _style(label)["color"]
        ax.annotate(
            label, (time, error), (1.02, height), textcoords="axes fraction", xycoords="data",
            ha="left", va="center", fontsize="small", color=color,
            weight="bold" if label == scene_padding else "normal",
            arrowprops={"arrowstyle": "-", "color": color, "lw": 0.6, "shrinkA": 0},
        )  # fmt: skip


def _causes(measured: Comparison, verdict: Verdict) -> CaptionedFigure:
    """Draw the error of each padding alone over n, beside the errors by cells and by tolerance."""
    fig, (padding_panel, cells_panel) = panels(2, width=WIDTH / 2, height=3.9)
    modes: dict[str, list[tuple[int, float]]] = {}
    for item in measured.paddings:
        mode, images = mode_of(item.padding)
        modes.setdefault(mode, []).append((images, item.l1))
    max_images = max((images for points in modes.values() for images, _ in points), default=1)
    for mode, points in modes.items():
        n, errors = np.array(sorted(points)).T
        if len(points) > 1:
            padding_panel.loglog(n + 0.5, errors, label=mode, **padding_style(mode))
        else:
            style = padding_style(mode) | {"marker": "none", "ls": "-."}
            padding_panel.loglog([1, max_images + 0.5], 2 * [errors[0]], label=mode, **style)
    scene_settings = [item for item in measured.of(measured.own_label) if item.is_bounded]
    labelled = inf
    for grid in scene_settings:
        if grid.error > labelled / 2:
            continue
        labelled = grid.error
        _level(padding_panel, grid.error, "{} x {}".format(*grid.setting.cells))
    padding_panel.set(
        xlabel="n, at n + ½",
        ylabel="L1 error by the padding alone",
        title="Which n: where its line crosses a grid's error",
    )
    line = measured.of(measured.own_label)
    style = _style(measured.own_label)
    cells = [item.setting.cells[0] for item in line]
    cells_panel.loglog(cells, [item.error for item in line], label="cells", **style)
    hollow = [k for k, item in enumerate(line) if not item.is_bounded]
    cells_panel.loglog(
        [cells[k] for k in hollow], [line[k].error for k in hollow],
        **style | {"ls": "none", "markerfacecolor": "white"},
    )  # fmt: skip
    for tolerance, error in measured.tolerances.items():
        if error > 0.02 * min(item.error for item in line):
            _level(cells_panel, error, f"tol. {tolerance_text(tolerance)}")
    cells_panel.axhline(verdict.error, color="k", ls="--", lw=1.0)
    cells_panel.set(
        xlabel="cells across",
        ylabel="L1 error of the pressure",
        title=f"Which grid: {padding_name(measured.own_label)}",
    )
    write_powers(padding_panel.yaxis, in_percent)
    write_powers(cells_panel.yaxis, in_percent)
    counted = sorted({n for points in modes.values() if len(points) > 1 for n, _ in points})
    tick_cells(padding_panel, counted, 0.5)
    tick_cells(cells_panel, cells[::-2])
    on = cells_text(measured.paddings_on)
    return captioned(
        "causes",
        fig,
        f"Left: what each padding alone does to the pressure, against {padding_name(measured.own_label)} on the same "
        f"{on}, where the error by the cells cancels; dotted: the errors of some grids. A padding whose line lies "
        "below the error of the grid costs no accuracy. Right: the error by the cells, and (dotted) that of some "
        f"tolerances on {on}.",
    )


def _level(ax: Axes, error: float, text: str) -> None:
    """Draw an error as a dotted line, with a text at its right."""
    ax.axhline(error, color="0.5", ls=":", lw=1.0)
    ax.annotate(
        text, (1.0, error), (3, 0), xycoords=ax.get_yaxis_transform(), textcoords="offset points",
        va="center", fontsize="x-small", color="0.4",
    )  # fmt: skip


def _which_n(measured: Comparison, verdict: Verdict) -> Finding:
    """State the least n at which a moving window costs no accuracy, and which paddings always cost some."""
    allowed = max(verdict.best.error, verdict.error / 10) / 3
    enough = [item for item in measured.paddings if item.l1 <= allowed]
    counted = sorted(
        mode_of(item.padding)[1] for item in enough if mode_of(item.padding)[0] == "circular"
    )
    worst = [label_of(item.padding) for item in measured.paddings if item.l1 > verdict.error]
    is_free = measured.own_label == "free"
    if is_free:
        least = min(measured.paddings, key=lambda item: item.l1)
        claim = f"The ends are free: every periodic padding is {percent(least.l1)} wrong or more, at any n."
    elif counted:
        claim = f"If images must be counted, n = {counted[0]} in a moving window suffices."
    else:
        max_images = max((mode_of(item.padding)[1] for item in measured.paddings), default=0)
        claim = f"No n that was tried suffices, up to {max_images}."
    beyond = "" if is_free or not worst else (
        f" Above the request of {percent(verdict.error)} on any grid: {', '.join(worst)}."
    )  # fmt: skip
    on = cells_text(measured.paddings_on)
    text = (
        f"A padding counts as good enough if it adds at most a third of the grid's error, {percent(allowed)}. The "
        f"table has what each does alone on {on}.{beyond}"
    )
    if is_free:
        text = f"They add neighbours that the scene does not have. The table has what each does alone on {on}."
    return Finding(claim, text, "Which n?")


def _reference(measured: Comparison) -> Finding:
    """State the reference of the errors, and what was left out."""
    if measured.reference is None:
        claim = "Errors are against Hertz's contact, which is exact here."
        text = "The measure is the L1 norm of the difference to the means of his pressure over each cell."
    else:
        bound = (
            f"its own bound is {percent(measured.floor)}, below which nothing is claimed"
            if measured.floor < inf
            else "its own error has no bound, so that nothing is claimed"
        )
        claim = f"Errors are against {cells_text(measured.reference)} at the scene's own boundary; {bound}."
        unknown = [
            REPORTED[name]
            for name, bound in measured.bounds.items()
            if bound == inf and name in REPORTED
        ]
        text = (
            "The measure is the L1 norm of the difference to the reference's means over each cell."
        )
        if unknown:
            text += f" Without a bound even there: {', '.join(unknown)}."
    return Finding(claim, " ".join([text, *measured.notes]), "Against what?")


def _costs(measured: Comparison) -> Table:
    """Return the quickest setting for each decade, with the next best padding."""
    rows = []
    reached = min(
        (setting.error for setting in measured.settings if setting.is_bounded), default=inf
    )
    for target in DECADES:
        verdict = measured.verdict(target)
        if verdict is None or not verdict.meets:
            continue
        best = verdict.best
        other_labels = [
            label for label in measured.labels if label != best.label and measured.of(label)
        ]
        rival_shown = min(verdict.rivals, key=lambda rival: rival.ratio, default=None)
        finest = {label: measured.of(label)[-1].setting.cells[0] for label in other_labels}
        is_judged = finest and min(finest.values()) >= best.setting.cells[0]
        beside = "none meets it" if is_judged else "not timed on such grids"
        if rival_shown is not None:
            took = "as fast" if rival_shown.is_tie else f"{rival_shown.ratio:.2g} times"
            took += ", not decided" * (not rival_shown.is_tie and not rival_shown.is_shown)
            beside = f"{rival_shown.measured.label}: {took}"
        rows.append(
            (
                percent(target),
                best.label,
                cells_text(best.setting.cells),
                tolerance_text(best.setting.tolerance),
                error_text(best.error, measured.floor),
                seconds_text(best.time),
                beside,
            )
        )
    # a setting that also meets a smaller error stands there alone
    rows = [row for k, row in enumerate(rows) if k + 1 == len(rows) or row[1:4] != rows[k + 1][1:4]]
    left_out = (
        f" Smaller errors are not listed: no setting is shown to reach them; the least error measured is "
        f"{error_text(reached, measured.floor)}."
        if reached < inf
        else ""
    )
    return Table(
        "The quickest setting for each error, by the median of its processor times on one thread; paddings within a "
        "tenth are a tie, which goes to the scene's own boundary. A setting that meets a smaller error too is listed "
        f"there alone.{left_out}",
        ("error at most", "padding", "grid", "tolerance", "measured", "time", "next padding"),
        tuple(rows),
    )


def _changes(measured: Comparison) -> Table:
    """Return what each padding alone does to the main numbers."""
    quantities = reported_quantities(measured)
    names = [
        (name, long_name)
        for name, long_name in quantities
        if any(abs(padding.changes.get(name, inf)) >= ZERO_CHANGE for padding in measured.paddings)
    ]

    def signed(value: float) -> str:
        sign = "+" if value > 0 else "−"
        return "0" if abs(value) < ZERO_CHANGE else f"{sign}{percent(value)}"

    rows = tuple(
        (
            label_of(item.padding),
            percent(item.l1),
            *(
                signed(item.changes[name]) if name in item.changes else "not known"
                for name, _ in names
            ),
        )
        for item in measured.paddings
    )
    no_bound = [long_name for name, long_name in names if measured.bounds.get(name) == inf]
    text = f" The reference has no bound on its own {enumerated(no_bound)}." if no_bound else ""
    if omitted := [long_name for name, long_name in quantities if (name, long_name) not in names]:
        text += f" No padding changes the {enumerated(omitted)}."
    return Table(
        f"What each padding alone does, against {padding_name(measured.own_label)} on "
        f"{cells_text(measured.paddings_on)}: the L1 error of the pressure, and the change of each number.{text}",
        ("padding", "pressure in L1", *(long_name for _, long_name in names)),
        rows,
    )
