"""Measured surfaces."""

from dataclasses import dataclass, field, replace
from hashlib import blake2b
from os import PathLike
from typing import Any, Self

import numpy as np

from contactstudy import measurement
from contactstudy.arrays import Array
from contactstudy.checks import InvalidInput, divides, keep, pair, positive
from contactstudy.grid import Grid
from contactstudy.missing import Missing, RefuseMissing
from contactstudy.resampling import cell_means
from contactstudy.seam import AsMeasured, Seam, Tapered
from contactstudy.trend import Trend


@dataclass(frozen=True)
class MeasuredSurface:
    """A surface given by its ``heights`` (width, length) [m], positive out of the body: peaks touch first.

    Heights are an array of real numbers, masked or nan where a point is missing, or an xarray.DataArray
    whose coordinates give the sizes. ``extent`` (width, length) [m] is the size of all points, each
    standing for an equal cell; without it, heights stand cell for cell on the grid. ``missing`` says what
    becomes of missing points, ``trend`` what is subtracted from all points, ``seam`` how the length is made
    periodic, in this order; an array is taken as it is, unless told.

    The surface is centred on the grid. A grid's width is at most the surface's, its period a whole
    number of the surface's; its cells have the means of a smooth surface with the heights given, the same
    on every grid. Two surfaces are equal where ``digest``, of all heights, and all else agree. Raises
    :class:`~contactstudy.InvalidInput` for anything that is not so.
    """

    heights: Any = field(repr=False, compare=False)
    extent: tuple[float, float] | None = None
    missing: Missing = field(default_factory=RefuseMissing)
    trend: Trend = Trend.NONE
    seam: Seam = field(default_factory=AsMeasured)
    digest: str = field(init=False)

    def __post_init__(self) -> None:
        points, sizes = measurement.measurement(self.heights)
        if self.extent is not None:
            remedy = "give two lengths, (width, length) [m]"
            width, length = pair("MeasuredSurface.extent", self.extent, remedy)
            extent = (
                positive("MeasuredSurface.extent[0]", width, "give a width above 0 m"),
                positive("MeasuredSurface.extent[1]", length, "give a length above 0 m"),
            )
            if sizes is not None and not np.allclose(extent, sizes, rtol=1e-6, atol=0):
                raise InvalidInput(
                    f"MeasuredSurface.extent is {extent!r}: leave it out, since the coordinates of the "
                    f"heights say {sizes!r} m."
                )
            sizes = extent
        for name, duty, example in (
            ("missing", "fill", "RefuseMissing()"),
            ("trend", "subtracted", "Trend.PLANE"),
            ("seam", "close", "Mirrored()"),
        ):
            value = getattr(self, name)
            if isinstance(value, type) or not hasattr(value, duty):
                raise InvalidInput(
                    f"MeasuredSurface.{name} is {value!r}: give a value such as {example}."
                )
        self.missing.admit(int(np.isnan(points).sum()), points.size)
        digest = blake2b(repr(points.shape).encode() + points.tobytes(), digest_size=16).hexdigest()
        keep(self, heights=points, extent=sizes, digest=digest)

    @classmethod
    def read(
        cls,
        path: str | PathLike[str],
        *,
        missing: Missing | None = None,
        trend: Trend = Trend.PLANE,
        seam: Seam | None = None,
    ) -> Self:
        """The surface in a file: X3P, OPD, SUR and whatever else the library SurfaceTopography reads.

        Less its tilt, and :class:`~contactstudy.Tapered` at the ends, unless told otherwise. Needs the
        extra ``measured``. Raises :class:`~contactstudy.InvalidInput` for a file without sizes or units.
        """
        heights, extent = measurement.read(path)
        return cls(heights, extent, missing or RefuseMissing(), trend, seam or Tapered())

    def turned(self) -> Self:
        """This surface turned by a quarter, so that what ran along the length runs across it."""
        extent = None if self.extent is None else (self.extent[1], self.extent[0])
        return replace(self, heights=np.rot90(self.heights), extent=extent)

    @property
    def curvature(self) -> float:
        """None that is known of."""
        return 0.0

    def gap(self, grid: Grid) -> Array:
        """Depths below the datum [m], shape (width, length), or (width, 1) where all is one profile."""
        depths = -self.seam.close(self.trend.subtracted(self.missing.fill(self.heights)))
        one_profile = bool((depths == depths[:, :1]).all())
        if one_profile:
            depths = depths[:, :1]
        if self.extent is None:
            return self._cell_for_cell(depths, grid)
        width, length = self.extent
        if grid.extent[0] > width * (1 + 1e-9):
            raise InvalidInput(
                f"MeasuredSurface.extent is {self.extent!r}: give a grid no wider than that, which is "
                f"{grid.extent[0]!r} m wide, or a wider surface."
            )
        depths = cell_means(
            depths, 0, extent=width, cells=grid.cells[0], width=grid.extent[0], ends="not-a-knot"
        )
        if one_profile:
            return depths
        period = self.seam.lengths * length
        divides("MeasuredSurface period", period, grid.period)
        return cell_means(
            depths, 1, extent=period, cells=grid.cells[1], width=grid.period, ends="periodic"
        )

    def _cell_for_cell(self, depths: Array, grid: Grid) -> Array:
        if depths.shape not in (grid.cells, (grid.cells[0], 1)):
            raise InvalidInput(
                f"MeasuredSurface.heights has {depths.shape} points in a period: give a grid of as many "
                f"cells, which has {grid.cells}, or MeasuredSurface.extent."
            )
        return depths
