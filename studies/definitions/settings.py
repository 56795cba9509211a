"""Settings of any scene as a study: padding, n, period, grid and tolerance, with errors against a finer reference.

The built-in studies of these names are about the paper's cylinder, whose reference is Hertz's contact.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import prod

import numpy as np
import xarray as xr

import contactstudy as cs
from contactstudy.domain.checks import positive, whole_number
from contactstudy.domain.grid import on_cells
from studies.advice.compared_scene import (
    REPORTED,
    ComparedScene,
    numbers_of,
    paper_scene,
    pressure_of,
)
from studies.advice.nested_grids import MULTIPLES, cells_at, is_reference
from studies.advice.reference_error import ReferencedCase, answer_of, pressure_error
from studies.model.axis import Axis, Value, one_of
from studies.model.case import SceneCase, TimedAnswer, dimensionless
from studies.model.study import Point, Study
from studies.reference import line_contact
from studies.reference.line_contact import PADDINGS, WIDTH, padding_at

FREE = "free"
# Cells along the length of a contact that does not vary along it; None for square ones. Every padding has both.
ALONG = {"square": None, "one": 1}
HALF_WIDTHS = "position across the contact over Hertz half-width"
# Tolerance of the reference.
REFERENCE_TOLERANCE = 1e-8
# Largest number of cells of the default grids, and of those across.
MAX_CELLS, MAX_CELLS_ACROSS = 2**15, 724
PAPER_CELLS = 128
TITLES = {
    "padding": "Paddings side by side",
    "period": "Accuracy against the period",
    "images": "Accuracy against the number n of superposed periods",
    "grid": "Accuracy against the number of cells",
    "pareto": "Cost of accuracy: paddings, n, grids and tolerances",
    "paper": "The paper's comparison: pressure across the contact with every padding",
}
# Numbers of images by preset.
IMAGES = {
    "padding": (1, 6, 20), "images": (0, 1, 2, 3, 4, 6, 8, 10, 20), "pareto": (1, 6), "paper": (1, 6)
}  # fmt: skip
# Periods by preset: over the half-width of a contact that does not vary along its length, and over the scene's own.
LENGTH_OF_PAPER = 3.0  # of its point contacts, the only one that it names
PERIODS = {
    "padding": (0.6, 2.4),
    "period": (0.15, 0.3, 0.6, 1.2, 2.4, 4.8, 9.6),
    "images": (0.6, LENGTH_OF_PAPER, 9.6),
    "pareto": (0.6, 2.4),
    "paper": (LENGTH_OF_PAPER,),
}
SCENE_PERIODS = {"period": (1, 2, 3)}
MEASURED_MESSAGE = "Period {} of the scene's own: a measured surface has one period, give 1."


def preset(name: str, subject: ComparedScene) -> Study:
    """Return the study of a scene's settings with the axes of a preset.

    Parameters
    ----------
    name
        padding, period, images, grid, pareto or paper.
    subject
        The scene.

    Raises
    ------
    InvalidInput
        For another name.
    """
    one_of("study of a scene", name, TITLES)
    grids = [
        (multiple, cells)
        for multiple in MULTIPLES
        for cells in [cells_at(subject.unit, multiple)]
        if prod(cells) <= MAX_CELLS and cells[0] <= MAX_CELLS_ACROSS
    ]
    across = [cells[0] for _, cells in grids]
    chosen = {"grid": tuple(across), "pareto": tuple(across[2:])}
    if subject.exact is not None:
        chosen["paper"] = (PAPER_CELLS,)
    hertz = subject.exact
    reference_text = "over the scene's own" if hertz is None else "over Hertz half-width"
    default_period: tuple[Value, ...] = (1,) if hertz is None else (WIDTH,)
    periods = (SCENE_PERIODS if hertz is None else PERIODS).get(name, default_period)
    names = (*PADDINGS, FREE) if subject.is_free else tuple(PADDINGS)
    finest = (across[-3 if hertz is None else -1],)
    axes = [
        Axis("padding", names, "treatment of the periodic direction (padding)"),
        Axis("images", IMAGES.get(name, (6,)), "periods superposed on each side"),
        Axis("period", periods, f"period length {reference_text}"),
        Axis("grid", chosen.get(name, finest), "cells across the width"),
    ]
    if name == "pareto" and hertz is not None:
        axes.append(
            Axis("along", tuple(ALONG), "cells along the length: square ones, or one alone")
        )
    if name == "pareto":
        axes.append(Axis("solver_tolerance", (1e-2, 1e-4), "residual to which the solver goes"))
    reference_multiple = next(m for m in MULTIPLES if is_reference(m) and m >= 3 * grids[-1][0])
    reference, against = None, "Hertz's contact"
    if hertz is None:
        cells = cells_at(subject.unit, reference_multiple)
        reference_options = replace(subject.options, tolerance=REFERENCE_TOLERANCE)
        reference = SceneCase(
            subject.scene, subject.grid(cells), subject.boundary, reference_options, subject.times
        )
        size = f"{cells[0]} x {cells[1]} cells"
        against = f"a solution on {size} under the scene's own boundary conditions"
    return Study(
        name,
        f"{TITLES[name]}, for {subject.name}.",
        tuple(axes),
        _SettingAt(subject, reference),
        profile_measures if name == "paper" else measures,
        attributes={"scene": subject.text, "scene_name": subject.name, "against": against},
    )


@dataclass(frozen=True, eq=False)
class _SettingAt:
    """Function of a point that returns its case."""

    subject: ComparedScene
    reference: SceneCase | None

    def __call__(self, point: Point) -> ReferencedCase:
        subject = self.subject
        name = str(point["padding"])
        padding = (
            subject.boundary if name == FREE and subject.is_free
            else padding_at(name, int(point["images"]))
        )  # fmt: skip
        across = whole_number("grid", point["grid"], 2, "give at least 2 cells across the width")
        along = ALONG[one_of("along", point.get("along", "square"), ALONG)]
        grid, periods = self._grid(across, point["period"], along)
        tolerance = float(point.get("solver_tolerance", REFERENCE_TOLERANCE))
        options = replace(subject.options, tolerance=tolerance)
        return ReferencedCase(
            subject.scene, grid, padding, options, subject.times,
            reference=self.reference, periods=periods,
        )  # fmt: skip

    def _grid(self, across: int, period: Value, along: int | None) -> tuple[cs.Grid, int]:
        """Return the grid of a period, with `along` or square cells, and how many of the scene's own it has."""
        subject, (width, length) = self.subject, self.subject.extent
        if (hertz := subject.exact) is not None:
            # nothing varies along the length, so that any period will do
            half_widths = positive("period", period, "give a period above 0 half-widths")
            length = hertz.half_width * half_widths
            cells = across, along or max(2, round(across * length / width))
            return cs.Grid(cells, (width, length)), 1
        remedy = "give a whole number of the scene's own periods"
        periods = whole_number("period", period, 1, remedy)
        is_measured = any(isinstance(shape, cs.MeasuredSurface) for shape in subject.scene.shapes)
        if periods > 1 and is_measured:
            raise cs.InvalidInput(MEASURED_MESSAGE.format(periods))
        if periods > 1 and subject.is_free:
            raise cs.InvalidInput(
                f"period is {periods}, and {subject.name} ends along its length: give 1."
            )
        unit = subject.unit
        along = 1 if unit[1] == 1 else max(2, round(across * unit[1] / unit[0]))
        return cs.Grid((across, along * periods), (width, length * periods)), periods


def measures(case: ReferencedCase, result: TimedAnswer) -> Mapping[str, xr.Variable]:
    """Return the relative errors of the pressure in L1 and of the main numbers, against the reference."""
    answer = result.answer
    if case.reference is None:
        assert isinstance(answer, cs.Contact)
        return line_contact.measures(case, answer)
    measured = dict(pressure_error(case, answer))
    numbers = numbers_of(answer)
    for name, value in numbers_of(answer_of(case.reference)).items():
        if value and name in numbers:
            what = f"relative error of the {REPORTED[name]}"
            measured[f"{name}_error"] = dimensionless(numbers[name] / value - 1, what)
    return measured


def profile_measures(case: ReferencedCase, result: TimedAnswer) -> Mapping[str, xr.Variable]:
    """Return the errors, and the pressure across the contact in the middle of the length, with its range along it.

    The pressure is over the largest of the reference.
    """
    pressure, grid = pressure_of(result.answer), case.grid
    if case.reference is None:
        hertz = case.scene.hertz
        assert hertz is not None
        true, largest = hertz.pressure(grid.x)[:, None], hertz.peak_pressure
        x = xr.Variable("x", grid.x / hertz.half_width, {"units": "1", "long_name": HALF_WIDTHS})
    else:
        true = on_cells(pressure_of(answer_of(case.reference)), grid.cells)
        largest = float(true.max())
        x = xr.Variable("x", grid.x, {"units": "m", "long_name": "position across the contact"})
    middle = pressure.shape[1] // 2
    lines = {
        "pressure": (pressure[:, middle], "pressure in the middle of the length"),
        "pressure_min": (pressure.min(axis=1), "least pressure along the length"),
        "pressure_max": (pressure.max(axis=1), "highest pressure along the length"),
        "pressure_true": (true[:, true.shape[1] // 2], "pressure of the reference"),
    }
    profiles = {
        name: dimensionless(line / largest, f"{what}, over the largest of the reference", "x")
        for name, (line, what) in lines.items()
    }
    half_cell = (x.values[1] - x.values[0]) / 2
    borders = np.stack([x.values - half_cell, x.values + half_cell], axis=1)
    label = {
        "long_name": f"borders of the cells: {x.attrs['long_name']}",
        "units": x.attrs["units"],
    }
    x.attrs["bounds"] = "x_bounds"
    bounds = xr.Variable(("x", "border"), borders, label)
    return {**measures(case, result), "x": x, "x_bounds": bounds, **profiles}


_PAPER = paper_scene().subject()
padding, period, images, grid, pareto, paper = (preset(name, _PAPER) for name in TITLES)
