"""Memory that a solve needs, and the refusal of a solve that this machine cannot hold."""

from math import prod

import numpy as np

from contactstudy.domain.checks import InvalidInput
from contactstudy.domain.device import Device, Precision, available_bytes
from contactstudy.domain.grid import Grid, Paddings
from contactstudy.elasticity.convolution import Convolution, padded_cells
from contactstudy.problem.problem import Problem

# Arrays of the grid's size that a solve holds, and of the padded grid: a pair for the transforms, and two more where a
# library's transforms take work arrays of their own.
SOLVE_FIELDS = 14
TRANSFORM_PAIR, PAIR_AND_WORK = 2, 4
# Bytes that any machine has free: asking the system takes as long as a solve of some hundred cells.
FREE_ON_ANY_MACHINE = 2**24
# Of these, the arrays that a problem holds before it is solved: its gap, and its real spectrum of half the length.
GAP, SPECTRUM = 1, 0.5
# The largest block [bytes] whose release raises the memory that glibc keeps.
LARGEST_KEPT_BLOCK = 2**25 - 2**13


def keep_freed_memory() -> None:
    """Let the C library keep up to 64 MiB of freed memory of this process for the next arrays.

    glibc keeps twice the size of the largest mapped block that was freed, of at most 32 MiB. Before there is one, a
    solve gets new pages for each temporary array, which takes up to a third of its time. Other C libraries do not adapt
    in this way.
    """
    block = np.empty(LARGEST_KEPT_BLOCK, dtype=np.uint8)
    del block


keep_freed_memory()


def solve_bytes(grid: Grid, paddings: Paddings) -> int:
    """Return the largest memory that a solve on `grid` holds at once [bytes]."""
    return 8 * (SOLVE_FIELDS * prod(grid.cells) + TRANSFORM_PAIR * prod(padded_cells(grid, paddings)))


def refuse_too_large(grid: Grid, paddings: Paddings) -> None:
    """Refuse a solve that this machine cannot hold, before any array is made.

    Raises
    ------
    InvalidInput
        If the memory left is too small.
    """
    _refuse(grid, solve_bytes(grid, paddings), "")


def refuse_solve(problem: Problem, precision: Precision) -> None:
    """Refuse a solve whose arrays, in addition to those of the `problem` itself, this machine cannot hold.

    Raises
    ------
    InvalidInput
        If the memory left is too small.
    """
    fields = (SOLVE_FIELDS - GAP) * problem.undeformed_gap.size
    padded = (TRANSFORM_PAIR - SPECTRUM) * problem.operator.transform_size
    _refuse(problem.grid, precision.bytes * (fields + padded), " more")


def _refuse(grid: Grid, needed: float, more: str) -> None:
    """Raise InvalidInput if this machine has no `needed` bytes left."""
    if needed <= FREE_ON_ANY_MACHINE:
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
    numbers = SOLVE_FIELDS * prod(operator.cells) + PAIR_AND_WORK * prod(operator.padded)
    needed, available = numbers * precision.bytes, device.available_bytes
    if needed > available:
        raise InvalidInput(
            f"solve.device is {device!r}: the solve needs {needed / 1e9:.3g} GB and it has {available / 1e9:.3g} GB "
            "left, give fewer cells or Cpu()."
        )
