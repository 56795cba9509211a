"""What a solve holds in memory, and whether this machine has it."""

from math import prod

from contactstudy.domain.checks import InvalidInput
from contactstudy.domain.device import Device, Precision
from contactstudy.domain.grid import Grid
from contactstudy.domain.memory import available_bytes
from contactstudy.domain.padding import Paddings
from contactstudy.elasticity.convolution import Convolution, padded_cells
from contactstudy.problem.problem import Problem

# Arrays of the grid's size that a solve holds beside those of the padded grid: the transform pair, and two more
# where the transforms of a library take room of their own.
FIELDS = 14
PAIR, WITH_ROOM = 2, 4
# Bytes that any machine has; to ask the system takes as long as a solve of some hundred cells.
ALWAYS_THERE = 2**24
# Of these, what a problem holds before it is solved: its gap and its spectrum, which is real and half as long.
GAP, SPECTRUM = 1, 0.5


def solve_bytes(grid: Grid, paddings: Paddings) -> int:
    """Bytes that a solve holds at the most."""
    return 8 * (FIELDS * prod(grid.cells) + PAIR * prod(padded_cells(grid, paddings)))


def refuse_too_large(grid: Grid, paddings: Paddings) -> None:
    """Raise :class:`~contactstudy.InvalidInput` where this machine cannot hold the solve, before any array."""
    _refuse(grid, solve_bytes(grid, paddings), "")


def refuse_solve(problem: Problem, precision: Precision) -> None:
    """The same for what a solve holds beside the ``problem``, which is there already."""
    fields = (FIELDS - GAP) * problem.undeformed_gap.size
    padded = (PAIR - SPECTRUM) * problem.operator.work
    _refuse(problem.grid, precision.bytes * (fields + padded), " more")


def _refuse(grid: Grid, needed: float, more: str) -> None:
    if needed <= ALWAYS_THERE:
        return
    there = available_bytes()
    if needed > there:
        raise InvalidInput(
            f"Grid.cells is {grid.cells!r}: a solve needs {needed / 1e9:.3g} GB{more} and this machine has "
            f"{there / 1e9:.3g} GB left, give fewer cells."
        )


def refuse_on(device: Device, operator: Convolution, precision: Precision) -> None:
    """Raise :class:`~contactstudy.InvalidInput` where the ``device`` cannot hold a solve with this operator."""
    numbers = FIELDS * prod(operator.cells) + WITH_ROOM * prod(operator.padded)
    needed, there = numbers * precision.bytes, device.available_bytes
    if needed > there:
        raise InvalidInput(
            f"solve.on is {device!r}: the solve needs {needed / 1e9:.3g} GB and it has {there / 1e9:.3g} GB "
            "left, give fewer cells or Cpu()."
        )
