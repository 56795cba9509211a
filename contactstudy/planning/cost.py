"""What a solve costs before it runs: seconds from a small one timed here, and bytes."""

from dataclasses import dataclass
from math import log2, prod
from time import perf_counter

import numpy as np

from contactstudy.domain.grid import Grid
from contactstudy.domain.padding import Padding, Paddings, across_and_along
from contactstudy.elasticity.convolution import convolution, padded_cells
from contactstudy.problem.memory import solve_bytes

# Influence coefficients, found in columns and rows by turns, cost less than in proportion to the cells.
SETUP = 0.8
# Iterations of a smooth and a rough contact, coarser grids included, and what one costs in convolutions.
SMOOTH_ITERATIONS, ROUGH_ITERATIONS, ITERATION = 10, 20, 3.5
# What is timed, to say how long the rest will take.
SAMPLE = 128


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


def padded(grid: Grid, padding: Padding | Paddings) -> int:
    """Points of the transform."""
    return prod(padded_cells(grid, across_and_along(padding)))


def memory(grid: Grid, padding: Padding | Paddings) -> int:
    """Bytes that a solve holds at the most."""
    return solve_bytes(grid, across_and_along(padding))
