"""Nested grids of one extent: cells 2^k and 1.5 x 2^k times those of a coarsest grid of about 12."""

from itertools import product
from math import log

# Cells along the shorter axis of the coarsest common grid, of which every grid has a multiple in MULTIPLES.
UNIT = (4, 5, 6, 8)
LARGEST_UNIT = 1024
# Multiples of the unit: 2^k and 1.5 x 2^k from 2 on.
MULTIPLES = tuple(sorted(part * 2**k for k in range(14) for part in (2, 3)))[:-1]


def unit_of(cells: tuple[int, int]) -> tuple[int, int]:
    """Return a small number of cells, without prime factors above 5, in nearly the ratio of `cells`.

    An axis with one cell keeps it.
    """
    across, along = cells
    if along == 1:
        return UNIT[2], 1
    ratio = max(across, along) / min(across, along)
    smooth = [n for n in range(1, LARGEST_UNIT + 1) if 30**10 % n == 0]  # 1024 is 2^10

    def deviation(unit: tuple[int, int]) -> float:
        # prefer a unit of 6 cells: most other grids share its multiples
        return abs(log(unit[1] / unit[0] / ratio)) + (0.02 if unit[0] != 6 else 0.0)

    short, long = min(product(UNIT, smooth), key=deviation)
    return (short, long) if along >= across else (long, short)


def cells_at(unit: tuple[int, int], multiple: int) -> tuple[int, int]:
    """Return the cells (across, along) of a multiple of the unit; one cell along stays one."""
    across, along = unit
    return across * multiple, along * multiple if along > 1 else 1


def is_reference(multiple: int) -> bool:
    """Return whether every grid with at most a third of these cells nests in this one, as in multiples 3 x 2^k."""
    return multiple % 3 == 0
