"""Drawing of the study `stability`: a finding and a table on the hard cases."""

import numpy as np
import xarray as xr

from studies.model.drawing import Finding, Table
from studies.reference.hard_case import Verdict
from studies.reference.hard_cases import CASES
from studies.report.style import percent

RIGHT, EXPLAINED, WRONG = (
    verdict.value
    for verdict in (Verdict.WITHIN_STATED_ERROR, Verdict.EXPLAINED_BY_STATUS, Verdict.WRONG)
)
MAX_NAMES = 10  # of cases in a list


def _count(dataset: xr.Dataset, verdict: int) -> int:
    """Return the number of solves with a verdict."""
    return int((dataset["verdict"] == verdict).sum())


def findings(dataset: xr.Dataset) -> tuple[Finding, ...]:
    """Return whether all cases end well; nothing for a part of them."""
    if dataset.sizes["case"] != len(CASES):
        return ()
    fraction = dataset["pressure_error_l1"] / dataset["stated_error"]
    fraction = fraction.where((dataset["verdict"] == RIGHT) & (dataset["stated_error"] > 0))
    claim = "Hard cases end with an error within the stated one, or with a status that explains why there is no answer."
    n_wrong, where = _count(dataset, WRONG), ""
    if n_wrong:
        claim = "Some hard cases end neither within the stated error nor with a status that explains why."
        is_wrong = (dataset["verdict"] == WRONG).any(("padding", "solver"))
        names = [str(name) for name in dataset["case"].values[is_wrong.values]]
        where = f" ({', '.join(names[:MAX_NAMES])}{', ...' * (len(names) > MAX_NAMES)})"
    return (
        Finding(
            claim,
            f"{dataset.sizes['case']} difficult contacts were solved with {dataset.sizes['padding']} paddings and "
            f"{dataset.sizes['solver']} solvers, where the combination applies: {_count(dataset, RIGHT)} solves have "
            f"an error within the one that the program states for its residual, {_count(dataset, EXPLAINED)} end with "
            f"a status that explains why there is no answer, and {n_wrong} do neither{where}. The median error is "
            f"{percent(fraction.median())} of the stated error. The references are dense matrices, built pair by pair "
            "without transforms and solved directly; the coefficients of a cell are the program's own, but for one "
            "case in plane strain.",
            "Is it stable?",
        ),
    )


def tables(dataset: xr.Dataset) -> tuple[Table, ...]:
    """Return the verdicts and the largest errors of each case."""
    rows = []
    for name in dataset["case"].values:
        case = dataset.sel(case=name)
        right = case.where(case["verdict"] == RIGHT)
        largest = (float(right[part].max()) for part in ("pressure_error_l1", "stated_error"))
        errors = (f"{error:.0e}" if np.isfinite(error) else "none" for error in largest)
        counts = (_count(case, verdict) for verdict in (RIGHT, EXPLAINED, WRONG))
        rows.append((str(name), *map(str, counts), *errors))
    return (
        Table(
            "Hard cases, over all paddings and both solvers: solves with an error within the stated one, with a status "
            "that explains why there is no answer, and with neither; largest and largest stated error of the pressure "
            "in L1. An error by rounding alone may be above a stated one of nearly zero.",
            ("hard case", "within stated", "explained", "neither", "largest error", "largest stated"),
            tuple(rows),
        ),
    )  # fmt: skip
