"""Passes over fields compiled by numba (extra ``fast``): each reads and writes its fields once.

They do what array operations do elsewhere in several passes. Fields (x, y) are blocks of rows, or whole fields with
the rows to work on, and are C-contiguous: others would be compiled for anew. Results differ by rounding from those of
array operations.
"""

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numpy as np
from numba import njit

from contactstudy.domain.devices.namespace import Array

Pass = TypeVar("Pass", bound=Callable[..., Any])

# Reordered sums; nan and inf keep their meaning.
SUMS = {"reassoc", "nsz"}


def _exact(function: Pass) -> Pass:
    return cast(Pass, njit(cache=True, nogil=True, error_model="numpy")(function))


def _summing(function: Pass) -> Pass:
    return cast(Pass, njit(cache=True, nogil=True, error_model="numpy", fastmath=SUMS)(function))


@_summing
def level(undeformed: Array, displacement: Array, pressure: Array, most: float) -> Any:
    """Sum of the gap over cells that are free, and their number."""
    heights, cells = 0.0, 0.0
    for i in range(pressure.shape[0]):
        for j in range(pressure.shape[1]):
            own = pressure[i, j]
            free = 1.0 if (own > 0) & (own < most) else 0.0
            heights += (undeformed[i, j] + displacement[i, j]) * free
            cells += free
    return heights, cells


@_exact
def heights(undeformed: Array, displacement: Array, approach: float, out: Array) -> None:
    """The gap, counted from the approach."""
    for i in range(out.shape[0]):
        for j in range(out.shape[1]):
            out[i, j] = undeformed[i, j] + displacement[i, j] - approach


@_summing
def violations(pressure: Array, height: Array, most: float) -> Any:
    """The load, the moment of the gap and the load of free cells, and the largest violation of the others."""
    borne, moment, free_borne, worst = 0.0, 0.0, 0.0, 0.0
    for i in range(pressure.shape[0]):
        for j in range(pressure.shape[1]):
            own, gap = pressure[i, j], height[i, j]
            free = 1.0 if (own > 0) & (own < most) else 0.0
            borne += own
            moment += own * abs(gap) * free
            free_borne += own * free
            left = (-gap if own == 0 else gap) * (1.0 - free)
            worst = left if left > worst else worst
    return borne, moment, free_borne, worst


@_exact
def contact(pressure: Array, height: Array, cells: Array, unlevel: Array, most: float) -> None:
    """Cells that bear pressure and are at no limit, and their gap."""
    for i in range(pressure.shape[0]):
        for j in range(pressure.shape[1]):
            own = pressure[i, j]
            free = 1.0 if (own > 0) & (own < most) else 0.0
            cells[i, j] = free
            unlevel[i, j] = height[i, j] * free


@_exact
def bearing(
    pressure: Array, height: Array, closing: Array, cells: Array, unlevel: Array, length: float,
    most: float,
) -> Any:  # fmt: skip
    """To these cells, those that will bear by the gap expected, and their gap; whether there are any."""
    count = 0
    for i in range(pressure.shape[0]):
        for j in range(pressure.shape[1]):
            own, gap = pressure[i, j], height[i, j]
            expected = gap - length * closing[i, j]
            wrong = ((own == 0) & (expected < 0)) | ((own >= most) & (expected > 0))
            count += 1 if wrong else 0
            chosen = 1.0 if wrong else cells[i, j]
            cells[i, j] = chosen
            unlevel[i, j] = gap * chosen
    return count > 0


@_summing
def products(gap: Array, closing: Array, cells: Array, step: Array, response: Array) -> Any:
    """The sums that a direction needs."""
    count = closed = downhill = along = over = ahead = kept = 0.0
    for i in range(gap.shape[0]):
        for j in range(gap.shape[1]):
            count += cells[i, j]
            closed += closing[i, j]
            downhill += gap[i, j] * closing[i, j]
            along += closing[i, j] * response[i, j]
            over += cells[i, j] * response[i, j]
            ahead += gap[i, j] * step[i, j]
            kept += cells[i, j] * step[i, j]
    return count, closed, downhill, along, over, ahead, kept


@_exact
def direction(closing: Array, cells: Array, step: Array, gap_level: float, kept: float) -> None:
    """Against ``closing`` and conjugate to a step, in place of it."""
    for i in range(closing.shape[0]):
        for j in range(closing.shape[1]):
            closing[i, j] = (gap_level - closing[i, j] + kept * step[i, j]) * cells[i, j]


@_exact
def trial(pressure: Array, direction: Array, length: float, most: float) -> Any:
    """The pressure one step ahead, in place of the direction, and whether it is beyond a limit."""
    cut = 0
    for i in range(pressure.shape[0]):
        for j in range(pressure.shape[1]):
            ahead = direction[i, j] * length + pressure[i, j]
            direction[i, j] = ahead
            cut += 1 if (ahead < 0) | (ahead > most) else 0
    return cut > 0


@_exact
def chosen(trial: Array, cells: Array) -> Any:
    """Tension and what is not chosen cut off, in place; the largest that is left."""
    most = 0.0
    for i in range(trial.shape[0]):
        for j in range(trial.shape[1]):
            kept = trial[i, j] * cells[i, j]
            kept = 0.0 if kept <= 0 else kept  # and nan stays
            trial[i, j] = kept
            most = kept if kept > most else most
    return most


@_summing
def lowered(trial: Array, shift: float) -> Any:
    """What is left of a pressure so much lower, and in how many cells."""
    borne, cells = 0.0, 0.0
    for i in range(trial.shape[0]):
        for j in range(trial.shape[1]):
            rest = trial[i, j] - shift
            borne += 0.0 if rest <= 0 else rest
            cells += 1.0 if rest > 0 else 0.0
    return borne, cells


@_exact
def lower(trial: Array, shift: float, scale: float) -> None:
    """The same in place, times a factor."""
    for i in range(trial.shape[0]):
        for j in range(trial.shape[1]):
            rest = trial[i, j] - shift
            trial[i, j] = (0.0 if rest <= 0 else rest) * scale


@_summing
def difference(one: Array, other: Array, weight: Array, out: Array) -> Any:
    """``one - other``, and the sum of its product with a weight."""
    total = 0.0
    for i in range(out.shape[0]):
        for j in range(out.shape[1]):
            change = one[i, j] - other[i, j]
            out[i, j] = change
            total += weight[i, j] * change
    return total


@_exact
def weights(
    weight: Array, two: tuple[bool, bool], factor: float, inverse: Array, blocks: Array,
    begin: int, end: int,
) -> None:  # fmt: skip
    """Of blocks of parts, and one over the sum of the parts' weights."""
    line = np.zeros(2 * weight.shape[1] + 2, dtype=weight.dtype)
    for k in range(begin, end):
        _sum(weight, two, k, line)
        for m in range(blocks.shape[1]):
            total = line[m]
            inverse[k, m] = 1 / total if total > 0 else 0.0
            total *= factor
            blocks[k, m] = total if total < 1 else 1.0


@_exact
def means(
    parts: Array, two: tuple[bool, bool], inverse: Array, out: Array, begin: int, end: int
) -> None:
    """Of parts over blocks."""
    line = np.zeros(2 * parts.shape[1] + 2, dtype=parts.dtype)
    for k in range(begin, end):
        _sum(parts, two, k, line)
        for m in range(out.shape[1]):
            out[k, m] = line[m] * inverse[k, m]


@_exact
def _sum(parts: Array, two: tuple[bool, bool], k: int, line: Array) -> None:
    """The sums of a row of blocks, at the beginning of a line that is zero from the number of parts on."""
    count = parts.shape[1]
    i = 2 * k if two[0] else k
    if two[0] and i + 1 < parts.shape[0]:
        for j in range(count):
            line[j] = parts[i, j] + parts[i + 1, j]
    else:
        for j in range(count):
            line[j] = parts[i, j]
    if two[1]:
        for m in range((count + 1) // 2):
            line[m] = line[2 * m] + line[2 * m + 1]


@_exact
def gathered(
    blocks: Array, two: tuple[bool, bool], weight: Array, pressure: Array, begin: int, end: int
) -> None:
    """What parts keep of a pressure, and their share in that of their blocks, in place."""
    across, along = (2 if two[0] else 1), (2 if two[1] else 1)
    for i in range(begin, end):
        k = i // across
        for j in range(pressure.shape[1]):
            pressure[i, j] = (pressure[i, j] + blocks[k, j // along]) * weight[i, j]


@_exact
def filled(
    blocks: Array, two: tuple[bool, bool], weight: Array, held: Array, out: Array,
    begin: int, end: int,
) -> None:  # fmt: skip
    """What is held, and what parts lack of weight from blocks, linear between their middles."""
    rows, columns = blocks.shape
    count = held.shape[1]
    line = np.empty(columns + 2, dtype=held.dtype)  # one more at either end, once round
    for i in range(begin, end):
        k = i // 2 if two[0] else i
        far = (k + (1 if i % 2 else rows - 1)) % rows
        for j in range(columns):
            line[j + 1] = 0.75 * blocks[k, j] + 0.25 * blocks[far, j] if two[0] else blocks[k, j]
        line[0], line[columns + 1] = line[columns], line[1]
        if two[1]:
            for m in range(columns):
                j = 2 * m
                near = 0.75 * line[m + 1]
                out[i, j] = (near + 0.25 * line[m]) * (1 - weight[i, j]) + held[i, j]
                if j + 1 < count:
                    j += 1
                    out[i, j] = (near + 0.25 * line[m + 2]) * (1 - weight[i, j]) + held[i, j]
        else:
            for j in range(count):
                out[i, j] = line[j + 1] * (1 - weight[i, j]) + held[i, j]


@_exact
def spilled(
    pressure: Array, two: tuple[bool, bool], weight: Array, blocks: Array, begin: int, end: int
) -> None:
    """The transpose of :func:`filled`: what parts give to blocks."""
    rows, count = pressure.shape
    columns = blocks.shape[1]
    line = np.zeros(2 * columns + 2, dtype=pressure.dtype)  # one more at either end, once round
    for k in range(begin, end):
        for j in range(count):
            if not two[0]:
                line[j + 1] = (1 - weight[k, j]) * pressure[k, j]
                continue
            line[j + 1] = 0.0
        if two[0]:
            for half in range(4):
                i = (2 * k + half + 2 * blocks.shape[0] - 1) % (2 * blocks.shape[0])
                if i < rows:  # an odd number lacks the last part
                    share = 0.75 if half in (1, 2) else 0.25
                    for j in range(count):
                        line[j + 1] += share * ((1 - weight[i, j]) * pressure[i, j])
        if two[1]:
            line[0], line[2 * columns + 1] = line[2 * columns], line[1]
            for m in range(columns):
                j = 2 * m
                near = 0.75 * (line[j + 1] + line[j + 2])
                blocks[k, m] = near + 0.25 * (line[j] + line[j + 3])
        else:
            for j in range(count):
                blocks[k, j] = line[j + 1]
