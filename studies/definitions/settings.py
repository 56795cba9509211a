"""Settings of any scene as a study: padding, n, period, grid and tolerance, with errors against a finer reference."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import prod

import numpy as np
import xarray as xr

import contactstudy as cs
from contactstudy.domain.checks import whole
from contactstudy.domain.fields import Array
from contactstudy.domain.identity import canonical
from contactstudy.domain.identity import key as hashed
from studies.advice.ladder import MULTIPLES, cells_at, is_reference
from studies.advice.subject import (
    REPORTED,
    Answer,
    Setting,
    Subject,
    hertz_means,
    numbers_of,
    paper_described,
    pressure_of,
    relative_l1,
)
from studies.model.axis import Axis, Value, one_of
from studies.model.case import SceneCase, Solved, number
from studies.model.study import Point, Study
from studies.reference.line_contact import PADDINGS, padding_at

FREE = "free"
# Tolerance of the reference.
TIGHT = 1e-8
# Cells of the finest grid that a study has unless told otherwise.
MOST = 2**15
TITLES = {
    "padding": "Paddings side by side",
    "period": "Accuracy against the period, in whole numbers of the scene's own",
    "images": "Accuracy against the number n of superposed periods",
    "grid": "Accuracy against the number of cells",
    "pareto": "Cost of accuracy: paddings, n, grids and tolerances",
}
MEASURED = "Period {} of the scene's own: a measured surface has one period, give 1."


@dataclass(frozen=True)
class SettingCase(SceneCase):
    """A scene at one setting, judged against its own boundary on `reference` cells; Hertz judges where that is None."""

    subject: Subject | None = field(default=None, compare=False)
    own: cs.Padding | cs.Paddings = field(default_factory=cs.ExactPeriodicity)
    reference: tuple[int, int] | None = None
    periods: int = 1


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
        if prod(cells) <= MOST and cells[0] <= MOST**0.5 * 4
    ]
    across = [cells[0] for _, cells in grids]
    modes = tuple(PADDINGS) if not subject.is_free else (*PADDINGS, FREE)
    axes: dict[str, tuple[Value, ...]] = {
        "padding": modes,
        "images": (1, 6),
        "period": (1,),
        "grid": (across[-3],),
        "solver_tolerance": (TIGHT,),
    }
    presets: dict[str, dict[str, tuple[Value, ...]]] = {
        "padding": {"images": (1, 6, 20)},
        "period": {"period": (1, 2, 3)},
        "images": {"images": (0, 1, 2, 3, 4, 6, 8, 10, 20)},
        "grid": {"grid": tuple(across)},
        "pareto": {"grid": tuple(across[2:]), "solver_tolerance": (1e-2, 1e-4)},
    }
    axes |= presets[name]
    words = {
        "padding": "representation of the periodic direction",
        "images": "periods superposed on each side",
        "period": "period length over the scene's own",
        "grid": "cells across the width",
        "solver_tolerance": "residual to which the solver goes",
    }
    finest = next(m for m in MULTIPLES if is_reference(m) and m >= 3 * grids[-1][0])
    reference = None if subject.exact is not None else cells_at(subject.unit, finest)
    return Study(
        name,
        f"{TITLES[name]}, for {subject.name}.",
        tuple(Axis(axis, values, words[axis]) for axis, values in axes.items()),
        _SettingAt(subject, reference),
        measures,
        attributes={"scene": subject.text},
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
            else padding_at(mode, whole("images", point["images"], 0, "must be a whole number, at least 0"))
        )  # fmt: skip
        periods = whole("period", point["period"], 1, "must be a whole number, at least 1")
        if periods > 1 and any(
            isinstance(shape, cs.MeasuredSurface) for shape in subject.scene.shapes
        ):
            raise cs.InvalidInput(MEASURED.format(periods))
        if periods > 1 and subject.is_free:
            raise cs.InvalidInput(
                f"period is {periods}, and {subject.name} ends along its length: give 1."
            )
        across = whole(
            "grid", point["grid"], 2, "must be a whole number of cells across, at least 2"
        )
        unit = subject.unit
        along = 1 if unit[1] == 1 else max(2, round(across * unit[1] / unit[0]))
        width, length = subject.extent
        return SettingCase(
            scene=subject.scene,
            grid=cs.Grid((across, along * periods), (width, length * periods)),
            padding=padding,
            options=replace(subject.options, tolerance=float(point["solver_tolerance"])),
            time_steps=subject.times,
            subject=subject,
            own=subject.own,
            reference=self.reference,
            periods=periods,
        )


def measures(case: SettingCase, result: Solved) -> Mapping[str, xr.Variable]:
    """Return the relative errors of the pressure in L1 and of the main numbers, against the reference."""
    assert case.subject is not None
    answer = result.answer
    if case.reference is None:
        hertz = case.subject.exact
        assert hertz is not None
        error = relative_l1(pressure_of(answer), hertz_means(hertz, case.grid))
        return {"pressure_error_l1": number(error, "relative L1 error of the pressure")}
    reference = _reference(case.subject, case.reference)
    error = relative_l1(pressure_of(answer), _repeated(pressure_of(reference), case.periods))
    measured = {"pressure_error_l1": number(error, "relative L1 error of the pressure")}
    found = numbers_of(answer)
    for name, value in numbers_of(reference).items():
        if value and name in found:
            scale = value * (case.periods if name == "contact_area" else 1)
            what = f"relative error of the {REPORTED[name]}"
            measured[f"{name}_error"] = number(found[name] / scale - 1, what)
    return measured


# The last reference of this process, by its scene and cells.
_LAST: dict[tuple[str, tuple[int, int]], Answer] = {}


def _reference(subject: Subject, cells: tuple[int, int]) -> Answer:
    """Return the answer at the scene's own boundary, solved once in each process."""
    key = hashed(canonical((subject.scene, subject.extent, subject.own, subject.times))), cells
    if key not in _LAST:
        _LAST.clear()
        _LAST[key] = subject.solve(Setting(subject.own, cells, TIGHT))
    return _LAST[key]


def _repeated(pressure: Array, periods: int) -> Array:
    """Return a pressure (x, y) over several periods; an even number begins in the middle of one."""
    shift = pressure.shape[1] // 2 if periods % 2 == 0 else 0
    return np.roll(np.tile(pressure, (1, periods)), shift, axis=1)


pareto = preset("pareto", paper_described().subject())
