"""Drawing of the study `stability`: a claim and a table on the hard cases."""

import numpy as np
import xarray as xr

from studies.definitions.hard_case import Verdict
from studies.definitions.hard_cases import CASES
from studies.model.drawing import Table
from studies.report.claims import Claim, drawing

RIGHT, EXPLAINED, WRONG = (
    verdict.value
    for verdict in (Verdict.WITHIN_STATED_ERROR, Verdict.EXPLAINED_BY_STATUS, Verdict.WRONG)
)


def _count(dataset: xr.Dataset, verdict: int) -> int:
    """Return the number of solves with a verdict."""
    return int((dataset["verdict"] == verdict).sum())


def _wrong(dataset: xr.Dataset) -> str:
    """Return how many solves are wrong, and of which cases."""
    wrong = (dataset["verdict"] == WRONG).any(("padding", "solver")).values
    names = ", ".join(map(str, dataset["case"].values[wrong]))
    return f"{_count(dataset, WRONG)} do neither" + (f" ({names})" if names else "")


def _median(dataset: xr.Dataset) -> float:
    """Return the median error over the stated one."""
    fraction = dataset["pressure_error_l1"] / dataset["stated_error"]
    is_right = (dataset["verdict"] == RIGHT) & (dataset["stated_error"] > 0)
    return float(fraction.where(is_right).median())


STABLE = Claim(
    "Is it stable?",
    "{all} hard cases end with the same answer by two solvers, within the errors that both state, or with a status that "
    "explains why there is none.",
    "{cases} difficult contacts were solved with {paddings} paddings and {solvers} solvers, where the combination "
    "applies: {right} solves differ from those of the other solver by no more than the errors that the program states "
    "for their residuals, {explained} end with a status that explains why there is no answer, and {wrong}. The median "
    "difference is {median} of the stated error. The tests compare each with a dense matrix, built pair by pair "
    "without transforms and solved directly.",
    {
        "all": lambda d: "Not all" if _count(d, WRONG) else "All",
        "cases": lambda d: d.sizes["case"],
        "paddings": lambda d: d.sizes["padding"],
        "solvers": lambda d: d.sizes["solver"],
        "right": lambda d: _count(d, RIGHT),
        "explained": lambda d: _count(d, EXPLAINED),
        "wrong": _wrong,
        "median": _median,
    },
    {"case": tuple(CASES)},
)


def verdicts(dataset: xr.Dataset) -> Table:
    """Return the verdicts and the largest errors of each case."""
    rows = []
    for name in dataset["case"].values:
        case = dataset.sel(case=name)
        right = case.where(case["verdict"] == RIGHT)
        largest = (float(right[part].max()) for part in ("pressure_error_l1", "stated_error"))
        errors = (f"{error:.0e}" if np.isfinite(error) else "none" for error in largest)
        counts = (_count(case, verdict) for verdict in (RIGHT, EXPLAINED, WRONG))
        rows.append((str(name), *map(str, counts), *errors))
    return Table(
        "Hard cases, over all paddings and both solvers: solves with an error within the stated one, with a status "
        "that explains why there is no answer, and with neither; largest and largest stated error of the pressure "
        "in L1. An error by rounding alone may be above a stated one of nearly zero. Where one cell bears the load, or "
        "all of it is at the hardness, the load gives the pressure, and the case tests the status alone.",
        ("hard case", "within stated", "explained", "neither", "largest error", "largest stated"),
        tuple(rows),
    )


stability = drawing(claims=[STABLE], tables=[verdicts])
