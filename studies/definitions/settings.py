"""Settings of any scene as a study: padding, n, period, grid and tolerance, with errors against a finer reference.

The built-in studies of these names are about the paper's cylinder, whose reference is Hertz's contact.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache
from math import prod

import numpy as np
import xarray as xr

import contactstudy as cs
from contactstudy.domain.checks import positive, whole
from contactstudy.domain.fields import Array
from contactstudy.domain.reuse import caching
from studies.advice.ladder import MULTIPLES, cells_at, is_reference
from studies.advice.subject import (
    REPORTED,
    Answer,
    Setting,
    Subject,
    numbers_of,
    paper_described,
    pressure_of,
)
from studies.model.axis import Axis, Value, one_of
from studies.model.case import SceneCase, Solved, number
from studies.model.study import Point, Study
from studies.reference import line_contact
from studies.reference.line_contact import PADDINGS, WIDTH, padding_at, relative_l1

FREE = "free"
# Tolerance of the reference.
TIGHT = 1e-8
# Cells of the finest grid that a study has unless told otherwise, and the most of them across.
MOST, MOST_ACROSS = 2**15, 724
TITLES = {
    "padding": "Paddings side by side",
    "period": "Accuracy against the period",
    "images": "Accuracy against the number n of superposed periods",
    "grid": "Accuracy against the number of cells",
    "pareto": "Cost of accuracy: paddings, n, grids and tolerances",
}
# Numbers of images by preset.
IMAGES = {"padding": (1, 6, 20), "images": (0, 1, 2, 3, 4, 6, 8, 10, 20), "pareto": (1, 6)}
# Periods by preset: over the half-width of a contact that does not vary along its length, and over the scene's own.
PERIODS = {
    "padding": (0.6, 2.4),
    "period": (0.15, 0.3, 0.6, 1.2, 2.4, 4.8, 9.6),
    "images": (0.6, 2.4, 9.6),
    "pareto": (0.6, 2.4),
}
OWN_PERIODS = {"period": (1, 2, 3)}
MEASURED = "Period {} of the scene's own: a measured surface has one period, give 1."


@dataclass(frozen=True)
class SettingCase(SceneCase):
    """A scene at one setting, judged against its own boundary on `reference` cells; Hertz judges where that is None."""

    subject: Subject | None = field(default=None, compare=False)
    own: cs.Padding | cs.Paddings = field(default_factory=cs.ExactPeriodicity)
    reference: tuple[int, int] | None = None
    periods: int = 1

    def run(self, prepared: None = None) -> Solved:  # type: ignore[override]
        """Return the answer with its wall time, set up anew: a time that is compared includes the set-up."""
        with caching(None):
            return super().run()


def preset(name: str, subject: Subject) -> Study:
    """Return the study of a scene's settings with the axes of a preset.

    Parameters
    ----------
    name
        padding, period, images, grid or pareto.
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
        if prod(cells) <= MOST and cells[0] <= MOST_ACROSS
    ]
    across = [cells[0] for _, cells in grids]
    hertz = subject.exact
    of_period = "over the scene's own" if hertz is None else "over Hertz half-width"
    own: tuple[Value, ...] = (1,) if hertz is None else (WIDTH,)
    axes = [
        Axis(
            "padding",
            (*PADDINGS, FREE) if subject.is_free else tuple(PADDINGS),
            "representation of the periodic direction",
        ),
        Axis("images", IMAGES.get(name, (6,)), "periods superposed on each side"),
        Axis(
            "period",
            (OWN_PERIODS if hertz is None else PERIODS).get(name, own),
            f"period length {of_period}",
        ),
        Axis(
            "grid",
            {"grid": tuple(across), "pareto": tuple(across[2:])}.get(
                name, (across[-3 if hertz is None else -1],)
            ),
            "cells across the width",
        ),
    ]
    if name == "pareto":
        axes.append(Axis("solver_tolerance", (1e-2, 1e-4), "residual to which the solver goes"))
    finest = next(m for m in MULTIPLES if is_reference(m) and m >= 3 * grids[-1][0])
    reference = None if hertz is not None else cells_at(subject.unit, finest)
    against = "Hertz's contact" if reference is None else (
        f"a solution on {reference[0]} x {reference[1]} cells at the scene's own boundary"
    )  # fmt: skip
    return Study(
        name,
        f"{TITLES[name]}, for {subject.name}.",
        tuple(axes),
        _SettingAt(subject, reference),
        measures,
        attributes={"scene": subject.text, "scene_name": subject.name, "against": against},
    )


@dataclass(frozen=True, eq=False)
class _SettingAt:
    """Function of a point that returns its case."""

    subject: Subject
    reference: tuple[int, int] | None

    def __call__(self, point: Point) -> SettingCase:
        subject = self.subject
        mode = str(point["padding"])
        padding = (
            subject.own if mode == FREE and subject.is_free
            else padding_at(mode, int(point["images"]))
        )  # fmt: skip
        across = whole("grid", point["grid"], 2, "give at least 2 cells across the width")
        grid, periods = self._grid(across, point["period"])
        return SettingCase(
            scene=subject.scene,
            grid=grid,
            padding=padding,
            options=replace(subject.options, tolerance=float(point.get("solver_tolerance", TIGHT))),
            time_steps=subject.times,
            subject=subject,
            own=subject.own,
            reference=self.reference,
            periods=periods,
        )

    def _grid(self, across: int, period: Value) -> tuple[cs.Grid, int]:
        """Return the grid of a period, and how many of the scene's own it has."""
        subject, (width, length) = self.subject, self.subject.extent
        if (hertz := subject.exact) is not None:
            # nothing varies along the length, so that any period will do; cells are square
            length = hertz.half_width * positive(
                "period", period, "give a period above 0 half-widths"
            )
            return cs.Grid((across, max(2, round(across * length / width))), (width, length)), 1
        periods = whole("period", period, 1, "give a whole number of the scene's own periods")
        if periods > 1 and any(
            isinstance(shape, cs.MeasuredSurface) for shape in subject.scene.shapes
        ):
            raise cs.InvalidInput(MEASURED.format(periods))
        if periods > 1 and subject.is_free:
            raise cs.InvalidInput(
                f"period is {periods}, and {subject.name} ends along its length: give 1."
            )
        unit = subject.unit
        along = 1 if unit[1] == 1 else max(2, round(across * unit[1] / unit[0]))
        return cs.Grid((across, along * periods), (width, length * periods)), periods


def measures(case: SettingCase, result: Solved) -> Mapping[str, xr.Variable]:
    """Return the relative errors of the pressure in L1 and of the main numbers, against the reference."""
    assert case.subject is not None
    answer = result.answer
    if case.reference is None:
        assert isinstance(answer, cs.Contact)
        return line_contact.measures(case, answer)
    reference = _reference(case.subject, case.reference)
    error = relative_l1(pressure_of(answer), _repeated(pressure_of(reference), case.periods))
    measured = {"pressure_error_l1": number(error, "relative L1 error of the pressure")}
    found = numbers_of(answer)
    for name, value in numbers_of(reference).items():
        if value and name in found:
            what = f"relative error of the {REPORTED[name]}"
            measured[f"{name}_error"] = number(found[name] / value - 1, what)
    return measured


@lru_cache(maxsize=1)
def _reference(subject: Subject, cells: tuple[int, int]) -> Answer:
    """Return the answer at the scene's own boundary, solved once in each process; it is the same for all cases."""
    return subject.solve(Setting(subject.own, cells, TIGHT))


def _repeated(pressure: Array, periods: int) -> Array:
    """Return a pressure (x, y) over several periods; an even number begins in the middle of one."""
    shift = pressure.shape[1] // 2 if periods % 2 == 0 else 0
    return np.roll(np.tile(pressure, (1, periods)), shift, axis=1)


_PAPER = paper_described().subject()
padding, period, images, grid, pareto = (preset(name, _PAPER) for name in TITLES)
