"""What the study of hard cases says, from its stored data alone."""

import numpy as np
import xarray as xr

from studies.model.finding import Finding, Table
from studies.reference.hard_cases import CASES
from studies.report.formatting import percent

# What became of a case: its error is within what is stated, or a status says why there is no answer, or
# neither; or the question makes no sense with that padding.
VERDICTS = ("right", "said", "wrong", "not_asked")


def ends_of(dataset: xr.Dataset, case: str) -> str:
    """The statuses a case ended in, most frequent first, and how many iterations that took at most."""
    one = dataset.sel(case=case)
    asked = one["verdict"].values != VERDICTS.index("not_asked")
    meanings = str(dataset["outcome"].attrs["flag_meanings"]).split()
    ends, counts = np.unique(one["outcome"].values[asked].astype(int), return_counts=True)
    names = [meanings[end].replace("_", " ") for end in ends[np.argsort(-counts)]]
    return f"{', '.join(names)}; up to {int(one['iterations'].values[asked].max())} iterations"


def findings(dataset: xr.Dataset) -> tuple[Finding, ...]:
    """Whether every case came out right or said why not, where all were asked."""
    return (_hard_cases(dataset),) if dataset.sizes["case"] == len(CASES) else ()


def _hard_cases(dataset: xr.Dataset) -> Finding:
    counts = [int((dataset["verdict"] == number).sum()) for number in range(len(VERDICTS))]
    right, said, wrong, _ = counts
    ended = dataset["verdict"] == VERDICTS.index("right")
    share = (dataset["pressure_error"] / dataset["stated_error"]).where(ended)
    claim = "Hard cases end in a right answer within a stated error, or in a sentence that says why not."
    if wrong:
        claim = "Some hard cases end neither right nor in a sentence that says why not."
    return Finding(
        claim,
        f"{dataset.sizes['case']} contacts with something hard about them were solved with "
        f"{dataset.sizes['padding']} paddings and {dataset.sizes['solver']} solvers, where that makes sense: "
        f"{right} solves are right within the error stated for them, {said} say why there is no answer, "
        f"{wrong} do neither. The error is on the median {percent(share.median())} of the one stated, and at "
        f"most {percent(share.max())}.",
        "Is it stable?",
    )


def tables(dataset: xr.Dataset) -> tuple[Table, ...]:
    """What was hard, how it ended, and the errors, over all paddings and solvers."""
    rows = []
    for name in (str(one) for one in dataset["case"].values):
        one = dataset.sel(case=name)
        asked = one.where(one["verdict"] != VERDICTS.index("not_asked"))
        right = one["verdict"] == VERDICTS.index("right")
        error, stated = (
            f"{float(one[which].where(right).max()):.0e}" if right.any() else "none"
            for which in ("pressure_error", "stated_error")
        )
        worst = VERDICTS[int(asked["verdict"].max())]
        hard = CASES[name].hard if name in CASES else ""
        rows.append((name, hard, ends_of(dataset, name), error, stated, worst))
    table = Table(
        "Hard cases: how each ended over all paddings and both solvers; the largest error of the pressure over "
        "its highest, and the largest error stated. The verdict is the worst of all solves: right within the "
        "error stated, or said by a status.",
        ("case", "what is hard", "how it ended", "error", "stated error", "verdict"),
        tuple(rows),
    )
    return (table,)
