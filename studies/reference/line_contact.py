"""The paper's smooth line contact: its scene at a point, and its errors against Hertz."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import xarray as xr

import contactstudy as cs
from contactstudy.accuracy.coarser import contact_area_in_cells
from contactstudy.domain.grid import Array, on_cells
from studies.model.case import Case, dimensionless, error_estimates

STEEL = cs.HalfSpace(youngs_modulus=210e9, poisson_ratio=0.3)
SCENE = cs.Scene(load=cs.LineLoad(1e5), solids=(STEEL, STEEL), shapes=(cs.Cylinder(radius=0.01),))
HERTZ = cs.analytic.HertzLine(SCENE.largest_load, 0.01, SCENE.contact_modulus)
A, P_H = HERTZ.half_width, HERTZ.peak_pressure
# Height of the cylinder at the edge of the contact [m], a^2 / (2 R) = p_H a / E*.
HERTZ_HEIGHT = A**2 / (2 * HERTZ.radius)
WIDTH = 2.4  # of the domain, in half-widths: the paper's choice

# Places of the contact edge, in cells outward of the last border of cells within it. On every grid the L1 error is
# largest at 0.32, where the next cell begins to bear, and that of a single cell at 0.5, the centre of a cell.
EDGE_PLACES = (0.0, 0.32, 0.5, 0.75)
EDGE = "The largest over places of the contact edge in its cell."
# Errors of a smooth contact by name, with their labels.
ERRORS = {
    "axis_pressure_error": "relative error of the mean pressure in the cells beside the axis",
    "peak_pressure_error": "relative error of the highest pressure anywhere, as means over cells",
    "pressure_error_max": "largest pressure error at a cell centre over Hertz peak pressure",
    "pressure_error_l1": "relative L1 error of the pressure",
    "half_width_error": "relative error of the contact half-width",
    "length_variation": "pressure variation along the length over Hertz peak pressure",
}
# Those that depend on the place of the contact edge in its cell.
BY_THE_EDGE = tuple(name for name in ERRORS if name != "length_variation")


def with_edges_moved(grid: cs.Grid, half_width: float) -> tuple[cs.Grid, ...]:
    """Return a grid, and grids of as many cells, with the edge of a contact at the `EDGE_PLACES` in a cell.

    The L1 error of the pressure changes by a factor of five with this place, which a slightly different load changes.
    The number of cells in the `half_width` [m] changes by at most a half; grids too narrow for the contact are left out.
    """
    (width, length), count = grid.extent, grid.cells[0]
    cells = half_width / grid.cell_size[0]  # cells in a half-width
    shifts = ((place - cells - count / 2 + 0.5) % 1 - 0.5 for place in EDGE_PLACES)
    shifted = (cells + shift for shift in shifts if 0.5 <= cells + shift < count / 2)
    return grid, *(replace(grid, extent=(width * cells / shifted_cells, length)) for shifted_cells in shifted)


def measures(case: Case, solution: cs.Contact) -> Mapping[str, xr.Variable]:
    """Return errors of pressure and half-width against Hertz's line contact, over p_H, a or the load.

    The errors named in `BY_THE_EDGE` are the largest over several places of the contact edge in its cell, each of which
    is solved.
    """
    hertz = case.scene.hertz
    assert hertz is not None
    measured = hertz_errors(hertz, case.grid, solution.pressure)
    for grid in with_edges_moved(case.grid, hertz.half_width)[1:]:
        answer = cs.solve(case.scene.problem(grid, case.padding), options=case.options)
        errors = hertz_errors(hertz, grid, answer.pressure)
        for name in BY_THE_EDGE:
            measured[name] = max(measured[name], errors[name], key=abs)
    variables = {name: dimensionless(float(measured[name]), label) for name, label in ERRORS.items()}
    for name in BY_THE_EDGE:
        variables[name].attrs["comment"] = EDGE
    assert not isinstance(case.padding, tuple)
    reach = case.padding.reach(case.grid.length / hertz.half_width)
    variables["reach"] = dimensionless(reach, "reach D of the window over the half-width a")
    return variables | error_estimates(solution.error)


def hertz_errors(hertz: cs.analytic.HertzLine, grid: cs.Grid, pressure: Array) -> dict[str, float]:
    """Return the errors of `ERRORS` of a pressure (x, y) [Pa] on one grid."""
    means = hertz_means(hertz, grid)
    l1 = relative_l1(pressure, means)
    pressure, means = pressure / hertz.peak_pressure, means / hertz.peak_pressure
    true = hertz.pressure(grid.x)[:, None] / hertz.peak_pressure
    widths = [contact_area_in_cells(row[:, None], (False, False)) for row in pressure.T]
    half_width = np.mean(widths) * grid.cell_size[0] / 2
    axis = np.abs(grid.x) < 0.75 * grid.cell_size[0]
    return {
        "axis_pressure_error": pressure[axis].mean() / means[axis].mean() - 1,
        "peak_pressure_error": pressure.max() / means.max() - 1,
        "pressure_error_max": np.abs(pressure - true).max(),
        "pressure_error_l1": l1,
        "half_width_error": half_width / hertz.half_width - 1,
        "length_variation": np.ptp(pressure, axis=1).max(),
    }


def hertz_means(hertz: cs.analytic.HertzLine, grid: cs.Grid) -> Array:
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
    """Return the processor time to set up and solve [s], the least of the repeats, which are taken in turns.

    Other work on the machine does not count, but for what it takes from the caches.
    """
    label = {"long_name": "processor time to set up and solve", "units": "s"}
    return (dataset["setup_time_cpu"] + dataset["solve_time_cpu"]).assign_attrs(label)
