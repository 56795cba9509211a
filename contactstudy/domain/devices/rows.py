"""Fields worked through in blocks of rows, which stay in the cache and which threads share."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextvars import copy_context
from functools import cache
from typing import TypeVar

import numpy as np

from contactstudy.domain.devices.device import Cpu, device, using
from contactstudy.domain.devices.namespace import Array

T = TypeVar("T")

# Cells of a block: half a dozen blocks of double precision fit into the cache of a core.
BLOCK = 2**15


def in_blocks(work: Callable[[slice], T], shape: tuple[int, ...]) -> list[T]:
    """What ``work`` makes of every block of rows of a field with that shape, in order.

    All blocks but the last have an even number of rows. They do not depend on the number of threads, so that
    sums over blocks do not either. On a device that is no :class:`Cpu` there is one block.
    """
    rows, columns = shape
    step = max(2, BLOCK // columns // 2 * 2)
    chosen = device()
    if rows <= step or not isinstance(chosen, Cpu):
        return [work(slice(0, rows))]
    blocks = [slice(begin, min(begin + step, rows)) for begin in range(0, rows, step)]
    threads = min(chosen.threads, len(blocks))
    if threads == 1:
        return [work(block) for block in blocks]
    size = -(-len(blocks) // threads)
    parts = [blocks[begin : begin + size] for begin in range(0, len(blocks), size)]
    rest = [
        _pool(threads - 1).submit(copy_context().run, _worked_alone, work, part)
        for part in parts[1:]
    ]
    done = _worked(work, parts[0])
    for one in rest:
        done += one.result()
    return done


def change(field: Array, changed: Callable[[Array], Array]) -> Array:
    """``field``, block by block in place of itself as it is ``changed``."""

    def some(rows: slice) -> None:
        field[rows, :] = changed(field[rows, :])

    in_blocks(some, field.shape)
    return field


def _worked(work: Callable[[slice], T], blocks: list[slice]) -> list[T]:
    return [work(block) for block in blocks]


def _worked_alone(work: Callable[[slice], T], blocks: list[slice]) -> list[T]:
    """In a thread of the pool, which takes no others, and warns of nothing as the solve does not."""
    with using(Cpu()), np.errstate(all="ignore"):
        return _worked(work, blocks)


@cache
def _pool(threads: int) -> ThreadPoolExecutor:
    return ThreadPoolExecutor(threads, thread_name_prefix="contactstudy")
