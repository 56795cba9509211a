"""A scene, its settings that were measured, the choice among them, and the dataset of both."""

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from math import prod
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

import contactstudy as cs
from contactstudy.domain.files import digest
from contactstudy.domain.grid import Array
from contactstudy.io.scene_files.structuring import scene_text, settings_text
from studies.reference.line_contact import HERTZ, SCENE, WIDTH
from studies.reference.paddings import padding_text

# A setting within this factor of the time of the fastest counts as equally fast.
TIE = 1.1
# Measures: what must meet the requested error. NAMED is for errors that are requested by the names of numbers.
EVERY_NUMBER, PRESSURE = "every number", "the pressure in L1"
NAMED = "every number that is named, in proportion to its own request"
# Name of the study of settings, and of its netCDF file.
SETTINGS = "settings"
# Variables of a setting and of what was measured of it, in the order of their fields: units and long name.
COLUMNS = {
    "label": ("", "padding"),
    "padding": ("", "padding as in Python"),
    "cells_across": ("1", "number of cells across"),
    "cells_along": ("1", "number of cells along"),
    "solver_tolerance": ("1", "tolerance of a solve"),
    "pressure_bound": ("1", "bound of the relative L1 error of the pressure"),
    "error_bound": ("1", "largest bound of the relative error of a number"),
    "worst": ("", "number of the largest bound"),
    "pressure_difference": ("1", "relative L1 difference of the pressure to the reference"),
    "processor_time": ("s", "least processor time of a solve on one thread"),
}
# Attributes of a verdict, whose texts are JSON where they are not plain.
ATTRIBUTES = {
    "scene_name": "name", "scene": "text", "requested_error": "error", "measure": "measure", "own": "own",
    "extent": "extent", "reference": "reference", "notes": "notes", "named_errors": "named",
}  # fmt: skip


@dataclass(frozen=True)
class Setting:
    """Way to solve a scene: padding, cells (across, along), tolerance of the solver."""

    padding: cs.Padding | cs.Paddings
    cells: tuple[int, int]
    tolerance: float

    @property
    def label(self) -> str:
        """Name of the padding."""
        if isinstance(self.padding, tuple):
            return "repeating across and along" if self.padding[0].wraps else "free ends"
        return padding_text(repr(self.padding))


@dataclass(frozen=True)
class Measured:
    """Measurement of a setting.

    Attributes
    ----------
    setting
        The setting.
    l1, error, worst
        Bound of the pressure in L1, the largest bound of any number that :func:`~contactstudy.solve` judges, and what
        that number is; nan where only the pressure was asked for.
    difference
        L1 difference of its pressure from the reference, nan without a reference.
    seconds
        Least processor time [s].
    """

    setting: Setting
    l1: float
    error: float
    worst: str
    difference: float
    seconds: float


@dataclass(frozen=True)
class Verdict:
    """Settings of a scene that were measured, and the choice among them.

    Attributes
    ----------
    name, text
        Name of the scene, and the scene as TOML.
    error
        Requested error. If numbers are named, it is the least of their errors; bounds of the others count in proportion.
    measure
        What must meet it: every number, those that are named, or the pressure in L1 alone where no setting meets the
        first.
    extent
        Width and length [m] of all grids.
    own
        Name of the padding that the scene itself has, or exact if it names none.
    reference
        What differences are against.
    settings
        What was measured, in the order in which it was tried.
    notes
        A sentence for each padding that has no answer.
    named
        Requested errors by the names of numbers; empty where one holds for all.
    """

    name: str
    text: str
    error: float
    measure: str
    extent: tuple[float, float]
    own: str
    reference: str
    settings: tuple[Measured, ...]
    notes: tuple[str, ...] = ()
    named: Mapping[str, float] = field(default_factory=dict)

    def best(self, error: float | None = None) -> Measured | None:
        """Return the fastest setting that meets an error; a tie goes to the scene's own padding and to more cells."""
        meeting = self.meeting(error)
        if not meeting:
            return None
        ties = [result for result in meeting if is_tie(result, meeting[0])]
        own = [result for result in ties if result.setting.label == self.own]
        return max(own or ties, key=lambda result: prod(result.setting.cells))

    def meeting(self, error: float | None = None) -> list[Measured]:
        """Return the settings that meet an error, the requested one if None, the fastest first."""
        limit = self.error if error is None else error
        meeting_limit = [result for result in self.settings if meets(result, limit, self.measure)]
        return sorted(meeting_limit, key=lambda result: result.seconds)

    def bound(self, result: Measured) -> float:
        """Return the bound of a setting for the verdict's measure, infinite without one."""
        return bound_of(result, self.measure)

    @property
    def nearest(self) -> Measured:
        """Setting of the least bound, or of the most cells if none has a bound."""
        return min(self.settings, key=lambda result: (self.bound(result), -result.setting.cells[0]))

    def toml(self, chosen: Measured) -> str:
        """Return the tables of a scene file that choose a setting."""
        setting = chosen.setting
        options = cs.SolveOptions(tolerance=setting.tolerance)
        plan = settings_text(cs.Grid(setting.cells, self.extent), setting.padding, options)
        named = {"pressure": self.error} if self.measure == PRESSURE else self.named
        errors = ", ".join(f"{name} = {error:g}" for name, error in named.items())
        return f"{plan}\n[plan]\nerror = {f'{{ {errors} }}' if named else f'{self.error:g}'}\n"


def is_tie(result: Measured, fastest: Measured) -> bool:
    """Return whether a setting is as fast as the fastest: by its time, or because it solves by the same transforms.

    Exact periodicity and a window that moves with the point differ on one grid in the set-up of the coefficients alone,
    by less than a busy machine adds to one of two times.
    """
    setting, fastest_setting = result.setting, fastest.setting
    is_same_grid = (setting.cells, setting.tolerance) == (fastest_setting.cells, fastest_setting.tolerance)
    has_same_transforms = (
        setting.padding == cs.ExactPeriodicity()
        and not isinstance(fastest_setting.padding, tuple)
        and fastest_setting.padding.wraps
    )
    return (is_same_grid and has_same_transforms) or result.seconds <= TIE * fastest.seconds


def bound_of(result: Measured, measure: str) -> float:
    """Return the bound of a setting that counts for a measure, infinite without one."""
    return result.l1 if measure == PRESSURE else result.error


def meets(result: Measured, error: float, measure: str) -> bool:
    """Return whether the bound of a setting meets an error, and its difference to the reference does not contradict it.

    That difference is of the pressure, which numbers that are named may not include: for these it counts for nothing.
    """
    contradicts = measure != NAMED and result.difference > error
    return bound_of(result, measure) <= error and not contradicts


@dataclass(frozen=True)
class SceneToJudge:
    """A scene with the grids on which it is solved.

    Attributes
    ----------
    name, text
        Name for people, and the scene as TOML.
    file
        The scene with its grid, padding and settings, if it has some.
    """

    name: str
    text: str
    file: cs.SceneFile

    @property
    def key(self) -> str:
        """Text that is equal for equal scenes alone."""
        file = self.file
        solved = file.scene, file.grid, file.padding, file.options, file.time_steps
        return digest((*solved, file.plan_settings.period))


def scene_in(path: Path) -> SceneToJudge:
    """Return the scene in a TOML file."""
    described = cs.read_scene(path)  # raises InvalidInput for an invalid file
    return SceneToJudge(path.stem, path.read_text(encoding="utf-8-sig"), described)


def paper_scene() -> SceneToJudge:
    """Return the paper's steel cylinder on its extent."""
    side = WIDTH * HERTZ.half_width
    file = cs.SceneFile(SCENE, grid=cs.Grid((24, 1), (side, side)))
    return SceneToJudge("the paper's cylinder", scene_text(SCENE, grid=file.grid), file)


def to_dataset(verdict: Verdict) -> xr.Dataset:
    """Return a verdict as a Dataset of its settings, with the rest as attributes."""
    rows = [
        (result.setting.label, repr(result.setting.padding), *result.setting.cells, result.setting.tolerance,
         result.l1, result.error, result.worst, result.difference, result.seconds)
        for result in verdict.settings
    ]  # fmt: skip
    data = {
        name: ("setting", list(values), {"long_name": about} | ({"units": units} if units else {}))
        for (name, (units, about)), values in zip(COLUMNS.items(), zip(*rows, strict=True), strict=True)
    }
    attributes: dict[str, Any] = {key: getattr(verdict, name) for key, name in ATTRIBUTES.items()}
    for key in ("notes", "named_errors"):
        attributes[key] = json.dumps(attributes[key])
    return xr.Dataset(data, attrs={"title": f"Settings of {verdict.name}"} | attributes)


def _padding(text: str) -> cs.Padding | cs.Paddings:
    """Return the padding of a representation in Python, or both of two."""
    stored = [
        getattr(cs, name)(*map(int, filter(None, [images])))
        for name, images in re.findall(r"(\w+)\((?:images=(\d+))?\)", text)
    ]
    return stored[0] if len(stored) == 1 else (stored[0], stored[1])


def from_dataset(dataset: xr.Dataset) -> Verdict:
    """Return the verdict in a Dataset."""
    rows = zip(*(dataset[name].values.tolist() for name in COLUMNS), strict=True)
    settings = tuple(
        Measured(Setting(_padding(padding), (across, along), tolerance), *measured)
        for _, padding, across, along, tolerance, *measured in rows
    )
    attributes: dict[str, Any] = {name: dataset.attrs[key] for key, name in ATTRIBUTES.items()}
    attributes["extent"] = tuple(np.asarray(attributes["extent"], float).tolist())
    attributes["notes"], attributes["named"] = (
        tuple(json.loads(attributes["notes"])),
        json.loads(attributes["named"]),
    )
    return Verdict(**attributes, settings=settings)


def pareto_front(cost: Array, error: Array) -> np.ndarray[tuple[int], np.dtype[np.intp]]:
    """Return the indices of the points that no other beats in both cost and error, by growing cost.

    Parameters
    ----------
    cost, error
        Flat arrays of one length; points with nan are left out.
    """
    order = np.lexsort((error, cost))
    order = order[np.isfinite(cost[order]) & np.isfinite(error[order])]
    best = np.minimum.accumulate(error[order])
    is_better = np.concatenate(([True], best[1:] < best[:-1]))[: len(order)]
    return order[is_better]
