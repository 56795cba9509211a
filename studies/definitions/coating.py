"""Coated bodies: effect of the thickness and stiffness of a layer on a line contact and on the stress below it."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import inf, sqrt
from typing import ClassVar

import numpy as np
import xarray as xr

import contactstudy as cs
from contactstudy.accuracy.discretisation.contact_edge import half_widths
from contactstudy.domain.checks import positive, whole_number
from contactstudy.domain.fields import Array
from contactstudy.elasticity.coating import CoatingCoefficients
from contactstudy.elasticity.kernels.layer.buried_potential import (
    buried_cell,
    buried_lattice,
    buried_row,
)
from contactstudy.scene.solids.bodies import response
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
    """Return the contact, the stress at the interface, and the errors of the image alone and of known contacts."""
    body = case.scene.solids[0]
    assert isinstance(body, CoatedHalfSpace)
    pressure, x = solution.pressure, case.grid.x
    ratio = body.coating.youngs_modulus / body.substrate.youngs_modulus
    shear, tension = interface(body, pressure[:, 0], case.grid.cell_size[0])
    highest = float(pressure.max())
    alone = _image_alone(case, body)
    without = np.abs(alone.pressure - pressure).sum() / pressure.sum()
    edges = half_widths(pressure, x)
    reference_error = _reference_error(ratio, case.grid.cells[0])
    measured = {
        "half_width": (float(edges[0]) / A, "half-width over Hertz's on the substrate"),
        "peak_pressure": (highest / P_H, "peak pressure over Hertz's on the substrate"),
        "interface_shear": (
            shear / highest,
            "largest shear at the interface over the peak pressure",
        ),
        "interface_tension": (
            tension / highest,
            "largest tension in the coating at the interface over the peak pressure",
        ),
        "image_error": (float(without), "L1 error of the pressure with the image at 2 h alone"),
    }
    if reference_error is not None:
        what = "largest relative error of the peak pressure of contacts that are known"
        measured["reference_error"] = reference_error, what
    return dimensionless_variables(measured)


@dataclass(frozen=True)
class ImageAlone:
    """Influence coefficients of a coating reduced to the image of the load two thicknesses below the surface."""

    coating: CoatingCoefficients
    parity: ClassVar[tuple[int, int]] = (1, 1)

    @property
    def _depth(self) -> float:
        return 2 * self.coating.thickness

    def swap_axes(self) -> "ImageAlone":
        """Return these coefficients: they are even along both axes."""
        return self

    def cell(self, x: Array, y: Array, dx: float, dy: float) -> Array:
        """Return the coefficients of one cell."""
        return self.coating.response.contrast * buried_cell(x, y, dx, dy, self._depth)

    def row(self, x: Array, y: Array, dx: float, dy: float, period: float) -> Array:
        """Return the coefficients of infinitely many images along y, up to a rigid shift."""
        return self.coating.response.contrast * buried_row(x, y, dx, dy, period, self._depth)

    def lattice(
        self, x: Array, y: Array, dx: float, dy: float, width: float, period: float
    ) -> Array:
        """Return the coefficients of infinitely many images along both axes."""
        extent = width, period
        return self.coating.response.contrast * buried_lattice(x, y, dx, dy, *extent, self._depth)


def _image_alone(case: Case, body: CoatedHalfSpace) -> cs.Solution:
    """Return the solution with the coating replaced by its single image."""
    problem = case.prepare()
    terms = {
        ImageAlone(coefficients)
        if isinstance(coefficients, CoatingCoefficients)
        else coefficients: weight
        for coefficients, weight in response((body, RIGID), problem.scales.length).items()
    }
    operator = cs.superposed(terms, case.grid, case.padding)
    return case.run(replace(problem, operator=operator))


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


# Period for the stress at the interface, in widths of the grid; its relative error is (a / period)^2.
PADDED = 32


def interface(body: CoatedHalfSpace, pressure: Array, step: float) -> tuple[float, float]:
    """Return the largest shear and tension [Pa] in the coating at the interface, in plane strain.

    The layered problem is solved for each wave, with Airy functions in the layer and below it and six conditions
    (Burmister 1945), independently of the coefficients of the contact.
    """
    count = PADDED * pressure.size
    waves = np.fft.rfft(pressure, count)
    q = 2 * np.pi / (count * step) * np.arange(waves.size)
    k = q[1:] * body.thickness
    inside = k < 40
    shear, along = np.zeros(waves.size), np.zeros(waves.size)
    shear[1:][inside], along[1:][inside] = _at_interface(body, k[inside])
    # the mean is the limit of long waves, since the surface continues beyond the load
    along[0] = 2 * along[1] - along[2]
    # s_xz is odd where the pressure is even
    largest_shear = np.abs(np.fft.irfft(1j * shear * waves, count)).max()
    return float(largest_shear), float(np.fft.irfft(along * waves, count).max())


def _at_interface(body: CoatedHalfSpace, k: Array) -> tuple[Array, Array]:
    """Return s_xz and s_xx in the layer at its interface under the pressure ``cos(q x)``, for k = q h."""
    ratio = body.coating.youngs_modulus / body.substrate.youngs_modulus
    ratio *= (1 + body.substrate.poisson_ratio) / (1 + body.coating.poisson_ratio)
    zero, unit = np.zeros_like(k), np.ones_like(k)
    fade = np.exp(-k)

    def falling(z: Array, e: Array) -> list[list[Array]]:
        """Return ``exp(-z)`` and ``z exp(-z)``, each with three derivatives; e is the exponential."""
        return [[e, -e, e, -e], [z * e, (1 - z) * e, (z - 2) * e, (3 - z) * e]]

    def rising(z: Array, e: Array) -> list[list[Array]]:
        """Return ``exp(z)`` and ``z exp(z)``, each with three derivatives; e is the exponential."""
        return [[e, e, e, e], [z * e, (1 + z) * e, (z + 2) * e, (3 + z) * e]]

    top = falling(zero, unit) + rising(zero, fade)
    bottom = falling(k, fade) + rising(k, unit)
    below = falling(zero, unit)

    def rows(d: list[Array], weight: float, nu: float) -> list[Array]:
        """Return the normal and shear stress and both displacements of an Airy function with three derivatives."""
        across = weight * ((1 - nu) * d[2] + nu * d[0])
        return [d[0], d[1], across, weight * ((1 - nu) * d[3] - (2 - nu) * d[1])]

    system = np.zeros((k.size, 6, 6))
    nus = body.coating.poisson_ratio, body.substrate.poisson_ratio
    for column, (above, at_bottom) in enumerate(zip(top, bottom, strict=True)):
        system[:, 0, column], system[:, 1, column] = above[0], above[1]
        for row, value in enumerate(rows(at_bottom, 1.0, nus[0])):
            system[:, 2 + row, column] = value
    for column, derivatives in enumerate(below):
        for row, value in enumerate(rows(derivatives, ratio, nus[1])):
            system[:, 2 + row, 4 + column] = -value
    right = np.zeros((k.size, 6, 1))
    right[:, 0] = 1.0
    strength = np.linalg.solve(system, right)[:, :, 0]
    shear = sum(strength[:, n] * bottom[n][1] for n in range(4))
    along = sum(strength[:, n] * bottom[n][2] for n in range(4))
    return np.asarray(shear), np.asarray(along)
