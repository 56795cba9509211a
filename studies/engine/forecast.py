"""What a run will take, before it starts; and how far off that was, after it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import exp, log
from pathlib import Path

import numpy as np

from studies.engine.forecast_model import Estimate, ForecastModel, Observation, total
from studies.store.journal import Contents, Journal


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
    """Fitted to all that the journals in ``folder`` say of this machine."""
    found: list[Observation] = []
    for path in sorted(folder.glob("*.journal.jsonl")):
        found += observations(Journal(path, None, machine).contents)
    return ForecastModel(found)


def observations(contents: Contents) -> list[Observation]:
    """What the good cases in a journal took."""
    found = []
    for name, record in contents.records.items():
        variables = record.outcome.variables
        if not variables:
            continue
        # CPU time is wall time on a core of one's own, whatever else the core was doing
        known = {"case": record.outcome.cpu, "bytes": float(record.size)}
        if samples := contents.samples.get(name):
            known["setup"] = min(sample.setup_cpu for sample in samples)
            known["solve"] = min(sample.solve_cpu for sample in samples)
        known["iterations"] = 1.0
        for count in ("iterations", "convolutions"):  # the latter says more
            if count in variables and variables[count].ndim == 0:
                known["iterations"] = max(float(variables[count]), 1.0)
        found.append(Observation(record.identity.tree, known))
    return found


def forecast(
    costs: ForecastModel, trees: Mapping[str, object], timed: Sequence[str], repeats: int
) -> Forecast:
    """Of the cases ``trees`` to compute and of those to time, by their keys."""
    names = list(trees)
    each = dict(zip(names, costs.predict("case", list(trees.values())), strict=True))
    known = {name: one for name, one in each.items() if one is not None}
    if len(known) < len(names):
        return Forecast(len(names), None, None, None, known)
    sizes = costs.predict("bytes", list(trees.values()))
    size = total(one for one in sizes if one is not None)
    parts: list[Estimate] = []
    for quantity in ("setup", "solve"):
        for one in costs.predict(quantity, [trees[name] for name in timed if name in trees]):
            if one is not None:
                parts.append(Estimate(repeats * one.value, one.factor))
    return Forecast(len(names), total(known.values()), total(parts), size, known)


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
