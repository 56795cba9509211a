"""Claims as data: sentences whose numbers are measured in a stored study."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from math import isfinite
from typing import SupportsFloat

import xarray as xr

from studies.model.drawing import CaptionedFigure, Drawing, Finding, Table
from studies.model.outcome import CaseStatus
from studies.report.plots import Law, Plot, draw, percent, with_total_time

# Function of a stored study: a fraction, or a text or a count that is written as it is.
Measurement = Callable[[xr.Dataset], SupportsFloat | str]


@dataclass(frozen=True)
class Claim:
    """A claim and the measurement behind it. ``{name}`` stands in both for one of the `numbers`.

    Attributes
    ----------
    question
        Question of the reader that it answers.
    claim, measured
        Sentences.
    numbers
        Functions of the stored study: fractions, which are written in per cent, or texts and counts.
    needs
        Values that axes or attributes of the study must have; without them the claim is left out.
    """

    question: str
    claim: str
    measured: str = ""
    numbers: Mapping[str, Measurement] = field(default_factory=dict)
    needs: Mapping[str, tuple[object, ...]] = field(default_factory=dict)


def number(measure: str, *first: str, **at: object) -> Callable[[xr.Dataset], float]:
    """Return a function for a measure `at` values of axes; of others at the last one, of those named `first` at that."""

    def of(dataset: xr.Dataset) -> float:
        part = dataset[measure].sel(at)
        return float(part.isel({name: 0 if name in first else -1 for name in part.dims}))

    return of


def largest_error(law: Law, x: str = "") -> Measurement:
    """Return a function for the largest relative difference of a measure to its law, which is over the axis `x`."""

    def largest(dataset: xr.Dataset) -> SupportsFloat:
        true = dataset[law.of] if isinstance(law.of, str) else law.of(dataset[x].values, dataset)
        return abs(dataset[law.y] / true - 1).max()

    return largest


def stated(claim: Claim, dataset: xr.Dataset) -> Finding | None:
    """Return a claim with its numbers; None where the study lacks what it needs, or a number is not finite."""
    if not (dataset["case_status"] == CaseStatus.OK).all():
        return None
    for name, values in claim.needs.items():
        has = dataset[name].values.tolist() if name in dataset.dims else [dataset.attrs.get(name)]
        if not set(values) <= set(has):
            return None
    texts, dataset = {}, with_total_time(dataset)
    for name, measured in claim.numbers.items():
        try:
            value = measured(dataset)
        except KeyError:  # a study whose times were not taken lacks them
            return None
        if not isinstance(value, str | int):
            if not isfinite(value):
                return None
            value = percent(value)
        texts[name] = value
    return Finding(claim.claim.format(**texts), claim.measured.format(**texts), claim.question)


Drawn = Plot | Callable[[xr.Dataset], CaptionedFigure | None]


def drawing(
    *figures: Drawn, claims: Sequence[Claim] = (), tables: Sequence[Callable[[xr.Dataset], Table | None]] = ()
) -> Drawing:
    """Return a drawing: figures, claims and tables of a study, of which those that it has no data for are left out."""

    def drawn(dataset: xr.Dataset) -> Sequence[CaptionedFigure]:
        drawings = [draw(dataset, entry) if isinstance(entry, Plot) else entry(dataset) for entry in figures]
        if figures and not any(drawings):
            names = [name for entry in figures if isinstance(entry, Plot) for name in entry.y]
            missing = next((name for name in names if name not in dataset), names[0])
            raise KeyError(f"No variable named {missing!r}, or no number of it")  # the error that a dataset raises
        return tuple(entry for entry in drawings if entry is not None)

    def findings(dataset: xr.Dataset) -> Sequence[Finding]:
        return tuple(entry for claim in claims if (entry := stated(claim, dataset)) is not None)

    def rows(dataset: xr.Dataset) -> Sequence[Table]:
        return tuple(entry for table in tables if (entry := table(dataset)) is not None)

    return Drawing(drawn, findings, rows)
