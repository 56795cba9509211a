"""Drawing of the study `speed`: figures, findings and tables from its stored data."""

from itertools import product

import numpy as np
import xarray as xr

from studies.definitions.cost.speed import ROUGH, SELF_AFFINE
from studies.model.drawing import CaptionedFigure, Finding
from studies.model.outcome import CaseStatus
from studies.model.plain_text import thread_count
from studies.report.formatting import percent
from studies.report.style import LAW_STYLE, add_legend, panels

COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
LINES = ("-", "--", ":", "-.")
FAMILY = ("hurst", "cut_off", "share")
WAYS = ("precision", "device", "threads")
FIRST = dict.fromkeys(WAYS, 0)
LABELS = {
    "solve_time": "wall time to solve [s]",
    "iterations": "iterations",
    "transform_ratio": "time over that of bare transforms",
}


def figure(dataset: xr.Dataset) -> tuple[CaptionedFigure, ...]:
    """Time, iterations and the ratio to bare transforms against the grid, a line for each surface."""
    cells = dataset["grid"].values
    fig, axes = panels(len(LABELS))
    for ax, (variable, label) in zip(axes, LABELS.items(), strict=True):
        values = dataset[variable]
        for number, (name, surface) in enumerate(_surfaces(dataset).items()):
            for line, (how, chosen) in enumerate(_ways(dataset).items()):
                style = {
                    "color": COLORS[number % len(COLORS)],
                    "linestyle": LINES[line % len(LINES)],
                    "marker": "o",
                }
                ax.semilogx(cells, values.sel(surface | chosen), label=f"{name}{how}", **style)
                if variable == "iterations":
                    break  # they are the same on any number of threads
        if variable == "solve_time":
            least = float(values.isel(grid=0).min())
            ax.semilogx(cells, least * (cells / cells[0]) ** 2, label="N²", **LAW_STYLE)
            ax.set_yscale("log")
        else:
            ax.set_ylim(bottom=0)
        ax.set(xlabel="cells N across and along", ylabel=label)
        ax.set_xticks(cells, [str(n) for n in cells])
        ax.minorticks_off()
    add_legend(fig)
    return (CaptionedFigure("speed", fig, _caption(dataset)),)


def _surfaces(dataset: xr.Dataset) -> dict[str, dict[str, object]]:
    """Where each surface is, by its name."""
    found: dict[str, dict[str, object]] = {}
    for surface in dataset["surface"].values.tolist():
        if surface == SELF_AFFINE:
            for values in product(*(dataset[axis].values.tolist() for axis in FAMILY)):
                chosen = dict(zip(FAMILY, values, strict=True))
                name = (
                    f"self-affine, H = {chosen['hurst']:g}, down to {chosen['cut_off']:g} cells, "
                    f"{percent(chosen['share'])}"
                )
                found[name] = {"surface": surface, **chosen}
        else:
            first = {axis: dataset[axis].values.tolist()[0] for axis in FAMILY}
            found[surface] = {"surface": surface, **first}
    return found


def _ways(dataset: xr.Dataset) -> dict[str, dict[str, object]]:
    """How a surface is solved, in words that follow its name; threads are those of the processor alone."""
    precisions, devices, threads = (dataset[axis].values.tolist() for axis in WAYS)
    found: dict[str, dict[str, object]] = {}
    for precision, device, count in product(precisions, devices, threads):
        words = [precision] * (len(precisions) > 1)
        words += [device] * (len(devices) > 1)
        words += [thread_count(count)] * (len(threads) > 1 and device == "cpu")
        chosen = {"precision": precision, "device": device, "threads": count}
        found.setdefault("".join(f", {word}" for word in words), chosen)
    return found


def _caption(dataset: xr.Dataset) -> str:
    finest = dataset.isel(FIRST | {"grid": -1})
    facts = [
        f"{name}: {int(one['iterations'])} iterations in {float(one['solve_time']):.2g} s, "
        f"{percent(one['contact_share'])} in contact, {float(one['memory']):.0f} fields of memory"
        for name, one in _each(finest)
    ]
    return (
        f"Cost of a solve against the grid, without set-up. {ROUGH.capitalize()} is a rough cylinder, semi-periodic, "
        "the same surface on every grid; a self-affine one is flat, periodic along both axes, and has waves down "
        f"to so many cells of every grid. At {int(finest['grid'])} x {int(finest['grid'])} cells, on "
        f"{_where(finest)}, {'; '.join(facts)}. Bare transforms are as many as the solve takes, of the full grid."
    )


def _where(one: xr.Dataset) -> str:
    return thread_count(one["threads"]) if one["device"] == "cpu" else "a graphics processor"


def _each(dataset: xr.Dataset) -> list[tuple[str, xr.Dataset]]:
    return [(name, dataset.sel(chosen)) for name, chosen in _surfaces(dataset).items()]


def findings(dataset: xr.Dataset) -> tuple[Finding, ...]:
    """How cost grows, and what threads save."""
    if dataset.sizes["grid"] < 2 or not (dataset["case_status"] == CaseStatus.OK).all():
        return ()
    first, last = dataset.isel(grid=0), dataset.isel(grid=-1)
    growth = float((last["iterations"] / first["iterations"]).max())
    facts = "; ".join(
        f"{name}: {int(one['iterations'][0])} to {int(one['iterations'][-1])}"
        for name, one in _each(dataset.isel(FIRST))
    )
    ratio = last["transform_ratio"].isel(FIRST)
    said = (
        f"Iterations from {int(first['grid'])} to {int(last['grid'])} cells across: {facts}. At "
        f"{int(last['grid'])} cells a solve takes {float(ratio.min()):.1f} to {float(ratio.max()):.1f} times the "
        "time of its bare transforms"
    )
    threads = dataset["threads"].values.tolist()
    if len(threads) > 1 and str(dataset["device"].values[0]) == "cpu":
        times = last["solve_time"].isel(precision=0, device=0)
        faster = times.isel(threads=0) / times.isel(threads=-1)
        said += (
            f", and is {float(np.min(faster)):.1f} to {float(np.max(faster)):.1f} times as fast on "
            f"{thread_count(threads[-1])} as on {thread_count(threads[0])} of this machine"
        )
    return (
        Finding(
            f"From {int(first['grid'])} to {int(last['grid'])} cells across, iterations grow by a factor of at most "
            f"{growth:.1f}.",
            f"{said}.",
            "How does the cost grow?",
        ),
    )
