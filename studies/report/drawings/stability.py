"""Drawing of the study `stability`: a claim and a table on the hard cases."""

import numpy as np
import xarray as xr

from studies.definitions.hard_cases import CASES
from studies.definitions.stability import EXPLAINED, NEITHER, WITHIN
from studies.model.drawing import Table
from studies.report.claims import Claim, drawing


def _count(dataset: xr.Dataset, verdict: int) -> int:
    """Return the number of cases with a verdict."""
    return int((dataset["verdict"] == verdict).sum())


def _wrong(dataset: xr.Dataset) -> str:
    """Return how many are wrong, and of which cases."""
    wrong = (dataset["verdict"] == NEITHER).any("padding").values
    names = ", ".join(map(str, dataset["case"].values[wrong]))
    return f"{_count(dataset, NEITHER)} do neither" + (f" ({names})" if names else "")


def _median(dataset: xr.Dataset) -> float:
    """Return the median difference over the stated errors."""
    fraction = dataset["pressure_difference_l1"] / dataset["stated_error"]
    is_right = (dataset["verdict"] == WITHIN) & (dataset["stated_error"] > 0)
    return float(fraction.where(is_right).median())


STABLE = Claim(
    "Is it stable?",
    "{all} hard cases end with the same answer by two solvers, within the errors that both state, or with a status that "
    "explains why there is none.",
    "{cases} difficult contacts were solved with {paddings} paddings, each by two solvers: {right} pairs of answers "
    "differ by no more than the errors that the program states for their residuals, {explained} end with a status that "
    "explains why there is no answer, and {wrong}. The median difference is {median} of the stated errors.",
    {
        "all": lambda d: "Not all" if _count(d, NEITHER) else "All",
        "cases": lambda d: d.sizes["case"],
        "paddings": lambda d: d.sizes["padding"],
        "right": lambda d: _count(d, WITHIN),
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
        right = case.where(case["verdict"] == WITHIN)
        largest = (float(right[part].max()) for part in ("pressure_difference_l1", "stated_error"))
        errors = (f"{error:.0e}" if np.isfinite(error) else "none" for error in largest)
        counts = (_count(case, verdict) for verdict in (WITHIN, EXPLAINED, NEITHER))
        rows.append((str(name), *map(str, counts), *errors))
    return Table(
        "Hard cases, over all paddings: pairs of answers that differ by no more than the stated errors, with a status "
        "that explains why there is no answer, and with neither; largest difference of the pressures in L1, and "
        "largest sum of the stated errors. Where one cell bears the load, or all of it is at the hardness, the load "
        "gives the pressure, and the case tests the status alone.",
        (
            "hard case",
            "within stated",
            "explained",
            "neither",
            "largest difference",
            "largest stated",
        ),
        tuple(rows),
    )


stability = drawing(claims=[STABLE], tables=[verdicts])
