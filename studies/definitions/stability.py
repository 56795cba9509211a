"""Hard cases: whether two solvers agree within the errors that they state, with every padding."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import xarray as xr

import contactstudy as cs
from contactstudy.domain.fields import Array
from contactstudy.io.dataset import flags
from studies.definitions.hard_case import PADDINGS, SOLVERS, HardCase, Verdict, stated_error
from studies.definitions.hard_cases import CASES
from studies.model.axis import Axis, one_of
from studies.model.case import dimensionless, recorded
from studies.model.study import Point, Study

TITLE = (
    "Hard cases: whether two solvers agree within the errors that they state, with every padding."
)
AXES = (
    Axis("case", tuple(CASES), "hard case"),
    Axis(
        "padding",
        ("zero", "superposed", "exact", "exact on both"),
        "treatment of both directions (padding)",
    ),
    Axis("solver", tuple(SOLVERS), "solver"),
)

VERDICTS = tuple(verdict.name.lower() for verdict in Verdict)


@dataclass(frozen=True)
class HardCaseRun:
    """A hard case with one padding and one solver."""

    case: str
    padding: str
    solver: str

    @property
    def hard_case(self) -> HardCase:
        """Scene, grid and reference."""
        return CASES[self.case]

    def prepare(self) -> cs.Problem:
        """Return the problem."""
        return self.hard_case.scene.problem(self.hard_case.grid, PADDINGS[self.padding])

    def run(self, prepared: cs.Problem) -> cs.Contact:
        """Solve with the settings of the case."""
        return self.hard_case.solve(prepared, SOLVERS[self.solver])

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
    """Return the L1 difference of the pressure to that of the other solver, the stated error, and the verdict."""

    def by_other() -> tuple[Array, float]:
        (solver,) = SOLVERS.keys() - {case.solver}
        other = replace(case, solver=solver).run(case.prepare())
        return other.pressure, stated_error(other)

    judged = case.hard_case.judge(solution, case.padding, by_other)
    what = "relative L1 error of the pressure"
    return {
        "pressure_error_l1": dimensionless(
            judged.error, f"{what} against the other solver, infinite where there is no answer"
        ),
        "stated_error": dimensionless(
            judged.stated, f"{what} that the program states, infinite where it states none"
        ),
        "verdict": flags((), np.asarray(judged.verdict.value), VERDICTS, "verdict on the case"),
    }


# the grids are small, and their times are not reported
stability = Study("stability", TITLE, AXES, case_at, measures, "none")
