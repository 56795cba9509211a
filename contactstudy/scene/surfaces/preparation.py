"""Preparation of measured heights: windows, missing points, trend, seam and resampling to cells."""

from dataclasses import dataclass
from enum import Enum
from typing import Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from contactstudy.domain.checks import InvalidInput, pair, positive, set_fields, whole
from contactstudy.domain.fields import Array


@dataclass(frozen=True)
class Window:
    """Window ``number`` of ``tiles`` (across, along) equal ones, counted from 0, along the length first.

    Points left over where the tiles do not divide them belong to none, at the far ends.
    Raises :class:`~contactstudy.InvalidInput` for a number that there is not.
    """

    tiles: tuple[int, int]
    number: int = 0

    def __post_init__(self) -> None:
        remedy = "give two whole numbers, (across, along)"
        across, along = pair("Window.tiles", self.tiles, remedy)
        tiles = (
            whole("Window.tiles[0]", across, 1, "give at least 1 window across"),
            whole("Window.tiles[1]", along, 1, "give at least 1 window along"),
        )
        count = tiles[0] * tiles[1]
        number = whole("Window.number", self.number, 0, f"give a number from 0 to {count - 1}")
        if number >= count:
            raise InvalidInput(f"Window.number is {number}: give a number from 0 to {count - 1}.")
        set_fields(self, tiles=tiles, number=number)

    def of(self, points: Array) -> Array:
        """The window of ``points`` (x, y)."""
        sides = [count // tiles for count, tiles in zip(points.shape, self.tiles, strict=True)]
        if min(sides) < 2:
            raise InvalidInput(
                f"Window.tiles is {self.tiles}: give fewer, since the surface has {points.shape} points and a "
                "window needs 2 x 2."
            )
        first, second = divmod(self.number, self.tiles[1])
        return points[
            first * sides[0] : (first + 1) * sides[0], second * sides[1] : (second + 1) * sides[1]
        ]


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


class Trend(Enum):
    """The least-squares polynomial that is subtracted; the value is its total degree."""

    NONE = -1
    MEAN = 0
    PLANE = 1
    QUADRATIC = 2

    def subtracted(self, heights: Array) -> Array:
        """``heights`` (x, y) less the polynomial, fitted to all points alike."""
        if self is Trend.NONE:
            return heights
        x, y = (_from_middle(count) for count in heights.shape)
        powers = [
            (i, j)
            for i in range(self.value + 1)
            for j in range(self.value + 1 - i)
            if i < heights.shape[0] and j < heights.shape[1]
        ]
        basis = np.stack([(x[:, None] ** i * y**j).ravel() for i, j in powers], axis=1)
        coefficients = np.linalg.lstsq(basis, heights.ravel(), rcond=None)[0]
        return np.asarray(heights - (basis @ coefficients).reshape(heights.shape))


def _from_middle(count: int) -> Array:
    """Positions of points from -1 to 1, so that powers of them stay apart."""
    return np.asarray((2 * np.arange(count) - (count - 1)) / max(count - 1, 1), dtype=np.float64)


class Seam(Protocol):
    """How the end of a surface is joined to its beginning."""

    @property
    def lengths(self) -> int:
        """The period, in lengths of the surface."""
        ...

    def close(self, heights: Array) -> Array:
        """One period (width, points along) [m] of the surface ``heights`` (x, y)."""
        ...


@dataclass(frozen=True)
class AsMeasured:
    """No change: the step between the end and the beginning stays."""

    @property
    def lengths(self) -> int:
        """One."""
        return 1

    def close(self, heights: Array) -> Array:
        """The surface as it is."""
        return heights


@dataclass(frozen=True)
class Mirrored:
    """The surface is followed by its mirror image: no step, twice the period, all heights unchanged."""

    @property
    def lengths(self) -> int:
        """Two."""
        return 2

    def close(self, heights: Array) -> Array:
        """The surface and its mirror image."""
        return np.concatenate([heights, heights[:, ::-1]], axis=1)


@dataclass(frozen=True)
class Tapered:
    """Heights fall to the surface's mean at both ends, as a cosine: Tukey's window.

    ``share`` of the length, above 0 and up to 1, is tapered, half of it at each end; there the surface is
    smoother than measured.

    Source: Harris (1978), Proceedings of the IEEE 66, eq. 38.
    """

    share: float = 0.1

    def __post_init__(self) -> None:
        remedy = "give a share of the length above 0 and up to 1"
        share = positive("Tapered.share", self.share, remedy)
        if share > 1:
            raise InvalidInput(f"Tapered.share is {self.share!r}: {remedy}.")
        set_fields(self, share=share)

    @property
    def lengths(self) -> int:
        """One."""
        return 1

    def close(self, heights: Array) -> Array:
        """The windowed surface."""
        count = heights.shape[1]
        from_end = np.minimum(np.arange(count) + 0.5, count - np.arange(count) - 0.5) / count
        window = (1 - np.cos(np.pi * np.minimum(from_end / (self.share / 2), 1))) / 2
        mean = heights.mean()
        return np.asarray(mean + (heights - mean) * window)


# The boundary condition of scipy.interpolate.CubicSpline.
Ends = Literal["periodic", "not-a-knot"]


def cell_means(
    heights: Array, axis: int, *, extent: float, cells: int, width: float, ends: Ends
) -> Array:
    """Means over ``cells`` equal cells of ``width`` in all of the smooth surface through ``heights``.

    Along ``axis``, the points are the means of equal pieces of ``extent``; both are centred on the
    same origin, and ``width`` lies within the extent unless the ``ends`` are periodic. The integral of
    the surface is known at every border between two pieces; a cubic spline through it is read at the
    borders of the cells. So a cell made of whole pieces has their mean, smaller cells make up the mean of
    a larger one, and in the limit they show a surface without kinks.
    """
    from scipy.interpolate import CubicSpline  # imported only where it is needed

    count = heights.shape[axis]
    if (cells, width) == (count, extent):
        return heights
    mean = heights.mean(axis=axis, keepdims=True)
    integral = np.cumsum(heights - mean, axis=axis)
    start = np.zeros_like(mean)
    # rounding aside, the integral of what is left of the mean closes to zero
    inner = np.take(integral, range(count - 1), axis=axis)
    integral = np.concatenate([start, inner, start], axis=axis) * (extent / count)
    borders = (np.arange(count + 1) / count - 0.5) * extent
    spline = CubicSpline(borders, integral, axis=axis, bc_type=ends)
    faces = (np.arange(cells + 1) / cells - 0.5) * width
    if ends != "periodic":
        faces = np.clip(faces, borders[0], borders[-1])
    return np.asarray(mean + np.diff(spline(faces), axis=axis) * (cells / width))
