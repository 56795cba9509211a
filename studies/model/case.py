"""Computations of a study, as values that define the contact and the accuracy."""

from collections.abc import Hashable, Mapping
from dataclasses import dataclass, field, replace
from time import perf_counter
from typing import Any, NamedTuple, Protocol

import numpy as np
import xarray as xr

import contactstudy as cs
from contactstudy.domain.errors import Request
from contactstudy.evolution.trajectory import Trajectory
from contactstudy.io.dataset import contact_fields, flags


class Computation(Hashable, Protocol):
    """Protocol of the computation at a point of a study.

    Points with equal computations share one. The two steps are timed separately, as ``setup_time``
    and ``solve_time``.
    """

    def prepare(self) -> Any:
        """Return what :meth:`run` needs, such as a problem."""
        ...

    def run(self, prepared: Any) -> Any:
        """Return the result, from what was prepared."""
        ...

    def record(self, result: Any) -> Mapping[str, xr.Variable]:
        """Return the variables stored of every result, in addition to a study's own measures."""
        ...


@dataclass(frozen=True)
class PosedCase:
    """A ``scene`` on a ``grid`` with a ``padding``, and the ``options`` of its solve."""

    scene: cs.Scene
    grid: cs.Grid
    padding: cs.Padding | cs.Paddings
    options: cs.SolveOptions = field(default_factory=cs.SolveOptions)


class Case(PosedCase):
    """A dry contact at rest to solve.

    Parameters
    ----------
    scene
        The scene.
    grid
        Cells.
    padding
        Boundary conditions.
    options
        Solver and its tolerance.
    """

    def prepare(self) -> cs.Problem:
        """Return the problem, with influence coefficients, their transforms and the gap."""
        return self.scene.problem(self.grid, self.padding)

    def run(self, prepared: cs.Problem) -> cs.Contact:
        """Return the solution of the problem."""
        return cs.solve(prepared, options=self.options)

    def record(self, result: cs.Contact) -> Mapping[str, xr.Variable]:
        """Return the numbers of the solver, and its status as CF flags."""
        return recorded(result)

    def fields(self, result: cs.Contact) -> Mapping[str, xr.Variable]:
        """Return pressure [Pa] and gap [m] over the grid."""
        dataset = contact_fields(result)
        return {name: dataset[name].variable for name in ("x", "y", "pressure", "gap")}


@dataclass(frozen=True, eq=False)
class TimedAnswer:
    """An answer with the wall time [s] of its set-up and solve."""

    answer: cs.Contact | cs.LubricatedContact | cs.Evolution
    seconds: float

    @property
    def trajectory(self) -> Trajectory:
        """Steps of a dry contact that changes in time."""
        assert isinstance(self.answer, cs.Evolution)
        assert self.answer.trajectory is not None
        return self.answer.trajectory


class TimedProblem(NamedTuple):
    """A problem with the wall time [s] of its set-up."""

    problem: cs.Problem
    seconds: float


@dataclass(frozen=True)
class SceneCase(PosedCase):
    """A scene of any kind to solve.

    Parameters
    ----------
    scene, grid, padding, options
        As of :class:`Case`.
    time_steps
        Instants and steps of a scene that changes in time; None for others.
    error
        Requested relative error of every number, or errors by name, of which steps in time take a part; None without a
        request.
    """

    time_steps: cs.TimeSteps | None = None
    error: Request | None = field(default=None, hash=False)

    def prepare(self) -> TimedProblem | None:
        """Return the problem of a dry contact at rest; other scenes set up theirs while they are solved."""
        scene, start = self.scene, perf_counter()
        if (
            scene.lubrication is not None
            or scene.takes_times
            or scene.rolls
            or scene.wears_steadily
        ):
            return None
        problem = scene.problem(self.grid, self.padding)
        return TimedProblem(problem, perf_counter() - start)

    def run(self, prepared: TimedProblem | None = None) -> TimedAnswer:
        """Return the answer with its wall time [s], which is shorter where the coefficients of its grid are cached."""
        start = perf_counter()
        answer: cs.Contact | cs.LubricatedContact | cs.Evolution
        if prepared is not None:
            start -= prepared.seconds
            answer = cs.solve(prepared.problem, options=self.options)
        else:
            answer = cs.solve(
                self.scene, self.grid, self.padding,
                times=self.time_steps, error=self.error if self.time_steps else None, options=self.options,
            )  # fmt: skip
        return TimedAnswer(replace(answer, requested=self.error), perf_counter() - start)

    def record(self, result: TimedAnswer) -> Mapping[str, xr.Variable]:
        """Return the numbers of the solver, and its status as CF flags."""
        return recorded(result.answer)

    def fields(self, result: TimedAnswer) -> Mapping[str, xr.Variable]:
        """Return all fields of the answer, without the displacement, which follows from the gap."""
        dataset = result.answer.to_dataset()
        return {
            str(name): variable
            for name, variable in dataset.variables.items()
            if variable.ndim and name != "displacement" and "cause" not in variable.dims
        }


def recorded(answer: cs.Contact | cs.LubricatedContact | cs.Evolution) -> dict[str, xr.Variable]:
    """Return the numbers of the solver of any answer, and its status as CF flags."""
    counts = {name: dimensionless(value, label) for name, (value, label) in answer.counts.items()}
    return {"solver_status": solver_status(answer.status, "how the solver ended"), **counts}


def solver_status(status: cs.Status, long_name: str) -> xr.Variable:
    """Return the status of a solution as a CF flag."""
    statuses = list(cs.Status)
    meanings = [member.name.lower() for member in statuses]
    return flags((), np.asarray(statuses.index(status)), meanings, long_name)


def dimensionless(values: Any, long_name: str, *dims: str) -> xr.Variable:
    """Return a dimensionless number, or an array of them along `dims`, as a variable with a long name."""
    return xr.Variable(dims, values, {"units": "1", "long_name": long_name})


def dimensionless_variables(measured: Mapping[str, tuple[float, str]]) -> dict[str, xr.Variable]:
    """Return dimensionless numbers as variables by name, from values with their long names."""
    return {
        name: dimensionless(float(value), long_name)
        for name, (value, long_name) in measured.items()
    }


def contact_fraction(pressure: np.ndarray) -> xr.Variable:
    """Return the fraction of the cells under pressure (x, y)."""
    return dimensionless(float((pressure > 0).mean()), "fraction of cells in contact")


def error_estimates(estimate: cs.ErrorEstimate) -> dict[str, xr.Variable]:
    """Return the estimated relative errors of an answer, in all and by cause.

    They have the names ``<quantity>_estimate`` and ``<quantity>_estimate_<cause>``, and that of the L1
    error ``pressure_l1_estimate``.
    """
    measured: dict[str, xr.Variable] = {}
    for quantity, parts in estimate:
        name = "pressure_l1" if quantity == "l1" else quantity
        what = "pressure in L1" if quantity == "l1" else quantity.replace("_", " ")
        description = f"estimated relative error of the {what}"
        measured[f"{name}_estimate"] = dimensionless(parts.total, description)
        for cause, part in parts.by_cause.items():
            measured[f"{name}_estimate_{cause}"] = dimensionless(part, f"{description}, by {cause}")
    return measured
