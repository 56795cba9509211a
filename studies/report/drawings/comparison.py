"""The comparison of a scene's settings: the price of accuracy, what each padding does, and what each grid does."""

from collections.abc import Sequence
from math import inf, isfinite
from operator import attrgetter
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from studies.advice.compared_scene import REPORTED
from studies.advice.comparison import (
    LINE,
    Comparison,
    MeasuredSetting,
    Verdict,
    label_of,
    name_and_images,
)
from studies.advice.stored import SETTINGS
from studies.model.drawing import CaptionedFigure, Finding, Table
from studies.report.section import Section
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
    alternatives_text,
    cells_text,
    enumerated,
    error_text,
    padding_name,
    reported_quantities,
    seconds_text,
    title_text,
    tolerance_text,
    verdict_text,
)

# Relative changes below this count as zero.
ZERO_CHANGE = 5e-7
# Difference of two labels over the height of the axes, below which they would touch.
LABEL_DISTANCE = 0.04
# Marks of settings without a bound.
HOLLOW = {"ls": "none", "markerfacecolor": "white"}


def sections(comparison: Comparison) -> Sequence[Section]:
    """Return the price of accuracy, what each padding and each grid does, and what errors are against."""
    verdict = comparison.verdict()
    if verdict is None:
        return ()
    claim = Finding(
        verdict_text(comparison, verdict), alternatives_text(comparison, verdict), "Which setting?"
    )
    costs = _costs(comparison)
    tables = [costs] if costs.rows else []
    figures = [_front(comparison, verdict)]
    parts = [Section(SETTINGS, "The price of accuracy", [claim], figures, tables)]
    if comparison.paddings:
        title = "What each padding does, and what each grid does"
        finding, figure = _which_n(comparison, verdict), _causes(comparison, verdict)
        parts.append(
            Section("paddings", title, [finding], [figure], [_changes(comparison)], file=SETTINGS)
        )
    against = _reference(comparison)
    return [
        *parts,
        Section("reference", "What the errors are against", [against], [], [], file=SETTINGS),
    ]


def _style(label: str) -> dict[str, Any]:
    """Return colour and marker of a padding, the same for every n."""
    return padding_style("line" if label == LINE else label.partition(",")[0])


def _front(comparison: Comparison, verdict: Verdict) -> CaptionedFigure:
    """Draw errors over times, with the verdict as the title."""
    fig, (ax,) = panels(1, width=WIDTH, height=5.2)
    best = verdict.best
    ends: list[tuple[float, float, str]] = []
    for label in reversed(comparison.labels):
        line = comparison.settings_of(label)
        if not line:
            continue
        is_own = label == comparison.boundary_label
        style = _style(label) | ({"lw": 3.0, "ms": 7, "zorder": 4} if is_own else {"lw": 1.0})
        front = comparison.front(label) or line
        dominated = [setting for setting in line if setting.is_bounded and setting not in front]
        unbounded = [setting for setting in line if not setting.is_bounded]
        for settings, marks in (
            (front, {"markevery": [setting.is_bounded for setting in front]}),
            (dominated, {"ls": "none", "ms": 3, "alpha": 0.5}),
            (unbounded, HOLLOW),
        ):
            times, errors = [item.time for item in settings], [item.error for item in settings]
            ax.loglog(times, errors, **style | marks)
        ends.append((front[-1].time, front[-1].error, label))
        if is_own:
            _label_cells(ax, front, style["color"])
    errors = [setting.error for setting in comparison.settings]
    lowest = min(min(errors), verdict.error) / 2
    if isfinite(comparison.reference_bound) and comparison.reference_bound > 0:
        lowest = min(lowest, comparison.reference_bound / 1.8)
        ax.axhspan(lowest, comparison.reference_bound, color="0.87", zorder=0)
        ax.text(
            0.01, comparison.reference_bound / 1.06, "bound on the error of the reference: not decidable below",
            transform=ax.get_yaxis_transform(), va="top", fontsize="small", color="0.35",
        )  # fmt: skip
    ax.axhline(verdict.error, color="k", ls="--", lw=1.2)
    ax.text(
        0.99, verdict.error * 1.04, f"requested {percent(verdict.error)}",
        transform=ax.get_yaxis_transform(), ha="right", va="bottom", fontsize="small",
    )  # fmt: skip
    ax.plot(best.time, best.error, "o", ms=19, mfc="none", mec="k", mew=1.8, zorder=6)
    ax.set_ylim(lowest, 1.6 * max(errors))
    _label_ends(ax, ends, comparison.boundary_label)
    ax.set(
        xlabel="processor time of set-up and solve, on one thread",
        ylabel="L1 error of the pressure",
    )
    write_powers(ax.xaxis, seconds_text)
    write_powers(ax.yaxis, in_percent)
    ax.set_title(title_text(comparison, verdict), loc="left")
    scene_padding = padding_name(comparison.boundary_label)
    hollow = "Hollow marks: neither the solution nor a coarser one has a bound on its error; none is recommended. "
    return captioned(
        "front",
        fig,
        f"The price of accuracy for {comparison.name}. Each line is one padding on ever finer grids; the thick one is "
        f"{scene_padding}, the boundary of the scene itself, with its cells. Small marks: dominated "
        "settings of the same padding. A line ends horizontally at the error of its padding, which finer grids do not "
        "reduce. The ring is the verdict. "
        + hollow * (not all(setting.is_bounded for setting in comparison.settings))
        + "Errors are the largest of this and any finer grid.",
    )


def _label_cells(ax: Axes, line: Sequence[MeasuredSetting], color: str) -> None:
    """Write the cells beside every second mark of the scene's own padding, from the finest."""
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


def _causes(comparison: Comparison, verdict: Verdict) -> CaptionedFigure:
    """Draw the error of each padding alone over n, beside the errors by cells and by tolerance."""
    fig, (padding_panel, cells_panel) = panels(2, width=WIDTH / 2, height=3.9)
    by_padding: dict[str, list[tuple[int, float]]] = {}
    for item in comparison.paddings:
        name, images = name_and_images(item.padding)
        by_padding.setdefault(name, []).append((images, item.l1))
    max_images = max((images for points in by_padding.values() for images, _ in points), default=1)
    for name, points in by_padding.items():
        n, errors = np.array(sorted(points)).T
        if len(points) > 1:
            padding_panel.loglog(n + 0.5, errors, label=name, **padding_style(name))
        else:
            style = padding_style(name) | {"marker": "none", "ls": "-."}
            padding_panel.loglog([1, max_images + 0.5], 2 * [errors[0]], label=name, **style)
    line, labelled = comparison.settings_of(comparison.boundary_label), inf
    for grid in line:
        if grid.is_bounded and grid.error <= labelled / 2:
            labelled = grid.error
            _level(padding_panel, grid.error, "{} x {}".format(*grid.setting.cells))
    padding_panel.set(
        xlabel="n, at n + ½",
        ylabel="L1 error by the padding alone",
        title="Which n: where its line crosses a grid's error",
    )
    style = _style(comparison.boundary_label)
    cells = [item.setting.cells[0] for item in line]
    cells_panel.loglog(cells, [item.error for item in line], label="cells", **style)
    unbounded = [k for k, item in enumerate(line) if not item.is_bounded]
    errors = [line[k].error for k in unbounded]
    cells_panel.loglog([cells[k] for k in unbounded], errors, **style | HOLLOW)
    for tolerance, error in comparison.tolerances.items():
        if error > 0.02 * min(item.error for item in line):
            _level(cells_panel, error, f"tol. {tolerance_text(tolerance)}")
    cells_panel.axhline(verdict.error, color="k", ls="--", lw=1.0)
    cells_panel.set(
        xlabel="cells across",
        ylabel="L1 error of the pressure",
        title=f"Which grid: {padding_name(comparison.boundary_label)}",
    )
    write_powers(padding_panel.yaxis, in_percent)
    write_powers(cells_panel.yaxis, in_percent)
    counted = sorted({n for points in by_padding.values() if len(points) > 1 for n, _ in points})
    tick_cells(padding_panel, counted, 0.5)
    tick_cells(cells_panel, cells[::-2])
    on = cells_text(comparison.paddings_on)
    return captioned(
        "causes",
        fig,
        f"Left: error of the pressure by each padding alone, against {padding_name(comparison.boundary_label)} on the "
        f"same {on}, where the discretisation error cancels; dotted: the errors of some grids. A padding whose line "
        "lies below the error of the grid costs no accuracy. Right: the discretisation error, and (dotted) that of some "
        f"tolerances on {on}.",
    )


def _level(ax: Axes, error: float, text: str) -> None:
    """Draw an error as a dotted line, with a text at its right."""
    ax.axhline(error, color="0.5", ls=":", lw=1.0)
    ax.annotate(
        text, (1.0, error), (3, 0), xycoords=ax.get_yaxis_transform(), textcoords="offset points",
        va="center", fontsize="x-small", color="0.4",
    )  # fmt: skip


def _which_n(comparison: Comparison, verdict: Verdict) -> Finding:
    """State the least n at which a moving window costs no accuracy, and which paddings always cost some."""
    allowed = max(verdict.best.error, verdict.error / 10) / 3
    enough = [item for item in comparison.paddings if item.l1 <= allowed]
    named = [name_and_images(item.padding) for item in enough]
    counted = sorted(images for name, images in named if name == "circular")
    worst = [label_of(item.padding) for item in comparison.paddings if item.l1 > verdict.error]
    is_free = comparison.boundary_label == "free"
    if is_free:
        least = min(comparison.paddings, key=lambda item: item.l1)
        claim = f"The ends are free: every periodic padding has an error of {percent(least.l1)} or more, at any n."
    elif counted:
        claim = f"If images must be counted, n = {counted[0]} in a moving window suffices."
    else:
        images = [name_and_images(item.padding)[1] for item in comparison.paddings]
        claim = f"No n that was tried suffices, up to {max(images, default=0)}."
    beyond = "" if is_free or not worst else (
        f" Above the request of {percent(verdict.error)} on any grid: {', '.join(worst)}."
    )  # fmt: skip
    on = cells_text(comparison.paddings_on)
    text = (
        "A padding counts as good enough if it adds at most a third of the grid's error, or of a tenth of the request, "
        f"{percent(allowed)}. The table has what each does alone on {on}.{beyond}"
    )
    if is_free:
        text = f"They add neighbours that the scene does not have. The table has what each does alone on {on}."
    return Finding(claim, text, "Which n?")


def _reference(comparison: Comparison) -> Finding:
    """State the reference of the errors, and what was left out."""
    if comparison.reference is None:
        claim = "Errors are against Hertz's contact, which is exact here."
        text = "The measure is the L1 norm of the difference to the means of his pressure over each cell."
    else:
        bound = (
            f"its own bound is {percent(comparison.reference_bound)}, below which differences are not significant"
            if comparison.reference_bound < inf
            else "its own error has no bound, so that no difference is significant"
        )
        cells = cells_text(comparison.reference)
        claim = f"Errors are against {cells} under the scene's own boundary conditions; {bound}."
        infinite = [name for name, bound in comparison.bounds.items() if bound == inf]
        text = "The measure is the L1 norm of the difference to the reference's means in each cell."
        if unknown := [REPORTED[name] for name in infinite if name in REPORTED]:
            text += f" Without a bound even there: {', '.join(unknown)}."
    return Finding(claim, " ".join([text, *comparison.notes]), "Against what?")


def _costs(comparison: Comparison) -> Table:
    """Return the quickest setting for each decade, with the next best padding."""
    rows = []
    bounded = [setting.error for setting in comparison.settings if setting.is_bounded]
    for target in DECADES:
        verdict = comparison.verdict(target)
        if verdict is None or not verdict.meets:
            continue
        best = verdict.best
        next_best = min(verdict.alternatives, key=attrgetter("ratio"), default=None)
        others = [label for label in comparison.labels if label != best.label]
        lines = [comparison.settings_of(label) for label in others]
        finest = [line[-1].setting.cells[0] for line in lines if line]
        is_judged = finest and min(finest) >= best.setting.cells[0]
        beside = "none meets it" if is_judged else "not timed on such grids"
        if next_best is not None:
            took = "as fast" if next_best.is_as_fast else f"{next_best.ratio:.2g} times"
            took += ", not decided" * (not next_best.is_as_fast and not next_best.is_significant)
            beside = f"{next_best.measured.label}: {took}"
        rows.append(
            (
                percent(target),
                best.label,
                cells_text(best.setting.cells),
                tolerance_text(best.setting.tolerance),
                error_text(best.error, comparison.reference_bound),
                seconds_text(best.time),
                beside,
            )
        )
    # a setting that also meets a smaller error stands there alone
    rows = [row for k, row in enumerate(rows) if k + 1 == len(rows) or row[1:4] != rows[k + 1][1:4]]
    left_out = ""
    if bounded:
        least = error_text(min(bounded), comparison.reference_bound)
        left_out = f" Smaller errors are not listed: no setting is shown to reach them; the least measured is {least}."
    return Table(
        "The quickest setting for each error, by the median of its processor times on one thread; paddings within a "
        "tenth, or that the rounds do not decide, are a tie, which goes to the scene's own padding. A setting that "
        f"meets a smaller error too is listed there alone.{left_out}",
        ("error at most", "padding", "grid", "tolerance", "measured", "time", "next padding"),
        tuple(rows),
    )


def _changes(comparison: Comparison) -> Table:
    """Return what each padding alone does to the main numbers."""
    quantities = reported_quantities(comparison)
    changes = [padding.changes for padding in comparison.paddings]
    names = [
        (name, long_name)
        for name, long_name in quantities
        if any(abs(change.get(name, inf)) >= ZERO_CHANGE for change in changes)
    ]

    def signed(value: float | None) -> str:
        if value is None:
            return "not known"
        return "0" if abs(value) < ZERO_CHANGE else f"{'+' if value > 0 else '−'}{percent(value)}"

    rows = tuple(
        (
            label_of(item.padding),
            percent(item.l1),
            *(signed(item.changes.get(name)) for name, _ in names),
        )
        for item in comparison.paddings
    )
    no_bound = [long_name for name, long_name in names if comparison.bounds.get(name) == inf]
    text = f" The reference has no bound on its own {enumerated(no_bound)}." if no_bound else ""
    if omitted := [long_name for name, long_name in quantities if (name, long_name) not in names]:
        text += f" No padding changes the {enumerated(omitted)}."
    return Table(
        f"What each padding alone does, against {padding_name(comparison.boundary_label)} on "
        f"{cells_text(comparison.paddings_on)}: the L1 error of the pressure, and the change of each number.{text}",
        ("padding", "pressure in L1", *(long_name for _, long_name in names)),
        rows,
    )
