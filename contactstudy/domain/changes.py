"""The rule that bounds a number by its changes between nested grids, where no law of its error is known."""

from collections.abc import Sequence

# Bound over the change of a number from half the cells, or over half of the change before.
MARGIN = 1.5
# Least change of a number, over the L1 error of the pressure, since a change may vanish by chance; and of an area, of a
# stick fraction, or of a number left by a plastic zone, over the fraction of its cells that lie at its edge.
FLOOR, AREA_FLOOR = 0.1, 0.5
# Bound over the change of a number of a film from twice the width: the error by the inlet falls with its length^-2.
INLET = 4 / 3


def largest_change(changes: Sequence[float]) -> float:
    """Return the change from half the cells, at least half of that from a quarter to half.

    Where a quarter of the cells has no solution, the only change counts twice.
    """
    return max(changes[0], changes[1] / 2) if len(changes) > 1 else 2 * changes[0]
