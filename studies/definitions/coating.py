"""Coated bodies: effect of the thickness and stiffness of a coating on a line contact."""

from collections.abc import Mapping
from math import inf, sqrt

import xarray as xr

import contactstudy as cs
from contactstudy.accuracy.discretisation.contact_edge import half_widths
from contactstudy.domain.checks import positive, whole_number
from contactstudy.scene.solids.coated import CoatedHalfSpace
from studies.model.axis import Axis
from studies.model.case import Case, dimensionless_variables
from studies.model.study import Point
from studies.reference.line_contact import STEEL

RIGID = cs.HalfSpace(inf, 0.3)
LOAD, RADIUS = 1e5, 0.01
# On the substrate alone.
HERTZ = cs.analytic.HertzLine(LOAD, RADIUS, 1 / STEEL.compliance)
A, P_H = HERTZ.half_width, HERTZ.peak_pressure
# Width of the grid over the wider of the contacts on either material.
WIDTH_FACTOR = 1.3

axes = (
    Axis(
        "ratio", (0.25, 0.5, 2.0, 4.0), "Young's modulus of the coating over that of the substrate"
    ),
    Axis(
        "thickness",
        (0.03, 0.1, 0.3, 1.0, 3.0, 10.0),
        "thickness of the coating over the Hertz half-width on the substrate",
    ),
    Axis("grid", (512,), "cells across the width"),
)

# A rigid cylinder, nu = 0.3 in both: ratio, half-width over thickness, P / (E1* a^2 / R), p0 / (E1* a / R).
# Source: Chebyshev collocation of the layered problem, residual 3e-12.
REFERENCE = (
    (4.0, 0.2, 0.750616102199, 0.477753453724),
    (4.0, 1.0, 0.458102570999, 0.277768758153),
    (0.25, 0.2, 0.800833019014, 0.509889180575),
    (0.25, 1.0, 1.054900786815, 0.687575655250),
)


def coated(ratio: float, thickness: float) -> CoatedHalfSpace:
    """Return steel with a coating of ``thickness`` [m] that is ``ratio`` times as stiff."""
    coating = cs.HalfSpace(ratio * STEEL.youngs_modulus, STEEL.poisson_ratio)
    return CoatedHalfSpace(coating, thickness, STEEL)


def case_at(point: Point) -> Case:
    """Return a rigid cylinder on coated steel, in plane strain."""
    ratio = positive("ratio", point["ratio"], "give a ratio of moduli above 0")
    thickness = positive("thickness", point["thickness"], "give a thickness above 0 half-widths")
    cells = whole_number("grid", point["grid"], 32, "give at least 32 cells across the width")
    solids = coated(ratio, thickness * A), RIGID
    scene = cs.Scene(cs.LineLoad(LOAD), solids, (cs.Cylinder(RADIUS),))
    width = 2 * WIDTH_FACTOR * A * max(1.0, 1 / sqrt(ratio))
    return Case(scene, cs.Grid((cells, 1), (width, width)), cs.ExactPeriodicity())


def measures(case: Case, solution: cs.Solution) -> Mapping[str, xr.Variable]:
    """Return half-width and peak pressure over Hertz's on the substrate, and the errors of contacts that are known."""
    body = case.scene.solids[0]
    assert isinstance(body, CoatedHalfSpace)
    ratio = body.coating.youngs_modulus / body.substrate.youngs_modulus
    half_width = float(half_widths(solution.pressure, case.grid.x)[0])
    measured = {
        "half_width": (half_width / A, "half-width over Hertz's on the substrate"),
        "peak_pressure": (solution.pressure.max() / P_H, "peak pressure over Hertz's on the substrate"),
    }  # fmt: skip
    reference_error = _reference_error(ratio, case.grid.cells[0])
    if reference_error is not None:
        what = "largest relative error of the peak pressure of contacts that are known"
        measured["reference_error"] = reference_error, what
    return dimensionless_variables(measured)


def _reference_error(ratio: float, cells: int) -> float | None:
    """Return the largest relative error of the peak pressure of the reference contacts; None for a ratio without."""
    errors = []
    for reference_ratio, wide, load, peak in REFERENCE:
        if reference_ratio != ratio:
            continue
        half_width = A
        body = coated(ratio, half_width / wide)
        modulus = 1 / body.coating.compliance
        line = cs.LineLoad(load * modulus * half_width**2 / RADIUS)
        scene = cs.Scene(line, (body, RIGID), (cs.Cylinder(RADIUS),))
        grid = cs.Grid((cells, 1), (2.4 * half_width, half_width))
        solution = cs.solve(scene.problem(grid, cs.ExactPeriodicity()))
        errors.append(abs(solution.pressure.max() / (peak * modulus * half_width / RADIUS) - 1))
    return max(map(float, errors), default=None)
