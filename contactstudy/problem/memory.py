"""What a solve holds in memory, and whether this machine has it."""

from math import prod

from contactstudy.domain.checks import InvalidInput
from contactstudy.domain.grid import Grid
from contactstudy.domain.memory import available_bytes
from contactstudy.domain.padding import Paddings
from contactstudy.elasticity.convolution import padded_cells

# Arrays of the grid's size that a solve holds beside the transform pair.
FIELDS = 16


def solve_bytes(grid: Grid, paddings: Paddings) -> int:
    """Bytes that a solve holds at the most."""
    return 8 * (FIELDS * prod(grid.cells) + 2 * prod(padded_cells(grid, paddings)))


def refuse_too_large(grid: Grid, paddings: Paddings) -> None:
    """Raise :class:`~contactstudy.InvalidInput` where this machine cannot hold the solve, before any array."""
    needed, there = solve_bytes(grid, paddings), available_bytes()
    if needed > there:
        raise InvalidInput(
            f"Grid.cells is {grid.cells!r}: a solve needs {needed / 1e9:.3g} GB and this machine has "
            f"{there / 1e9:.3g} GB left, give fewer cells."
        )
