"""Predicts what a case will cost from what similar cases did cost.

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

UNLIKE = 1.0  # standard deviation, in logarithms, between one mode and another
LARGEST = 100.0  # limit of any logarithm, against overflow
CELLS = ".cells"  # in the names of a grid's numbers; nothing is predicted across modes without them
DIGITS = "tolerance"  # a number whose digits, not whose size, cost time
MOST = 300  # cases of a mode that are used, the last ones


@dataclass(frozen=True)
class Observation:
    """A case, and what is known of it: ``case``, ``setup``, ``solve`` [s], ``iterations``, ``bytes``."""

    tree: Tree
    known: Mapping[str, float]


@dataclass(frozen=True)
class Estimate:
    """A positive number, right within ``factor`` in 19 of 20 cases."""

    value: float
    factor: float


@dataclass(frozen=True, eq=False)
class ForecastModel:
    """Fitted to ``observations``, anew for each question."""

    observations: Sequence[Observation]

    def predict(self, quantity: str, trees: Sequence[Tree]) -> list[Estimate | None]:
        """``quantity`` of each case; None where nothing comparable is stored."""
        by_mode: dict[str, list[tuple[Mapping[str, float], float]]] = defaultdict(list)
        for one in self.observations:
            value = one.known.get(quantity, 0.0)
            if value > 0:
                named, numbers = _described(one.tree)
                by_mode[named].append((numbers, log(value) - _work(quantity, numbers)))
        everything = [row for rows in by_mode.values() for row in rows if _has_cells(row[0])]
        groups: dict[tuple[str, ...], list[int]] = defaultdict(list)
        described = [_described(tree) for tree in trees]
        for place, (mode, numbers) in enumerate(described):
            if mode in by_mode:
                groups[mode,].append(place)
            elif _has_cells(numbers):
                # a new mode is predicted from all others that have the same numbers
                groups["", *sorted(numbers)].append(place)
        found: list[Estimate | None] = [None] * len(trees)
        for (mode, *_), places in groups.items():
            rows = by_mode.get(mode) or everything
            if not rows:
                continue
            means, deviations = _fitted(rows[-MOST:], [described[place][1] for place in places])
            for place, mean, deviation in zip(places, means, deviations, strict=True):
                logarithm = mean + _work(quantity, described[place][1])
                spread = 2 * np.hypot(deviation, 0.0 if mode in by_mode else UNLIKE)
                found[place] = Estimate(
                    exp(np.clip(logarithm, -LARGEST, LARGEST)), exp(min(spread, LARGEST))
                )
        return found


def total(estimates: Iterable[Estimate]) -> Estimate:
    """The sum; the errors of its parts are taken to be fully correlated."""
    each = list(estimates)
    value = sum(one.value for one in each)
    sd = sum(one.value * log(one.factor) for one in each) / value if value else 0.0
    return Estimate(value, exp(sd))


def _has_cells(numbers: Mapping[str, float]) -> bool:
    return any(CELLS in name for name in numbers)


def _work(quantity: str, numbers: Mapping[str, float]) -> float:
    """The logarithm of N log N, and of the calls that any N takes, for what takes time so."""
    if quantity not in ("case", "setup", "solve"):
        return 0.0
    cells = sum(value for name, value in numbers.items() if CELLS in name)
    return log_work(exp(cells)) if cells > 0 else 0.0


def mode(tree: Tree) -> str:
    """Return all that is named in a case, whatever its numbers."""
    return _described(tree)[0]


def _described(tree: Tree) -> tuple[str, Mapping[str, float]]:
    """The mode of a case, and the logarithms of its numbers."""
    names: list[str] = []
    numbers: dict[str, float] = {}
    _walk(tree, "", names, numbers)
    return text(names), numbers


def _walk(tree: Tree, path: str, names: list[str], numbers: dict[str, float]) -> None:
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
    rows: Sequence[tuple[Mapping[str, float], float]], wanted: Sequence[Mapping[str, float]]
) -> tuple[Array, Array]:
    """Mean and standard deviation of the logarithm at ``wanted``, by the numbers that all have."""
    names = sorted(set.intersection(*(set(numbers) for numbers, _ in rows), *map(set, wanted)))

    def logarithms(all_numbers: Iterable[Mapping[str, float]]) -> Array:
        return np.array([[numbers[name] for name in names] for numbers in all_numbers], ndmin=2)

    law = PowerLaw.fit(
        logarithms(numbers for numbers, _ in rows), np.array([value for _, value in rows])
    )
    return law.predict(logarithms(wanted))


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

    @property
    def is_worth_telling(self) -> bool:
        """Return whether a user waits for more than a moment, and the forecast is good for something."""
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
    return f"{estimate.value:.3g} {unit} (within a factor {estimate.factor:.2g})"


def fit_model(folder: Path, machine: str) -> ForecastModel:
    """Fitted to what the journals in ``folder`` say of this machine; a damaged one says less, or nothing."""
    found: list[Observation] = []
    for path in sorted(folder.glob("*.journal.jsonl")):
        with suppress(InvalidInput):
            found += observations(Journal(path, None, machine).contents)
    return ForecastModel(found)


def observations(contents: Contents) -> list[Observation]:
    """Return what the good cases in a journal took, of the last ``SAMPLE``."""
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
    """Predict the cost of the cases ``trees`` to compute, and of those to time so many times, by their keys.

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
