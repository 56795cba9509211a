"""Forecast of what cases will cost, from what similar cases did cost.

Cases that agree in everything but numbers (same padding, solver, kinds of shapes) form a mode. In each mode a
quantity is ``N log N`` for N cells, if it is a time, times a power law of all numbers of the case
(:class:`~contactstudy.planning.cost.PowerLaw`).
"""

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import islice
from math import exp, log
from pathlib import Path

import numpy as np

from contactstudy import InvalidInput
from contactstudy.domain.fields import Array
from contactstudy.domain.identity import DEFAULTS, Tree, text
from contactstudy.planning.cost import PowerLaw, log_work
from studies.model.outcome import CaseStatus
from studies.store.journal import Journal
from studies.store.records import Contents

UNLIKE = 1.0  # standard deviation between two modes, in logarithms
LARGEST = 100.0  # limit of any logarithm, against overflow
CELLS = ".cells"  # in the names of a grid's numbers; nothing is predicted across modes without them
DIGITS = "tolerance"  # a number whose logarithm costs time
MOST = 300  # last cases of a mode that are used


@dataclass(frozen=True)
class Observation:
    """A stored case as a tree, and its measured quantities by name.

    They are ``case``, ``setup`` and ``solve`` [s], ``iterations`` and ``bytes``.
    """

    tree: Tree
    quantities: Mapping[str, float]


@dataclass(frozen=True)
class Estimate:
    """A positive number, correct within `factor` in 19 of 20 cases."""

    value: float
    factor: float


@dataclass(frozen=True, eq=False)
class ForecastModel:
    """Power laws through observations, fitted anew for each prediction."""

    observations: Sequence[Observation]

    def predict(self, quantity: str, trees: Sequence[Tree]) -> list[Estimate | None]:
        """Return a quantity of each case; None where nothing comparable is stored.

        Parameters
        ----------
        quantity
            Name of the quantity, see :class:`Observation`.
        trees
            The cases.
        """
        by_mode: dict[str, list[tuple[Mapping[str, float], float]]] = defaultdict(list)
        for observation in self.observations:
            value = observation.quantities.get(quantity, 0.0)
            if value > 0:
                mode_name, numbers = _described(observation.tree)
                by_mode[mode_name].append((numbers, log(value) - _work(quantity, numbers)))
        everything = [row for rows in by_mode.values() for row in rows if _has_cells(row[0])]
        groups: dict[tuple[str, ...], list[int]] = defaultdict(list)
        described = [_described(tree) for tree in trees]
        for index, (mode, numbers) in enumerate(described):
            if mode in by_mode:
                groups[mode,].append(index)
            elif _has_cells(numbers):
                # a new mode is predicted from all others that have the same numbers
                groups["", *sorted(numbers)].append(index)
        estimates: list[Estimate | None] = [None] * len(trees)
        for (mode, *_), places in groups.items():
            rows = by_mode.get(mode) or everything
            if not rows:
                continue
            means, deviations = _fitted(rows[-MOST:], [described[index][1] for index in places])
            for index, mean, deviation in zip(places, means, deviations, strict=True):
                logarithm = mean + _work(quantity, described[index][1])
                spread = 2 * np.hypot(deviation, 0.0 if mode in by_mode else UNLIKE)
                estimates[index] = Estimate(
                    exp(np.clip(logarithm, -LARGEST, LARGEST)), exp(min(spread, LARGEST))
                )
        return estimates


def total(estimates: Iterable[Estimate]) -> Estimate:
    """Return the sum of estimates, whose errors are taken to be fully correlated."""
    parts = list(estimates)
    value = sum(part.value for part in parts)
    sd = sum(part.value * log(part.factor) for part in parts) / value if value else 0.0
    return Estimate(value, exp(sd))


def _has_cells(numbers: Mapping[str, float]) -> bool:
    """Return whether the numbers of a case include cells of a grid."""
    return any(CELLS in name for name in numbers)


def _work(quantity: str, numbers: Mapping[str, float]) -> float:
    """Return the logarithm of the work N log N for a time; 0 for other quantities."""
    if quantity not in ("case", "setup", "solve"):
        return 0.0
    cells = sum(value for name, value in numbers.items() if CELLS in name)
    return log_work(exp(cells)) if cells > 0 else 0.0


def mode(tree: Tree) -> str:
    """Return the mode of a case: everything but its numbers."""
    return _described(tree)[0]


def _described(tree: Tree) -> tuple[str, Mapping[str, float]]:
    """Return the mode of a case, and the logarithms of its numbers by path."""
    names: list[str] = []
    numbers: dict[str, float] = {}
    _walk(tree, "", names, numbers)
    return text(names), numbers


def _walk(tree: Tree, path: str, names: list[str], numbers: dict[str, float]) -> None:
    """Add the names and the logarithms of the numbers of a tree to `names` and `numbers`."""
    if isinstance(tree, dict):
        names.append(f"{path}:{tree.get('', '')}")
        parts = {**tree.get(DEFAULTS, {}), **tree}
        for name in sorted(parts.keys() - {"", DEFAULTS}):
            _walk(parts[name], f"{path}.{name}", names, numbers)
    elif isinstance(tree, list):
        for place, item in enumerate(tree):
            _walk(item, f"{path}[{place}]", names, numbers)
    elif isinstance(tree, str):
        try:
            value = abs(float(tree))
        except ValueError:
            names.append(f"{path}={tree}")
            return
        if value == np.inf:
            names.append(f"{path}=inf")
        elif tree.lstrip("-").isdigit():  # a count may be zero
            numbers[path] = log(value + 0.5)
        elif value == 0:
            names.append(f"{path}=0")
        elif path.endswith(DIGITS) and value < 1:
            numbers[path] = log(-log(value))
        else:
            numbers[path] = log(value)


def _fitted(
    rows: Sequence[tuple[Mapping[str, float], float]], new_cases: Sequence[Mapping[str, float]]
) -> tuple[Array, Array]:
    """Return mean and standard deviation of the logarithm for new cases, by the numbers that all cases have."""
    names = sorted(set.intersection(*(set(numbers) for numbers, _ in rows), *map(set, new_cases)))

    def logarithms(all_numbers: Iterable[Mapping[str, float]]) -> Array:
        return np.array([[numbers[name] for name in names] for numbers in all_numbers], ndmin=2)

    law = PowerLaw.fit(
        logarithms(numbers for numbers, _ in rows), np.array([value for _, value in rows])
    )
    return law.predict(logarithms(new_cases))


SAMPLE = 1000  # largest number of cases that are predicted or observed


@dataclass(frozen=True)
class Forecast:
    """Predicted cost of a run; None for what is not known.

    Attributes
    ----------
    cases
        Number of cases.
    seconds
        Seconds of all cases, one after the other, on a core that does nothing else.
    timing
        Seconds of all timed runs.
    size
        Bytes on disk.
    by_case
        Seconds of each predicted case.
    """

    cases: int
    seconds: Estimate | None
    timing: Estimate | None
    size: Estimate | None
    by_case: Mapping[str, Estimate]

    @property
    def is_worth_telling(self) -> bool:
        """True if the run takes more than a moment, and the forecast is accurate enough to be useful."""
        return self.seconds is not None and self.seconds.value > 10 and self.seconds.factor < 4

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
    """Return an estimate in words."""
    return f"{estimate.value:.3g} {unit} (within a factor {estimate.factor:.2g})"


def fit_model(folder: Path, machine: str) -> ForecastModel:
    """Return the model of what the journals in `folder` hold of this machine; damaged lines are left out."""
    stored: list[Observation] = []
    for path in sorted(folder.glob("*.journal.jsonl")):
        with suppress(InvalidInput):
            stored += observations(Journal(path, None, machine).contents)
    return ForecastModel(stored)


def observations(contents: Contents) -> list[Observation]:
    """Return the cost of the last ``SAMPLE`` good cases in a journal."""
    latest_first = []
    for name, record in islice(reversed(contents.records.items()), SAMPLE):
        if record.case_status is not CaseStatus.OK:
            continue
        # CPU time is the wall time on an idle core
        quantities = {"case": record.cpu, "bytes": float(record.size)}
        if samples := contents.samples.get(name):
            quantities["setup"] = min(sample.setup_cpu for sample in samples)
            quantities["solve"] = min(sample.solve_cpu for sample in samples)
        quantities["iterations"] = 1.0
        for count in ("iterations", "convolutions"):  # the latter says more
            variable = record.variable(count)
            if variable is not None and variable.ndim == 0:
                quantities["iterations"] = max(float(variable), 1.0)
        latest_first.append(Observation(record.identity.tree, quantities))
    return latest_first[::-1]


def forecast(
    costs: ForecastModel, trees: Mapping[str, object], timed: Mapping[str, tuple[object, int]]
) -> Forecast:
    """Return the predicted cost of a run.

    Of more than ``SAMPLE`` cases a sample is predicted, which represents the others.

    Parameters
    ----------
    costs
        The model.
    trees
        Cases to compute, by key.
    timed
        Cases to time with their numbers of timed runs, by key.
    """
    names, share = _sample(list(trees))
    predictions = dict(
        zip(names, costs.predict("case", [trees[name] for name in names]), strict=True)
    )
    predicted = {name: part for name, part in predictions.items() if part is not None}
    timings, timed_share = _sample(list(timed))
    parts: list[Estimate] = []
    is_known = len(predicted) == len(names)
    for quantity in ("setup", "solve"):
        times = costs.predict(quantity, [timed[name][0] for name in timings])
        for name, part in zip(timings, times, strict=True):
            if part is not None:
                repeats = timed[name][1]
                parts.append(Estimate(timed_share * repeats * part.value, part.factor))
    if not is_known:
        return Forecast(len(trees), None, None, None, predicted)
    sizes = costs.predict("bytes", [trees[name] for name in names])
    size = total(Estimate(share * part.value, part.factor) for part in sizes if part is not None)
    seconds = total(Estimate(share * part.value, part.factor) for part in predicted.values())
    return Forecast(len(trees), seconds, total(parts), size, predicted)


def _sample(names: list[str]) -> tuple[list[str], float]:
    """Return at most ``SAMPLE`` evenly spaced names, and how many names each represents."""
    step = -(-len(names) // SAMPLE) or 1
    chosen = names[::step]
    return chosen, len(names) / max(len(chosen), 1)


def score(predicted: Forecast, measured: Mapping[str, float]) -> Mapping[str, float]:
    """Return the predicted beside the measured seconds as attributes; empty where nothing was predicted."""
    pairs = [
        (predicted.by_case[name].value, seconds)
        for name, seconds in measured.items()
        if name in predicted.by_case
    ]
    pairs = [pair for pair in pairs if pair[1] > 0]
    if predicted.seconds is None or not pairs:
        return {}
    errors = [abs(log(seconds / value)) for value, seconds in pairs]
    return {
        "predicted_seconds": sum(value for value, _ in pairs),
        "predicted_within_factor": predicted.seconds.factor,
        "taken_seconds": sum(seconds for _, seconds in pairs),
        "prediction_error_factor_median": exp(float(np.median(errors))),
        "prediction_error_factor_largest": exp(max(errors)),
    }
