"""Hard cases: how each ended, with every padding and both solvers, and how far from the right answer."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import inf

import numpy as np
import xarray as xr

import contactstudy as cs
from studies.model.axis import Axis, one_of
from studies.model.case import Case, flags, number
from studies.model.study import Plate, Point
from studies.reference.hard_case import PADDINGS, SOLVERS
from studies.reference.hard_cases import CASES, GROUPS
from studies.report.findings.stability import VERDICTS, ends_of, findings, tables
from studies.report.style import finish, panels

__all__ = ["figure", "findings", "measures", "points", "scene_at", "tables", "times"]

points = (
    Axis("case", tuple(CASES), "what is hard"),
    Axis(
        "padding",
        ("zero", "superposed", "exact", "exact on both"),
        "representation of both directions",
    ),
    Axis("solver", tuple(SOLVERS), "solver"),
)

# of small grids, and nothing is said about them
times = "none"

COLORS = {"preconditioned CG": "#0072B2", "Polonsky-Keer": "#D55E00"}
SHOWN = 1e-17  # where an error of zero is drawn


@dataclass(frozen=True)
class Trial:
    """A hard case with one padding and one solver."""

    case: str
    padding: str
    solver: str

    @property
    def asked(self) -> bool:
        """Whether the case makes sense with this padding."""
        return self.padding in CASES[self.case].paddings

    def prepare(self) -> cs.Problem:
        """The problem."""
        hard = CASES[self.case]
        return hard.scene.problem(hard.grid, PADDINGS[self.padding])

    def run(self, prepared: cs.Problem) -> cs.Solution:
        """The solve, with the case's own settings."""
        return CASES[self.case].solve(prepared, SOLVERS[self.solver])

    def record(self, result: cs.Solution) -> Mapping[str, xr.Variable]:
        """The solver's own numbers."""
        hard = CASES[self.case]
        return Case(hard.scene, hard.grid, PADDINGS[self.padding]).record(result)


def scene_at(point: Point) -> Trial:
    """A case by its name."""
    return Trial(
        one_of("case", point["case"], CASES),
        one_of("padding", point["padding"], PADDINGS),
        one_of("solver", point["solver"], SOLVERS),
    )


def measures(case: Trial, solution: cs.Solution) -> Mapping[str, xr.Variable]:
    """Largest error of the pressure and the error stated for it, over the highest pressure."""
    hard = CASES[case.case]
    error, stated, verdict = 0.0, inf, "not_asked"
    claims = solution.residual <= hard.tolerance or solution.status is cs.Status.PRECISION_LIMIT
    if case.asked and claims:
        error, stated = hard.judge(solution, PADDINGS[case.padding], SOLVERS[case.solver])
        verdict = (
            "right"
            if error <= stated and solution.status in hard.may_end(case.padding)
            else "wrong"
        )
    elif case.asked:
        verdict = "said" if solution.status in hard.may_end(case.padding) else "wrong"
    index = np.asarray(VERDICTS.index(verdict))
    return {
        "pressure_error": number(error, "largest pressure error over highest pressure"),
        "stated_error": number(stated, "stated error, infinite where none is stated"),
        "verdict": flags((), index, VERDICTS, "what became of the case"),
    }


def figure(dataset: xr.Dataset) -> tuple[Plate, ...]:
    """A row for each case: every error, and the largest stated."""
    names = [str(name) for name in dataset["case"].values]
    plate, (ax,) = panels(1, width=8.5, height=1.2 + 0.19 * len(names))
    right = dataset["verdict"] == VERDICTS.index("right")
    rows = np.arange(len(names))
    for solver in (str(name) for name in dataset["solver"].values):
        one = dataset.sel(solver=solver)
        errors = one["pressure_error"].where(right.sel(solver=solver)).values
        shown = np.maximum(errors, SHOWN)
        offset = 0.15 if solver == "Polonsky-Keer" else -0.15
        ax.plot(
            shown.ravel(), np.repeat(rows + offset, shown.shape[1]), ".", ms=4,
            color=COLORS[solver], label=f"error, {solver}",
        )  # fmt: skip
    stated = dataset["stated_error"].where(right).max(("padding", "solver")).values
    ax.plot(stated, rows, "|", ms=9, color="black", label="largest error stated")
    for row, name in enumerate(names):
        if not right.sel(case=name).any():
            ax.text(1e-16, row, ends_of(dataset, name), va="center", fontsize="x-small")
    ax.set_xscale("log")
    ax.set_yticks(rows, names, fontsize="x-small")
    ax.set(ylim=(len(names) - 0.5, -0.5), xlabel="largest pressure error / highest pressure")
    finish(plate)
    return (Plate("stability", plate, _words(dataset)),)


def _words(dataset: xr.Dataset) -> str:
    counts = {
        name: int((dataset["verdict"] == number).sum()) for number, name in enumerate(VERDICTS)
    }
    groups = [
        group
        for group in GROUPS
        if any(CASES[str(n)].group == group for n in dataset["case"].values if str(n) in CASES)
    ]
    return (
        f"{dataset.sizes['case']} hard cases ({', '.join(groups)}), each with {dataset.sizes['padding']} "
        f"paddings and {dataset.sizes['solver']} solvers. {counts['right']} solves came out within the error "
        f"stated for them, {counts['said']} ended in a status that says why there is no answer, "
        f"{counts['wrong']} in neither. The right answer is that of a dense matrix, built pair by pair without "
        "transforms, whose sets of cells are found by pivoting, or the same contact in another form (other "
        "units, moved, mirrored, over two periods). The error stated is what the solution leaves of the "
        "contact conditions, times the softness of the softest wave on its contact. Errors of nothing stand "
        "at the left end."
    )
