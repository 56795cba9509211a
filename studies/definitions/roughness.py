"""Rough surfaces: change of the contact by roughness, and the error of each padding."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import xarray as xr

import contactstudy as cs
from contactstudy.analytic import image_error
from contactstudy.domain.checks import non_negative, positive, whole_number, whole_quotient
from contactstudy.domain.fields import Array
from studies.model.axis import Axis
from studies.model.case import Case, dimensionless
from studies.model.study import Point
from studies.reference.line_contact import (
    HERTZ,
    HERTZ_HEIGHT,
    P_H,
    PADDINGS,
    SCENE,
    A,
    padding_at,
    relative_l1,
)

# The surface repeats after 3.2 a across and 2.4 a along, on every grid and period. That holds four of
# its longest waves along with the strongest lay below; the finest are five cells of the grid below.
WIDTH, LENGTH = 3.2, 2.4
ROLL_OFF, CUT_OFF = 0.3, 0.1

axes = (
    Axis("rms", (0.0, 0.03, 0.1, 0.3), "rms height over a²/(2R)"),
    Axis("hurst", (0.3, 0.8), "Hurst exponent"),
    Axis("peklenik", (0.5, 1.0, 2.0), "correlation length across the contact over that along it"),
    Axis("seed", (1, 2), "seed of the surface"),
    Axis("images", (6,), "periods superposed on each side"),
    Axis("period", (LENGTH,), "period length over Hertz half-width"),
    Axis("grid", (160,), "cells across the width"),
)

QUANTITIES = {
    "contact_area": "contact area over Hertz's",
    "half_width": "effective half-width over Hertz's",
    "contact_extent": "farthest contact from the axis over Hertz half-width",
    "peak_pressure": "peak pressure over Hertz peak pressure",
    "load_spread": "standard deviation of the load along the length over its mean",
    "smooth_difference": "relative L1 difference of the pressure from the smooth contact's",
}
ERRORS = {
    "pressure_error_l1": "relative L1 error of the pressure",
    "half_width_error": "relative error of the effective half-width",
    "peak_pressure_error": "relative error of the peak pressure",
    "pressure_error_max": "largest pressure error over Hertz peak pressure",
    "curved_difference": "relative L1 difference from exact on a cylinder more curved by a²/(4D²), D the window's reach",
}


@dataclass(frozen=True)
class PaddingComparison(Case):
    """A contact with exact periodicity, and the number of images of the paddings compared with it."""

    images: int = 0


def case_at(point: Point) -> PaddingComparison:
    """Return the paper's cylinder with a rough surface; with zero rms all surfaces are one case."""
    rms = non_negative("rms", point["rms"], "give an rms height of 0 or more")
    cells = whole_number("grid", point["grid"], 2, "give at least 2 cells across the width")
    period = positive("period", point["period"], "give a period above 0 half-widths")
    whole_quotient("the rough surface's length", LENGTH * A, period * A)
    shape = cs.Roughness(
        rms=rms * HERTZ_HEIGHT,
        hurst=float(point["hurst"]),
        roll_off=ROLL_OFF * A,
        cut_off=CUT_OFF * A,
        seed=int(point["seed"]),
        peklenik=float(point["peklenik"]),
        extent=(WIDTH * A, LENGTH * A),
    )
    return PaddingComparison(
        scene=replace(SCENE, shapes=SCENE.shapes + ((shape,) if rms else ())),
        grid=cs.Grid((cells, max(1, round(cells * period / WIDTH))), (WIDTH * A, period * A)),
        padding=cs.ExactPeriodicity(),
        images=whole_number("images", point["images"], 0, "must be a whole number, at least 0"),
    )


def measures(case: PaddingComparison, solution: cs.Solution) -> Mapping[str, xr.Variable]:
    """Return the solution with every padding, and its error against exact periodicity on this surface and grid."""
    smooth_case = replace(case, scene=SCENE, grid=replace(case.grid, cells=(case.grid.cells[0], 1)))
    smooth = smooth_case.run(smooth_case.prepare()).pressure
    rows, converged = [], []
    for name in PADDINGS:
        padding = padding_at(name, case.images)
        padded = replace(case, padding=padding)
        answer, curved = solution, solution
        if name != "exact":
            answer = padded.run(padded.prepare())
            curved = _with_window_curvature(case, solution.problem, padding)
        row = _quantities(answer.pressure, smooth, case.grid)
        row |= _errors(answer.pressure, solution.pressure, case.grid)
        rows.append(row | {"curved_difference": relative_l1(answer.pressure, curved.pressure)})
        # with zero padding the contact reaches the ends of the length, which is no failure
        whole_width = not answer.pressure[list(answer.problem.open_edges)].any()
        solved = answer.status in (cs.Status.CONVERGED, cs.Status.CONTACT_AT_EDGE)
        converged.append(solved and whole_width)
    label = {"long_name": "treatment of the periodic direction (padding)"}
    flag = "1 where the solve of this padding converged within the width"
    return {
        "padding": xr.Variable(("padding",), list(PADDINGS), label),
        "converged": dimensionless(np.array(converged, dtype=np.int8), flag, "padding"),
    } | {
        name: dimensionless([row[name] for row in rows], long_name, "padding")
        for name, long_name in (QUANTITIES | ERRORS).items()
    }


def _with_window_curvature(exact: Case, problem: cs.Problem, padding: cs.Padding) -> cs.Solution:
    """Solve with exact periodicity on a cylinder with the additional curvature that a window of images causes.

    Beyond the window's reach D the kernel ``-2 ln r`` lacks ``(x - x')^2 / (2 D^2)``. Under the load of any pressure
    that is a parabola and a tilt, whatever the surface.
    """
    curvature = 2 * image_error(HERTZ.half_width, padding.reach(exact.grid.length))
    opened = sum(shape.gap(exact.grid) for shape in SCENE.shapes) * curvature
    return exact.run(replace(problem, undeformed_gap=problem.undeformed_gap + opened))


def _quantities(pressure: Array, smooth: Array, grid: cs.Grid) -> dict[str, float]:
    """Return the quantities of ``QUANTITIES`` of a pressure (x, y) [Pa]; `smooth` (x, 1) is the smooth contact's."""
    load = pressure.sum(axis=0)
    touched = np.abs(grid.x)[(pressure > 0).any(axis=1)]
    return {
        "contact_area": float((pressure > 0).sum() * grid.cell_area / (2 * A * grid.length)),
        "half_width": _half_width(pressure, grid) / A,
        "contact_extent": float(touched.max() + grid.cell_size[0] / 2) / A,
        "peak_pressure": float(pressure.max()) / P_H,
        "load_spread": float(load.std() / load.mean()),
        "smooth_difference": relative_l1(pressure, smooth),
    }


def _errors(pressure: Array, exact: Array, grid: cs.Grid) -> dict[str, float]:
    """Return the errors of a pressure (x, y) [Pa] against that with exact periodicity."""
    return {
        "pressure_error_l1": relative_l1(pressure, exact),
        "half_width_error": _half_width(pressure, grid) / _half_width(exact, grid) - 1,
        "peak_pressure_error": float(pressure.max() / exact.max()) - 1,
        "pressure_error_max": float(np.abs(pressure - exact).max()) / P_H,
    }


def _half_width(pressure: Array, grid: cs.Grid) -> float:
    """Return the half-width [m] of Hertz's pressure with the same second moment, ``<x^2> = a^2 / 4``."""
    across = pressure.sum(axis=1)
    return float(2 * np.sqrt((across * grid.x**2).sum() / across.sum()))
