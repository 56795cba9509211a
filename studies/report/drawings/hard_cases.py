"""Figure and claim of the study `stability`, as data."""

import xarray as xr

from studies.definitions.hard_cases import CASES, EXPLAINED, NEITHER, WITHIN
from studies.report.claims import Claim, drawing
from studies.report.plots import Law, Plot


def _count(dataset: xr.Dataset, verdict: int) -> int:
    """Return the number of cases with a verdict."""
    return int((dataset["verdict"] == verdict).sum())


def _wrong(dataset: xr.Dataset) -> str:
    """Return how many are wrong, and of which cases."""
    failed = (dataset["verdict"] == NEITHER).any("padding").values
    names = ", ".join(map(str, dataset["case"].values[failed]))
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


DIFFERENCES = Plot(
    "hard_cases", ("pressure_difference_l1",), "stated_error", hue="padding", line="none", log="xy",
    laws=(Law("as large as stated", "pressure_difference_l1", lambda stated, _: stated),),
    labels={"pressure_difference_l1": "L1 difference of the pressures by two solvers",
            "stated_error": "sum of the errors that both state"},
    caption="Hard cases, each a mark for each padding: below the dotted line two solvers differ by no more than they "
    "state. Cases without an answer have no mark.",
)  # fmt: skip
stability = drawing(DIFFERENCES, claims=[STABLE])
