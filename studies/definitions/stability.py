"""Hard cases: status and error with every padding and both solvers."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import inf

import numpy as np
import xarray as xr

import contactstudy as cs
from contactstudy.io.dataset import flags
from studies.model.axis import Axis, one_of
from studies.model.case import dimensionless, recorded
from studies.model.study import Point
from studies.reference.hard_case import PADDINGS, SOLVERS
from studies.reference.hard_cases import CASES

axes = (
    Axis("case", tuple(CASES), "hard case"),
    Axis(
        "padding",
        ("zero", "superposed", "exact", "exact on both"),
        "treatment of both directions (padding)",
    ),
    Axis("solver", tuple(SOLVERS), "solver"),
)

# the grids are small, and their times are not reported
times = "none"


# Verdicts: the error is within the stated one; a status explains why there is no solution; neither; or the case does
# not apply to the padding.
VERDICTS = ("within_stated_error", "explained_by_status", "wrong", "not_applicable")


@dataclass(frozen=True)
class HardCaseRun:
    """A hard case with one padding and one solver."""

    case: str
    padding: str
    solver: str

    @property
    def applies(self) -> bool:
        """True if the case applies to this padding."""
        return self.padding in CASES[self.case].paddings

    def prepare(self) -> cs.Problem:
        """Return the problem."""
        hard_case = CASES[self.case]
        return hard_case.scene.problem(hard_case.grid, PADDINGS[self.padding])

    def run(self, prepared: cs.Problem) -> cs.Contact:
        """Solve with the settings of the case."""
        return CASES[self.case].solve(prepared, SOLVERS[self.solver])

    def record(self, result: cs.Contact) -> Mapping[str, xr.Variable]:
        """Return the solver's numbers."""
        return recorded(result)


def case_at(point: Point) -> HardCaseRun:
    """Return a case by its name."""
    return HardCaseRun(
        one_of("case", point["case"], CASES),
        one_of("padding", point["padding"], PADDINGS),
        one_of("solver", point["solver"], SOLVERS),
    )


def measures(case: HardCaseRun, solution: cs.Contact) -> Mapping[str, xr.Variable]:
    """Return the largest error of the pressure and the error stated for it, over the peak pressure, and the verdict."""
    hard_case = CASES[case.case]
    error, stated, verdict = inf, inf, "not_applicable"
    expected = solution.status in hard_case.allowed_statuses(case.padding)
    claims = solution.residual <= hard_case.options.tolerance
    if case.applies and (claims or solution.status is cs.Status.PRECISION_LIMIT):
        padding, solver = PADDINGS[case.padding], SOLVERS[case.solver]
        error, stated = hard_case.error_and_bound(solution, padding, solver)
        verdict = "within_stated_error" if error <= stated and expected else "wrong"
    elif case.applies:
        verdict = "explained_by_status" if expected else "wrong"
    index = np.asarray(VERDICTS.index(verdict))
    return {
        "pressure_error": dimensionless(
            error, "largest pressure error over peak pressure, infinite where none is found"
        ),
        "stated_error": dimensionless(stated, "stated error, infinite where none is stated"),
        "verdict": flags((), index, VERDICTS, "verdict on the case"),
    }
