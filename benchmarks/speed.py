"""Time, iterations and memory of a solve against the grid, on smooth, rough and self-affine surfaces.

The form is that of asv (airspeed velocity); ``python -m benchmarks speed`` runs them without it.
"""

import tracemalloc
from collections.abc import Callable
from dataclasses import replace
from math import sqrt
from time import process_time
from typing import Annotated, cast

import numpy as np
from scipy.special import erfinv

import contactstudy as cs
from contactstudy.domain.device import Precision, using
from contactstudy.domain.validation import ABOVE_ZERO, BELOW_ONE, valid
from contactstudy.elasticity.convolution import Convolution
from contactstudy.elasticity.transforms import transforms
from contactstudy.problem.problem import Operator
from studies.reference.line_contact import HERTZ_HEIGHT, SCENE, A

LINE, SMOOTH, ROUGH, SELF_AFFINE = "line", "smooth", "rough", "self-affine"
SURFACES = (LINE, SMOOTH, ROUGH, SELF_AFFINE)
EXACT = cs.ExactPeriodicity()
TOLERANCE = 1e-8
# Solves and transforms are repeated until they have taken so long together [s].
SECONDS = 0.05
WIDTH, PERIOD = 4.8, 2.4  # half-widths
# It leaves a third of Hertz's area in contact.
ROUGHNESS = cs.Roughness(rms=0.6 * HERTZ_HEIGHT, hurst=0.8, roll_off=1.2 * A, cut_off=0.15 * A, seed=1)
# Iterations after which the memory of a solve does not grow: all fields are allocated after the second.
ENOUGH = 3
# Of the self-affine surface: its longest wave over its side, its rms slope, Hurst exponent, shortest wave in cells, and
# the fraction in contact.
ROLL_OFF, SLOPE, HURST, CUT_OFF, FRACTION = 0.25, 0.1, 0.8, 2.0, 0.2


class Solve:
    """A solve with exact periodicity on one thread, without its set-up."""

    params = (list(SURFACES), [64, 128, 256, 512])
    param_names = ("surface", "cells")
    timer = staticmethod(process_time)

    def setup(self, surface: str, cells: int) -> None:
        """Pose the problem of a surface on a grid."""
        padding: cs.Padding | cs.Paddings = EXACT
        if surface == SELF_AFFINE:
            grid, padding = cs.Grid((cells, cells), (A, A)), (EXACT, EXACT)
            scene = self_affine(grid, HURST, CUT_OFF, FRACTION)
        else:
            grid = cs.Grid((cells, 1 if surface == LINE else cells), (WIDTH * A, PERIOD * A))
            rough = (ROUGHNESS,) if surface == ROUGH else ()
            scene = replace(SCENE, shapes=SCENE.shapes + rough)
        self.problem = scene.problem(grid, padding)

    def solved(self, max_iterations: int = 1000) -> cs.Contact:
        """Return the solution after at most ``max_iterations``."""
        return cast(cs.Contact, cs.solve(self.problem, tolerance=TOLERANCE, max_iterations=max_iterations))

    def time_solve(self, surface: str, cells: int) -> None:
        """Solve."""
        self.solved()

    def track_iterations(self, surface: str, cells: int) -> int:
        """Return the number of iterations."""
        return self.solved().iterations

    def track_over_transforms(self, surface: str, cells: int) -> float:
        """Return the time of a solve over that of as many bare transforms of the full grid."""
        seconds = least_seconds(process_time, self.solved)
        operator = self.problem.operator
        return seconds / (self.solved().convolutions * transform_seconds(operator))

    def track_fields(self, surface: str, cells: int) -> float:
        """Return the peak host memory of a solve over that of one field in double precision."""
        field = 8 * self.problem.undeformed_gap.size
        return peak_bytes(lambda: self.solved(ENOUGH)) / field


def self_affine(grid: cs.Grid, hurst: float, cut_off: float, fraction: float) -> cs.Scene:
    """Return a flat surface with waves down to so many cells, under the load of a ``fraction`` in contact.

    Source: Persson (2001): the fraction is ``erf(sqrt(2) p / (E* slope))``.
    """
    side = grid.length
    cut_off = valid("cut_off", cut_off, Annotated[float, ABOVE_ZERO])
    fraction = valid("fraction", fraction, Annotated[float, BELOW_ONE])
    rms, longest, shortest = cs.RmsSlope(SLOPE), ROLL_OFF * side, cut_off * grid.cell_size[0]
    shape = cs.Roughness(rms=rms, hurst=hurst, roll_off=longest, cut_off=shortest, seed=1)
    mean = float(erfinv(fraction)) / sqrt(2) * SCENE.contact_modulus * SLOPE
    return cs.Scene(cs.LineLoad(mean * side), SCENE.solids, (shape,))


def peak_bytes(compute: Callable[[], object]) -> int:
    """Return the peak memory [bytes] that Python and numpy allocate in `compute`."""
    tracemalloc.start()
    try:
        compute()
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


def least_seconds(clock: Callable[[], float], act: Callable[[], object]) -> float:
    """Return the least time [s] of three runs of `act`, or of as many more as take ``SECONDS`` together."""
    durations: list[float] = []
    while len(durations) < 3 or sum(durations) < SECONDS:
        before = clock()
        act()
        durations.append(clock() - before)
    return min(durations)


def transform_seconds(operator: Operator) -> float:
    """Return the least time [s] of a bare pair of transforms of the operator's size."""
    assert isinstance(operator, Convolution)
    with using(cs.Cpu()):
        scaled, pair = operator.scaled(1.0, Precision.DOUBLE), transforms()
        field = np.zeros(scaled.cells)

        def transform_pair() -> object:
            work = scaled.work_array(scaled.padded, np.dtype(float))
            waves = pair.forward(field, scaled.padded, work)
            return pair.backward(waves, scaled.cells, scaled.padded)

        return least_seconds(process_time, transform_pair)
