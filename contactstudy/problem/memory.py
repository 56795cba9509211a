"""Memory that a solve needs, and the refusal of a solve that this machine cannot hold."""

from math import prod

import numpy as np

from contactstudy.domain.checks import InvalidInput
from contactstudy.domain.device import Device, Precision, available_bytes
from contactstudy.domain.grid import Grid, Paddings
from contactstudy.elasticity.convolution import Convolution, padded_cells
from contactstudy.problem.problem import Problem

# Arrays of the grid's size that a solve holds beside those of the padded grid: the transform pair, and two more
# where the transforms of a library take room of their own.
FIELDS = 14
PAIR, WITH_ROOM = 2, 4
# Bytes that any machine has; to ask the system takes as long as a solve of some hundred cells.
ALWAYS_THERE = 2**24
# Arrays of these that a problem holds before it is solved: its gap and its spectrum, which is real and half as long.
GAP, SPECTRUM = 1, 0.5

# The largest block [bytes] by which glibc learns to keep memory.
LEARNT = 2**25 - 2**13


def keep_freed_memory() -> None:
    """Let the C library keep up to 64 MiB of freed memory of this process for the next arrays.

    glibc keeps twice the size of the largest mapped block that was freed, of at most 32 MiB. Until there has been one, a
    solve would get new pages for its temporary arrays again and again, which takes up to a third of its time. Other C
    libraries do not learn so.
    """
    block = np.empty(LEARNT, dtype=np.uint8)
    del block


keep_freed_memory()


def solve_bytes(grid: Grid, paddings: Paddings) -> int:
    """Return the largest memory that a solve on `grid` holds at once [bytes]."""
    return 8 * (FIELDS * prod(grid.cells) + PAIR * prod(padded_cells(grid, paddings)))


def refuse_too_large(grid: Grid, paddings: Paddings) -> None:
    """Refuse a solve that this machine cannot hold, before any array is made.

    Raises
    ------
    InvalidInput
        If the memory left is too small.
    """
    _refuse(grid, solve_bytes(grid, paddings), "")


def refuse_solve(problem: Problem, precision: Precision) -> None:
    """Refuse a solve whose arrays, beside those of the `problem` itself, this machine cannot hold.

    Raises
    ------
    InvalidInput
        If the memory left is too small.
    """
    fields = (FIELDS - GAP) * problem.undeformed_gap.size
    padded = (PAIR - SPECTRUM) * problem.operator.work
    _refuse(problem.grid, precision.bytes * (fields + padded), " more")


def _refuse(grid: Grid, needed: float, more: str) -> None:
    """Raise InvalidInput if this machine has no `needed` bytes left."""
    if needed <= ALWAYS_THERE:
        return
    available = available_bytes()
    if needed > available:
        raise InvalidInput(
            f"Grid.cells is {grid.cells!r}: a solve needs {needed / 1e9:.3g} GB{more} and this machine has "
            f"{available / 1e9:.3g} GB left, give fewer cells."
        )


def refuse_on(device: Device, operator: Convolution, precision: Precision) -> None:
    """Refuse a solve with this `operator` that the `device` cannot hold.

    Raises
    ------
    InvalidInput
        If the memory left there is too small.
    """
    numbers = FIELDS * prod(operator.cells) + WITH_ROOM * prod(operator.padded)
    needed, available = numbers * precision.bytes, device.available_bytes
    if needed > available:
        raise InvalidInput(
            f"solve.on is {device!r}: the solve needs {needed / 1e9:.3g} GB and it has {available / 1e9:.3g} GB "
            "left, give fewer cells or Cpu()."
        )
