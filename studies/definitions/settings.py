"""Settings of the paper's cylinder as studies: padding, n, period, grid and tolerance, with errors against Hertz."""

from collections.abc import Mapping
from typing import Annotated

import numpy as np
import xarray as xr

import contactstudy as cs
from contactstudy.domain.validation import ABOVE_ZERO, at_least, valid
from contactstudy.io.scene_files.structuring import scene_text
from studies.model.axis import Axis, one_of
from studies.model.case import Case, dimensionless
from studies.model.study import Measures, Point, Study
from studies.reference.line_contact import HERTZ, SCENE, WIDTH, measures
from studies.reference.paddings import PADDINGS, padding_at

# Cells along the length of a contact that does not vary along it; None for square cells.
ALONG = {"square": None, "one": 1}
HALF_WIDTHS = "position across the contact over Hertz half-width"
# Tolerance of the solver where a study does not vary it.
TOLERANCE = 1e-8
# Cells across the grids, two to an octave; the study of cost leaves out the first two.
GRIDS = (12, 18, 24, 36, 48, 72, 96, 144)
# Period of the paper's point contacts over Hertz half-width, the only one that it names.
PERIOD_OF_PAPER = 3.0
COST = (
    Axis("along", tuple(ALONG), "cells along the length: square ones, or one alone"),
    Axis("solver_tolerance", (1e-4, 1e-2), "residual to which the solver goes"),
)


def case_at(point: Point) -> Case:
    """Return the case of a point, with one cell or square cells along; any period will do, as nothing varies along."""
    padding = padding_at(str(point["padding"]), int(point["images"]))
    across = valid("grid", point["grid"], Annotated[int, at_least(2)])
    along = ALONG[one_of("along", point.get("along", "square"), ALONG)]
    half_widths = valid("period", point["period"], Annotated[float, ABOVE_ZERO])
    width, length = WIDTH * HERTZ.half_width, half_widths * HERTZ.half_width
    grid = cs.Grid((across, along or max(2, round(across * length / width))), (width, length))
    tolerance = float(point.get("solver_tolerance", TOLERANCE))
    return Case(SCENE, grid, padding, cs.SolveOptions(tolerance=tolerance))


def profile_measures(case: Case, contact: cs.Contact) -> Mapping[str, xr.Variable]:
    """Return the errors, and the pressure across the contact in the middle of the length, with its range along it.

    The pressure is over Hertz's peak pressure.
    """
    pressure, grid = contact.pressure, case.grid
    x = xr.Variable("x", grid.x / HERTZ.half_width, {"units": "1", "long_name": HALF_WIDTHS})
    middle = pressure.shape[1] // 2
    lines = {
        "pressure": (pressure[:, middle], "pressure in the middle of the length"),
        "pressure_min": (pressure.min(axis=1), "least pressure along the length"),
        "pressure_max": (pressure.max(axis=1), "highest pressure along the length"),
        "pressure_true": (HERTZ.pressure(grid.x), "Hertz's pressure"),
    }
    profiles = {
        name: dimensionless(line / HERTZ.peak_pressure, f"{what}, over Hertz's peak pressure", "x")
        for name, (line, what) in lines.items()
    }
    half_cell = (x.values[1] - x.values[0]) / 2
    borders = np.stack([x.values - half_cell, x.values + half_cell], axis=1)
    label = {"long_name": f"borders of the cells: {x.attrs['long_name']}", "units": x.attrs["units"]}
    x.attrs["bounds"] = "x_bounds"
    bounds = xr.Variable(("x", "border"), borders, label)
    return {**measures(case, contact), "x": x, "x_bounds": bounds, **profiles}


def _study(
    name: str, title: str, images: tuple[int, ...] = (6,), period: tuple[float, ...] = (WIDTH,),
    grid: tuple[int, ...] = GRIDS[-1:], more: tuple[Axis, ...] = (), measures: Measures = measures,
) -> Study:  # fmt: skip
    """Return a study of the cylinder's settings: all paddings, and some n, periods over Hertz half-width and grids."""
    axes = (
        Axis("padding", tuple(PADDINGS), "treatment of the periodic direction (padding)"),
        Axis("images", images, "periods superposed on each side"),
        Axis("period", period, "period length over Hertz half-width"),
        Axis("grid", grid, "cells across the width"),
    )
    scene = {"scene": scene_text(SCENE)}
    return Study(name, f"{title}, for the paper's cylinder.", axes + more, case_at, measures, attributes=scene)


padding = _study("padding", "Paddings side by side", (1, 6, 20), (0.6, 2.4))
period = _study("period", "Accuracy against the period", period=(0.15, 0.3, 0.6, 1.2, 2.4, 4.8, 9.6))
images = _study(
    "images", "Accuracy against the number n of superposed periods", (0, 1, 2, 3, 4, 6, 8, 10, 20),
    (0.6, PERIOD_OF_PAPER, 9.6),
)  # fmt: skip
grid = _study("grid", "Accuracy against the number of cells", grid=GRIDS)
pareto = _study("pareto", "Cost of accuracy: paddings, n, grids and tolerances", (1, 6), (0.6, 2.4), GRIDS[2:], COST)
paper = _study(
    "paper", "The paper's comparison: pressure across the contact with every padding", (1, 6), (PERIOD_OF_PAPER,),
    (128,), measures=profile_measures,
)  # fmt: skip
