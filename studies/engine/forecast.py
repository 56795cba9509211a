"""What a run will take, before it starts; and how far off that was, after it."""

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from itertools import islice
from math import exp, log
from pathlib import Path

import numpy as np

from contactstudy import InvalidInput
from studies.engine.forecast_model import Estimate, ForecastModel, Observation, total
from studies.model.outcome import CaseStatus
from studies.store.journal import Contents, Journal

SAMPLE = 1000  # cases that are looked at


@dataclass(frozen=True)
class Forecast:
    """Seconds of the cases, one after the other, and of their timing, and bytes on disk; None if not known.

    Seconds are those of a core that does nothing else.
    """

    cases: int
    seconds: Estimate | None
    timing: Estimate | None
    size: Estimate | None
    each: Mapping[str, Estimate]

    def __str__(self) -> str:
        if self.seconds is None:
            return "how long is not known: nothing like it is stored in this folder"
        text = f"{_estimate_text(self.seconds, 's')} to compute (shared by the workers)"
        if self.timing is not None and self.timing.value:
            text += f", {_estimate_text(self.timing, 's')} to time"
        if self.size is not None:
            kilobytes = Estimate(self.size.value / 1000, self.size.factor)
            text += f", {_estimate_text(kilobytes, 'kB')} on disk"
        return text


def _estimate_text(estimate: Estimate, unit: str) -> str:
    return f"{estimate.value:.3g} {unit} (within a factor {estimate.factor:.2g})"


def fit_model(folder: Path, machine: str) -> ForecastModel:
    """Fitted to what the journals in ``folder`` say of this machine; a damaged one says less, or nothing."""
    found: list[Observation] = []
    for path in sorted(folder.glob("*.journal.jsonl")):
        with suppress(InvalidInput):
            found += observations(Journal(path, None, machine).contents)
    return ForecastModel(found)


def observations(contents: Contents) -> list[Observation]:
    """What the good cases in a journal took, of the last ``SAMPLE``."""
    found = []
    for name, record in islice(reversed(contents.records.items()), SAMPLE):
        if record.case_status is not CaseStatus.OK:
            continue
        # CPU time is wall time on a core of one's own, whatever else the core was doing
        known = {"case": record.cpu, "bytes": float(record.size)}
        if samples := contents.samples.get(name):
            known["setup"] = min(sample.setup_cpu for sample in samples)
            known["solve"] = min(sample.solve_cpu for sample in samples)
        known["iterations"] = 1.0
        for count in ("iterations", "convolutions"):  # the latter says more
            variable = record.variable(count)
            if variable is not None and variable.ndim == 0:
                known["iterations"] = max(float(variable), 1.0)
        found.append(Observation(record.identity.tree, known))
    return found[::-1]


def forecast(
    costs: ForecastModel, trees: Mapping[str, object], timed: Mapping[str, tuple[object, int]]
) -> Forecast:
    """Of the cases ``trees`` to compute, and of those to time so many times, by their keys.

    Of very many cases a sample is looked at, and stands for the others.
    """
    names, share = _sample(list(trees))
    each = dict(zip(names, costs.predict("case", [trees[name] for name in names]), strict=True))
    known = {name: one for name, one in each.items() if one is not None}
    timings, timed_share = _sample(list(timed))
    parts: list[Estimate] = []
    is_known = len(known) == len(names)
    for quantity in ("setup", "solve"):
        found = costs.predict(quantity, [timed[name][0] for name in timings])
        for name, one in zip(timings, found, strict=True):
            if one is not None:
                repeats = timed[name][1]
                parts.append(Estimate(timed_share * repeats * one.value, one.factor))
    if not is_known:
        return Forecast(len(trees), None, None, None, known)
    sizes = costs.predict("bytes", [trees[name] for name in names])
    size = total(Estimate(share * one.value, one.factor) for one in sizes if one is not None)
    seconds = total(Estimate(share * one.value, one.factor) for one in known.values())
    return Forecast(len(trees), seconds, total(parts), size, known)


def _sample(names: list[str]) -> tuple[list[str], float]:
    """At most ``SAMPLE`` names, evenly taken, and how many each stands for."""
    step = -(-len(names) // SAMPLE) or 1
    chosen = names[::step]
    return chosen, len(names) / max(len(chosen), 1)


def score(predicted: Forecast, taken: Mapping[str, float]) -> Mapping[str, float]:
    """The forecast beside the seconds ``taken``, as attributes; nothing where it said nothing."""
    both = [
        (predicted.each[name].value, seconds)
        for name, seconds in taken.items()
        if name in predicted.each
    ]
    both = [pair for pair in both if pair[1] > 0]
    if predicted.seconds is None or not both:
        return {}
    errors = [abs(log(seconds / value)) for value, seconds in both]
    return {
        "predicted_seconds": sum(value for value, _ in both),
        "predicted_within_factor": predicted.seconds.factor,
        "taken_seconds": sum(seconds for _, seconds in both),
        "prediction_error_factor_median": exp(float(np.median(errors))),
        "prediction_error_factor_largest": exp(max(errors)),
    }


def describe_score(found: Mapping[str, float]) -> str:
    """What :func:`score` found."""
    return (
        f"predicted {found['predicted_seconds']:.2g} s of CPU time, taken "
        f"{found['taken_seconds']:.2g} s; "
        f"half of the cases within a factor {found['prediction_error_factor_median']:.2g}"
    )
