"""Hard cases: whether two solvers give one answer within the errors that they state, with every padding."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import inf

import numpy as np
import xarray as xr

import contactstudy as cs
from contactstudy.io.dataset import flags
from studies.definitions.hard_cases import CASES, SOLVERS, UNFINISHED, HardCase, stated_error
from studies.model.axis import Axis, one_of
from studies.model.case import dimensionless, recorded
from studies.model.study import Point, Study
from studies.reference.line_contact import relative_l1

TITLE = "Hard cases: whether two solvers give one answer within the errors that they state, with every padding."
PADDINGS: dict[str, cs.Padding | cs.Paddings] = {
    "zero": cs.ZeroPadding(),
    "superposed": cs.Superposition(2),
    "exact": cs.ExactPeriodicity(),
    "exact on both": (cs.ExactPeriodicity(), cs.ExactPeriodicity()),
}
AXES = (
    Axis("case", tuple(CASES), "hard case"),
    Axis("padding", tuple(PADDINGS), "treatment of both directions (padding)"),
)
WITHIN, EXPLAINED, NEITHER = range(3)
VERDICTS = "within_stated_error", "explained_by_status", "neither"


@dataclass(frozen=True)
class HardCaseRun:
    """A hard case with one padding, solved by both solvers."""

    case: str
    padding: str

    @property
    def hard_case(self) -> HardCase:
        """Scene and grid."""
        return CASES[self.case]

    def prepare(self) -> cs.Problem:
        """Return the problem."""
        return self.hard_case.scene.problem(self.hard_case.grid, PADDINGS[self.padding])

    def run(self, prepared: cs.Problem) -> list[cs.Contact]:
        """Return the solution by each solver."""
        return [self.hard_case.solve(prepared, solver) for solver in SOLVERS.values()]

    def record(self, result: list[cs.Contact]) -> Mapping[str, xr.Variable]:
        """Return the numbers of the first solver."""
        return recorded(result[0])


def case_at(point: Point) -> HardCaseRun:
    """Return a case by its name."""
    return HardCaseRun(one_of("case", point["case"], CASES), one_of("padding", point["padding"], PADDINGS))


def measures(case: HardCaseRun, solutions: list[cs.Contact]) -> Mapping[str, xr.Variable]:
    """Return the L1 difference of the pressures, the sum of the errors stated for their residuals, and the verdict."""
    hard, (first, second) = case.hard_case, solutions
    expected = all(hard.expects(one, PADDINGS[case.padding]) for one in solutions)
    difference, stated = inf, inf
    if all(one.status in UNFINISHED for one in solutions):
        verdict = EXPLAINED if expected else NEITHER
    else:
        difference = relative_l1(second.pressure, first.pressure)
        stated = sum(map(stated_error, solutions))
        is_within = expected and difference <= stated and hard.is_useful(stated)
        verdict = WITHIN if is_within else NEITHER
    what = "relative L1 {} of the pressure{}, infinite where there is no answer"
    return {
        "pressure_difference_l1": dimensionless(difference, what.format("difference", " by two solvers")),
        "stated_error": dimensionless(stated, what.format("error", " that the program states for both")),
        "verdict": flags((), np.asarray(verdict), VERDICTS, "verdict on the case"),
    }


# the grids are small, and their times are not reported
stability = Study("stability", TITLE, AXES, case_at, measures, "none")
