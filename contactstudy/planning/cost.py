"""What a solve costs before it runs: seconds from a small one timed here, threads included, and bytes."""

from dataclasses import dataclass
from math import log, log2, prod
from time import perf_counter

import numpy as np

from contactstudy.domain.device import ONE_THREAD, Device, using
from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid
from contactstudy.domain.padding import Padding, Paddings, across_and_along
from contactstudy.elasticity.convolution import Convolution, convolution, padded_cells
from contactstudy.problem.memory import solve_bytes

# Influence coefficients, found in columns and rows by turns, cost less than in proportion to the cells.
SETUP = 0.8
# Iterations of a smooth and a rough contact, coarser grids included, and what one costs in convolutions.
SMOOTH_ITERATIONS, ROUGH_ITERATIONS, ITERATION = 10, 12, 3.5
# What is timed, to say how long the rest will take, and what of a large grid, to say what threads save.
SAMPLE, LARGE_SAMPLE = 128, 512
# A busy machine takes the processor away for some hundredths of a second.
LONG_ENOUGH = 0.1


@dataclass(frozen=True)
class Timed:
    """Seconds that setting up ``cells`` cells took, and one convolution over ``work`` points."""

    cells: int
    work: float
    setup: float
    convolution: float

    def seconds(self, grid: Grid, padding: Padding | Paddings, iterations: float) -> float:
        """Of a whole solve: the set-up in proportion to a power of N, convolutions to N log N."""
        count = padded(grid, padding)
        one = self.convolution * count * log2(count) / (self.work * log2(self.work))
        setup = self.setup * max(prod(grid.cells) / self.cells, 1) ** SETUP
        return float(setup + one * ITERATION * iterations)


def timed(grid: Grid, padding: Padding | Paddings) -> Timed:
    """A small grid of as many dimensions as ``grid``, timed on this machine just now."""
    sample = Grid((SAMPLE, 1 if grid.cells[1] == 1 else SAMPLE), grid.extent)
    setups, convolutions = [], []
    for _ in range(3):
        start = perf_counter()
        operator = convolution(1.0, sample, padding, 1.0)
        ready = perf_counter()
        operator(np.ones(sample.cells))
        convolutions.append(perf_counter() - ready)
        setups.append(ready - start)
    return Timed(prod(sample.cells), operator.work, min(setups), min(convolutions))


def times_faster(grid: Grid, padding: Padding | Paddings, on: Device) -> float:
    """How many times faster a convolution runs ``on`` a device than on one thread, measured just now.

    On this grid, or on one of ``LARGE_SAMPLE`` cells along either axis; 1 on one thread, which nothing is timed for.
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
    """Points of the transform."""
    return prod(padded_cells(grid, across_and_along(padding)))


def memory(grid: Grid, padding: Padding | Paddings) -> int:
    """Bytes that a solve holds at the most."""
    return solve_bytes(grid, across_and_along(padding))


# Prior widths, all of natural logarithms: any scale, exponents and curvatures of ordinary size, and the spread that
# is assumed where too little was measured, which counts as so many measurements.
SCALE, EXPONENT, CURVATURE = 10.0, 0.6, 0.1
SPREAD, MEASUREMENTS = log(1.25), 2
PASSES = 3  # of spread and fit; the spread settles within a percent


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
    def fit(cls, logarithms: Array, values: Array) -> "PowerLaw":
        """Of the natural logarithms, shape (measurements, variables), and those of y, (measurements,).

        The spread is that of the errors of each measurement when it is predicted from all others.
        """
        centre, mean = logarithms.mean(axis=0), float(values.mean())
        terms = _terms(logarithms - centre)
        variables = logarithms.shape[1]
        prior = np.diag(
            np.array([SCALE] + [EXPONENT] * variables + [CURVATURE] * variables) ** -2.0
        )
        spread = SPREAD
        for _ in range(PASSES):
            covariance = np.linalg.inv(terms.T @ terms / spread**2 + prior)
            coefficients = covariance @ (terms.T @ (values - mean)) / spread**2
            leverage = np.einsum("ij,jk,ik->i", terms, covariance, terms) / spread**2
            left_out = (values - mean - terms @ coefficients) / np.maximum(1 - leverage, 1e-3)
            total = float((left_out**2).sum()) + MEASUREMENTS * SPREAD**2
            spread = float(np.sqrt(total / (len(values) + MEASUREMENTS)))
        covariance = np.linalg.inv(terms.T @ terms / spread**2 + prior)
        coefficients = covariance @ (terms.T @ (values - mean)) / spread**2
        return cls(centre, mean, coefficients, covariance, spread)

    def predict(self, logarithms: Array) -> tuple[Array, Array]:
        """``log y``, and its standard deviation, which grows away from what was measured."""
        terms = _terms(logarithms - self.centre)
        variance = self.spread**2 + np.einsum("ij,jk,ik->i", terms, self.covariance, terms)
        return self.mean + terms @ self.coefficients, np.sqrt(variance)


def _terms(centred: Array) -> Array:
    return np.column_stack([np.ones(len(centred)), centred, centred**2])
