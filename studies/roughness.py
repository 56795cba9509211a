"""Rough surfaces: how far the smooth contact's answer shifts, and what each padding adds to that."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

import contactstudy as cs
from contactstudy.analytic import truncation_error
from contactstudy.arrays import Array
from contactstudy.checks import divides, from_zero, positive, whole
from studies.axis import Axis
from studies.case import Case
from studies.line_contact import HERTZ, PADDINGS, SCENE, padding_at
from studies.study import Plate, Point
from studies.style import LAW, finish, label_of, look, paddings, panels

A, P_H = HERTZ.half_width, HERTZ.peak_pressure
FLATTENING = A**2 / (
    2 * HERTZ.radius
)  # [m], the cylinder's height over the width of Hertz's contact
# The surface repeats after 3.2 a across and 2.4 a along, on every grid and period. That holds four of
# its longest waves along with the strongest lay below; the finest are five cells of the grid below.
WIDTH, LENGTH = 3.2, 2.4
ROLL_OFF, CUT_OFF = 0.3, 0.1

points = (
    Axis("rms", (0.0, 0.03, 0.1, 0.3), "rms height over a²/(2R)"),
    Axis("hurst", (0.3, 0.8), "Hurst exponent"),
    Axis("peklenik", (0.5, 1.0, 2.0), "correlation length across the contact over that along it"),
    Axis("seed", (1, 2), "seed of the surface"),
    Axis("images", (6,), "periods superposed on each side"),
    Axis("period", (LENGTH,), "period length over Hertz half-width"),
    Axis("grid", (160,), "cells across the width"),
)

ANSWERS = {
    "contact_area": "contact area over Hertz's",
    "half_width": "effective half-width over Hertz's",
    "contact_extent": "farthest contact from the axis over Hertz half-width",
    "peak_pressure": "highest pressure over Hertz peak pressure",
    "load_spread": "standard deviation of the load along the length over its mean",
    "smooth_difference": "relative L1 difference of the pressure from the smooth contact's",
}
ERRORS = {
    "pressure_error_l1": "relative L1 error of the pressure",
    "half_width_error": "relative error of the effective half-width",
    "highest_pressure_error": "relative error of the highest pressure",
    "pressure_error_max": "largest pressure error over Hertz peak pressure",
    "curved_difference": "relative L1 difference from exact on a cylinder more curved by a²/(4D²)",
}


@dataclass(frozen=True)
class Comparison:
    """A surface with exact periodicity, and the number of images of the paddings held against it."""

    exact: Case
    images: int

    def prepare(self) -> cs.Problem:
        """That of the exact case."""
        return self.exact.prepare()

    def run(self, prepared: cs.Problem) -> cs.Solution:
        """The exact solve alone: what the others cost is the other studies' to say."""
        return self.exact.run(prepared)

    def record(self, result: cs.Solution) -> Mapping[str, xr.Variable]:
        """That of the exact case."""
        return self.exact.record(result)


def scene_at(point: Point) -> Comparison:
    """The sweeps' cylinder with a rough surface on it; with zero rms, all other choices are one case."""
    rms = from_zero("rms", point["rms"], "give an rms height of 0 or more")
    cells = whole("grid", point["grid"], 2, "give at least 2 cells across the width")
    period = positive("period", point["period"], "give a period above 0 half-widths")
    divides("the rough surface's length", LENGTH * A, period * A)
    shape = cs.Roughness(
        rms=rms * FLATTENING,
        hurst=float(point["hurst"]),
        roll_off=ROLL_OFF * A,
        cut_off=CUT_OFF * A,
        seed=int(point["seed"]),
        peklenik=float(point["peklenik"]),
        extent=(WIDTH * A, LENGTH * A),
    )
    case = Case(
        scene=replace(SCENE, shapes=SCENE.shapes + ((shape,) if rms else ())),
        grid=cs.Grid((cells, max(1, round(cells * period / WIDTH))), (WIDTH * A, period * A)),
        padding=cs.ExactPeriodicity(),
    )
    images = whole("images", point["images"], 0, "give a whole number of periods from 0 on")
    return Comparison(case, images)


def measures(case: Comparison, solution: cs.Solution) -> Mapping[str, xr.Variable]:
    """The answer with every padding, and its error against the exact one on this surface and grid."""
    exact = case.exact
    flat = replace(exact, scene=SCENE, grid=replace(exact.grid, cells=(exact.grid.cells[0], 1)))
    smooth = flat.run(flat.prepare()).pressure
    rows, ends = [], []
    for name in PADDINGS:
        padding = padding_at(name, case.images)
        one = replace(exact, padding=padding)
        found = solution if name == "exact" else one.run(one.prepare())
        curved = solution if name == "exact" else _more_curved(exact, solution.problem, padding)
        rows.append(
            _answers(found.pressure, smooth, exact.grid)
            | _errors(found.pressure, solution.pressure, exact.grid)
            | {"curved_difference": _l1(found.pressure, curved.pressure)}
        )
        ends.append(found.status is cs.Status.CONVERGED)
    label = {"long_name": "representation of the periodic direction"}
    flag = {
        "units": "1",
        "long_name": "1 where the solve of this padding converged within the width",
    }
    return {
        "padding": xr.Variable(("padding",), list(PADDINGS), label),
        "converged": xr.Variable(("padding",), np.array(ends, dtype=np.int8), flag),
    } | {
        name: xr.Variable(
            ("padding",), [row[name] for row in rows], {"units": "1", "long_name": long_name}
        )
        for name, long_name in (ANSWERS | ERRORS).items()
    }


def _more_curved(exact: Case, problem: cs.Problem, padding: cs.Padding) -> cs.Solution:
    """What a window should answer by the law: exact periodicity on a cylinder of more curvature.

    Beyond the window's reach D the logarithm lacks ``(x - x')^2 / (2 D^2)``. Under the load of any pressure
    that is one parabola and a tilt, so the law knows nothing of the surface.
    """
    more = 2 * truncation_error(HERTZ.half_width, padding.reach(exact.grid.period))
    opened = sum(shape.gap(exact.grid) for shape in SCENE.shapes) * more
    return exact.run(replace(problem, undeformed_gap=problem.undeformed_gap + opened))


def _answers(pressure: Array, smooth: Array, grid: cs.Grid) -> dict[str, float]:
    load = pressure.sum(axis=0)
    touched = np.abs(grid.x)[(pressure > 0).any(axis=1)]
    return {
        "contact_area": float((pressure > 0).sum() * grid.cell_area / (2 * A * grid.period)),
        "half_width": _half_width(pressure, grid) / A,
        "contact_extent": float(touched.max() + grid.cell[0] / 2) / A,
        "peak_pressure": float(pressure.max()) / P_H,
        "load_spread": float(load.std() / load.mean()),
        "smooth_difference": _l1(pressure, np.broadcast_to(smooth, pressure.shape)),
    }


def _errors(pressure: Array, exact: Array, grid: cs.Grid) -> dict[str, float]:
    return {
        "pressure_error_l1": _l1(pressure, exact),
        "half_width_error": _half_width(pressure, grid) / _half_width(exact, grid) - 1,
        "highest_pressure_error": float(pressure.max() / exact.max()) - 1,
        "pressure_error_max": float(np.abs(pressure - exact).max()) / P_H,
    }


def _l1(pressure: Array, reference: Array) -> float:
    return float(np.abs(pressure - reference).sum() / reference.sum())


def _half_width(pressure: Array, grid: cs.Grid) -> float:
    """That of Hertz's pressure with the same second moment, ``<x^2> = a^2 / 4`` [m]."""
    across = pressure.sum(axis=1)
    return float(2 * np.sqrt((across * grid.x**2).sum() / across.sum()))


def figure(dataset: xr.Dataset) -> tuple[Plate, ...]:
    """What roughness does, what each padding does to that, and how far the law of the window reaches."""
    finest = dataset.isel(images=-1, period=-1, grid=-1)
    return _shift(finest.sel(padding="exact")), _paddings(finest), _law(finest)


COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00")
LINES = ("-", "--", "-.", ":")


def _shift(dataset: xr.Dataset) -> Plate:
    labels = {
        "contact_area": "contact area / Hertz's",
        "half_width": "effective half-width / a",
        "contact_extent": "farthest contact / a",
        "peak_pressure": "highest pressure / p_H",
        "load_spread": "spread of the load along",
        "smooth_difference": "L1 difference from smooth",
    }
    plate, axes = panels(len(labels), columns=2, width=3.6, height=2.7)
    for ax, (variable, label) in zip(axes, labels.items(), strict=True):
        for peklenik, color in zip(dataset["peklenik"].values, COLORS, strict=False):
            for hurst, line in zip(dataset["hurst"].values, LINES, strict=False):
                one = dataset[variable].sel(peklenik=peklenik, hurst=hurst)
                style = {"color": color, "linestyle": line}
                _over_rms(ax, one, f"lay {peklenik:g}, H = {hurst:g}", **style)
        ax.set_ylabel(label)
    finish(plate)
    rough = dataset.isel(rms=-1)
    facts = "; ".join(
        f"lay {float(lay):g}: area {float(one['contact_area'].mean()):.2f}, highest pressure "
        f"{float(one['peak_pressure'].mean()):.1f} p_H"
        for lay, one in rough.groupby("peklenik")
    )
    return Plate(
        "shift",
        plate,
        "What roughness does to a line contact, exactly periodic; lines are the mean of the surfaces, "
        "bands their span. Heights over a²/(2R), lay as the correlation length across the contact over that "
        "along it (below 1 the lay runs along the length), H the Hurst exponent. The effective half-width "
        "is that of Hertz's pressure with the same second moment; the spread is the standard deviation of "
        f"the load along the length over its mean. At an rms of {float(rough['rms']):g}: {facts}.",
    )


def _paddings(dataset: xr.Dataset) -> Plate:
    labels = {
        "pressure_error_l1": "relative L1 error",
        "half_width_error": "|half-width error|",
        "highest_pressure_error": "|highest-pressure error|",
        "pressure_error_max": "largest error / p_H",
    }
    plate, axes = panels(len(labels), columns=2, width=3.6, height=2.9)
    for ax, (variable, label) in zip(axes, labels.items(), strict=True):
        for name in (name for name in paddings(dataset) if name != "exact"):
            one = dataset.sel(padding=name)
            _over_rms(ax, abs(one[variable]), label_of(one), **look(name))
        if variable == "pressure_error_l1":
            shift = dataset["smooth_difference"].sel(padding="exact")
            style = {"color": "black", "linestyle": "--"}
            _over_rms(ax, shift.where(shift.rms > 0), "shift by the roughness itself", **style)
        ax.set(ylabel=label, yscale="log")
    finish(plate)
    return Plate(
        "paddings",
        plate,
        "Error of each padding against exact periodicity on the same surface and grid; lines are the "
        "median over lays, Hurst exponents and seeds, bands their span. "
        f"L = {float(dataset['period']):g} a. The dashed line is how far the pressure moves from the smooth "
        "contact's because of the roughness: a padding is good enough where its error is well below. The "
        "largest error grows with the roughness, since asperities that barely touch come and go.",
    )


def _law(dataset: xr.Dataset) -> Plate:
    plate, (ratio, after) = panels(2, width=3.6, height=2.9)
    for name in ("duplicated", "superposed", "circular"):
        one = dataset.sel(padding=name)
        _over_rms(ratio, -one["half_width_error"] / law_of(one), label_of(one), **look(name))
        left = one["curved_difference"] / one["pressure_error_l1"]
        _over_rms(after, left, label_of(one), **look(name))
    ratio.axhline(1, label="law a²/(8D²)", **LAW)
    ratio.set(ylabel="half-width error / law")
    ratio.set_ylim(bottom=0)
    after.set(ylabel="share of L1 error left", yscale="log")
    finish(plate)
    return Plate(
        "law",
        plate,
        "A window that reaches D to each side makes the cylinder more curved by a²/(4D²), which lessens the "
        "half-width by a²/(8D²): left, the error found over that. Right, what is left of the L1 error when "
        "the answer is held against exact periodicity on a cylinder of just that curvature with the same "
        "roughness. Little is left of circular windows; superposition errs along the length as well, since "
        "its window does not move with the observer, and of that the law knows nothing.",
    )


def law_of(dataset: xr.Dataset) -> float:
    """a²/(8D²) of one padding at one n and period."""
    padding = padding_at(str(dataset["padding"].values), int(dataset["images"]))
    return float(truncation_error(1, padding.reach(float(dataset["period"]))))


def _over_rms(ax: Axes, values: xr.DataArray, label: str, **style: Any) -> None:
    """Median and span of all surfaces at each rms; the rms stand side by side, for one may be zero."""
    others = [name for name in values.dims if name != "rms"]
    place = np.arange(values.sizes["rms"])
    ax.plot(place, values.median(others), label=label, **style)
    band = {"color": style["color"], "alpha": 0.15, "linewidth": 0}
    ax.fill_between(place, values.min(others), values.max(others), **band)
    names = ["smooth" if rms == 0 else f"{rms:g}" for rms in values["rms"].values]
    ax.set_xticks(place, names)
    ax.set_xlabel("rms height / (a²/2R)")
