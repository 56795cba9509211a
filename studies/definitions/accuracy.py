"""Error estimates on every kind of surface, beside the true errors."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from math import inf

import numpy as np
import xarray as xr

import contactstudy as cs
from contactstudy.io.dataset import flags
from studies.model.axis import Axis, one_of
from studies.model.case import Case, number
from studies.model.study import Point
from studies.reference.accuracy.case import Errors, errors
from studies.reference.accuracy.matrix import matrix

points = (Axis("case", tuple(matrix()), "contact with a known truth"),)

# the grids are small, and their times are not reported
times = "none"

METRICS = tuple(field.name for field in fields(Errors))
# stored where the true error is not known, since nan marks a failure
UNKNOWN = -1.0
KINDS = tuple(dict.fromkeys(case.kind for case in matrix().values()))


@dataclass(frozen=True)
class AccuracyRun:
    """A case of the accuracy matrix, by its name."""

    name: str

    def prepare(self) -> cs.Problem:
        """Return the problem."""
        return matrix()[self.name].problem()

    def run(self, prepared: cs.Problem) -> cs.Solution:
        """Solve with the default options."""
        return cs.solve(prepared)

    def record(self, result: cs.Solution) -> Mapping[str, xr.Variable]:
        """Return the solver's numbers."""
        case = matrix()[self.name]
        return Case(case.scene, case.grid, case.padding).record(result)


def scene_at(point: Point) -> AccuracyRun:
    """Return a case by its name."""
    return AccuracyRun(one_of("case", point["case"], matrix()))


def measures(case: AccuracyRun, solution: cs.Solution) -> Mapping[str, xr.Variable]:
    """Return ``<metric>_error``, -1 where it is not known, and ``<metric>_bound``, infinite where there is none."""
    judged = matrix()[case.name]
    estimate, true = cs.error_estimate(solution), errors(solution, judged.truth())
    kind = np.asarray(KINDS.index(judged.kind))
    variables = {
        "kind": flags((), kind, [name.replace(" ", "_") for name in KINDS], "kind of surface")
    }
    for metric in METRICS:
        error, bound = getattr(true, metric), getattr(estimate, metric).total
        label = metric.replace("_", " ")
        stored_error = error if error == error else UNKNOWN  # nan is not itself
        variables[f"{metric}_error"] = number(stored_error, f"relative error of the {label}")
        variables[f"{metric}_bound"] = number(bound, f"bound of the relative error of the {label}")
    missing = inf in {getattr(estimate, metric).total for metric in METRICS}
    variables["silent"] = number(
        int(missing and not estimate.warnings), "1 where a bound is missing without a reason"
    )
    return variables
