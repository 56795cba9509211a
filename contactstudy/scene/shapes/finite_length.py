"""Where a roller shorter than the grid ends."""

from dataclasses import dataclass

import numpy as np

from contactstudy.domain.checks import in_range, set_fields
from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid
from contactstudy.domain.units import Metres
from contactstudy.scene.shapes.detail import Detail


@dataclass(frozen=True)
class FiniteLength:
    """A roller that ends at ``|y| = length / 2``, with flat, sharp-edged faces.

    ``length`` [m], above zero, else :class:`~contactstudy.InvalidInput`. Cells whose centre lies beyond
    the ends stand back by ``length``: more than any elastic displacement, which is a small part of
    the body's own size, and finite, so that averages over blocks of cells stay finite too. The end is
    therefore resolved to a cell, and exactly where it falls between two. Under a scene's load per length
    of the grid, the roller carries that times the grid's period over its own length. Along a free length a
    grid of the roller's own length ends it as well, without a cell to spare.
    """

    length: Metres

    def __post_init__(self) -> None:
        set_fields(
            self,
            length=in_range(
                "FiniteLength.length", self.length, "give the roller's length above 0 m"
            ),
        )

    @property
    def curvature(self) -> float:
        """None."""
        return 0.0

    @property
    def detail(self) -> Detail:
        """The roller."""
        return Detail(roller=self.length)

    def gap(self, grid: Grid) -> Array:
        """Zero on the roller, ``length`` beyond it, shape (1, length), or (nx, 1) without an end [m]."""
        beyond = np.abs(grid.y) > self.length / 2
        if not beyond.any():
            return np.zeros((grid.cells[0], 1))
        return np.where(beyond, self.length, 0.0)[None, :]
