"""Drawings of the studies of cost: speed, and other programs."""

from itertools import cycle, product

import numpy as np
import xarray as xr

from studies.definitions.speed import LINE, ROUGH, SELF_AFFINE
from studies.model.drawing import CaptionedFigure, Drawing, Finding
from studies.model.outcome import CaseStatus
from studies.model.plain_text import thread_count
from studies.reference.line_contact import total_time
from studies.report.style import (
    COLORS,
    LAW_STYLE,
    by_color,
    captioned,
    panels,
    percent,
    tick_cells,
)

LINES = ("-", "--", ":", "-.")


# speed


FAMILY = ("hurst", "cut_off", "fraction")
WAYS = ("precision", "device", "threads")
FIRST = dict.fromkeys(WAYS, 0)
LABELS = {
    "solve_time": "wall time to solve [s]",
    "iterations": "iterations",
    "transform_ratio": "time over that of bare transforms",
}


def _speed_figures(dataset: xr.Dataset) -> tuple[CaptionedFigure, ...]:
    """Draw time, iterations and the ratio to bare transforms against the grid, a line for each surface."""
    fig, axes = panels(len(LABELS))
    cells = dataset["grid"].values
    surfaces = list(zip(_surfaces(dataset).items(), cycle(COLORS), strict=False))
    ways = list(zip(_ways(dataset).items(), cycle(LINES), strict=False))
    for ax, (variable, title) in zip(axes, LABELS.items(), strict=True):
        for ((name, surface), color), ((way, chosen), line) in product(surfaces, ways):
            if variable == "iterations" and chosen["threads"] != dataset["threads"].values[0]:
                continue  # it does not depend on the threads
            curve = dataset[variable].sel(surface | chosen)
            label = f"{name}{way}"
            ax.plot(dataset["grid"], curve, line, color=color, marker="o", label=label)
        if variable == "solve_time":
            least = float(dataset[variable].isel(grid=0).min())
            ax.plot(cells, least * (cells / cells[0]) ** 2, label="N²", **LAW_STYLE)
            ax.set(yscale="log")
        else:
            ax.set_ylim(bottom=0)
        ax.set(xscale="log", xlabel="cells N across, and along but for a line", ylabel=title)
        tick_cells(ax, cells)
    return (captioned("speed", fig, _speed_caption(dataset)),)


def _surfaces(dataset: xr.Dataset) -> dict[str, dict[str, object]]:
    """Return the selection of each surface, by its name, which tells the values of axes that have several."""
    selections: dict[str, dict[str, object]] = {}
    for surface in dataset["surface"].values.tolist():
        count = None if surface == SELF_AFFINE else 1
        for values in product(*(dataset[axis].values.tolist()[:count] for axis in FAMILY)):
            chosen = dict(zip(FAMILY, values, strict=True))
            words = {
                "hurst": f", H = {chosen['hurst']:g}",
                "cut_off": f", down to {chosen['cut_off']:g} cells",
                "fraction": f", {percent(chosen['fraction'])} in contact",
            }
            varied = [words[axis] for axis in FAMILY if count is None and dataset.sizes[axis] > 1]
            selections[f"{surface}{''.join(varied)}"] = {"surface": surface, **chosen}
    return selections


def _ways(dataset: xr.Dataset) -> dict[str, dict[str, object]]:
    """Return the selections of precision, device and threads, with the text that follows the name of a surface."""
    precisions, devices, threads = (dataset[axis].values.tolist() for axis in WAYS)
    selections: dict[str, dict[str, object]] = {}
    for precision, device, count in product(precisions, devices, threads):
        words = [precision] * (len(precisions) > 1)
        words += [device] * (len(devices) > 1)
        words += [thread_count(count)] * (len(threads) > 1 and device == "cpu")
        chosen = {"precision": precision, "device": device, "threads": count}
        selections.setdefault("".join(f", {word}" for word in words), chosen)
    return selections


def _speed_caption(dataset: xr.Dataset) -> str:
    finest = dataset.isel(FIRST | {"grid": -1})
    shortest = " or ".join(f"{cells:g}" for cells in dataset["cut_off"].values)
    on_cpu = finest["device"] == "cpu"
    device = thread_count(finest["threads"]) if on_cpu else "a GPU"
    facts = [
        f"{name}: {int(part['iterations'])} iterations in {float(part['solve_time']):.2g} s, "
        f"{percent(part['contact_fraction'])} in contact, {float(part['memory']):.0f} fields of host memory"
        for name, part in _each(finest)
    ]
    return (
        f"Cost of a solve against the grid, without set-up. {ROUGH.capitalize()} is a rough cylinder, semi-periodic, "
        f"the same surface on every grid; a {LINE} is a smooth cylinder with one cell along; a "
        "self-affine one is flat, periodic along both axes, and has waves down "
        f"to {shortest} cells of every grid. At {int(finest['grid'])} x {int(finest['grid'])} cells, on "
        f"{device}, {'; '.join(facts)}. Bare transforms are as many as the solve takes, of the full grid."
    )


def _each(dataset: xr.Dataset) -> list[tuple[str, xr.Dataset]]:
    return [(name, dataset.sel(chosen)) for name, chosen in _surfaces(dataset).items()]


def _speed_findings(dataset: xr.Dataset) -> tuple[Finding, ...]:
    """Return how the cost grows, and the time that threads save."""
    if dataset.sizes["grid"] < 2 or (dataset["case_status"] != CaseStatus.OK).any():
        return ()
    first, last = dataset.isel(grid=0), dataset.isel(grid=-1)
    growth = float((last["iterations"] / first["iterations"]).max())
    facts = "; ".join(
        f"{name}: {int(part['iterations'][0])} to {int(part['iterations'][-1])}"
        for name, part in _each(dataset.isel(FIRST))
    )
    ratio = last["transform_ratio"].isel(FIRST)
    measured = (
        f"Iterations from {int(first['grid'])} to {int(last['grid'])} cells across: {facts}. At "
        f"{int(last['grid'])} cells a solve takes {float(ratio.min()):.1f} to {float(ratio.max()):.1f} times the "
        "time of its bare transforms"
    )
    threads = dataset["threads"].values.tolist()
    if len(threads) > 1 and str(dataset["device"].values[0]) == "cpu":
        times = last["solve_time"].isel(precision=0, device=0)
        faster = times.isel(threads=0) / times.isel(threads=-1)
        measured += (
            f", and is {float(np.min(faster)):.1f} to {float(np.max(faster)):.1f} times as fast on "
            f"{thread_count(threads[-1])} as on {thread_count(threads[0])} of this machine"
        )
    claim = (
        f"From {int(first['grid'])} to {int(last['grid'])} cells across, the number of iterations"
    )
    grows = f"grows by a factor of at most {growth:.1f}" if growth >= 1.05 else "does not grow"
    return (Finding(f"{claim} {grows}.", f"{measured}.", "How does the cost grow?"),)


speed = Drawing(_speed_figures, _speed_findings)


# peers


def _peers_figures(dataset: xr.Dataset) -> tuple[CaptionedFigure, ...]:
    """Draw the total time against the grid, a panel for each boundary."""
    boundaries = dataset["boundary"].values.tolist()
    fig, axes = panels(len(boundaries), share="y")
    threads = dataset["threads"].values.tolist()
    facts = []
    for ax, boundary in zip(axes, boundaries, strict=True):
        for part, style in by_color(dataset.sel(boundary=boundary), "program", "{}"):
            for count, line in zip(threads, cycle(LINES), strict=False):
                chosen = part.sel(threads=count)
                time = total_time(chosen)
                if not np.isfinite(time).any():
                    continue
                program = str(part["program"].values)
                name = program if len(threads) == 1 else f"{program}, {thread_count(count)}"
                ax.loglog(time["grid"], time, **style | {"linestyle": line, "label": name})
                facts.append(
                    f"{boundary}, {name} {float(time[-1]):.2g} s with a difference of "
                    f"{float(chosen['difference'][-1]):.0e}"
                )
        ax.set(title=boundary, xlabel="cells across and along")
        tick_cells(ax, dataset["grid"].values)
    axes[0].set_ylabel("wall time, set-up and solve [s]")
    caption = (
        f"Total time on {' or '.join(map(thread_count, threads))}. At {int(dataset['grid'][-1])} cells: "
        f"{'; '.join(facts)}. The difference is the largest one from the converged solution for cells of constant "
        "pressure. On periodic surfaces the other programs represent the pressure as a sum of waves, which is "
        "another discretisation and not an error."
    )
    return (captioned("peers", fig, caption),)


peers = Drawing(_peers_figures)
