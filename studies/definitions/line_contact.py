"""The smooth line contact beside its sweeps of settings: influence coefficients, and the paper's figures."""

from collections.abc import Mapping

import numpy as np
import xarray as xr

import contactstudy as cs
from contactstudy.domain.grid import across_and_along
from contactstudy.elasticity.coefficients import Displacement, kernel
from studies.model.case import Case, OperatorCase, number
from studies.model.study import Point, Study
from studies.reference.line_contact import HERTZ, axes, measures, scene_at


def operator_at(point: Point) -> OperatorCase:
    """Return the operator of the sweeps' line contact, to be built and applied once."""
    case = scene_at(point)
    return OperatorCase(case.scene.contact_modulus, case.grid, case.padding, HERTZ.half_width)


def kernel_error(case: OperatorCase, result: cs.Convolution) -> Mapping[str, xr.Variable]:
    """Return the largest error of the coefficients of the convolution, without a common rigid shift.

    It is over ``2 dx dy / L``, the weight of the logarithm, and thus the error of the logarithm.
    """
    window, exact = (
        kernel(case.grid, across_and_along(padding), Displacement(case.datum))
        for padding in (case.padding, cs.ExactPeriodicity())
    )
    cells = case.grid.cells[1]
    offsets = np.arange(window.shape[1])
    mirrored = exact[:, np.minimum(offsets, cells - offsets)]
    difference = (window - mirrored) * case.grid.period / (2 * case.grid.cell_area)
    spread = float(np.ptp(difference)) / 2
    return {"kernel_error": number(spread, "largest error of the logarithm in the coefficients")}


kernels = Study(
    "kernels",
    "Influence coefficients of every padding: how far from exact, and how long to build.",
    axes(images=(0, 1, 2, 4, 6, 10, 30), period=(0.15, 0.6, 2.4, 9.6), grid=(128,)),
    operator_at,
    kernel_error,
)

# The paper's Fig. 4: a square of three contact radii, which is also the period.
POINT_WIDTH, POINT_CELLS = 3.0, 120


def paper_at(point: Point) -> Case:
    """Return the paper's line contact: 128 x 128 cells over 2.4 a x 2.4 a."""
    return scene_at({"period": 2.4, "grid": 128} | dict(point))


def paper_measures(case: Case, solution: cs.Contact) -> Mapping[str, xr.Variable]:
    """Return errors against Hertz, the pressure across the contact (Fig. 5) and the displacement of Fig. 4."""
    hertz, cells = case.scene.hertz, case.grid
    assert hertz is not None
    pressure = solution.pressure / hertz.peak_pressure
    across = {"long_name": "pressure over Hertz peak pressure", "units": "1"}
    x_label = {"long_name": "position across the contact over Hertz half-width", "units": "1"}
    return {
        **measures(case, solution),
        **point_displacement(case.padding),
        "x": xr.Variable("x", cells.x / hertz.half_width, x_label),
        "pressure": xr.Variable(
            "x",
            pressure[:, pressure.shape[1] // 2],
            across | {"comment": "in the middle of the length"},
        ),
        "pressure_min": xr.Variable("x", pressure.min(axis=1), across),
        "pressure_max": xr.Variable("x", pressure.max(axis=1), across),
    }


def point_displacement(along: cs.Padding | cs.Paddings) -> Mapping[str, xr.Variable]:
    """Return the displacement under a semi-elliptic pressure that repeats every three radii.

    It is divided by the displacement at the centre of one such contact alone (Hertz).
    """
    hertz = cs.analytic.HertzPoint(load=1.0, radius=1.0, contact_modulus=1.0)
    a = hertz.contact_radius
    cells = cs.Grid(cells=(POINT_CELLS, POINT_CELLS), extent=(POINT_WIDTH * a, POINT_WIDTH * a))
    pressure = hertz.pressure(np.hypot(*np.meshgrid(cells.x, cells.y, indexing="ij")))
    displacement = cs.convolution(hertz.contact_modulus, cells, along, datum=a)(pressure)
    displacement /= hertz.approach
    label = {"units": "1", "long_name": "displacement over Hertz central displacement"}
    distance_label = {"units": "1", "long_name": "distance from the centre over contact radius"}
    return {
        "offset": xr.Variable("offset", cells.x / a, distance_label),
        "displacement_x": xr.Variable("offset", displacement[:, POINT_CELLS // 2], label),
        "displacement_y": xr.Variable("offset", displacement[POINT_CELLS // 2], label),
    }


paper = Study(
    "paper",
    "The paper's figures: displacement under a periodic point pressure, pressure of a line contact.",
    axes(images=(1, 6))[:2],
    paper_at,
    paper_measures,
)
