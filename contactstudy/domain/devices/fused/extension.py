"""Passes of an extension, from parts to blocks and back, over whole fields and the rows to work on."""

import numpy as np

from contactstudy.domain.devices.fused.jit import exact
from contactstudy.domain.devices.namespace import Array


@exact
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


@exact
def means(
    parts: Array, two: tuple[bool, bool], inverse: Array, out: Array, begin: int, end: int
) -> None:
    """Of parts over blocks."""
    line = np.zeros(2 * parts.shape[1] + 2, dtype=parts.dtype)
    for k in range(begin, end):
        _sum(parts, two, k, line)
        for m in range(out.shape[1]):
            out[k, m] = line[m] * inverse[k, m]


@exact
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


@exact
def gathered(
    blocks: Array, two: tuple[bool, bool], weight: Array, pressure: Array, begin: int, end: int
) -> None:
    """What parts keep of a pressure, and their share in that of their blocks, in place."""
    columns, count = blocks.shape[1], pressure.shape[1]
    line = np.empty(2 * columns, dtype=pressure.dtype)
    for i in range(begin, end):
        k = i // 2 if two[0] else i
        if two[1]:
            for m in range(columns):
                line[2 * m] = blocks[k, m]
                line[2 * m + 1] = blocks[k, m]
            for j in range(count):
                pressure[i, j] = (pressure[i, j] + line[j]) * weight[i, j]
        else:
            for j in range(count):
                pressure[i, j] = (pressure[i, j] + blocks[k, j]) * weight[i, j]


@exact
def filled(
    blocks: Array, two: tuple[bool, bool], weight: Array, held: Array, out: Array,
    begin: int, end: int,
) -> None:  # fmt: skip
    """What is held, and what parts lack of weight from blocks, linear between their middles."""
    rows, columns = blocks.shape
    count = held.shape[1]
    near = np.empty(columns + 2, dtype=held.dtype)  # one more at either end, once round
    line = np.empty(2 * columns, dtype=held.dtype)
    for i in range(begin, end):
        k = i // 2 if two[0] else i
        far = (k + (1 if i % 2 else rows - 1)) % rows
        for j in range(columns):
            near[j + 1] = 0.75 * blocks[k, j] + 0.25 * blocks[far, j] if two[0] else blocks[k, j]
        if two[1]:
            near[0], near[columns + 1] = near[columns], near[1]
            for m in range(columns):
                most = 0.75 * near[m + 1]
                line[2 * m] = most + 0.25 * near[m]
                line[2 * m + 1] = most + 0.25 * near[m + 2]
        else:
            for j in range(count):
                line[j] = near[j + 1]
        for j in range(count):
            out[i, j] = line[j] * (1 - weight[i, j]) + held[i, j]


@exact
def spilled(
    pressure: Array, two: tuple[bool, bool], weight: Array, blocks: Array, begin: int, end: int
) -> None:
    """The transpose of :func:`filled`: what parts give to blocks."""
    rows, count = pressure.shape
    columns = blocks.shape[1]
    line = np.zeros(2 * columns + 2, dtype=pressure.dtype)  # one more at either end, once round
    for k in range(begin, end):
        if two[0]:
            for j in range(count):
                line[j + 1] = 0.75 * ((1 - weight[2 * k, j]) * pressure[2 * k, j])
            for part, share in ((1, 0.75), (2, 0.25), (-1, 0.25)):
                i = (2 * k + part) % (2 * blocks.shape[0])
                if i < rows:  # an odd number lacks the last part
                    for j in range(count):
                        line[j + 1] += share * ((1 - weight[i, j]) * pressure[i, j])
        else:
            for j in range(count):
                line[j + 1] = (1 - weight[k, j]) * pressure[k, j]
        if two[1]:
            line[0], line[2 * columns + 1] = line[2 * columns], line[1]
            for m in range(columns):
                most = 0.75 * (line[2 * m + 1] + line[2 * m + 2])
                blocks[k, m] = most + 0.25 * (line[2 * m] + line[2 * m + 3])
        else:
            for j in range(count):
                blocks[k, j] = line[j + 1]
