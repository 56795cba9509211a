"""Loops over fields compiled by numba (extra ``fast``): each reads and writes its fields once.

Each takes the place of several array operations, and differs from them by rounding. They belong to the conjugate
gradient iteration for the pressure, to its preconditioner, to transforms or to a film.

Arguments of one name have one meaning. Fields have the shape (x, y) and are C-contiguous: others would be compiled
again. Pressures, gaps and displacements are dimensionless. ``height`` is the gap between the bodies, ``limit`` the upper
limit of the pressure, infinite where there is none. ``active`` is 1 in the active set, the cells with a pressure between
zero and the limit, and 0 elsewhere. ``preconditioned`` is the preconditioned residual. ``results`` (x, numbers) takes
the sums of each row, in the order of the docstring, so that they do not depend on the number of threads.
"""

import errno
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any, TypeVar, cast

import numpy as np
from numba import njit
from numba.core.caching import FunctionCache

from contactstudy.domain.device import Array
from contactstudy.domain.files import lock_descriptor, open_descriptor

Loop = TypeVar("Loop", bound=Callable[..., Any])

# Loops over blocks of 2 x 2 cells, the coarse grid of the preconditioner. They take the rows of blocks from `begin` to
# `end`, all others the rows of cells that they are given.
OVER_BLOCKS = ("block_means", "block_means_transposed", "interpolated_outside", "interpolated_outside_transposed")
# Errors of a file system without locks.
NO_LOCK_ERRORS = frozenset({errno.ENOSYS, errno.ENOLCK, errno.EOPNOTSUPP, errno.EINVAL})
# All loops, so that a forecast can count what was compiled during a solve.
LOOPS: list[Any] = []


class LockedCache(FunctionCache):
    """Machine code of a function on disk, read or written by one process at a time.

    numba names the file of a signature in an index that it reads and writes apart: two processes that compile two
    signatures at once would give both one name, and every later process would load the code of the other.
    """

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return the compiled function of a signature, None where there is none."""
        with self._locked():
            return super().load_overload(sig, target_context)  # type: ignore[no-untyped-call]

    def save_overload(self, sig: Any, data: Any) -> None:
        """Write the compiled function of a signature."""
        with self._locked():
            super().save_overload(sig, data)  # type: ignore[no-untyped-call]

    @contextmanager
    def _locked(self) -> Iterator[None]:
        """Hold the lock of the folder for compiled code in a block, without one where the file system has none."""
        self._impl.locator.ensure_cache_path()
        lock = Path(self.cache_path, ".compiled.lock")
        descriptor = open_descriptor(lock, os.O_RDWR | os.O_CREAT)
        try:
            try:
                lock_descriptor(descriptor, wait=True)
            except OSError as error:
                if error.errno not in NO_LOCK_ERRORS:
                    raise
            yield
        finally:
            os.close(descriptor)


def _compiled(function: Loop, fastmath: set[str]) -> Loop:
    """Compile a loop at its first call; `fastmath` are the rules of IEEE arithmetic that it need not keep."""
    loop: Any = njit(nogil=True, error_model="numpy", fastmath=fastmath)(function)
    loop._cache = LockedCache(function)  # type: ignore[no-untyped-call]  # in place of cache=True
    LOOPS.append(loop)
    return cast(Loop, loop)


# Decorators of a loop whose sums are taken in the order that is written, and of one that may reorder them and lose the
# sign of a zero. In both nan and inf keep their meaning.
exact = partial(_compiled, fastmath=set())
summing = partial(_compiled, fastmath={"reassoc", "nsz"})


@summing
def active_gap_sums(undeformed: Array, displacement: Array, pressure: Array, limit: float, results: Array) -> None:
    """Write for each row the sum of the gap at no approach over the active set, and the set's number of cells."""
    for i in range(pressure.shape[0]):
        heights, cells = 0.0, 0.0
        for j in range(pressure.shape[1]):
            loaded = pressure[i, j]
            active = 1.0 if (loaded > 0) & (loaded < limit) else 0.0
            heights += (undeformed[i, j] + displacement[i, j]) * active
            cells += active
        results[i, 0], results[i, 1] = heights, cells


@summing
def gap(
    undeformed: Array, displacement: Array, pressure: Array, approach: float, limit: float,
    height: Array, results: Array,
) -> None:  # fmt: skip
    """Write the `height` of the gap, counted from the approach, and the terms of its residual.

    Each row gets the sum of the pressure, and over the active set the sums of pressure times absolute gap and of the
    pressure. The first row also gets two values of all rows: the largest violation in other cells, which is a negative
    gap without pressure or a positive one at the limit, and the largest absolute displacement.
    """
    columns = height.shape[1]
    # one maximum a column: that of a row would not be vectorised
    largest_violation, largest_displacement = np.zeros(columns), np.zeros(columns)
    for i in range(height.shape[0]):
        load, moment, active_load = 0.0, 0.0, 0.0
        for j in range(columns):
            loaded, deflection = pressure[i, j], displacement[i, j]
            distance = undeformed[i, j] + deflection - approach
            height[i, j] = distance
            empty, full = loaded == 0, loaded >= limit
            active = 0.0 if empty | full else loaded
            load += loaded
            moment += active * abs(distance)
            active_load += active
            violation = -distance if empty else (distance if full else 0.0)
            highest = largest_violation[j]
            largest_violation[j] = violation if violation > highest else highest
            farthest = largest_displacement[j]
            largest_displacement[j] = abs(deflection) if abs(deflection) > farthest else farthest
        results[i, 0], results[i, 1], results[i, 2] = load, moment, active_load
        results[i, 3], results[i, 4] = 0.0, 0.0
    results[0, 3], results[0, 4] = largest_violation.max(), largest_displacement.max()


@exact
def active_set(pressure: Array, height: Array, limit: float, active: Array, active_gap: Array) -> None:
    """Write the `active` set, and the gap in it, zero elsewhere, as `active_gap`."""
    for i in range(pressure.shape[0]):
        for j in range(pressure.shape[1]):
            loaded = pressure[i, j]
            active[i, j] = 1.0 if (loaded > 0) & (loaded < limit) else 0.0
        for j in range(pressure.shape[1]):
            active_gap[i, j] = height[i, j] * active[i, j]


@exact
def add_entering(
    pressure: Array, height: Array, extended: Array, step_length: float, limit: float, active: Array,
    active_gap: Array, results: Array,
) -> None:  # fmt: skip
    """Add to an active set the cells that enter it after a step, and for each row write their number.

    A cell without pressure enters if its gap after the step is negative, a cell at the upper limit if it is positive.
    `active_gap` gets the gap before the step. The step subtracts from the gap of all cells `step_length` times
    `extended`, the gap of the set continued to other cells.
    """
    for i in range(pressure.shape[0]):
        count = 0
        for j in range(pressure.shape[1]):
            loaded, expected = pressure[i, j], height[i, j] - step_length * extended[i, j]
            enters = ((loaded == 0) & (expected < 0)) | ((loaded >= limit) & (expected > 0))
            count += 1 if enters else 0
            active[i, j] = 1.0 if enters else active[i, j]
            active_gap[i, j] = height[i, j] if enters else active_gap[i, j]
        results[i, 0] = count


@summing
def direction_sums(active: Array, preconditioned: Array, results: Array) -> None:
    """Write for each row the number of cells in the `active` set, and the sum of the `preconditioned` residual."""
    for i in range(active.shape[0]):
        count = preconditioned_sum = 0.0
        for j in range(active.shape[1]):
            count += active[i, j]
            preconditioned_sum += preconditioned[i, j]
        results[i, 0], results[i, 1] = count, preconditioned_sum


@summing
def conjugacy_sums(
    height: Array, preconditioned: Array, active: Array, before: Array, after: Array,
    displacement_before: Array, displacement_after: Array, results: Array,
) -> None:  # fmt: skip
    """Write for each row the sums that make a direction conjugate to the last step.

    They are the number of active cells, the preconditioned residual, gap times preconditioned residual, preconditioned
    residual times response, response over the active set, gap times step, and the step. The step is the change of the
    pressure of active cells from `before` to `after`, the response that of the displacement.
    """
    for i in range(height.shape[0]):
        cells = preconditioned_sum = gap_preconditioned = preconditioned_response = 0.0
        active_response = gap_step = step_sum = 0.0
        for j in range(height.shape[1]):
            step = active[i, j] * (after[i, j] - before[i, j])
            response = displacement_after[i, j] - displacement_before[i, j]
            cells += active[i, j]
            preconditioned_sum += preconditioned[i, j]
            gap_preconditioned += height[i, j] * preconditioned[i, j]
            preconditioned_response += preconditioned[i, j] * response
            active_response += active[i, j] * response
            gap_step += height[i, j] * step
            step_sum += step
        results[i, 0], results[i, 1], results[i, 2] = cells, preconditioned_sum, gap_preconditioned
        results[i, 3], results[i, 4] = preconditioned_response, active_response
        results[i, 5], results[i, 6] = gap_step, step_sum


@summing
def trial(
    pressure: Array, height: Array, preconditioned: Array, active: Array, shift: float, beta: float,
    step_length: float, limit: float, buffer: Array, results: Array,
) -> None:  # fmt: skip
    """Write the pressure one step ahead, without tension, into `buffer`, which holds that before the last step.

    The direction is `shift` less the preconditioned residual, plus `beta` times the last step; it is zero outside the
    active set. Each row gets the number of cells that were beyond a limit, the sum of the new pressure, the number of
    cells with pressure, and the sum of gap times change, the slope of the complementary energy along the step. The first
    row also gets the largest pressure of all rows.
    """
    columns = pressure.shape[1]
    largest = np.zeros(columns)
    for i in range(pressure.shape[0]):
        cut = load = loaded = slope = 0.0
        for j in range(columns):
            direction = shift - preconditioned[i, j]
            if beta != 0:
                direction += beta * (pressure[i, j] - buffer[i, j])
            change = direction * active[i, j] * step_length
            after = pressure[i, j] + change
            slope += height[i, j] * change
            cut += 1.0 if (after < 0) | (after > limit) else 0.0
            after = 0.0 if after <= 0 else after  # a nan stays nan
            buffer[i, j] = after
            load += after
            loaded += 1.0 if after > 0 else 0.0
            largest[j] = after if after > largest[j] else largest[j]
        results[i, 0], results[i, 1], results[i, 2], results[i, 3] = cut, load, loaded, slope
        results[i, 4] = 0.0
    results[0, 4] = largest.max()


@summing
def load_above(trial: Array, shift: float, results: Array) -> None:
    """Write for each row the load of a pressure less a `shift`, without tension, and its number of loaded cells."""
    for i in range(trial.shape[0]):
        load, cells = 0.0, 0.0
        for j in range(trial.shape[1]):
            shifted_pressure = trial[i, j] - shift
            load += 0.0 if shifted_pressure <= 0 else shifted_pressure
            cells += 1.0 if shifted_pressure > 0 else 0.0
        results[i, 0], results[i, 1] = load, cells


@summing
def project(trial: Array, shift: float, factor: float, pressure: Array, height: Array, results: Array) -> None:
    """Subtract a `shift` from a trial pressure, cut it off at zero and multiply it by a `factor`, in place.

    Each row gets the slope of the complementary energy along the step from `pressure`.
    """
    for i in range(trial.shape[0]):
        slope = 0.0
        for j in range(trial.shape[1]):
            shifted_pressure = trial[i, j] - shift
            trial[i, j] = (0.0 if shifted_pressure <= 0 else shifted_pressure) * factor
            slope += height[i, j] * (trial[i, j] - pressure[i, j])
        results[i, 0] = slope


@summing
def curvature(trial: Array, pressure: Array, trial_displacement: Array, displacement: Array, results: Array) -> None:
    """Write for each row the inner product of the step from `pressure` with the displacement that it makes."""
    for i in range(trial.shape[0]):
        product = 0.0
        for j in range(trial.shape[1]):
            change = trial_displacement[i, j] - displacement[i, j]
            product += (trial[i, j] - pressure[i, j]) * change
        results[i, 0] = product


@exact
def outside_limits(trial: Array, pressure: Array, factor: float, limit: float, results: Array) -> None:
    """Write for each row the number of cells beyond a limit after `factor` times the step from `pressure`."""
    for i in range(trial.shape[0]):
        count = 0
        for j in range(trial.shape[1]):
            trial_pressure = pressure[i, j] + factor * (trial[i, j] - pressure[i, j])
            count += 1 if (trial_pressure < 0) | (trial_pressure > limit) else 0
        results[i, 0] = count


@exact
def take_fraction(
    trial: Array, pressure: Array, trial_displacement: Array, displacement: Array, fraction: float,
    limit: float,
) -> None:  # fmt: skip
    """Take a `fraction` of the step from `pressure`, in place.

    The trial fields become the pressure, between its limits, and the displacement to which that fraction leads.
    """
    for i in range(trial.shape[0]):
        for j in range(trial.shape[1]):
            after = pressure[i, j] + fraction * (trial[i, j] - pressure[i, j])
            after = 0.0 if after < 0 else after
            trial[i, j] = limit if after > limit else after
            change = trial_displacement[i, j] - displacement[i, j]
            trial_displacement[i, j] = displacement[i, j] + fraction * change


@exact
def scale(waves: Any, factors: Array, by: float) -> None:
    """Multiply complex `waves` by real `factors`, one for each wave, times `by`, in place."""
    common = factors.dtype.type(by)
    for i in range(factors.shape[0]):
        for j in range(factors.shape[1]):
            waves[i, j] *= factors[i, j] * common


@exact
def block_means(field: Array, means: Array, begin: int, end: int) -> None:
    """Write the means of a field over blocks of 2 x 2 cells, for the blocks of rows `begin` to `end`."""
    quarter = means.dtype.type(0.25)
    for k in range(begin, end):
        for m in range(means.shape[1]):
            upper = field[2 * k, 2 * m] + field[2 * k, 2 * m + 1]
            lower = field[2 * k + 1, 2 * m] + field[2 * k + 1, 2 * m + 1]
            means[k, m] = quarter * (upper + lower)


@exact
def block_means_transposed(
    pressure: Array, blocks: Array, block_active: Array, active: Array, begin: int, end: int
) -> None:
    """Add to the pressure of each cell in the active set a quarter of that of its block, the transposed mean, in place.

    The pressure becomes zero outside the set. `block_active` are the means of `active` over the blocks. `blocks` is the
    pressure of the blocks times `block_active`, by which it is divided here.
    """
    columns = blocks.shape[1]
    line = np.empty(2 * columns, dtype=pressure.dtype)
    for k in range(begin, end):
        for m in range(columns):
            fraction = blocks[k, m] / (4 * block_active[k, m]) if block_active[k, m] > 0 else 0.0
            line[2 * m] = fraction
            line[2 * m + 1] = fraction
        for i in (2 * k, 2 * k + 1):
            for j in range(2 * columns):
                pressure[i, j] = (pressure[i, j] + line[j]) * active[i, j]


@exact
def interpolated_outside(
    displacement: Array, blocks: Array, active: Array, extended: Array, begin: int, end: int
) -> None:
    """Write the displacement of the active set, and elsewhere that of blocks, linear between their middles.

    `displacement` is zero outside the active set.
    """
    rows, columns = blocks.shape
    full, most, least = blocks.dtype.type(1), blocks.dtype.type(0.75), blocks.dtype.type(0.25)
    near = np.empty(columns + 2, dtype=displacement.dtype)  # a row of blocks between its periodic neighbours
    line = np.empty(2 * columns, dtype=displacement.dtype)
    for i in range(2 * begin, 2 * end):
        k = i // 2
        far = (k + (1 if i % 2 else rows - 1)) % rows
        for j in range(columns):
            near[j + 1] = most * blocks[k, j] + least * blocks[far, j]
        near[0], near[columns + 1] = near[columns], near[1]
        for m in range(columns):
            middle = most * near[m + 1]
            line[2 * m] = middle + least * near[m]
            line[2 * m + 1] = middle + least * near[m + 2]
        for j in range(2 * columns):
            extended[i, j] = line[j] * (full - active[i, j]) + displacement[i, j]


@exact
def interpolated_outside_transposed(pressure: Array, active: Array, blocks: Array, begin: int, end: int) -> None:
    """Gather the pressure outside the active set to blocks: the transpose of :func:`interpolated_outside`."""
    rows, columns = blocks.shape
    full, most, least = blocks.dtype.type(1), blocks.dtype.type(0.75), blocks.dtype.type(0.25)
    line = np.zeros(2 * columns + 2, dtype=pressure.dtype)  # a row of cells between its periodic neighbours
    for k in range(begin, end):
        first, last = 2 * k, 2 * k + 1
        above, below = (first - 1) % (2 * rows), (last + 1) % (2 * rows)
        for j in range(2 * columns):
            inner = (full - active[first, j]) * pressure[first, j]
            inner += (full - active[last, j]) * pressure[last, j]
            outer = (full - active[above, j]) * pressure[above, j]
            outer += (full - active[below, j]) * pressure[below, j]
            line[j + 1] = most * inner + least * outer
        line[0], line[2 * columns + 1] = line[2 * columns], line[1]
        for m in range(columns):
            middle, ends = line[2 * m + 1] + line[2 * m + 2], line[2 * m] + line[2 * m + 3]
            blocks[k, m] = most * middle + least * ends
