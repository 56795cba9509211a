"""Seconds of a setting before it runs: fitted to stored times, or from a small one timed just now."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import log2, log10, prod

import numpy as np
import xarray as xr

import contactstudy as cs
from contactstudy.domain.fields import Array
from contactstudy.domain.padding import Paddings
from contactstudy.planning.cost import SMOOTH_ITERATIONS, Timed, padded, timed
from studies.model.outcome import CaseStatus
from studies.reference.line_contact import LINE, PADDINGS, padding_at

# Images between which the time to set up is taken as a straight line, where nothing is stored.
FEW, MANY = 1, 6
# The default tolerance, at which iterations are counted.
DIGITS = 8


def mode_of(grid: cs.Grid, padding: cs.Padding | Paddings) -> str:
    """The name the sweeps give a padding along the length; "line" for exact periodicity on one cell.

    "free" for a pair of paddings.
    """
    if isinstance(padding, tuple):
        return "free"
    if isinstance(padding, cs.ExactPeriodicity) and grid.cells[1] == 1:
        return LINE
    names = (name for name, make in PADDINGS.items() if type(make(1)) is type(padding))
    return next(names, "")


@dataclass(frozen=True, eq=False)
class Fit:
    """Seconds to set up and to solve as sums of terms, each in proportion to its share of the work."""

    setup: Array
    solve: Array

    def seconds(self, grid: cs.Grid, padding: cs.Padding, tolerance: float, times: float) -> float:
        """With ``times`` as many iterations as a smooth contact takes."""
        setup, solve = _terms(grid, padding, tolerance)
        return float(setup @ self.setup + times * (solve @ self.solve))


@dataclass(frozen=True, eq=False)
class CostModel:
    """Fits by mode; what has none is timed on this machine when it is first asked for."""

    fits: Mapping[str, Fit]
    samples: dict[str, Timed] = field(default_factory=dict)

    def seconds(
        self, grid: cs.Grid, padding: cs.Padding | Paddings, tolerance: float, iterations: float
    ) -> float:
        """Set-up and solve on one thread, where a solve to 1e-8 takes so many ``iterations``."""
        mode = mode_of(grid, padding)
        if mode in self.fits and not isinstance(padding, tuple):
            return self.fits[mode].seconds(grid, padding, tolerance, iterations / SMOOTH_ITERATIONS)
        scaled = iterations * -log10(tolerance) / DIGITS
        return self._timed(mode, grid, padding).seconds(grid, padding, scaled)

    def _timed(self, mode: str, grid: cs.Grid, padding: cs.Padding | Paddings) -> Timed:
        if isinstance(padding, tuple) or not hasattr(padding, "images"):
            return self._sample(grid, padding)
        few, many = (self._sample(grid, padding_at(mode, images)) for images in (FEW, MANY))
        each = max(many.setup - few.setup, 0.0) / (MANY - FEW)
        return replace(few, setup=max(few.setup + each * (padding.images - FEW), 0.0))

    def _sample(self, grid: cs.Grid, padding: cs.Padding | Paddings) -> Timed:
        key = repr((min(grid.cells[1], 2), padding))
        if key not in self.samples:
            self.samples[key] = timed(grid, padding)
        return self.samples[key]


def cost_model(dataset: xr.Dataset | None, cpu: str) -> CostModel:
    """Fitted to a stored ``pareto`` if its times are those of this ``cpu``, else without fits."""
    if dataset is None or dataset.attrs.get("cpu") != cpu:
        return CostModel({})
    reference_runs = dataset[["setup_time", "solve_time", "case_status"]].sel(
        solver="preconditioned_cg"
    )
    fits = {}
    for mode in (str(name) for name in dataset["padding"].values):
        rows = [
            _row(mode, reference_runs.sel(padding=mode).isel(at)) for at in _places(reference_runs)
        ]
        known = [row for row in rows if row is not None]
        if len(known) > 3:
            setups, solves, times = (np.array(part) for part in zip(*known, strict=True))
            fits[mode] = Fit(_shares(setups, times[:, 0]), _shares(solves, times[:, 1]))
    return CostModel(fits)


def _places(dataset: xr.Dataset) -> list[dict[str, int]]:
    axes = ("images", "period", "grid", "solver_tolerance")
    shape = tuple(dataset.sizes[name] for name in axes)
    return [dict(zip(axes, index, strict=True)) for index in np.ndindex(shape)]


def _row(mode: str, one: xr.Dataset) -> tuple[Array, Array, Array] | None:
    times = np.array([float(one["setup_time"]), float(one["solve_time"])])
    if int(one["case_status"]) != CaseStatus.OK or not (times > 0).all():
        return None
    cells = int(one["grid"])
    grid = cs.Grid((cells, 1 if mode == LINE else cells), (1.0, float(one["period"])))
    padding = padding_at("exact" if mode == LINE else mode, int(one["images"]))
    return *_terms(grid, padding, float(one["solver_tolerance"])), times


def _terms(grid: cs.Grid, padding: cs.Padding, tolerance: float) -> tuple[Array, Array]:
    cells, points, digits = prod(grid.cells), padded(grid, padding), -log10(tolerance)
    images = 1 if padding.window is None else len(padding.window)
    setup = np.array([1.0, cells, cells * images])
    return setup, np.array([1.0, digits, digits * points * log2(points)])


def _shares(terms: Array, times: Array) -> Array:
    """Of each term, none of them negative, by least squares of the relative errors."""
    from scipy.optimize import nnls

    size = terms.max(axis=0)
    return np.asarray(nnls(terms / size / times[:, None], np.ones(len(times)))[0] / size)
