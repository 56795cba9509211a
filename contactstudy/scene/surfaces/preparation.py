"""Preparation of measured heights: tiles, missing points, trend, periodic extension (seam) and resampling to cells."""

from dataclasses import dataclass
from enum import Enum
from typing import ClassVar, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from contactstudy.domain.checks import (
    InvalidInput,
    below_one,
    check_fields,
    pair,
    set_fields,
    suggest_fields,
    up_to_one,
    whole_number,
)
from contactstudy.domain.fields import Array


@suggest_fields
@dataclass(frozen=True)
class Tile:
    """Tile of a measured surface that is cut into equal ones.

    If the tiles do not divide the number of points, the remaining points at the far ends belong to none.

    Parameters
    ----------
    tiles
        Numbers of tiles (across, along).
    number
        Index of this tile, at least 0, counted along the length first.

    Raises
    ------
    InvalidInput
        If there is no tile of that index.
    """

    tiles: tuple[int, int]
    number: int = 0

    def __post_init__(self) -> None:
        remedy = "give two whole numbers, (across, along)"
        across, along = pair("Tile.tiles", self.tiles, remedy)
        tiles = (
            whole_number("Tile.tiles[0]", across, 1, "give at least 1 tile across"),
            whole_number("Tile.tiles[1]", along, 1, "give at least 1 tile along"),
        )
        count = tiles[0] * tiles[1]
        remedy = f"give a number from 0 to {count - 1}"
        number = whole_number("Tile.number", self.number, 0, remedy, at_most=count - 1)
        set_fields(self, tiles=tiles, number=number)

    def of(self, points: Array) -> Array:
        """Return this tile of `points` (x, y)."""
        sides = [count // tiles for count, tiles in zip(points.shape, self.tiles, strict=True)]
        if min(sides) < 2:
            raise InvalidInput(
                f"Tile.tiles is {self.tiles}: give fewer, since the surface has {points.shape} points and a tile "
                "needs 2 x 2."
            )
        first, second = divmod(self.number, self.tiles[1])
        return points[
            first * sides[0] : (first + 1) * sides[0], second * sides[1] : (second + 1) * sides[1]
        ]


class Missing(Protocol):
    """Rule for missing points, the non-measured points of ISO 25178."""

    def check(self, missing: int, points: int) -> None:
        """Raise :class:`~contactstudy.InvalidInput` if the rule refuses that many missing points."""

    def fill(self, heights: Array) -> Array:
        """Return heights with a number at every point, from heights with nan where one is missing."""


@suggest_fields
@dataclass(frozen=True)
class RefuseMissing:
    """Rule that refuses a surface with missing points."""

    def check(self, missing: int, points: int) -> None:
        """Raise :class:`~contactstudy.InvalidInput` if any point is missing."""
        if missing:
            raise InvalidInput(
                f"MeasuredSurface.heights has {missing} missing points of {points}: fill them, or give "
                "missing=HarmonicFill()."
            )

    def fill(self, heights: Array) -> Array:
        """Return the heights unchanged."""
        return heights


@suggest_fields
@dataclass(frozen=True)
class HarmonicFill:
    """Rule that interpolates missing points by Laplace's equation.

    Each is the mean of its neighbours, so that none is higher or lower than the points around the hole.

    Parameters
    ----------
    up_to
        Largest fraction of missing points, above 0 and below 1; a surface with more is refused.
    """

    up_to: float = 0.1

    def __post_init__(self) -> None:
        check_fields(self, up_to=(below_one, "give a fraction above 0 and below 1"))

    def check(self, missing: int, points: int) -> None:
        """Raise :class:`~contactstudy.InvalidInput` if more points are missing than the fraction allows."""
        if missing > self.up_to * points:
            raise InvalidInput(
                f"MeasuredSurface.heights has {missing} missing points of {points}, a fraction of "
                f"{missing / points:.2g}: give missing=HarmonicFill(up_to=...) with a larger fraction, or "
                "another surface."
            )

    def fill(self, heights: Array) -> Array:
        """Return heights with the solution of Laplace's five-point equation where one is missing."""
        holes = np.isnan(heights)
        if not holes.any():
            return heights
        filled = heights.copy()
        filled[holes] = _harmonic_heights(heights, holes)
        return filled


def _harmonic_heights(heights: Array, holes: NDArray[np.bool_]) -> Array:
    """Return the heights at the `holes`, in the order of that mask, each the mean of its neighbours."""
    from scipy import sparse  # imported only where it is needed
    from scipy.sparse.linalg import spsolve

    number = np.full(heights.shape, -1)
    count = int(holes.sum())
    number[holes] = np.arange(count)
    row, column = np.nonzero(holes)
    neighbours, border_sum = np.zeros(count), np.zeros(count)
    pairs = []
    for step in ((1, 0), (-1, 0), (0, 1), (0, -1)):
        i, j = row + step[0], column + step[1]
        within = (i >= 0) & (i < heights.shape[0]) & (j >= 0) & (j < heights.shape[1])
        row_in_system, neighbour = np.flatnonzero(within), (i[within], j[within])
        neighbours[row_in_system] += 1
        is_hole = holes[neighbour]
        pairs.append((row_in_system[is_hole], number[neighbour][is_hole]))
        np.add.at(border_sum, row_in_system[~is_hole], heights[neighbour][~is_hole])
    rows, columns = (np.concatenate(side) for side in zip(*pairs, strict=True))
    links = sparse.coo_array((np.ones(len(rows)), (rows, columns)), shape=(count, count))
    return np.asarray(spsolve((sparse.diags_array(neighbours) - links).tocsc(), border_sum))


class Trend(Enum):
    """Least-squares polynomial that is subtracted from a measured surface; the value is its total degree."""

    NONE = -1
    MEAN = 0
    PLANE = 1
    QUADRATIC = 2

    def subtracted(self, heights: Array) -> Array:
        """Return `heights` (x, y) less the polynomial, fitted to all points alike."""
        return heights if self is Trend.NONE else heights - self._fitted(heights)

    @staticmethod
    def rise(heights: Array) -> tuple[float, float]:
        """Return by how much the best-fitting plane rises across and along all points [m]."""
        plane = Trend.PLANE._fitted(heights)
        return float(plane[-1, 0] - plane[0, 0]), float(plane[0, -1] - plane[0, 0])

    def _fitted(self, heights: Array) -> Array:
        """Return the least-squares polynomial at the points of `heights` (x, y)."""
        x, y = (_from_middle(count) for count in heights.shape)
        powers = [
            (i, j)
            for i in range(self.value + 1)
            for j in range(self.value + 1 - i)
            if i < heights.shape[0] and j < heights.shape[1]
        ]
        basis = np.stack([(x[:, None] ** i * y**j).ravel() for i, j in powers], axis=1)
        coefficients = np.linalg.lstsq(basis, heights.ravel(), rcond=None)[0]
        return np.asarray((basis @ coefficients).reshape(heights.shape))


def _from_middle(count: int) -> Array:
    """Return positions of points from -1 to 1, which keeps the fit of their powers well conditioned."""
    return np.asarray((2 * np.arange(count) - (count - 1)) / max(count - 1, 1), dtype=np.float64)


class PeriodicExtension(Protocol):
    """Rule of the periodic extension of a measured surface, such as a tapering window or mirroring."""

    @property
    def lengths(self) -> int:
        """Period, in lengths of the surface."""

    def periodic(self, heights: Array) -> Array:
        """Return one period (x, y) [m] along the length of the surface `heights` (x, y)."""


@suggest_fields
@dataclass(frozen=True)
class AsMeasured:
    """Unchanged surface: the step between its end and its beginning stays."""

    #: Period, in lengths of the surface.
    lengths: ClassVar[int] = 1

    def periodic(self, heights: Array) -> Array:
        """Return the heights unchanged."""
        return heights


@suggest_fields
@dataclass(frozen=True)
class Mirrored:
    """Surface followed by its mirror image: no step, twice the period, all heights unchanged."""

    #: Period, in lengths of the surface.
    lengths: ClassVar[int] = 2

    def periodic(self, heights: Array) -> Array:
        """Return the surface and its mirror image."""
        return np.concatenate([heights, heights[:, ::-1]], axis=1)


@suggest_fields
@dataclass(frozen=True)
class Tapered:
    """Surface that falls to its mean at both ends as a cosine (Tukey's window; Harris 1978, Proc. IEEE 66, eq. 38).

    In the tapered part the surface is smoother than measured.

    Parameters
    ----------
    fraction
        Tapered fraction of the length, half of it at each end, above 0 and up to 1.
    """

    #: Period, in lengths of the surface.
    lengths: ClassVar[int] = 1

    fraction: float = 0.1

    def __post_init__(self) -> None:
        remedy = "give a fraction of the length above 0 and up to 1"
        check_fields(self, fraction=(up_to_one, remedy))

    def periodic(self, heights: Array) -> Array:
        """Return the tapered surface."""
        count = heights.shape[1]
        from_end = np.minimum(np.arange(count) + 0.5, count - np.arange(count) - 0.5) / count
        taper = (1 - np.cos(np.pi * np.minimum(from_end / (self.fraction / 2), 1))) / 2
        mean = heights.mean()
        return np.asarray(mean + (heights - mean) * taper)


# The boundary condition of scipy.interpolate.CubicSpline.
Ends = Literal["periodic", "not-a-knot"]


def cell_means(
    heights: Array, axis: int, *, extent: float, cells: int, width: float, ends: Ends
) -> Array:
    """Return means over equal cells of a smooth surface that has the means `heights`.

    This is conservative resampling: a cubic spline interpolates the cumulative integral, and its differences between
    the edges of a cell give the mean. A cell made of whole pieces has their mean.

    Parameters
    ----------
    heights
        Means of equal pieces of `extent` along `axis`.
    axis
        Axis that is resampled.
    extent
        Length of all pieces [m], centred on the same origin as `width`.
    cells
        Number of cells.
    width
        Length of all cells [m], within the extent unless the ends are periodic.
    ends
        Boundary condition of the spline.
    """
    from scipy.interpolate import CubicSpline  # imported only where it is needed

    count = heights.shape[axis]
    if (cells, width) == (count, extent):
        return heights
    mean = heights.mean(axis=axis, keepdims=True)
    integral = np.cumsum(heights - mean, axis=axis)
    start = np.zeros_like(mean)
    # the integral of the deviation from the mean is zero at both ends, except for rounding
    inner = np.take(integral, range(count - 1), axis=axis)
    integral = np.concatenate([start, inner, start], axis=axis) * (extent / count)
    piece_edges = (np.arange(count + 1) / count - 0.5) * extent
    spline = CubicSpline(piece_edges, integral, axis=axis, bc_type=ends)
    cell_edges = (np.arange(cells + 1) / cells - 0.5) * width
    if ends != "periodic":
        cell_edges = np.clip(cell_edges, piece_edges[0], piece_edges[-1])
    return np.asarray(mean + np.diff(spline(cell_edges), axis=axis) * (cells / width))
