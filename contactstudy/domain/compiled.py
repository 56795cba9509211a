"""Passes over fields compiled by numba (extra ``fast``): each reads and writes its fields once.

They do what array operations do elsewhere in several passes. Fields (x, y) are C-contiguous: others would be compiled
for anew. ``found`` (x, results) takes what a pass finds in each row, so that sums do not depend on who works on which
rows. ``most`` is the upper limit of the pressure, infinite where there is none. Results differ by rounding from those
of array operations.
"""

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numpy as np
from numba import njit

from contactstudy.domain.device import Array

Pass = TypeVar("Pass", bound=Callable[..., Any])

# Reordered sums; nan and inf keep their meaning.
SUMS = {"reassoc", "nsz"}


def exact(function: Pass) -> Pass:
    """Compile a pass whose sums are taken in the order that is written."""
    return cast(Pass, njit(cache=True, nogil=True, error_model="numpy")(function))


def summing(function: Pass) -> Pass:
    """Compile a pass whose sums are taken in any order."""
    return cast(Pass, njit(cache=True, nogil=True, error_model="numpy", fastmath=SUMS)(function))


@summing
def level(
    undeformed: Array, displacement: Array, pressure: Array, most: float, found: Array
) -> None:
    """Write the sum of the gap over cells that are free, and their number, for each row."""
    for i in range(pressure.shape[0]):
        heights, cells = 0.0, 0.0
        for j in range(pressure.shape[1]):
            bearing = pressure[i, j]
            free = 1.0 if (bearing > 0) & (bearing < most) else 0.0
            heights += (undeformed[i, j] + displacement[i, j]) * free
            cells += free
        found[i, 0], found[i, 1] = heights, cells


@exact
def measured(
    undeformed: Array, displacement: Array, pressure: Array, approach: float, most: float,
    height: Array, found: Array,
) -> None:  # fmt: skip
    """The gap, counted from the approach.

    The load, the moment of the gap and the load of free cells; and, of all rows in the first, the largest violation of
    the others, and the largest displacement.
    """
    columns = height.shape[1]
    bound, worst, farthest = np.empty(columns), np.zeros(columns), np.zeros(columns)
    for i in range(height.shape[0]):
        for j in range(columns):
            height[i, j] = undeformed[i, j] + displacement[i, j] - approach
        for j in range(columns):
            bearing = pressure[i, j]
            bound[j] = (1.0 if bearing >= most else 0.0) - (1.0 if bearing == 0 else 0.0)
        found[i, 0], found[i, 1], found[i, 2] = _of_free(pressure[i], height[i], bound)
        found[i, 3], found[i, 4] = 0.0, 0.0
        # column by column: the largest of a row is found one by one
        for j in range(columns):
            violation = bound[j] * height[i, j]
            worst[j] = violation if violation > worst[j] else worst[j]
        for j in range(columns):
            size = abs(displacement[i, j])
            farthest[j] = size if size > farthest[j] else farthest[j]
    found[0, 3], found[0, 4] = worst.max(), farthest.max()


@summing
def _of_free(pressure: Array, height: Array, bound: Array) -> Any:
    borne, moment, free_borne = 0.0, 0.0, 0.0
    for j in range(pressure.size):
        free = 1.0 - abs(bound[j])
        borne += pressure[j]
        moment += pressure[j] * abs(height[j]) * free
        free_borne += pressure[j] * free
    return borne, moment, free_borne


@exact
def contact(pressure: Array, height: Array, most: float, cells: Array, unlevel: Array) -> None:
    """Write the cells that bear pressure and are at no limit (1, others 0), and their gap."""
    for i in range(pressure.shape[0]):
        for j in range(pressure.shape[1]):
            bearing = pressure[i, j]
            cells[i, j] = 1.0 if (bearing > 0) & (bearing < most) else 0.0
        for j in range(pressure.shape[1]):
            unlevel[i, j] = height[i, j] * cells[i, j]


@exact
def joined(
    pressure: Array, height: Array, whole: Array, length: float, most: float, contact: Array,
    cells: Array, found: Array,
) -> None:  # fmt: skip
    """Write the contact with the cells at a limit that should leave it by the gap expected; how many do, in each row."""
    for i in range(pressure.shape[0]):
        count = 0
        for j in range(pressure.shape[1]):
            bearing, expected = pressure[i, j], height[i, j] - length * whole[i, j]
            leaves = ((bearing == 0) & (expected < 0)) | ((bearing >= most) & (expected > 0))
            count += 1 if leaves else 0
            cells[i, j] = 1.0 if leaves else contact[i, j]
        found[i, 0] = count


@exact
def product(field: Array, cells: Array, out: Array) -> None:
    """Multiply two fields cell by cell, into a third."""
    for i in range(out.shape[0]):
        for j in range(out.shape[1]):
            out[i, j] = field[i, j] * cells[i, j]


@summing
def totals(cells: Array, closing: Array, found: Array) -> None:
    """Write the sums that a direction needs which is conjugate to no other, for each row."""
    for i in range(cells.shape[0]):
        count = closed = 0.0
        for j in range(cells.shape[1]):
            count += cells[i, j]
            closed += closing[i, j]
        found[i, 0], found[i, 1] = count, closed


@summing
def products(
    gap: Array, closing: Array, cells: Array, step: Array, response: Array, found: Array
) -> None:
    """Write the sums that a conjugate direction needs, for each row."""
    for i in range(gap.shape[0]):
        count = closed = downhill = along = over = along_gap = shifted = 0.0
        for j in range(gap.shape[1]):
            closes, change = closing[i, j], step[i, j] * cells[i, j]
            count += cells[i, j]
            closed += closes
            downhill += gap[i, j] * closes
            along += closes * response[i, j]
            over += cells[i, j] * response[i, j]
            along_gap += gap[i, j] * change
            shifted += change
        found[i, 0], found[i, 1], found[i, 2], found[i, 3] = count, closed, downhill, along
        found[i, 4], found[i, 5], found[i, 6] = over, along_gap, shifted


@exact
def trial(
    pressure: Array, closing: Array, cells: Array, gap_level: float, kept: float, length: float,
    most: float, step: Array, found: Array,
) -> None:  # fmt: skip
    """The pressure so far along the direction, in place of the last step, and in how many cells beyond a limit."""
    for i in range(pressure.shape[0]):
        cut = 0
        for j in range(pressure.shape[1]):
            way = gap_level - closing[i, j]
            if kept != 0:
                way += kept * step[i, j]
            trial_pressure = way * cells[i, j] * length + pressure[i, j]
            step[i, j] = trial_pressure
            cut += 1 if (trial_pressure < 0) | (trial_pressure > most) else 0
        found[i, 0] = cut


@exact
def chosen(trial: Array, cells: Array, found: Array) -> None:
    """Tension and what is not chosen cut off, in place.

    The load, in how many cells, and, of all rows in the first, the largest that is left.
    """
    columns = trial.shape[1]
    most = np.zeros(columns)
    for i in range(trial.shape[0]):
        for j in range(columns):
            compressive = trial[i, j] * cells[i, j]
            trial[i, j] = 0.0 if compressive <= 0 else compressive  # and nan stays
        found[i, 0], found[i, 1] = _left(trial[i], 0.0)
        found[i, 2] = 0.0
        for j in range(columns):
            most[j] = trial[i, j] if trial[i, j] > most[j] else most[j]
    found[0, 2] = most.max()


@exact
def lowered(trial: Array, shift: float, found: Array) -> None:
    """Write the load left of a pressure lowered by a shift, and the number of cells that bear it, for each row."""
    for i in range(trial.shape[0]):
        found[i, 0], found[i, 1] = _left(trial[i], shift)


@summing
def _left(pressure: Array, shift: float) -> Any:
    borne, cells = 0.0, 0.0
    for j in range(pressure.size):
        lowered_pressure = pressure[j] - shift
        borne += 0.0 if lowered_pressure <= 0 else lowered_pressure
        cells += 1.0 if lowered_pressure > 0 else 0.0
    return borne, cells


@exact
def lower(trial: Array, shift: float, scale: float) -> None:
    """Lower a pressure by a shift, cut it off at zero and multiply it by a factor, in place."""
    for i in range(trial.shape[0]):
        for j in range(trial.shape[1]):
            lowered_pressure = trial[i, j] - shift
            trial[i, j] = (0.0 if lowered_pressure <= 0 else lowered_pressure) * scale


@summing
def slope(trial: Array, pressure: Array, height: Array, found: Array) -> None:
    """Write the work of the gap on the step to a trial pressure, for each row."""
    for i in range(trial.shape[0]):
        work = 0.0
        for j in range(trial.shape[1]):
            work += height[i, j] * (trial[i, j] - pressure[i, j])
        found[i, 0] = work


@summing
def curvature(trial: Array, pressure: Array, ahead: Array, moved: Array, found: Array) -> None:
    """Write the work of a step on the displacement that it makes, for each row."""
    for i in range(trial.shape[0]):
        work = 0.0
        for j in range(trial.shape[1]):
            work += (trial[i, j] - pressure[i, j]) * (ahead[i, j] - moved[i, j])
        found[i, 0] = work


@exact
def beyond(trial: Array, pressure: Array, factor: float, most: float, found: Array) -> None:
    """Write the number of cells in each row that are beyond a limit after a number of steps."""
    for i in range(trial.shape[0]):
        count = 0
        for j in range(trial.shape[1]):
            trial_pressure = pressure[i, j] + factor * (trial[i, j] - pressure[i, j])
            count += 1 if (trial_pressure < 0) | (trial_pressure > most) else 0
        found[i, 0] = count


@exact
def advance(
    trial: Array, pressure: Array, ahead: Array, moved: Array, taken: float, most: float
) -> None:
    """Take a share of a step: the pressure and the displacement there, and the way back in place of those before."""
    for i in range(trial.shape[0]):
        for j in range(trial.shape[1]):
            pressure[i, j] -= trial[i, j]
            moved[i, j] -= ahead[i, j]
        if taken != 1:
            for j in range(trial.shape[1]):
                after = trial[i, j] + (1 - taken) * pressure[i, j]
                after = 0.0 if after < 0 else after
                trial[i, j] = most if after > most else after
                ahead[i, j] += (1 - taken) * moved[i, j]
                pressure[i, j] *= taken
                moved[i, j] *= taken


@exact
def block_means(parts: Array, out: Array, begin: int, end: int) -> None:
    """Write the means of parts over blocks of 2 x 2."""
    for k in range(begin, end):
        line = parts[2 * k] + parts[2 * k + 1]
        for m in range(out.shape[1]):
            out[k, m] = (line[2 * m] + line[2 * m + 1]) / 4


@exact
def block_means_transposed(
    blocks: Array, block_weight: Array, weight: Array, pressure: Array, begin: int, end: int
) -> None:
    """Add to the pressure of parts their share in that of their weighted blocks, and weight it, in place."""
    columns = blocks.shape[1]
    line = np.empty(2 * columns, dtype=pressure.dtype)
    for k in range(begin, end):
        for m in range(columns):
            share = blocks[k, m] / (4 * block_weight[k, m]) if block_weight[k, m] > 0 else 0.0
            line[2 * m] = share
            line[2 * m + 1] = share
        for i in (2 * k, 2 * k + 1):
            for j in range(2 * columns):
                pressure[i, j] = (pressure[i, j] + line[j]) * weight[i, j]


@exact
def filled(blocks: Array, weight: Array, held: Array, out: Array, begin: int, end: int) -> None:
    """Write the held displacement and what parts lack of weight from blocks, linear between their middles."""
    rows, columns = blocks.shape
    near = np.empty(columns + 2, dtype=held.dtype)  # one more at either end, once round
    line = np.empty(2 * columns, dtype=held.dtype)
    for i in range(2 * begin, 2 * end):
        k = i // 2
        far = (k + (1 if i % 2 else rows - 1)) % rows
        for j in range(columns):
            near[j + 1] = 0.75 * blocks[k, j] + 0.25 * blocks[far, j]
        near[0], near[columns + 1] = near[columns], near[1]
        for m in range(columns):
            most = 0.75 * near[m + 1]
            line[2 * m] = most + 0.25 * near[m]
            line[2 * m + 1] = most + 0.25 * near[m + 2]
        for j in range(2 * columns):
            out[i, j] = line[j] * (1 - weight[i, j]) + held[i, j]


@exact
def filled_transposed(pressure: Array, weight: Array, blocks: Array, begin: int, end: int) -> None:
    """Write what parts give to blocks: the transpose of :func:`filled`."""
    rows, columns = blocks.shape
    line = np.zeros(2 * columns + 2, dtype=pressure.dtype)  # one more at either end, once round
    for k in range(begin, end):
        for j in range(2 * columns):
            line[j + 1] = 0.75 * ((1 - weight[2 * k, j]) * pressure[2 * k, j])
        for part, share in ((1, 0.75), (2, 0.25), (-1, 0.25)):
            i = (2 * k + part) % (2 * rows)
            for j in range(2 * columns):
                line[j + 1] += share * ((1 - weight[i, j]) * pressure[i, j])
        line[0], line[2 * columns + 1] = line[2 * columns], line[1]
        for m in range(columns):
            most = 0.75 * (line[2 * m + 1] + line[2 * m + 2])
            blocks[k, m] = most + 0.25 * (line[2 * m] + line[2 * m + 3])
