"""The paper's figures: displacement under a periodic point pressure, pressure of a line contact."""

from collections.abc import Mapping

import numpy as np
import xarray as xr

import contactstudy as cs
from studies.model.case import Case
from studies.model.study import Point
from studies.reference import line_contact

WIDTH, CELLS = 3.0, 120  # Fig. 4: a square of three contact radii, which is also the period

points = tuple(
    axis for axis in line_contact.axes(images=(1, 6)) if axis.name in ("padding", "images")
)


def scene_at(point: Point) -> Case:
    """The paper's line contact: 128 x 128 cells over 2.4 a x 2.4 a."""
    return line_contact.scene_at({"period": 2.4, "grid": 128} | dict(point))


def measures(case: Case, solution: cs.Solution) -> Mapping[str, xr.Variable]:
    """Errors against Hertz, pressure across the contact (Fig. 5), displacement of Fig. 4."""
    hertz, grid = case.scene.hertz, case.grid
    assert hertz is not None
    pressure = solution.pressure / hertz.peak_pressure
    middle = pressure.shape[1] // 2
    across = {"long_name": "pressure over Hertz peak pressure", "units": "1"}
    return {
        **line_contact.measures(case, solution),
        **point_displacement(case.padding),
        "x": xr.Variable(
            ("x",),
            grid.x / hertz.half_width,
            {"units": "1", "long_name": "position across the contact over Hertz half-width"},
        ),
        "pressure": xr.Variable(
            ("x",), pressure[:, middle], across | {"comment": "in the middle of the length"}
        ),
        "pressure_min": xr.Variable(("x",), pressure.min(axis=1), across),
        "pressure_max": xr.Variable(("x",), pressure.max(axis=1), across),
    }


def point_displacement(padding: cs.Padding | cs.Paddings) -> Mapping[str, xr.Variable]:
    """Displacement under a semi-elliptic pressure that repeats every three radii, over Hertz's central one."""
    hertz = cs.analytic.hertz_point(load=1.0, radius=1.0, contact_modulus=1.0)
    a = hertz.contact_radius
    grid = cs.Grid(cells=(CELLS, CELLS), extent=(WIDTH * a, WIDTH * a))
    pressure = hertz.pressure(np.hypot(*np.meshgrid(grid.x, grid.y, indexing="ij")))
    displacement = cs.convolution(hertz.contact_modulus, grid, padding, datum=a)(pressure)
    displacement /= hertz.approach
    label = {"units": "1", "long_name": "displacement over Hertz central displacement"}
    return {
        "offset": xr.Variable(
            ("offset",),
            grid.x / a,
            {"units": "1", "long_name": "distance from the centre over contact radius"},
        ),
        "displacement_x": xr.Variable(("offset",), displacement[:, CELLS // 2], label),
        "displacement_y": xr.Variable(("offset",), displacement[CELLS // 2], label),
    }
