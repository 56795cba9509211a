"""Influence coefficients of every padding: how far from exact, and how long to build."""

from collections.abc import Mapping

import numpy as np
import xarray as xr

import contactstudy as cs
from contactstudy.domain.padding import across_and_along
from contactstudy.elasticity.coefficients import Displacement, kernel
from studies.model.case import Operator, number
from studies.model.study import Point
from studies.reference import line_contact

points = line_contact.axes(
    images=(0, 1, 2, 4, 6, 10, 30), period=(0.15, 0.6, 2.4, 9.6), grid=(128,)
)


def scene_at(point: Point) -> Operator:
    """The operator of the sweeps' line contact."""
    case = line_contact.scene_at(point)
    half_width = line_contact.HERTZ.half_width
    return Operator(case.scene.contact_modulus, case.grid, case.padding, half_width)


def measures(case: Operator, result: cs.Convolution) -> Mapping[str, xr.Variable]:
    """The largest error of a coefficient that the convolution uses, but for a rigid shift of all.

    In units of ``2 dx dy / L``, the weight of the logarithm: so it is the error of that logarithm.
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
