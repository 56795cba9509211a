"""What a case will cost, from what cases like it did cost.

Per mode (all that is named: padding, solver, shapes) a quantity is taken to be ``c N log N`` for N cells,
times iterations where it is the time of a solve, times a power of each number of the case, times
a smooth factor: a Gaussian process on logarithms (Rasmussen & Williams (2006), eq. 2.42, with the
coefficients of the powers integrated out).
"""

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import exp, log

import numpy as np

from contactstudy.domain.arrays import Array
from studies.store.identity import DEFAULTS, Tree, text

# Priors, in natural logarithms: any scale; powers of the order of one; a factor of 1.5 that changes where a
# number changes four-fold; times that repeat within a tenth.
SCALE, POWER, FACTOR, REACH, NOISE = 10.0, 1.0, 0.4, 1.5, 0.1
UNLIKE = 1.0  # how far, in logarithms, one mode may be from another
CALLS = 5e4  # what a small transform costs, in units of N log N: that of 80 x 80 cells
LARGEST = 100.0  # of any logarithm: e100 is as good as without end
CELLS = ".cells"  # what the numbers of a grid are called; without them, and without its like, nothing is known
MOST = 300  # cases of a mode that are looked at, the last ones


@dataclass(frozen=True)
class Observation:
    """A case, and what is known of it: ``case``, ``setup``, ``solve`` [s], ``iterations``, ``bytes``."""

    tree: Tree
    known: Mapping[str, float]


@dataclass(frozen=True)
class Estimate:
    """A positive number, right within ``factor`` two times out of three."""

    value: float
    factor: float


@dataclass(frozen=True, eq=False)
class ForecastModel:
    """Fitted to ``observations``, anew for each question."""

    observations: Sequence[Observation]

    def predict(self, quantity: str, trees: Sequence[Tree]) -> list[Estimate | None]:
        """``quantity`` of each case; None where nothing at all is known of it.

        ``solve`` is the product of the iterations and of the time that one takes.
        """
        if quantity == "solve" and any("iterations" in one.known for one in self.observations):
            counts = self._estimates("iterations", trees)
            each = self._estimates("each", trees)
            return [
                None if a is None or b is None else _product(a, b)
                for a, b in zip(counts, each, strict=True)
            ]
        return self._estimates(quantity, trees)

    def _estimates(self, quantity: str, trees: Sequence[Tree]) -> list[Estimate | None]:
        by_mode: dict[str, list[tuple[Mapping[str, float], float]]] = defaultdict(list)
        for one in self.observations:
            value = _value(one.known, quantity)
            if value > 0:
                named, numbers = _described(one.tree)
                by_mode[named].append((numbers, log(value) - _work(quantity, numbers)))
        everything = [row for rows in by_mode.values() for row in rows if _has_cells(row[0])]
        asked: dict[tuple[str, ...], list[int]] = defaultdict(list)
        described = [_described(tree) for tree in trees]
        for place, (mode, numbers) in enumerate(described):
            if mode in by_mode:
                asked[mode,].append(place)
            elif _has_cells(numbers):
                # unlike anything known, and so alike to whatever has the same numbers
                asked["", *sorted(numbers)].append(place)
        found: list[Estimate | None] = [None] * len(trees)
        for (mode, *_), places in asked.items():
            rows = by_mode.get(mode) or everything
            if not rows:
                continue
            noise = NOISE if mode in by_mode else UNLIKE
            means, sds = _regress(rows[-MOST:], [described[place][1] for place in places], noise)
            for place, mean, sd in zip(places, means, sds, strict=True):
                work = _work(quantity, described[place][1])
                found[place] = Estimate(
                    exp(np.clip(mean + work, -LARGEST, LARGEST)), exp(min(sd, LARGEST))
                )
        return found


def total(estimates: Iterable[Estimate]) -> Estimate:
    """The sum; what is wrong of one is taken to be wrong of all."""
    each = list(estimates)
    value = sum(one.value for one in each)
    sd = sum(one.value * log(one.factor) for one in each) / value if value else 0.0
    return Estimate(value, exp(sd))


def _product(a: Estimate, b: Estimate) -> Estimate:
    return Estimate(a.value * b.value, exp(np.hypot(log(a.factor), log(b.factor))))


def _has_cells(numbers: Mapping[str, float]) -> bool:
    return any(CELLS in name for name in numbers)


def _value(known: Mapping[str, float], quantity: str) -> float:
    if quantity == "each":
        return known.get("solve", 0.0) / known.get("iterations", 1.0)
    return known.get(quantity, 0.0)


def _work(quantity: str, numbers: Mapping[str, float]) -> float:
    """The logarithm of N log N, and of the calls that any N takes, for what takes time so."""
    if quantity not in ("case", "setup", "each", "solve"):
        return 0.0
    cells = sum(value for name, value in numbers.items() if CELLS in name)
    return log(exp(cells) * cells + CALLS) if cells > 0 else 0.0


def mode(tree: Tree) -> str:
    """All that is named in a case, whatever its numbers."""
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
        elif tree.lstrip("-").isdigit():  # a count may be none
            numbers[path] = log(value + 0.5)
        elif value > 0:
            numbers[path] = log(value)


def _regress(
    rows: Sequence[tuple[Mapping[str, float], float]],
    asked: Sequence[Mapping[str, float]],
    noise: float,
) -> tuple[Array, Array]:
    """Mean and standard deviation of the process at ``asked``, given its values at ``rows``."""
    names = sorted(set.intersection(*(set(numbers) for numbers, _ in rows), *map(set, asked)))
    x = np.array([[numbers[name] for name in names] for numbers, _ in rows])
    z = np.array([[numbers[name] for name in names] for numbers in asked])
    y = np.array([value for _, value in rows])
    middle = x.mean(axis=0)
    x, z = x - middle, z - middle

    def covariance(a: Array, b: Array) -> Array:
        distance = ((a[:, None] - b[None]) ** 2).sum(axis=2)
        smooth = FACTOR**2 * np.exp(-distance / (2 * REACH**2))
        powers = POWER**2 * np.einsum("ik,jk->ij", a, b)
        return np.asarray(SCALE**2 + powers + smooth)

    known = covariance(x, x) + noise**2 * np.eye(len(x))
    across = covariance(z, x)
    solved = np.linalg.solve(known, np.column_stack([y - y.mean(), across.T]))
    mean = y.mean() + across @ solved[:, 0]
    own = SCALE**2 + POWER**2 * (z**2).sum(axis=1) + FACTOR**2
    variance = own - np.einsum("ij,ji->i", across, solved[:, 1:]) + noise**2
    return mean, np.sqrt(np.maximum(variance, noise**2))
