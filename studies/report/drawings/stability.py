"""Drawing of the study `stability`: figures, findings and tables from its stored data."""

import numpy as np
import xarray as xr

from studies.definitions.stability import VERDICTS
from studies.model.drawing import CaptionedFigure, Finding, Table
from studies.reference.hard_cases import CASES, GROUPS
from studies.report.formatting import percent
from studies.report.style import add_legend, panels

COLORS = {"preconditioned CG": "#0072B2", "Polonsky-Keer": "#D55E00"}
SHOWN = 1e-17  # where an error of zero is drawn


def figure(dataset: xr.Dataset) -> tuple[CaptionedFigure, ...]:
    """A row for each case: every error, and the largest stated."""
    names = [str(name) for name in dataset["case"].values]
    fig, (ax,) = panels(1, width=8.5, height=1.2 + 0.19 * len(names))
    right = dataset["verdict"] == VERDICTS.index("within_stated_error")
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
    ax.set(ylim=(len(names) - 0.5, -0.5), xlabel="largest pressure error / peak pressure")
    add_legend(fig)
    return (CaptionedFigure("stability", fig, _caption(dataset)),)


def _caption(dataset: xr.Dataset) -> str:
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
        f"paddings and {dataset.sizes['solver']} solvers. {counts['within_stated_error']} solves have an error "
        f"within the stated one, {counts['explained_by_status']} ended with a status that explains why there "
        f"is no answer, and {counts['wrong']} did neither. The reference answer comes from a dense matrix, built "
        "pair by pair without transforms, whose contact sets are found by pivoting, or from an equivalent "
        "form of the same contact (other units, shifted, mirrored, over two periods). The stated error is the "
        "remaining violation of the contact conditions times the largest compliance of a wave in "
        "the contact. Errors of exactly zero are drawn at the left end."
    )


def ends_of(dataset: xr.Dataset, case: str) -> str:
    """The statuses a case ended in, most frequent first, and how many iterations that took at most."""
    one = dataset.sel(case=case)
    applies = one["verdict"].values != VERDICTS.index("not_applicable")
    meanings = str(dataset["solver_status"].attrs["flag_meanings"]).split()
    ends, counts = np.unique(one["solver_status"].values[applies].astype(int), return_counts=True)
    names = [meanings[end].replace("_", " ") for end in ends[np.argsort(-counts)]]
    return f"{', '.join(names)}; up to {int(one['iterations'].values[applies].max())} iterations"


def findings(dataset: xr.Dataset) -> tuple[Finding, ...]:
    """Whether every case ended within its stated error or with a status that explains why not."""
    return (_hard_cases(dataset),) if dataset.sizes["case"] == len(CASES) else ()


def _hard_cases(dataset: xr.Dataset) -> Finding:
    counts = [int((dataset["verdict"] == number).sum()) for number in range(len(VERDICTS))]
    right, said, wrong, _ = counts
    ended = dataset["verdict"] == VERDICTS.index("within_stated_error")
    share = (dataset["pressure_error"] / dataset["stated_error"]).where(ended)
    claim = "Hard cases end with an error within the stated one, or with a status that explains why there is no answer."
    if wrong:
        claim = "Some hard cases end neither within the stated error nor with a status that explains why."
    return Finding(
        claim,
        f"{dataset.sizes['case']} difficult contacts were solved with {dataset.sizes['padding']} paddings and "
        f"{dataset.sizes['solver']} solvers, where the combination applies: {right} solves have an error within "
        f"the one stated for them, {said} end with a status that explains why there is no answer, and {wrong} do "
        f"neither. The median error is {percent(share.median())} of the stated error, the largest "
        f"{percent(share.max())}.",
        "Is it stable?",
    )


def tables(dataset: xr.Dataset) -> tuple[Table, ...]:
    """What was hard, how it ended, and the errors, over all paddings and solvers."""
    rows = []
    for name in (str(one) for one in dataset["case"].values):
        one = dataset.sel(case=name)
        applies = one.where(one["verdict"] != VERDICTS.index("not_applicable"))
        right = one["verdict"] == VERDICTS.index("within_stated_error")
        error, stated = (
            f"{float(one[which].where(right).max()):.0e}" if right.any() else "none"
            for which in ("pressure_error", "stated_error")
        )
        worst = VERDICTS[int(applies["verdict"].max())].replace("_", " ")
        hard = CASES[name].hard if name in CASES else ""
        rows.append((name, hard, ends_of(dataset, name), error, stated, worst))
    table = Table(
        "Hard cases, over all paddings and both solvers: the statuses, the largest error of the pressure "
        "relative to its maximum, the largest stated error, and the worst verdict of all solves.",
        ("case", "difficulty", "statuses", "error", "stated error", "verdict"),
        tuple(rows),
    )
    return (table,)
