"""The grid of cells over the width and one period of the length, and its padding along both axes.

For one axis a padding defines the ``window`` of periods whose pressure acts on a point, and whether the convolution is
circular (``wraps``, n points) or padded with zeros (2 n points). A line contact is usually unbounded along x and
periodic along y; either axis may take any padding.
"""

from math import inf
from typing import Annotated, ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray

from contactstudy.domain.checks import InvalidInput
from contactstudy.domain.fields import Array
from contactstudy.domain.units import Metres
from contactstudy.domain.validation import Limits, at_least, validated

# Largest length of a cell over its width, and largest width over its length. A row of cells wider than their period is
# summed image by image.
LONGEST_CELL, WIDEST_CELL = 1e9, 1e6


@validated
class Grid:
    """Grid of equal rectangular cells, centred on the origin.

    x runs across the contact line, in the direction of motion (longitudinal), y along the line (lateral). Fields are
    constant in a cell and have the shape (nx, ny).

    Parameters
    ----------
    cells
        Number of cells (nx, ny), across and along; ``ny = 1`` with :class:`ExactPeriodicity` along is
        plane strain.
    extent
        Width and length (across, along) [m]; the length is a period where the axis is periodic.

    Raises
    ------
    InvalidInput
        If there are fewer than two cells across or none along, if the extent is no positive length, or if the
        cells are more than 1e9 times as long as wide, where influence coefficients would be lost in rounding, or more
        than 1e6 times as wide as long, where they would take minutes.
    """

    cells: tuple[Annotated[int, at_least(2)], Annotated[int, at_least(1)]]
    extent: tuple[Metres, Metres]

    def check_together(self) -> None:
        """Check the ratio of the sides of a cell."""
        aspect_ratio = self.cell_size[1] / self.cell_size[0]
        if not 1 / WIDEST_CELL <= aspect_ratio <= LONGEST_CELL:
            raise InvalidInput(
                f"Grid.extent is {self.extent!r}: give lengths whose cells are at most {LONGEST_CELL:g} times as long "
                f"as wide, and {WIDEST_CELL:g} times as wide as long; these are {aspect_ratio:g} times as long."
            )

    @property
    def cell_size(self) -> tuple[float, float]:
        """Sides of a cell (dx, dy) [m]."""
        return self.extent[0] / self.cells[0], self.extent[1] / self.cells[1]

    @property
    def cell_area(self) -> float:
        """Area of a cell, dx dy [m^2]."""
        return self.cell_size[0] * self.cell_size[1]

    @property
    def length(self) -> float:
        """Extent along the length [m]."""
        return self.extent[1]

    @property
    def x(self) -> Array:
        """Cell centres across the width, shape (nx,) [m], antisymmetric to the last bit."""
        return _centres(self.cells[0], self.cell_size[0])

    @property
    def y(self) -> Array:
        """Cell centres along the length, shape (ny,) [m], antisymmetric to the last bit."""
        return _centres(self.cells[1], self.cell_size[1])


def _centres(count: int, step: float) -> Array:
    """Return the centres of `count` cells of size `step`, antisymmetric to the last bit."""
    return np.asarray((2 * np.arange(count) - (count - 1)) * (step / 2))


class Padding(Protocol):
    """Boundary condition of one axis: which images of the pressure act on a point, and whether the axis is periodic."""

    @property
    def wraps(self) -> bool:
        """True if the convolution along this axis is circular."""

    @property
    def window(self) -> range | None:
        """Periods whose pressure acts on a point, relative to its own (0); None for all of them.

        The image in period m is at the offset ``d + m L``, with d >= 0 the offset in period 0.
        """

    def reach(self, period: float) -> float:
        """Return the distance to each side whose pressure acts on a point in the middle, in the unit of `period`."""


@validated
class ZeroPadding:
    """Padding with zeros, the classical DC-FFT: no images, not periodic (Liu, Wang & Liu 2000)."""

    wraps: ClassVar[bool] = False
    window: ClassVar[range] = range(1)

    def reach(self, period: float) -> float:
        """Return half a period, which is the domain itself."""
        return period / 2


@validated
class DuplicatedPadding:
    """Padding with a copy of the pressure in the padded half of the axis, in place of zeros.

    The pressure within one period to either side then acts on every point. The doubled transform equals a circular one
    with the folded coefficients ``K(d) + K(d - L)``, which is used here. The coefficient ``K(L)``, which wrap-around
    order leaves open, is kept and not set to zero. The window therefore covers half a cell more on one side of a point
    than on the other, which matters with few cells along.
    """

    wraps: ClassVar[bool] = True
    window: ClassVar[range] = range(-1, 1)

    def reach(self, period: float) -> float:
        """Return one period, which is the reach from any point."""
        return period


# More images than these, each of which is summed, are those of ExactPeriodicity to five digits, at no cost.
MAX_IMAGES = 10_000
Images = Annotated[
    int,
    Limits(f"from 0 to {MAX_IMAGES}, since each is summed; all are ExactPeriodicity()", lambda x: 0 <= x <= MAX_IMAGES),
]


class _Counted:
    """Padding with a number of images on each side; the subclass says whether of the domain or of each point."""

    images: int

    @property
    def window(self) -> range:
        """Periods whose pressure acts on a point, `images` on each side."""
        return range(-self.images, self.images + 1)

    def reach(self, period: float) -> float:
        """Return half a period and `images` whole ones more."""
        return (self.images + 0.5) * period


@validated
class Superposition(_Counted):
    """Padding with zeros, and coefficients summed over images on each side.

    The window of images is centred on the domain and not on each point, so that points near the ends of the domain
    see more pressure on one side.

    Parameters
    ----------
    images
        Number of periods on each side, from 0 to 10000; 0 is :class:`ZeroPadding`.
    """

    wraps: ClassVar[bool] = False
    images: Images


@validated
class CircularSuperposition(_Counted):
    """Periodic axis with coefficients summed over images on each side of every point.

    The pressure within ``images + 1/2`` periods to either side acts on every point, so a uniform contact stays uniform,
    with a transform of half the size of :class:`Superposition`. This is how semi-periodic contacts are computed in
    ContactMechanics (with 10 images) and slippy.

    Parameters
    ----------
    images
        Number of periods on each side, from 0 to 10000.
    """

    wraps: ClassVar[bool] = True
    images: Images


@validated
class ExactPeriodicity:
    """Periodic axis with the sum over infinitely many images, in closed form.

    The displacement under infinitely many loads is finite only up to a rigid displacement. Along one axis it is
    relative to a point at the scene's length scale (for a cylinder, the Hertz half-width) from the axis, under the mean
    line load concentrated on the axis; along both axes it is relative to its mean.
    """

    wraps: ClassVar[bool] = True
    window: ClassVar[None] = None

    def reach(self, period: float) -> float:
        """Return infinity."""
        return inf


# The padding across the width and the one along the length.
Paddings = tuple[Padding, Padding]


def is_free(padding: Padding) -> bool:
    """Return whether the surface continues beyond the domain without pressure on it."""
    return not padding.wraps and padding.window is not None and len(padding.window) == 1


def across_and_along(padding: Padding | Paddings) -> Paddings:
    """Return the paddings of both axes, (across, along).

    Parameters
    ----------
    padding
        Padding of the length, with ZeroPadding across, or a tuple of two.

    Raises
    ------
    InvalidInput
        If it is neither.
    """
    both = padding if isinstance(padding, tuple) else (ZeroPadding(), padding)
    if len(both) != 2 or any(isinstance(axis, type) or not hasattr(axis, "window") for axis in both):
        raise InvalidInput(
            f"padding is {padding!r}: give one for the length, such as ExactPeriodicity(), or a "
            "tuple of two, (across, along)."
        )
    return both


def cells_text(cells: tuple[int, ...]) -> str:
    """Return numbers of cells, across and along, such as "128 x 96 cells"."""
    return f"{' x '.join(map(str, cells))} cells"


def on_cells(field: Array, cells: tuple[int, int]) -> Array:
    """Return the means of a field over the cells of another grid of the same extent.

    Parameters
    ----------
    field
        Values (x, y), constant in each cell.
    cells
        Number of cells (across, along) of the other grid.
    """
    for axis, count in enumerate(cells):
        along = axis_first(field, axis)
        present = len(along)
        if present == count:
            continue
        if count % present == 0:
            field = axis_first(np.repeat(along, count // present, axis=0), axis)
            continue
        if present % count == 0:
            merged = present // count
            sums = sum((along[k::merged] for k in range(1, merged)), start=along[::merged])
            field = axis_first(sums / merged, axis)
            continue
        # the integral up to each border of the new cells, which is linear inside a given cell
        sums = np.concatenate([np.zeros((1, along.shape[1])), np.cumsum(along, axis=0)])
        border = np.arange(count + 1) * (present / count)
        full_cells = np.minimum(border.astype(int), present - 1)
        integral = sums[full_cells] + (border - full_cells)[:, None] * along[full_cells]
        field = axis_first(np.diff(integral, axis=0) * (count / present), axis)
    return field


def axis_first(field: Array, axis: int) -> Array:
    """Return a `field` (x, y) with its `axis` first; done twice, it is the field again."""
    return field.T if axis else field


def edge_fraction(touching: NDArray[np.bool_]) -> float:
    """Return the fraction of the `touching` cells (x, y) with a neighbour that does not touch; zero without any.

    An area counted in whole cells may be the same on several grids and still be wrong by these cells.
    """
    inside = touching.copy()
    for axis, step in ((0, 1), (0, -1), (1, 1), (1, -1)):
        inside &= np.roll(touching, step, axis)
    return float(1 - inside.sum() / touching.sum()) if touching.any() else 0.0
