"""Operations on fields (x, y) in blocks of rows that fit into the cache, shared among threads, and sums of fields."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from contextvars import copy_context
from functools import cache, partial
from importlib import import_module
from importlib.util import find_spec
from math import isnan, nan, prod
from typing import Any, TypeVar

import numpy as np

from contactstudy.domain.device import Array as Array
from contactstudy.domain.device import Cpu, Numbers, arrays, device, threads, using

T = TypeVar("T")

# Cells in a block: six blocks of double precision fit into the cache of a core.
BLOCK_CELLS = 2**15
# From this number of cells on, compiled loops save more time in about a dozen solves than loading them takes.
MIN_COMPILED_CELLS = 2**14
# In rows of fewer cells, the overhead of a compiled loop exceeds its work.
MIN_COMPILED_COLUMNS = 4
# Smallest number of cells for a thread: waking a thread takes as long as a loop over about 100 000 cells.
CELLS_PER_THREAD = 2**17


def in_blocks(work: Callable[..., T], *fields: Numbers) -> list[T]:
    """Call `work` on the same block of rows of all `fields` (x, y), for every block, and return the results in order.

    Blocks, and so sums over blocks, do not depend on the number of threads. `work` is called once with whole fields if
    they fit into one block, or are on a device that is not a :class:`Cpu`.
    """
    cells = prod(fields[0].shape)
    if cells <= BLOCK_CELLS or not isinstance(device(), Cpu):
        return [work(*fields)]

    def in_turn(blocks: list[slice]) -> list[T]:
        return [work(*(field[block, :] for field in fields)) for block in blocks]

    blocks = _blocks(*fields[0].shape)
    return [result for part in _distributed(in_turn, blocks, cells) for result in part]


def sums(work: Callable[..., tuple[float, ...]], *fields: Array) -> tuple[float, ...]:
    """Return the sums of what `work` returns for each block of rows of all `fields` (x, y)."""
    results = in_blocks(work, *fields)
    return results[0] if len(results) == 1 else tuple(map(sum, zip(*results, strict=True)))


def equal(first: Array, second: Array) -> bool:
    """Return whether two fields (x, y) are the same; blocks after the first one that differs are not read."""
    if (loops := device_loops()) is not None:
        return bool(loops.differences(first, second, results=1)[0] == 0)
    in_one_block = not isinstance(device(), Cpu)
    blocks = [slice(None)] if in_one_block else _blocks(*first.shape)
    return all(bool(arrays().all(first[block, :] == second[block, :])) for block in blocks)


def in_threads(work: Callable[[slice], object], shape: tuple[int, ...]) -> None:
    """Call `work` on one part of the rows of a field of that `shape` in each thread.

    Every part but the last has an even number of rows. The part of this thread is larger by what it does while the
    others wake. `work` may only use compiled loops, since no device is set in other threads.
    """
    rows, columns = shape
    count = min(threads(), rows * columns // CELLS_PER_THREAD)
    if count <= 1:
        work(slice(0, rows))
        return
    lead = CELLS_PER_THREAD // 2 // columns // 2 * 2
    size = max(2, -(-(rows - lead) // count // 2) * 2)
    begins = range(lead + size, rows, size)
    futures = [_pool(count - 1).submit(work, slice(begin, min(begin + size, rows))) for begin in begins]
    work(slice(0, min(lead + size, rows)))
    for future in futures:
        future.result()


def first_cells(field: Array, shape: tuple[int, ...]) -> Array:
    """Return the first cells of `field` along both axes, as many as `shape` says, in an array of their own."""
    if field.shape == shape:
        return field
    cells: Array = arrays().asarray(field[: shape[0], : shape[1]], copy=True)
    return cells


def replace_blocks(field: Array, new: Callable[[Array], Array]) -> Array:
    """Replace every block of `field` (x, y) by what `new` returns for it, in place, and return the field."""

    def replace(block: Array) -> None:
        block[...] = new(block)

    in_blocks(replace, field)
    return field


def _blocks(rows: int, columns: int) -> list[slice]:
    """Return the rows of each block of a field, an even number but in the last."""
    step = max(2, BLOCK_CELLS // columns // 2 * 2)
    return [slice(begin, min(begin + step, rows)) for begin in range(0, rows, step)]


def _distributed(work: Callable[[list[slice]], T], blocks: list[slice], cells: int) -> list[T]:
    """Give each thread a part of the `blocks` of a field of that many `cells`, and return all results in order."""
    count = min(threads(), len(blocks), cells // CELLS_PER_THREAD)
    if count <= 1:
        return [work(blocks)]
    size = -(-len(blocks) // count)
    parts = [blocks[begin : begin + size] for begin in range(0, len(blocks), size)]
    futures = [_pool(count - 1).submit(copy_context().run, _in_thread, work, part) for part in parts[1:]]
    return [work(parts[0]), *(future.result() for future in futures)]


def _in_thread(work: Callable[[list[slice]], T], blocks: list[slice]) -> T:
    """Call `work` on `blocks` in a thread of the pool.

    It uses no further threads and gives no floating-point warnings, like the solve itself.
    """
    with using(Cpu()), np.errstate(all="ignore"):
        return work(blocks)


def compiled_loops(shape: tuple[int, ...]) -> Any:
    """Return compiled loops over fields of that `shape` (x, y); None if they are missing or too slow.

    ``loops.NAME(*arguments, results=n)`` runs one, where the first argument is a field. It returns the sums or maxima
    that it takes (n, parts), of parts of the field.
    """
    if (loops := device_loops()) is not None:
        return loops
    rows, columns = shape
    pays = rows * columns >= MIN_COMPILED_CELLS and columns >= MIN_COMPILED_COLUMNS
    return _loops() if pays and isinstance(device(), Cpu) else None


def device_loops() -> Any:
    """Return the loops of a device that has some of its own, as a GPU, else None."""
    return getattr(device(), "loops", None)


class ThreadedLoops:
    """Loops of a compiled `module`, each called once a thread with the rows of that thread."""

    def __init__(self, module: Any) -> None:
        self._module = module

    def __getattr__(self, name: str) -> Callable[..., Any]:
        """Return a loop as a function of fields (x, y)."""
        run: Callable[..., Any] = _over_blocks if name in self._module.OVER_BLOCKS else _over_rows
        loop: Callable[..., Any] = partial(run, getattr(self._module, name))
        setattr(self, name, loop)
        return loop


def _over_rows(loop: Callable[..., object], *arguments: Any, results: int = 0) -> Array:
    """Run a `loop` over fields (x, y) and numbers, and return its results by row (`results`, x).

    It gets the thread's part of each field, other arguments as they are, and last, if it has `results`, that part of an
    array for them.
    """
    shape = arguments[0].shape
    values = np.empty((shape[0], results))
    if shape[0] * shape[1] < 2 * CELLS_PER_THREAD or threads() == 1:
        loop(*arguments, *([values] if results else []))
        return values.T

    def run(rows: slice) -> None:
        parts = [value[rows] if isinstance(value, np.ndarray) else value for value in arguments]
        loop(*parts, *([values[rows]] if results else []))

    in_threads(run, shape)
    return values.T


def _over_blocks(loop: Callable[..., object], field: Array, *arguments: Any) -> None:
    """Run a `loop` over blocks of 2 x 2 cells of a `field` (x, y); it gets the ends of a thread's rows of blocks."""
    rows, columns = field.shape
    in_threads(lambda part: loop(field, *arguments, part.start, part.stop), (rows // 2, 2 * columns))


@cache
def _loops() -> ThreadedLoops | None:
    """Return the loops compiled by numba; None if it is missing or does not work."""
    if find_spec("numba") is None:
        return None
    # raised by numba for another version of numpy, or without a folder for compiled code
    with suppress(ImportError, RuntimeError):
        return ThreadedLoops(import_module("contactstudy.domain.loops.compiled"))
    return None


@cache
def _pool(threads: int) -> ThreadPoolExecutor:
    """Return the pool with that number of threads."""
    return ThreadPoolExecutor(threads, thread_name_prefix="contactstudy")


# Up to this many cells BLAS starts no threads, and sums in single precision need not be taken by rows.
MAX_FLAT_CELLS = 1024


def inner(a: Array, b: Array) -> float:
    """Return the sum of ``a b`` over two fields (x, y).

    It is taken row by row: BLAS would start threads for a whole large field, which on a busy machine cost a hundred
    times the time they save.
    """
    return sum(in_blocks(dot, a, b))


def dot(a: Array, b: Array) -> float:
    """Return the sum of ``a b`` over one block of two fields."""
    xp = arrays()
    if prod(a.shape) <= MAX_FLAT_CELLS:
        return float(xp.vecdot(xp.reshape(a, (-1,)), xp.reshape(b, (-1,))))
    return float(xp.sum(xp.vecdot(a, b)))


def total(field: Array) -> float:
    """Return the sum over a field (x, y)."""
    return sum(in_blocks(lambda block: float(arrays().sum(block)), field))


def max_abs(field: Array) -> float:
    """Return the largest absolute value in a field (x, y); nan if one is nan."""
    xp = arrays()
    sizes = in_blocks(lambda block: max(float(xp.max(block)), -float(xp.min(block))), field)
    return nan if isnan(sum(sizes)) else max(sizes)


def mean_over(active: Array, field: Array) -> float:
    """Return the mean of `field` over the cells in which `active` is 1; `active` is 0 in the others."""
    return inner(field, active) / total(active)


def matrix_product(a: Array, b: Array) -> Array:
    """Return the matrix product of two numpy arrays, row by row.

    BLAS would start threads for it, which on a busy machine cost a hundred times the time they save.
    """
    return np.asarray(np.matmul(a[:, None], b)[:, 0])
