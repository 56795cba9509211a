"""Loops over fields on a GPU: each is one launch of a CUDA kernel in ``loops.cu``.

They do on a GPU what the loops of the same names in the module `compiled` do on the processor. Blocks of threads share
the cells of a field, and wait for each other at a barrier where sums over all cells are taken.
"""

from functools import cache, partial
from importlib import import_module
from pathlib import Path
from threading import local
from typing import Any

import numpy as np

from contactstudy.domain.device import Array

SOURCE = Path(__file__).with_name("loops.cu")
# Threads of a block, the least number of cells for each thread, and blocks on each multiprocessor. THREADS and BLOCKS
# are the ``__launch_bounds__`` of the kernels in ``loops.cu``. Since blocks wait for each other, all must be on the GPU
# at once: two of 512 threads leave each thread 64 of the 65,536 registers of a multiprocessor. With CELLS a small field
# takes fewer blocks, which wait less.
THREADS, CELLS, BLOCKS = 512, 2, 2
# Largest number of sums that a kernel returns; the terms of a conjugate direction are 7.
MAX_SUMS = 8
# C type of the numbers in a field, by NumPy's character for its dtype; of a complex field, the type of either part.
_TYPES = {"d": "double", "f": "float", "D": "double", "F": "float"}


class _Memory(local):
    """Memory that the launches of one thread of Python share.

    `work` is on the GPU. It holds two numbers for the barrier between blocks, then the sums of all blocks twice, since
    successive totals take turns. `out` is memory of the host and takes the totals.
    """

    def __init__(self) -> None:
        cupy: Any = import_module("cupy")
        processors = cupy.cuda.Device().attributes["MultiProcessorCount"]
        self.blocks = BLOCKS * processors
        self.work = cupy.zeros(2 + 2 * self.blocks * MAX_SUMS)
        # the GPU writes to it: no copy follows a launch
        pinned = cupy.cuda.alloc_pinned_memory(8 * MAX_SUMS)
        self.out = np.frombuffer(pinned, np.float64, MAX_SUMS)
        self.arguments = self.work, np.uintp(pinned.ptr)
        self.stream = cupy.cuda.Stream.null


@cache
def _memory() -> _Memory:
    """Return the memory of launches, made at the first call, since it needs a GPU."""
    return _Memory()


@cache
def _kernel(name: str, real: str, preconditioner: str) -> Any:
    """Return the kernel `name`; `real` and `preconditioner` are keys of `_TYPES` for the two kinds of fields."""
    return _module(_TYPES[real], _TYPES[preconditioner]).get_function(name)


@cache
def _module(real: str, preconditioner: str) -> Any:
    """Return the compiled kernels for fields of these C types, see :func:`types_and_cells`; CuPy keeps them on disk."""
    options = f"-DREAL={real}", f"-DPRE={preconditioner}", "-std=c++17"
    source = SOURCE.read_text(encoding="utf-8")
    return import_module("cupy").RawModule(code=source, options=options, enable_cooperative_groups=True)


def types_and_cells(arguments: tuple[Any, ...]) -> tuple[str, str, int, int]:
    """Return two types and two numbers of cells, of the `arguments` of a kernel, for its launch.

    The types, as keys of `_TYPES`, are that of the first field, and that of a field of the preconditioner, which may
    have less precision. The numbers are those of all cells of the first field, and of the cells in one row of it. A
    complex number counts as two cells.
    """
    first = arguments[0]
    real, columns, cells = first.dtype.char, first.shape[-1], first.size
    if real in "DF":
        return real.lower(), real.lower(), 2 * cells, 2 * columns
    kinds = (argument.dtype.char for argument in arguments if hasattr(argument, "dtype"))
    return real, next((kind for kind in kinds if kind != real), real), cells, columns


def launch(name: str, *arguments: Any, results: int = 0) -> Array:
    """Run the kernel `name` over the cells of its first argument, and return its sums (results, 1).

    `results` is the number of sums. Their array is memory that the next launch of this thread overwrites.
    """
    memory = _memory()
    real, preconditioner, cells, columns = types_and_cells(arguments)
    blocks = min(memory.blocks, -(-cells // (THREADS * CELLS)))
    numbers = (float(a) if isinstance(a, int | float) else a for a in arguments)
    kernel = _kernel(name, real, preconditioner)
    kernel((blocks,), (THREADS,), (cells, columns, *numbers, *memory.arguments))
    if results:
        memory.stream.synchronize()
    return memory.out[:results, None]


class GpuLoops:
    """The kernels as functions: ``loops.gap(*arguments, results=7)``."""

    def __getattr__(self, name: str) -> Any:
        """Return the function of a kernel."""
        return partial(launch, name)


LOOPS = GpuLoops()
