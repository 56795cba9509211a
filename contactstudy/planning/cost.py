"""The one model of cost: seconds by a power law through solves that were timed, and the bytes that a solve holds."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from math import exp, inf, log, log10, pi, prod
from time import perf_counter, process_time

import numpy as np

from contactstudy.domain.device import ONE_THREAD, Device, using
from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid
from contactstudy.domain.padding import (
    CircularSuperposition,
    Padding,
    Paddings,
    Superposition,
    across_and_along,
)
from contactstudy.elasticity.convolution import Convolution, padded_cells
from contactstudy.problem.memory import solve_bytes
from contactstudy.problem.problem import Problem
from contactstudy.scene.bodies import HalfSpace
from contactstudy.scene.load import LineLoad
from contactstudy.scene.scene import Scene
from contactstudy.scene.shapes.roller import Cylinder
from contactstudy.solvers.solution import Solution
from contactstudy.solvers.solve import SolveOptions

# Transform pairs of the full grid in a solve of a smooth and of a rough contact to DIGITS, coarser grids included.
SMOOTH_CONVOLUTIONS, ROUGH_CONVOLUTIONS, DIGITS = 35.0, 42.0, 8
# Cells along an axis of the solve that is timed where nothing is known, and the images that are summed in it.
SAMPLE, SAMPLE_IMAGES = 128, (1, 6)
# Cells along an axis of the convolution that shows what a device saves.
LARGE_SAMPLE = 512
# A quick solve is timed again for so long [s]: the first one fills caches, and a busy machine interrupts.
LONG_ENOUGH = 0.1
# Calls that a transform of any size takes, in units of N log N: a transform of 80 x 80 cells takes as long.
CALLS = 5e4


@dataclass(frozen=True)
class Timing:
    """Seconds of processor time that it took to set up a problem and to solve it with so many ``convolutions``."""

    grid: Grid
    padding: Padding | Paddings
    convolutions: float
    setup: float
    solve: float


@dataclass(frozen=True, eq=False)
class CostModel:
    """Seconds of a solve on one thread, predicted from ``timings`` of the same paddings on other grids.

    Where there are none for the paddings asked for, ``sample`` is timed on this machine, once.
    """

    timings: Sequence[Timing] = ()
    sample: Callable[[Grid, Padding | Paddings], Sequence[Timing]] = field(
        default_factory=lambda: sample_timings
    )
    _laws: "dict[str, tuple[PowerLaw, PowerLaw]]" = field(default_factory=dict, init=False)

    def seconds(self, grid: Grid, padding: Padding | Paddings, convolutions: float) -> float:
        """Predict the seconds of set-up and solve, of a solve with so many ``convolutions``."""
        kind = _kind(grid, padding)
        if kind not in self._laws:
            alike = [one for one in self.timings if _kind(one.grid, one.padding) == kind]
            alike = alike or list(self.sample(grid, padding))
            sizes = [_sizes(one.grid, one.padding, one.convolutions) for one in alike]
            self._laws[kind] = (
                _law([setup for setup, _ in sizes], [one.setup for one in alike]),
                _law([solve for _, solve in sizes], [one.solve for one in alike]),
            )
        sizes_here = _sizes(grid, padding, convolutions)
        return sum(map(_predicted, self._laws[kind], sizes_here))


def _law(sizes: list[tuple[float, float]], seconds: list[float]) -> "PowerLaw":
    """Fit what the ``seconds`` are over N log N for the first of each of the ``sizes``, times the second."""
    works = [log_work(n) + log(times) for n, times in sizes]
    return PowerLaw.fit(np.log(sizes), np.log(seconds) - works, NEARLY, OUTLIER)


def _predicted(law: "PowerLaw", size: tuple[float, float]) -> float:
    mean, _ = law.predict(np.log([size]))
    return size[1] * exp(float(mean[0]) + log_work(size[0]))


def convolutions_to(tolerance: float, to_default: float) -> float:
    """Return the convolutions of a solve to ``tolerance``, from those of a solve to the default tolerance."""
    return to_default * -log10(tolerance) / DIGITS


def log_work(count: float) -> float:
    """Return the logarithm of ``N log N`` for a ``count`` N of points, and of the calls that any N takes."""
    return log(count * log(count) + CALLS) if count > 0 else 0.0


def timed(
    problem_on: Callable[[Grid], Problem], grid: Grid, tolerance: float
) -> tuple[Solution, Timing]:
    """Solve on ``grid`` and time it: the least of as many runs as fit into a tenth of a second."""
    setups: list[float] = []
    solves: list[float] = []
    started = process_time()
    while len(setups) < 1 or process_time() - started < LONG_ENOUGH / 2:
        start = process_time()
        problem = problem_on(grid)
        ready = process_time()
        solution = SolveOptions(tolerance).solved(problem)
        solves.append(process_time() - ready)
        setups.append(ready - start)
    assert problem.paddings is not None
    timing = Timing(
        grid, problem.paddings, max(solution.convolutions, 1.0), min(setups), min(solves)
    )
    return solution, timing


def sample_timings(grid: Grid, padding: Padding | Paddings) -> tuple[Timing, ...]:
    """Time a smooth line contact on a small grid with as many dimensions as ``grid``.

    A padding that counts images is timed with few and with many of them, all others once.
    """
    across, along = across_and_along(padding)
    sample = Grid((SAMPLE, 1 if grid.cells[1] == 1 else SAMPLE), (2.4, 2.4))
    # a contact of half-width 1 on bodies of modulus 1
    steel = HalfSpace(1.0, 0.0)
    scene = Scene(LineLoad(pi / 800), (steel, HalfSpace(inf, 0.0)), (Cylinder(100.0),))
    counted: tuple[Padding, ...] = (along,)
    if isinstance(along, Superposition | CircularSuperposition):
        counted = tuple(replace(along, images=images) for images in SAMPLE_IMAGES)
    problems = (partial(scene.problem, padding=(across, one)) for one in counted)
    return tuple(timed(problem, sample, 10.0**-DIGITS)[1] for problem in problems)


def _kind(grid: Grid, padding: Padding | Paddings) -> str:
    """Name of what timings must have in common: both paddings but for images, and one cell along or several."""
    names = (type(one).__name__ for one in across_and_along(padding))
    return f"{' '.join(names)} {min(grid.cells[1], 2)}"


def _sizes(
    grid: Grid, padding: Padding | Paddings, convolutions: float
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return what a set-up goes through, (cells, images), and a solve, (points of a transform, transforms)."""
    windows = (one.window for one in across_and_along(padding))
    images = prod(1 if window is None else len(window) for window in windows)
    return (prod(grid.cells), images), (padded(grid, padding), convolutions)


def times_faster(grid: Grid, padding: Padding | Paddings, on: Device) -> float:
    """Measure how many times faster a convolution runs ``on`` a device than on one thread.

    On this grid, or on one of ``LARGE_SAMPLE`` cells along either axis. One thread gives 1 without any timing.
    """
    if on == ONE_THREAD:
        return 1.0
    across, along = (min(count, LARGE_SAMPLE) for count in grid.cells)
    sample = Grid((across, along), grid.extent)
    points = padded_cells(sample, across_and_along(padding))
    alone, there = (_seconds(sample, points, device) for device in (ONE_THREAD, on))
    return alone / there


def _seconds(grid: Grid, points: tuple[int, int], on: Device) -> float:
    """Wall time of one convolution on ``grid`` padded to so many points, the least of those in ``LONG_ENOUGH``."""
    taken: list[float] = []
    with using(on):
        operator = Convolution(on.put(np.ones((points[0], points[1] // 2 + 1))), grid.cells, points)
        pressure = on.put(np.ones(grid.cells))
        while len(taken) < 5 or sum(taken) < LONG_ENOUGH:
            start = perf_counter()
            float(operator(pressure)[0, 0])  # a graphics processor is done when a number is here
            taken.append(perf_counter() - start)
    return min(taken)


def padded(grid: Grid, padding: Padding | Paddings) -> int:
    """Number of points of the padded transform."""
    return prod(padded_cells(grid, across_and_along(padding)))


def memory(grid: Grid, padding: Padding | Paddings) -> int:
    """Bytes that a solve holds at the most."""
    return solve_bytes(grid, across_and_along(padding))


# Prior widths, all of natural logarithms: any scale, exponents and curvatures of ordinary size, and the spread that
# is assumed where too little was measured, which counts as so many measurements.
SCALE, EXPONENT, CURVATURE = 10.0, 0.6, 0.1
SPREAD, MEASUREMENTS = log(1.25), 2
PASSES = 3  # of spread and fit; the spread settles within a percent
# The prior width of an exponent beside N log N, of what is known to be nearly in proportion to it.
NEARLY = 0.1
# A timing so many median residuals off counts half: an interrupted run takes far longer than all others.
OUTLIER = 3.0


@dataclass(frozen=True, eq=False)
class PowerLaw:
    """``log y = c0 + sum_k (p_k u_k + q_k u_k^2)`` with ``u`` the logarithms of what ``y`` depends on.

    Least squares with a weak prior on every coefficient (ridge regression), which decides where the
    measurements do not: an exponent of something that did not vary is zero, give or take 0.6. The curvature
    is small; it follows sums such as ``a + b N``.
    """

    centre: Array
    mean: float
    coefficients: Array
    covariance: Array
    spread: float

    @classmethod
    def fit(
        cls, logarithms: Array, values: Array, exponent: float = EXPONENT, outlier: float = inf
    ) -> "PowerLaw":
        """Of the natural logarithms, shape (measurements, variables), and those of y, (measurements,).

        The spread is that of the errors of each measurement when it is predicted from all others.
        """
        centre, mean = logarithms.mean(axis=0), float(values.mean())
        terms = _terms(logarithms - centre)
        variables = logarithms.shape[1]
        prior = np.diag(
            np.array([SCALE] + [exponent] * variables + [CURVATURE] * variables) ** -2.0
        )
        spread, weights = SPREAD, np.ones(len(values))
        for step in range(PASSES + 1):
            weighted = (terms * weights[:, None]).T / spread**2
            covariance = np.linalg.inv(weighted @ terms + prior)
            coefficients = covariance @ weighted @ (values - mean)
            if step == PASSES:
                break
            leverage = weights * np.einsum("ij,jk,ik->i", terms, covariance, terms) / spread**2
            left_out = (values - mean - terms @ coefficients) / np.maximum(1 - leverage, 1e-3)
            total = float((left_out**2).sum()) + MEASUREMENTS * SPREAD**2
            spread = float(np.sqrt(total / (len(values) + MEASUREMENTS)))
            far = left_out / max(float(np.median(np.abs(left_out))), 1e-3)
            weights = 1 / (1 + (far / outlier) ** 2)
        return cls(centre, mean, coefficients, covariance, spread)

    def predict(self, logarithms: Array) -> tuple[Array, Array]:
        """``log y``, and its standard deviation, which grows away from what was measured."""
        terms = _terms(logarithms - self.centre)
        variance = self.spread**2 + np.einsum("ij,jk,ik->i", terms, self.covariance, terms)
        return self.mean + terms @ self.coefficients, np.sqrt(variance)


def _terms(centred: Array) -> Array:
    return np.column_stack([np.ones(len(centred)), centred, centred**2])
