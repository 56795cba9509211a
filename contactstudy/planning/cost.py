"""The one model of cost: seconds of a solve by a regression on timed solves, and the bytes that it holds."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from math import exp, inf, log, pi, prod
from time import perf_counter, process_time

import numpy as np

from contactstudy.domain.device import ONE_THREAD, Device
from contactstudy.domain.fields import Array
from contactstudy.domain.grid import (
    CircularSuperposition,
    Grid,
    Padding,
    Paddings,
    Superposition,
    across_and_along,
)
from contactstudy.elasticity.convolution import padded_cells
from contactstudy.problem.memory import solve_bytes
from contactstudy.problem.problem import Problem
from contactstudy.scene.loads.constant_load import LineLoad
from contactstudy.scene.scene import Scene
from contactstudy.scene.shapes.roller import Cylinder
from contactstudy.scene.solids.bodies import HalfSpace
from contactstudy.solvers.solution import Solution
from contactstudy.solvers.solve import SolveOptions, solve_contact


@dataclass(frozen=True)
class TimingConstants:
    """Constants of timed solves and of the forecasts from them.

    Attributes
    ----------
    smooth_convolutions, rough_convolutions, tolerance
        FFT convolutions of the full grid in a solve of a smooth and of a rough contact to this tolerance, coarser grids
        included.
    sample_cells, sample_images
        Cells along an axis of the solve that is timed where there is no timing, and its numbers of images.
    stress_cells
        Cells along an axis of the two grids on which stress is timed, at the most.
    large_sample
        Largest number of cells along an axis of the solve that is timed on a device.
    min_total_seconds
        Time for which quick solves are repeated, since the first fills caches and other processes
        interrupt.
    min_seconds
        Smallest time that is recorded.
    transform_overhead
        Overhead of a transform of any size, in units of N log N: the time of a transform of 80 x 80 cells.
    """

    smooth_convolutions: float = 35.0
    rough_convolutions: float = 42.0
    tolerance: float = 1e-8
    sample_cells: int = 128
    sample_images: tuple[int, ...] = (1, 6)
    stress_cells: tuple[int, int] = (64, 256)
    large_sample: int = 512
    min_total_seconds: float = 0.02
    min_seconds: float = 1e-6
    transform_overhead: float = 5e4


CONSTANTS = TimingConstants()
SAMPLE_EXTENT = 2.4, 2.4


@dataclass(frozen=True)
class Timing:
    """Measured seconds of processor time of one solve.

    Attributes
    ----------
    grid, padding
        Cells and boundary conditions.
    convolutions
        FFT convolutions of the full grid.
    setup
        Seconds to set the problem up.
    solve
        Seconds to solve it.
    """

    grid: Grid
    padding: Padding | Paddings
    convolutions: float
    setup: float
    solve: float


@dataclass(frozen=True, eq=False)
class CostModel:
    """Model of the seconds of a solve on one thread, from timings of the same paddings on other grids.

    Parameters
    ----------
    timings
        Measured solves.
    sample
        Measures solves for a grid and a padding that have no timing: once for each pair of kinds of padding, and for one
        cell along or several.
    """

    timings: Sequence[Timing] = ()
    sample: Callable[[Grid, Padding | Paddings], Sequence[Timing]] = field(
        default_factory=lambda: sample_timings
    )
    _laws: "dict[str, tuple[CostLaw, CostLaw]]" = field(default_factory=dict, init=False)

    def seconds(self, grid: Grid, padding: Padding | Paddings, convolutions: float) -> float:
        """Return the predicted seconds of set-up and solve.

        Parameters
        ----------
        grid, padding
            Cells and boundary conditions.
        convolutions
            FFT convolutions of the full grid.
        """
        key = _law_key(grid, padding)
        if key not in self._laws:
            similar = [
                timing for timing in self.timings if _law_key(timing.grid, timing.padding) == key
            ]
            similar = similar or list(self.sample(grid, padding))
            sizes = [
                _work_sizes(timing.grid, timing.padding, timing.convolutions) for timing in similar
            ]
            self._laws[key] = (
                CostLaw.fit([setup for setup, _ in sizes], [timing.setup for timing in similar]),
                CostLaw.fit([solve for _, solve in sizes], [timing.solve for timing in similar]),
            )
        new_sizes = _work_sizes(grid, padding, convolutions)
        return sum(law.seconds(size) for law, size in zip(self._laws[key], new_sizes, strict=True))


def timed(
    problem_on: Callable[[Grid], Problem], grid: Grid, tolerance: float
) -> tuple[Solution, Timing]:
    """Solve on `grid`, and return the solution with the mean seconds of as many runs as take twice `min_total_seconds`.

    Parameters
    ----------
    problem_on
        Returns the problem on a grid.
    grid
        The grid.
    tolerance
        Tolerance of the solver.
    """
    setup, solve, count = 0.0, 0.0, 0
    # some clocks tick every 4 to 16 ms: a single short run is not measurable
    while setup + solve < 2 * CONSTANTS.min_total_seconds:
        start = process_time()
        problem = problem_on(grid)
        ready = process_time()
        solution = solve_contact(problem, SolveOptions(tolerance))
        setup, solve, count = setup + ready - start, solve + process_time() - ready, count + 1
    assert problem.paddings is not None
    timing = Timing(
        grid,
        problem.paddings,
        max(solution.convolutions, 1.0),
        max(setup / count, CONSTANTS.min_seconds),
        max(solve / count, CONSTANTS.min_seconds),
    )
    return solution, timing


def stress_seconds(scene: Scene, grid: Grid, padding: Padding | Paddings) -> float:
    """Return the seconds of the stress that a scene names on a grid, from that at one depth on fewer of its cells.

    They have a part in proportion to the cells, from two such grids, and one that is the same on any. Each component of
    a tangential traction takes as long again as the pressure.
    """
    from contactstudy.scene.stress import SubsurfaceStressOperator

    paddings, seconds = across_and_along(padding), 0.0
    for output in scene.outputs:
        operator = output.of(scene.solids, grid, paddings)
        if not isinstance(operator, SubsurfaceStressOperator):
            continue
        count = len(operator.depths) or operator.count_searched(grid.extent[0])
        cells, durations = [], []
        for most in (CONSTANTS.stress_cells[0], *CONSTANTS.stress_cells):  # the first fills caches
            side = most if grid.cells[1] > 1 else most**2
            sample = Grid((min(grid.cells[0], side), min(grid.cells[1], most)), grid.extent)
            at_one_depth = replace(operator, grid=sample, depths=(grid.extent[0] / 8,))
            start = process_time()
            at_one_depth(np.ones(sample.cells))
            durations.append(process_time() - start)
            cells.append(prod(sample.cells))
        beyond = (prod(grid.cells) - cells[-1]) / max(cells[-1] - cells[-2], 1)
        seconds += count * (durations[-1] + max(durations[-1] - durations[-2], 0.0) * beyond)
    sticks = getattr(scene.friction, "sticks", False) and grid.cells[1] > 1
    return seconds * (1 if scene.friction is None else 2 + sticks)


def sample_timings(grid: Grid, padding: Padding | Paddings) -> tuple[Timing, ...]:
    """Time a smooth line contact on a small grid with as many dimensions as `grid`.

    A padding that counts images is timed with few and with many of them, any other once.
    """
    across, along = across_and_along(padding)
    cells = CONSTANTS.sample_cells
    sample = Grid((cells, 1 if grid.cells[1] == 1 else cells), SAMPLE_EXTENT)
    counted: tuple[Padding, ...] = (along,)
    if isinstance(along, Superposition | CircularSuperposition):
        counted = tuple(replace(along, images=images) for images in CONSTANTS.sample_images)
    problems = (
        partial(_smooth_contact().problem, padding=(across, each_padding))
        for each_padding in counted
    )
    return tuple(timed(problem, sample, CONSTANTS.tolerance)[1] for problem in problems)


def _smooth_contact() -> Scene:
    """Return a smooth line contact of modulus 1, 3.4 half-widths of which are in the sampled extent."""
    solids = HalfSpace(1.0, 0.0), HalfSpace(inf, 0.0)
    return Scene(LineLoad(pi / 800), solids, (Cylinder(100.0),))


def _law_key(grid: Grid, padding: Padding | Paddings) -> str:
    """Return the key of a law: the names of both paddings, and 1 or 2 for one cell along or several."""
    names = (type(axis_padding).__name__ for axis_padding in across_and_along(padding))
    return f"{' '.join(names)} {min(grid.cells[1], 2)}"


def _work_sizes(
    grid: Grid, padding: Padding | Paddings, convolutions: float
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return (cells, images) for a set-up and (points of a transform, FFT convolutions) for a solve."""
    windows = (axis_padding.window for axis_padding in across_and_along(padding))
    images = prod(1 if window is None else len(window) for window in windows)
    return (prod(grid.cells), images), (padded_points(grid, padding), convolutions)


def speedup(grid: Grid, padding: Padding | Paddings, device: Device) -> float:
    """Measure how many times faster a solve is on `device` than on one thread; 1 for one thread.

    A smooth line contact is solved on as many cells, at most `large_sample` along either axis.
    """
    if device == ONE_THREAD:
        return 1.0
    across, along = (min(count, CONSTANTS.large_sample) for count in grid.cells)
    problem = _smooth_contact().problem(Grid((across, along), SAMPLE_EXTENT), padding)
    return _seconds(problem, ONE_THREAD) / _seconds(problem, device)


def _seconds(problem: Problem, device: Device) -> float:
    """Return the wall time [s] of a solve on a device: the least of several, after a first one that fills caches."""
    options, durations = SolveOptions(CONSTANTS.tolerance), [inf]
    solve_contact(problem, options, device=device)
    while len(durations) < 3 or sum(durations[1:]) < CONSTANTS.min_total_seconds:
        start = perf_counter()
        solve_contact(problem, options, device=device)
        durations.append(perf_counter() - start)
    return min(durations)


def padded_points(grid: Grid, padding: Padding | Paddings) -> int:
    """Return the number of points of the padded transform."""
    return prod(padded_cells(grid, across_and_along(padding)))


def memory(grid: Grid, padding: Padding | Paddings) -> int:
    """Return the bytes that a solve holds at most."""
    return solve_bytes(grid, across_and_along(padding))


@dataclass(frozen=True)
class PriorConstants:
    """Priors of the fit, judged by forecasts of four times the largest size from 2 to 6 timings with 10 % of noise.

    Attributes
    ----------
    scale
        Prior standard deviation of the logarithm of the scale. From 3 to 30 forecasts are the same.
    exponent
        That of the exponents beyond N log N. With 0.03 errors of forecasts grow by up to 1.6 times; 0.3 changes 5 %.
    curvature
        That of the curvatures, which follow sums such as a + b N. With 0.3 errors grow by up to 1.6 times.
    deviation, timings
        Standard deviation assumed of the logarithms of timings, and the number of timings that it counts as. Half or
        twice as many change errors by 4 %.
    iterations
        Iterations of deviation and fit, after which the deviation changes by less than 1 %.
    outlier
        Median residuals from the fit at which a timing counts half: an interrupted run takes far longer than all others.
        Values from 2 to 5 change errors by 15 %.
    """

    scale: float = 10.0
    exponent: float = 0.1
    curvature: float = 0.1
    deviation: float = log(1.25)
    timings: int = 2
    iterations: int = 3
    outlier: float = 3.0


PRIOR = PriorConstants()


@dataclass(frozen=True, eq=False)
class CostLaw:
    """Log-quadratic fit ``log y = log(N log N + b) + log n + m + c0 + sum_k (p_k u_k + q_k u_k^2)`` for seconds y.

    N is a number of points, n one of repetitions, and u are their logarithms, less their means. The overhead b of a
    transform is `transform_overhead`, and m is `log_mean`.

    Attributes
    ----------
    centre
        Mean logarithms of N and n (2,).
    log_mean
        Mean logarithm of the seconds over the work.
    coefficients
        c0, then all p, then all q.
    """

    centre: Array
    log_mean: float
    coefficients: Array

    @classmethod
    def fit(cls, sizes: Sequence[tuple[float, float]], seconds: Sequence[float]) -> "CostLaw":
        """Fit the law to the `seconds` of some `sizes` (N, n).

        Least squares with a weak prior on every coefficient (ridge regression), which decides where the timings do not;
        outliers count less. The standard deviation is that of the errors of each timing when predicted from all others.
        """
        logarithms = np.log(sizes)
        values = np.log(seconds) - [log_work(*size) for size in sizes]
        centre, mean = logarithms.mean(axis=0), float(values.mean())
        terms = _terms(logarithms - centre)
        deviations = [PRIOR.scale, *2 * [PRIOR.exponent], *2 * [PRIOR.curvature]]
        prior = np.diag(np.array(deviations) ** -2.0)
        deviation, weights = PRIOR.deviation, np.ones(len(values))
        for iteration in range(PRIOR.iterations + 1):
            weighted = (terms * weights[:, None]).T / deviation**2
            covariance = np.linalg.inv(weighted @ terms + prior)
            coefficients = covariance @ weighted @ (values - mean)
            if iteration == PRIOR.iterations:
                break
            leverage = weights * np.einsum("ij,jk,ik->i", terms, covariance, terms) / deviation**2
            left_out = (values - mean - terms @ coefficients) / np.maximum(1 - leverage, 1e-3)
            total = float((left_out**2).sum()) + PRIOR.timings * PRIOR.deviation**2
            deviation = float(np.sqrt(total / (len(values) + PRIOR.timings)))
            residual_ratio = left_out / max(float(np.median(np.abs(left_out))), 1e-3)
            weights = 1 / (1 + (residual_ratio / PRIOR.outlier) ** 2)
        return cls(centre, mean, coefficients)

    def seconds(self, size: tuple[float, float]) -> float:
        """Return the seconds of a `size` (N, n)."""
        terms = _terms(np.log([size]) - self.centre)
        return exp(float(self.log_mean + (terms @ self.coefficients)[0]) + log_work(*size))


def log_work(points: float, repetitions: float = 1.0) -> float:
    """Return the logarithm of the work ``n N log N`` of N `points`, with a fixed overhead, n `repetitions` times."""
    return log(points * log(points) + CONSTANTS.transform_overhead) + log(repetitions)


def _terms(centred: Array) -> Array:
    """Return the constant, linear and square terms (timings, coefficients) of centred logarithms."""
    return np.column_stack([np.ones(len(centred)), centred, centred**2])
