"""Outcomes of computations, and their times, as variables of a Dataset."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import IntEnum

import numpy as np
import xarray as xr

from studies.model.plain_text import counted
from studies.model.study import Measures


class CaseStatus(IntEnum):
    """Status of a computation."""

    NOT_RUN = 0
    OK = 1
    FAILED = 2
    TIMEOUT = 3
    KILLED = 4


# variables that the store adds to every case; and keywords of xarray's ``sel``, which no axis may have
RESERVED_NAMES = frozenset((
    "case_status", "case_key", "error", "repeat", "wall_time",
    "tolerance", "method", "drop",
    *(f"{part}_time{end}" for part in ("setup", "solve") for end in ("", "_cpu", "_all")),
))  # fmt: skip


@dataclass(frozen=True, eq=False)
class Outcome:
    """Variables of one computation, or its failure.

    Attributes
    ----------
    case_status
        Status of the computation.
    variables
        Measured variables, by name.
    error
        Why there are no variables, in a sentence; empty where there are some.
    seconds
        Wall time of the whole computation [s].
    fields
        Fields of the contact, where they are stored.
    sample
        Times of a timed run.
    """

    case_status: CaseStatus
    variables: Mapping[str, xr.Variable] = field(default_factory=dict)
    error: str = ""
    seconds: float = 0.0
    fields: Mapping[str, xr.Variable] = field(default_factory=dict)
    sample: "TimedRun | None" = None


def summary_messages(dataset: xr.Dataset) -> Iterator[str]:
    """Yield sentences on how many cases failed, did not converge, miss their accuracy or lack a bound."""
    keys, statuses = dataset["case_key"].values.astype(str).ravel(), dataset["case_status"].values
    _, places = np.unique(keys, return_index=True)
    places = places[statuses.ravel()[places] != CaseStatus.NOT_RUN]
    failed = places[statuses.ravel()[places] != CaseStatus.OK]
    if failed.size:
        first = dataset["error"].values.ravel()[failed.min()]
        yield f"{failed.size} of {counted(places.size, 'case')} failed, the first with {first}"
    status = dataset.get("solver_status")
    if status is not None and "flag_meanings" in status.attrs and status.shape == statuses.shape:
        ended = status.values.ravel()[places]
        solves = np.isfinite(ended).sum()
        for number, meaning in enumerate(str(status.attrs["flag_meanings"]).upper().split()):
            if number and (count := np.count_nonzero(ended == number)):
                yield f"{count} of {counted(solves, 'solve')} ended with {meaning}; see 'solver_status'"
    if "accuracy_met" in dataset and dataset["accuracy_met"].shape == statuses.shape:
        met = dataset["accuracy_met"].values.ravel()[places]
        if missed := np.count_nonzero(met == 0):
            why = dataset.get("accuracy_missed", dataset["accuracy_met"]).values.ravel()
            first = f", the first with {why[places][met == 0][0]}" if why.dtype.kind in "OU" else ""
            verb = "misses" if missed == 1 else "miss"
            yield f"{missed} of {counted(places.size, 'case')} {verb} the requested accuracy{first}"
    unbounded = {}
    for name, bound in dataset.data_vars.items():
        value = dataset.get(str(name).removesuffix("_bound"))
        if value is None or value.name == name or bound.shape != statuses.shape:
            continue
        if not {value.dtype.kind, bound.dtype.kind} <= set("iuf"):
            continue
        has_value, has_bound = (np.isfinite(of.values.ravel()[places]) for of in (value, bound))
        # where no case has a bound, the answer gives the reason
        if 0 < (count := np.count_nonzero(has_value & ~has_bound)) < np.count_nonzero(has_value):
            unbounded[str(value.name)] = count
    if unbounded:
        counts = ", ".join(f"{name} in {count}" for name, count in unbounded.items())
        yield f"no bound of {counts} of {counted(places.size, 'case')}"


@dataclass(frozen=True, eq=False)
class RunSettings:
    """Settings of a run that every case needs.

    `measures` returns the measured variables of a case and its result, which have no name of the `axes`.
    """

    measures: Measures
    keeps_fields: bool = False
    axes: frozenset[str] = frozenset()


@dataclass(frozen=True)
class TimedRun:
    """Wall and processor times [s] of set-up and solve in one timed run of a case."""

    setup: float
    solve: float
    setup_cpu: float
    solve_cpu: float


def is_time(name: str) -> bool:
    """Return whether a variable has times of a case, which depend on the machine."""
    return name.startswith(("setup_time", "solve_time", "wall_time"))


PARTS = {
    "setup": "to set up coefficients and transforms, where a solve does not do it itself",
    "solve": "to solve",
}


def timing_variables(
    names: tuple[str, ...], index: np.ndarray, samples: Sequence[Sequence[TimedRun]]
) -> Mapping[str, xr.Variable]:
    """Return the least wall and processor times of each case, and every wall time.

    The variables are over the axes `names`; `index` has the number of the case at each point. There are none where no
    case was timed.
    """
    repeats = max((len(runs) for runs in samples), default=0)
    if not repeats:
        return {}
    data = {}

    def seconds(attribute: str) -> np.ndarray:
        rows = [[getattr(sample, attribute) for sample in runs] for runs in samples]
        filled = [row + [np.nan] * (repeats - len(row)) for row in rows]
        return np.array(filled, dtype=float).reshape(len(samples), repeats)

    def variable(values: np.ndarray, what: str, *further_dims: str) -> xr.Variable:
        return xr.Variable(names + further_dims, values[index], {"units": "s", "long_name": what})

    for part, what in PARTS.items():
        wall, cpu = seconds(part), seconds(f"{part}_cpu")
        name = f"{part}_time"
        about = f"wall time {what}, one case at a time, least of the repeats"
        data[name] = variable(np.fmin.reduce(wall, axis=1), about)
        about = f"processor time {what}, least of the repeats"
        data[f"{name}_cpu"] = variable(np.fmin.reduce(cpu, axis=1), about)
        data[f"{name}_all"] = variable(wall, f"wall time {what}, every repeat", "repeat")
    return data
