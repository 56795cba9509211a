"""Computations of a study, as values that define the contact and the accuracy."""

from collections.abc import Hashable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Protocol

import numpy as np
import xarray as xr

import contactstudy as cs
from contactstudy.domain.errors import Request
from contactstudy.io.dataset import flags, known_or_nan
from contactstudy.scene import combinations as methods

Answer = cs.Contact | cs.LubricatedContact | cs.Evolution


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
class Case:
    """A scene of any kind to solve.

    Parameters
    ----------
    scene, grid, padding, options
        The scene, its cells and boundary conditions, and the solver with its tolerance.
    time_steps
        Instants and steps of a scene that changes in time; None for others.
    error
        Requested relative error of every number, or errors by name, of which steps in time take a part; None without a
        request.
    reference
        Case on the same extent, against whose answer errors are measured; None without one.
    """

    scene: cs.Scene
    grid: cs.Grid
    padding: cs.Padding | cs.Paddings
    options: cs.SolveOptions = field(default_factory=cs.SolveOptions)
    time_steps: cs.TimeSteps | None = None
    error: Request | None = field(default=None, hash=False)
    reference: "Case | None" = None

    def prepare(self) -> cs.Problem | None:
        """Return the problem of a dry contact at rest; other scenes set up theirs while they are solved."""
        if self.scene.method is not methods.STATIC:
            return None
        return self.scene.problem(self.grid, self.padding)

    def run(self, prepared: cs.Problem | None = None) -> Answer:
        """Return the answer, of the problem that was prepared if there is one."""
        answer: Answer
        if prepared is not None:
            answer = cs.solve(prepared, options=self.options)
        else:
            answer = cs.solve(
                self.scene, self.grid, self.padding,
                times=self.time_steps, error=self.error if self.time_steps else None, options=self.options,
            )  # fmt: skip
        return replace(answer, requested=self.error)

    def record(self, answer: Answer) -> Mapping[str, xr.Variable]:
        """Return the numbers of the solver, and its status as CF flags."""
        return recorded(answer)

    def fields(self, answer: Answer) -> Mapping[str, xr.Variable]:
        """Return all fields of the answer, without the displacement, which follows from the gap."""
        return {
            str(name): variable
            for name, variable in answer.to_dataset().variables.items()
            if variable.ndim and name != "displacement" and "cause" not in variable.dims
        }


def recorded(answer: Answer) -> dict[str, xr.Variable]:
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


def error_estimates(estimate: cs.ErrorEstimate) -> dict[str, xr.Variable]:
    """Return the estimated relative errors of an answer, in all and by cause.

    They have the names ``<quantity>_estimate`` and ``<quantity>_estimate_<cause>``, and that of the L1
    error ``pressure_l1_estimate``. One that is not known is NaN.
    """
    measured: dict[str, xr.Variable] = {}
    for quantity, parts in estimate:
        name = "pressure_l1" if quantity == "l1" else quantity
        what = "pressure in L1" if quantity == "l1" else quantity.replace("_", " ")
        description = f"estimated relative error of the {what}"
        measured[f"{name}_estimate"] = dimensionless(known_or_nan(parts.total), description)
        for cause, part in parts.by_cause.items():
            about = f"{description}, by {cause}"
            measured[f"{name}_estimate_{cause}"] = dimensionless(known_or_nan(part), about)
    return measured
