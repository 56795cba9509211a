"""What becomes of points that a measurement lacks."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from contactstudy.domain.checks import InvalidInput, positive, set_fields
from contactstudy.domain.fields import Array


class Missing(Protocol):
    """A rule for missing points."""

    def admit(self, missing: int, points: int) -> None:
        """Raise :class:`~contactstudy.InvalidInput` where the rule cannot stand for so many."""
        ...

    def fill(self, heights: Array) -> Array:
        """Heights with a number at every point, from heights with nan where one is missing."""
        ...


@dataclass(frozen=True)
class RefuseMissing:
    """A surface with missing points is refused."""

    def admit(self, missing: int, points: int) -> None:
        """None may be missing."""
        if missing:
            raise InvalidInput(
                f"MeasuredSurface.heights has {missing} missing points of {points}: fill them, or give "
                "missing=HarmonicFill()."
            )

    def fill(self, heights: Array) -> Array:
        """As they are: none is missing."""
        return heights


@dataclass(frozen=True)
class HarmonicFill:
    """Missing points lie on the membrane spanned by their neighbours: Laplace's equation.

    Each is the mean of its neighbours, so that none is higher or lower than the points around the hole.
    A share of points ``up_to``, above 0 and below 1, may be missing; a surface with more is refused.
    """

    up_to: float = 0.1

    def __post_init__(self) -> None:
        remedy = "give a share above 0 and below 1"
        share = positive("HarmonicFill.up_to", self.up_to, remedy)
        if share >= 1:
            raise InvalidInput(f"HarmonicFill.up_to is {self.up_to!r}: {remedy}.")
        set_fields(self, up_to=share)

    def admit(self, missing: int, points: int) -> None:
        """No more than the share."""
        if missing > self.up_to * points:
            raise InvalidInput(
                f"MeasuredSurface.heights has {missing} missing points of {points}, a share of "
                f"{missing / points:.2g}: give missing=HarmonicFill(up_to=...) with a larger share, or "
                "another surface."
            )

    def fill(self, heights: Array) -> Array:
        """The solution of Laplace's equation on five points where one is missing."""
        holes = np.isnan(heights)
        if not holes.any():
            return heights
        filled = heights.copy()
        filled[holes] = _membrane(heights, holes)
        return filled


def _membrane(heights: Array, holes: NDArray[np.bool_]) -> Array:
    """Heights at the holes, in the order of a mask."""
    from scipy import sparse  # imported only where it is needed
    from scipy.sparse.linalg import spsolve

    number = np.full(heights.shape, -1)
    count = int(holes.sum())
    number[holes] = np.arange(count)
    row, column = np.nonzero(holes)
    neighbours, known = np.zeros(count), np.zeros(count)
    pairs = []
    for step in ((1, 0), (-1, 0), (0, 1), (0, -1)):
        i, j = row + step[0], column + step[1]
        within = (i >= 0) & (i < heights.shape[0]) & (j >= 0) & (j < heights.shape[1])
        here, there = np.flatnonzero(within), (i[within], j[within])
        neighbours[here] += 1
        open_too = holes[there]
        pairs.append((here[open_too], number[there][open_too]))
        np.add.at(known, here[~open_too], heights[there][~open_too])
    rows, columns = (np.concatenate(side) for side in zip(*pairs, strict=True))
    links = sparse.coo_array((np.ones(len(rows)), (rows, columns)), shape=(count, count))
    return np.asarray(spsolve((sparse.diags_array(neighbours) - links).tocsc(), known))
