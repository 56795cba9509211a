"""Error estimates on every kind of surface, beside the true errors.

The margins of the estimates may be calibrated on one half of the matrix. They are validated on the other half, and on
random contacts of each ``--seed``.
"""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from math import inf, isnan

import numpy as np
import xarray as xr

import contactstudy as cs
from contactstudy.domain.checks import whole_number
from contactstudy.io.dataset import flags
from studies.model.axis import Axis, one_of
from studies.model.case import dimensionless, recorded
from studies.model.study import Point
from studies.reference.accuracy.case import AccuracyCase, Errors, errors
from studies.reference.accuracy.matrix import matrix
from studies.reference.accuracy.random_scenes import NAMES, RANDOM, random_case

axes = (
    Axis("case", (*matrix(), *NAMES), "contact with a known solution"),
    Axis("seed", (1,), "choice of the random contacts"),
)

# the grids are small, and their times are not reported
times = "none"

METRICS = tuple(field.name for field in fields(Errors))
KINDS = (*dict.fromkeys(case.kind for case in matrix().values()), *RANDOM)
# Use of a contact: calibration of the margins of the estimates, or their validation, of random contacts too.
USES = ("calibration", "validation", "random")


def use_of(name: str) -> str:
    """Return the use of a contact, see `USES`: of each kind of the matrix every other one."""
    if name in NAMES:
        return "random"
    return "validation" if int(name.rpartition(" ")[2]) % 2 else "calibration"


@dataclass(frozen=True)
class AccuracyRun:
    """A case of the accuracy matrix, or a random one, by its name and seed."""

    name: str
    seed: int

    @property
    def case(self) -> AccuracyCase:
        """Scene, grid, padding and truth."""
        return random_case(self.name, self.seed) if self.name in NAMES else matrix()[self.name]

    def prepare(self) -> cs.Problem:
        """Return the problem."""
        return self.case.problem()

    def run(self, prepared: cs.Problem) -> cs.Contact:
        """Solve with the default options."""
        return cs.solve(prepared)

    def record(self, result: cs.Contact) -> Mapping[str, xr.Variable]:
        """Return the solver's numbers."""
        return recorded(result)


def case_at(point: Point) -> AccuracyRun:
    """Return a case by its name and seed."""
    name = one_of("case", point["case"], (*matrix(), *NAMES))
    seed = whole_number("seed", point["seed"], 0, "must be a whole number, at least 0")
    # contacts of the matrix are the same for all seeds
    return AccuracyRun(name, seed if name in NAMES else 0)


def measures(case: AccuracyRun, solution: cs.Contact) -> Mapping[str, xr.Variable]:
    """Return ``<metric>_error`` where it is known, and ``<metric>_bound``, infinite where there is none."""
    judged = case.case
    estimate, true = solution.error, errors(solution, judged.truth())
    kind, use = np.asarray(KINDS.index(judged.kind)), np.asarray(USES.index(use_of(case.name)))
    variables = {
        "kind": flags((), kind, [name.replace(" ", "_") for name in KINDS], "kind of surface"),
        "use": flags((), use, list(USES), "use of the contact"),
    }
    for metric in METRICS:
        error, bound = getattr(true, metric), getattr(estimate, metric).total
        label = f"relative error of the {metric.replace('_', ' ')}"
        if not isnan(error):
            variables[f"{metric}_error"] = dimensionless(error, label)
        variables[f"{metric}_bound"] = dimensionless(bound, f"bound of the {label}")
    is_missing = inf in {getattr(estimate, metric).total for metric in METRICS}
    without_reason = int(is_missing and not estimate.warnings)
    what = "1 where a bound is missing without a reason"
    return variables | {"missing_without_reason": dimensionless(without_reason, what)}
