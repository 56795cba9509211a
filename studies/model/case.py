"""One computation of a study: a value that says what to compute, and how exactly."""

from collections.abc import Hashable, Mapping
from dataclasses import asdict, dataclass, field
from typing import Any, Protocol

import numpy as np
import xarray as xr

import contactstudy as cs
from contactstudy.io.dataset import flags


class Computation(Hashable, Protocol):
    """What a study computes at a point.

    Two points with equal computations share one. The two steps are timed apart, as ``setup_time``
    and ``solve_time``.
    """

    def prepare(self) -> Any:
        """Return the set-up."""
        ...

    def run(self, prepared: Any) -> Any:
        """Return the result, from what was prepared."""
        ...

    def record(self, result: Any) -> Mapping[str, xr.Variable]:
        """What is kept of every result, whatever else a study measures of it."""
        ...


@dataclass(frozen=True)
class Case:
    """A contact to solve: a scene on a grid with a padding, and the solver's settings."""

    scene: cs.Scene
    grid: cs.Grid
    padding: cs.Padding | cs.Paddings
    options: cs.SolveOptions = field(default_factory=cs.SolveOptions)

    def prepare(self) -> cs.Problem:
        """Influence coefficients, transforms, gap."""
        return self.scene.problem(self.grid, self.padding)

    def run(self, prepared: cs.Problem) -> cs.Solution:
        """The solve proper."""
        return self.options.solved(prepared)

    def record(self, result: cs.Solution) -> Mapping[str, xr.Variable]:
        """The solver's own numbers, and its status as CF flags."""
        return {
            "solver_status": solver_status(result.status, "how the solver ended"),
            "iterations": number(result.iterations, "solver iterations"),
            "convolutions": number(result.convolutions, "transform pairs of the full grid"),
            "residual": number(result.residual, "residual of the solver"),
        }

    def fields(self, result: cs.Solution) -> Mapping[str, xr.Variable]:
        """Pressure and gap over the grid, for those who ask for fields."""
        dataset = cs.to_dataset(result)
        return {name: dataset[name].variable for name in ("x", "y", "pressure", "gap")}


@dataclass(frozen=True)
class EvolutionCase:
    """A contact that changes in time: a scene marched through ``times`` [s].

    With an ``error``, steps between the times are chosen to meet it.
    """

    scene: cs.Scene
    grid: cs.Grid
    padding: cs.Padding | cs.Paddings
    times: tuple[float, ...]
    error: float | None = None
    scheme: str = "IMPLICIT"
    step_error: str = "COMPANION"
    tolerance: float = 1e-8

    def prepare(self) -> None:
        """Do nothing: a march sets itself up."""

    def run(self, prepared: object = None) -> cs.Evolution:
        """March through the times."""
        return cs.evolve(
            self.scene,
            self.grid,
            self.padding,
            times=self.times,
            error=self.error,
            scheme=cs.Scheme[self.scheme],
            step_error=cs.StepError[self.step_error],
            tolerance=self.tolerance,
        )

    def record(self, result: cs.Evolution) -> Mapping[str, xr.Variable]:
        """Return the solver's numbers over all steps."""
        return {
            "solver_status": solver_status(result.status, "how the worst step ended"),
            "iterations": number(result.iterations, "solver iterations of all steps"),
            "convolutions": number(result.convolutions, "transform pairs of the full grid"),
            "residual": number(result.residual, "largest residual"),
            "solves": number(result.steps, "solves"),
        }


@dataclass(frozen=True)
class Operator:
    """A convolution to set up, and to apply once."""

    contact_modulus: float
    grid: cs.Grid
    padding: cs.Padding | cs.Paddings
    datum: float

    def prepare(self) -> cs.Convolution:
        """Influence coefficients and their transform."""
        return cs.convolution(self.contact_modulus, self.grid, self.padding, self.datum)

    def run(self, prepared: cs.Convolution) -> cs.Convolution:
        """One transform pair."""
        prepared(np.ones(self.grid.cells))
        return prepared

    def record(self, result: cs.Convolution) -> Mapping[str, xr.Variable]:
        """The size of what is transformed."""
        return {"padded_cells": number(int(np.prod(result.padded)), "cells of the padded grid")}


def solver_status(status: cs.Status, long_name: str) -> xr.Variable:
    """The status of a solution as a CF flag."""
    statuses = list(cs.Status)
    meanings = [one.name.lower() for one in statuses]
    return flags((), np.asarray(statuses.index(status)), meanings, long_name)


def number(value: float, long_name: str) -> xr.Variable:
    """A dimensionless number with its name."""
    return xr.Variable((), value, {"units": "1", "long_name": long_name})


def contact_share(pressure: np.ndarray) -> xr.Variable:
    """Of the cells of a grid, how many bear ``pressure`` (x, y)."""
    return number(float((pressure > 0).mean()), "share of cells in contact")


def error_estimates(solution: cs.Solution) -> Mapping[str, xr.Variable]:
    """``<metric>_estimate`` and its parts ``<metric>_estimate_<cause>``, for the peak pressure and L1."""
    estimate = cs.error_estimate(solution)
    metrics = {
        "peak_pressure": ("peak pressure", estimate.peak_pressure),
        "pressure_l1": ("pressure in L1", estimate.l1),
    }
    measured: dict[str, xr.Variable] = {}
    for name, (what, parts) in metrics.items():
        said = f"estimated relative error of the {what}"
        measured[f"{name}_estimate"] = number(parts.total, said)
        for cause, part in asdict(parts).items():
            measured[f"{name}_estimate_{cause}"] = number(part, f"{said}, by {cause}")
    return measured
