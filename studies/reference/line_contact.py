"""The paper's smooth line contact: its scene at a point, and its errors against Hertz."""

from collections.abc import Callable, Mapping

import numpy as np
import xarray as xr

import contactstudy as cs
from contactstudy.accuracy.discretisation.contact_edge import corrected_pressure, half_widths
from contactstudy.domain.checks import positive, whole_number
from contactstudy.domain.fields import Array
from contactstudy.domain.grid import on_cells
from studies.model.axis import one_of
from studies.model.case import Case, PosedCase, dimensionless_variables, error_estimates
from studies.model.study import Point

STEEL = cs.HalfSpace(youngs_modulus=210e9, poisson_ratio=0.3)
SCENE = cs.Scene(load=cs.LineLoad(1e5), solids=(STEEL, STEEL), shapes=(cs.Cylinder(radius=0.01),))
HERTZ = cs.analytic.HertzLine(SCENE.largest_load, 0.01, SCENE.contact_modulus)
A, P_H = HERTZ.half_width, HERTZ.peak_pressure
# [m], height of the cylinder at the edge of the contact, a^2 / (2 R) = p_H a / E*
HERTZ_HEIGHT = A**2 / (2 * HERTZ.radius)
WIDTH = 2.4  # of the domain, in half-widths: the paper's choice

PADDINGS: dict[str, Callable[[int], cs.Padding]] = {
    "zero": lambda images: cs.ZeroPadding(),
    "duplicated": lambda images: cs.DuplicatedPadding(),
    "superposed": cs.Superposition,
    "circular": cs.CircularSuperposition,
    "exact": lambda images: cs.ExactPeriodicity(),
}


# paddings with a number n of images
HAS_IMAGES = frozenset(name for name, make in PADDINGS.items() if make(0) != make(1))


def padding_at(padding: str, images: int) -> cs.Padding:
    """Return the padding of a name, with a number of images where it has one."""
    make = PADDINGS[one_of("padding", padding, PADDINGS)]
    return make(whole_number("images", images, 0, "must be a whole number, at least 0"))


def case_at(point: Point) -> Case:
    """Return a steel cylinder on a steel flat, with as many cells across as along, and the period in half-widths."""
    cells = whole_number("grid", point["grid"], 2, "give at least 2 cells across the width")
    period = positive("period", point["period"], "give a period above 0 half-widths")
    a = HERTZ.half_width
    return Case(
        scene=SCENE,
        grid=cs.Grid(cells=(cells, cells), extent=(WIDTH * a, period * a)),
        padding=padding_at(str(point["padding"]), int(point["images"])),
    )


def measures(case: PosedCase, solution: cs.Contact) -> Mapping[str, xr.Variable]:
    """Return errors of pressure and half-width against Hertz's line contact, over p_H, a or the load."""
    hertz, grid = case.scene.hertz, case.grid
    assert hertz is not None
    pressure = solution.pressure / hertz.peak_pressure
    true = hertz.pressure(grid.x)[:, None] / hertz.peak_pressure
    error = np.abs(pressure - true).max()
    axis = np.abs(grid.x) < 0.75 * grid.cell_size[0]
    half_width = half_widths(pressure, grid.x).mean() / hertz.half_width
    l1 = relative_l1(solution.pressure, hertz_means(hertz, grid))
    corrected = np.abs(corrected_pressure(pressure) - true).max()
    on_axis, varies = pressure[axis].mean() - 1, np.ptp(pressure, axis=1).max()
    largest = "largest pressure error over Hertz peak pressure"
    measured = {
        "axis_pressure_error": (
            on_axis,
            "pressure beside the axis over Hertz peak pressure less 1, its mean along the length",
        ),
        "peak_pressure_error": (pressure.max() - 1, "relative error of the peak pressure anywhere"),
        "pressure_error_max": (error, largest),
        "corrected_error_max": (corrected, f"{largest}, corrected at the edge"),
        "pressure_error_l1": (l1, "relative L1 error of the pressure"),
        "half_width_error": (half_width - 1, "relative error of the contact half-width"),
        "length_variation": (varies, "pressure variation along the length over peak pressure"),
    }
    return dimensionless_variables(measured) | error_estimates(solution.error)


def hertz_means(hertz: "cs.analytic.HertzLine", grid: cs.Grid) -> Array:
    """Return the means of Hertz's pressure over the cells of a grid (x, y) [Pa]."""
    borders = np.linspace(-0.5, 0.5, grid.cells[0] + 1) * grid.extent[0] / hertz.half_width
    borders = np.clip(borders, -1, 1)
    integral = (borders * np.sqrt(1 - borders**2) + np.arcsin(borders)) / 2
    load = hertz.peak_pressure * hertz.half_width * np.maximum(np.diff(integral), 0.0)
    return np.repeat(load[:, None] / grid.cell_size[0], grid.cells[1], axis=1)


def relative_l1(pressure: Array, reference: Array) -> float:
    """Return the L1 error of a pressure (x, y) against a finer one's cell means, over the L1 norm of these.

    The norm is the load, without adhesion.
    """
    means = on_cells(reference, (pressure.shape[0], pressure.shape[1]))
    return float(np.abs(pressure - means).sum() / np.abs(means).sum())


def total_time(dataset: xr.Dataset) -> xr.DataArray:
    """Return the wall time to set up and solve [s]."""
    return dataset["setup_time"] + dataset["solve_time"]


def padding_label(padding: str, images: int) -> str:
    """Return the name of a padding, with its n where it has one."""
    return f"{padding}, n = {images}" if padding in HAS_IMAGES else padding
