"""Padding strategies side by side: what each reaches, and at what cost."""

import numpy as np
import xarray as xr

from contactstudy.analytic import truncation_error
from studies import line_contact
from studies.front import pareto_front
from studies.line_contact import COUNTED, measures, padding_at, scene_at
from studies.study import Plate
from studies.style import LAW, finish, label_of, look, paddings, panels, percent, some

__all__ = ["figure", "measures", "points", "scene_at"]

points = line_contact.axes(images=(1, 6, 20), period=(0.6, 2.4), grid=(32, 64, 128, 256))


def figure(dataset: xr.Dataset) -> tuple[Plate, ...]:
    """Error against the window's reach, and against runtime with the Pareto front."""
    return _reach(dataset.isel(grid=-1)), _runtime(dataset)


def _reach(dataset: xr.Dataset) -> Plate:
    plate, (ax,) = panels(1, width=6, height=3.8)
    spans: list[float] = []
    for name in paddings(dataset):
        errors, reaches = [], []
        for images in dataset["images"].values if name in COUNTED else dataset["images"].values[:1]:
            for period in dataset["period"].values:
                chosen = dataset["peak_pressure_error"].sel(
                    padding=name, images=images, period=period
                )
                errors.append(abs(float(chosen)))
                reaches.append(padding_at(name, int(images)).reach(float(period)))
        if np.isfinite(reaches).all():
            ax.loglog(reaches, errors, linestyle="none", label=name, **look(name))
            spans += reaches
        else:
            floor = {"color": look(name)["color"], "linestyle": "--"}
            ax.axhline(max(errors), label=f"{name} (grid error alone)", **floor)
    if spans:
        reach = np.geomspace(min(spans), max(spans))
        ax.loglog(reach, truncation_error(1, reach), label="law a²/(8D²)", **LAW)
    ax.set(xlabel="reach of the window D / half-width a", ylabel="|peak-pressure error|")
    finish(plate)
    return Plate(
        "reach",
        plate,
        "Peak-pressure error of every setting against how far to each side a point sees pressure "
        "(D = L/2 without neighbours, L duplicated, (n + ½)L superposed). What is not seen costs "
        "a²/(8D²) once D exceeds about 3a, whichever way the images are counted. Zero padding follows no such "
        "law, since its pressure ends with the domain. Only exact periodicity is left with the error of "
        "the grid alone.",
    )


def _runtime(dataset: xr.Dataset) -> Plate:
    periods = some(dataset["period"].values)
    plate, axes = panels(len(periods), height=3.6, share="both")
    words = []
    for ax, period in zip(axes, periods, strict=True):
        points = settings(dataset.sel(period=period))
        cost, error, labels = (points[name].values for name in ("cost", "error", "padding"))
        for name in paddings(dataset):
            own = labels == name
            ax.loglog(cost[own], error[own], linestyle="none", label=name, alpha=0.8, **look(name))
        front = pareto_front(cost, error)
        ax.step(
            cost[front],
            error[front],
            where="post",
            color="black",
            linewidth=0.9,
            label="Pareto front",
        )
        own = np.flatnonzero(labels == "exact")
        if own.size:
            finest = own[np.argmin(error[own])]
            span = np.array([cost[own].min(), cost[finest]])
            law = error[finest] * (span / cost[finest]) ** -0.75
            ax.loglog(span, law, label="law t^(−3/4), exact", **LAW)
        ax.set(title=f"period L = {period:g} a", xlabel="wall time, set-up and solve [s]")
        best = points.isel(point=front[-1])
        words.append(
            f"L = {period:g} a: {label_of(best)} at {int(best['grid'])} cells, L1 error "
            f"{percent(best['error'])} in {float(best['cost']):.2g} s"
        )
    axes[0].set_ylabel("relative L1 error of the pressure")
    finish(plate)
    return Plate(
        "runtime",
        plate,
        "Accuracy against wall time on one thread, every mode, n and grid; the line joins the settings "
        "that nothing beats on both counts. The dotted law is what an error of N^(−3/2) costs when a "
        "solve takes N² operations an iteration, but for logarithms, and as many iterations on every grid; "
        "small grids lie above it since their set-up does not shrink with them. The most accurate settings: "
        + "; ".join(words)
        + ".",
    )


def settings(dataset: xr.Dataset) -> xr.Dataset:
    """Every setting at one period as a flat list of ``cost`` [s] and L1 ``error``."""
    flat = dataset[["setup_time", "solve_time", "pressure_error_l1"]].stack(
        point=("padding", "images", "grid")
    )
    cost = flat["setup_time"] + flat["solve_time"]
    return xr.Dataset({"cost": cost, "error": flat["pressure_error_l1"]}).reset_index("point")
