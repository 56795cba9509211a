"""Loops over fields on a GPU, those of the module `compiled`: each is one launch of a kernel in ``loops.cu``."""

from functools import cache, partial
from importlib import import_module
from pathlib import Path
from threading import local
from typing import Any

import numpy as np

from contactstudy.domain.device import Array

SOURCE = Path(__file__).with_name("loops.cu")
# Threads of a block, the least cells for one of them, and blocks of a processor, as the kernels are compiled for.
THREADS, CELLS, BLOCKS = 512, 2, 2
# Most sums of a kernel.
MAX_SUMS = 8
# Types of the numbers in fields, and of the parts of complex ones.
_TYPES = {"d": "double", "f": "float", "D": "double", "F": "float"}


class _Memory(local):
    """Of a thread: the barrier and the sums of a launch on the GPU, and its totals in memory of the host."""

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
    """Return the memory of launches."""
    return _Memory()


@cache
def _kernel(name: str, real: str, preconditioner: str) -> Any:
    """Return a kernel for fields of these types."""
    return _module(_TYPES[real], _TYPES[preconditioner]).get_function(name)


@cache
def _module(real: str, preconditioner: str) -> Any:
    """Return the compiled kernels for fields of these types; CuPy keeps them on disk."""
    options = f"-DREAL={real}", f"-DPRE={preconditioner}", "-std=c++17"
    source = SOURCE.read_text(encoding="utf-8")
    return import_module("cupy").RawModule(
        code=source, options=options, enable_cooperative_groups=True
    )


def described(arguments: tuple[Any, ...]) -> tuple[str, str, int, int]:
    """Return the types of an iteration's fields and of its preconditioner's, and the cells of the first field and a row.

    A field of complex numbers has two cells for each.
    """
    first = arguments[0]
    real, columns, cells = first.dtype.char, first.shape[-1], first.size
    if real in "DF":
        return real.lower(), real.lower(), 2 * cells, 2 * columns
    kinds = (argument.dtype.char for argument in arguments if hasattr(argument, "dtype"))
    return real, next((kind for kind in kinds if kind != real), real), cells, columns


def launch(name: str, *arguments: Any, results: int = 0) -> Array:
    """Run a kernel over the cells of its first argument, and return its `results` (results, 1), valid until the next."""
    memory = _memory()
    real, preconditioner, cells, columns = described(arguments)
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
        loop = partial(launch, name)
        setattr(self, name, loop)
        return loop


LOOPS = GpuLoops()
