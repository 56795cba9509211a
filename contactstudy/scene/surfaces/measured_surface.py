"""Measured surfaces: how their heights are prepared, and what they are on a grid.

A surface keeps the heights as measured, and how they are prepared as fields of its own: the modules `measurement` and
`preparation` of this folder read and prepare them.
"""

from dataclasses import field, replace
from functools import lru_cache
from hashlib import blake2b
from math import ceil, inf
from os import PathLike
from pathlib import Path
from typing import Any, ClassVar, Self

import numpy as np

from contactstudy.domain import validation
from contactstudy.domain.grid import Array, Grid
from contactstudy.domain.validation import InvalidInput, readable, set_fields, validated, whole_quotient
from contactstudy.scene.shapes.shape import LengthScales
from contactstudy.scene.surfaces import measurement, preparation
from contactstudy.scene.surfaces.text_surface import Reading


@validated
class MeasuredSurface:
    """Measured surface.

    The surface is centred on the grid; a smaller grid contains its middle part. A grid must not be wider than the
    surface unless `seam_across` repeats it, and a period of the grid above the surface's must be a whole multiple of
    it. One smooth surface is interpolated whose mean over the cell of each point is its height, and a cell of any grid
    has the mean of that surface. Two surfaces are equal if the `digest` of all heights and all other fields agree.

    Parameters
    ----------
    heights
        Heights (x, y) [m], positive out of the body: peaks touch first. An array of real numbers, masked or nan where
        a point is missing, an xarray.DataArray whose coordinates give the sizes, or a ``Topography`` of the library
        SurfaceTopography. A file is read by :meth:`read`.
    extent
        Size (width, length) [m] of all points, each standing for an equal cell; without it, heights are
        those of the grid's cells.
    missing
        Rule for missing (non-measured) points, applied first.
    trend
        Least-squares form subtracted from all points, applied second: "none", the "mean", a "plane", a "quadratic",
        "cubic" or "quartic" polynomial, or a "cylinder".
    seam
        Rule of the periodic extension along the length, applied last.
    seam_across
        Rule of the periodic extension across; as measured (the default), the surface is not repeated across.
    file
        File that the heights were read from, if any.
    is_turned
        Whether the surface was rotated by 90 degrees.
    tile
        Tile that was cut from the surface, if any.
    filter
        Gaussian filter of the heights, applied after the trend; None for none.
    reading
        What was given to :meth:`read` beside the file.
    notes
        What was done to the numbers of the file.

    Raises
    ------
    InvalidInput
        If the heights or sizes cannot be used.
    """

    heights: Any = field(repr=False, compare=False)
    extent: tuple[validation.Metres, validation.Metres] | None = None
    missing: preparation.Missing = field(default_factory=preparation.RefuseMissing)
    trend: preparation.Trend = "none"
    seam: preparation.PeriodicExtension = field(default_factory=preparation.AsMeasured)
    file: str | None = field(default=None, compare=False, repr=False)
    is_turned: bool = field(default=False, compare=False, repr=False)
    tile: preparation.Tile | None = field(default=None, compare=False, repr=False)
    seam_across: preparation.PeriodicExtension = field(default_factory=preparation.AsMeasured)
    filter: preparation.GaussianFilter | None = None
    reading: Reading = field(default_factory=Reading, compare=False, repr=False)
    notes: tuple[str, ...] = field(default=(), compare=False, repr=False)
    digest: str = field(init=False)
    #: Heights at points, which a motion of the surface shifts by interpolation.
    is_sampled: ClassVar[bool] = True

    def check_together(self) -> None:
        """Read the heights, which must have the given extent and no missing points that are refused."""
        points, sizes = measurement.measurement(self.heights)
        sizes = measurement.agreed_extent(sizes, self.extent)
        self.missing.check(int(np.isnan(points).sum()), points.size)
        digest = blake2b(repr(points.shape).encode() + points.tobytes(), digest_size=16).hexdigest()
        set_fields(self, heights=points, extent=sizes, digest=digest)

    @classmethod
    def read(
        cls,
        path: str | PathLike[str],
        *,
        missing: preparation.Missing | None = None,
        trend: preparation.Trend = "plane",
        seam: preparation.PeriodicExtension | None = None,
        seam_across: preparation.PeriodicExtension | None = None,
        filter: preparation.GaussianFilter | None = None,  # noqa: A002 (the field's name)
        **reading: Any,
    ) -> Self:
        """Read a surface from a file; by default its tilt is subtracted and its ends are tapered.

        Parameters
        ----------
        path
            Matrix of numbers, points in columns x, y, height, or a profile in columns x, height, as text of any name,
            encoding and separator, with or without the header of an instrument; npy; netCDF; X3P, OPD, SUR and
            whatever else the library SurfaceTopography reads (extra ``measured``). x of named columns and of X3P and
            the like runs across the contact. A matrix is one of heights (x, y), with or without a header: a row runs
            along the contact, and the rows follow one another across it.
        missing, trend, seam, seam_across, filter
            As for the class; the defaults are to refuse missing points, ``"plane"``, ``Tapered()``,
            ``AsMeasured()`` and no filter.
        reading
            What the file leaves open: ``extent``, ``unit``, ``invalid``, ``decimal``, ``transpose``, ``flip`` and
            ``sizes``, as for :class:`~contactstudy.scene.surfaces.text_surface.Reading`. A matrix without an extent, and
            a netCDF file that lacks coordinates, are heights of the grid's cells.

        Raises
        ------
        InvalidInput
            If the file cannot be read, has no units, others than those given, or implausible sizes.
        """
        said = Reading(**reading)
        points, size, notes = measurement.read(path, said)
        return cls(
            points, size, missing or preparation.RefuseMissing(), trend, seam or preparation.Tapered(),
            str(Path(path).absolute()), filter=filter, seam_across=seam_across or preparation.AsMeasured(),
            reading=said, notes=notes,
        )  # fmt: skip

    @property
    def description(self) -> str:
        """Sentence on the points, their size, and how they were prepared."""
        across, along = self.heights.shape
        size = "cell for cell on the grid"
        if self.extent is not None:
            size = f"over {readable(self.extent[0])} x {readable(self.extent[1])}"
        parts = [f"{across} x {along} points (across x along) {size}", *self.notes]
        if missing := int(np.isnan(self.heights).sum()):
            parts.append(f"missing points: {missing} ({missing / self.heights.size:.2%}) {self.missing.description}")
        parts.append(preparation.trend_text(self.trend, self.missing.fill(self.heights), self.extent))
        if self.filter is not None:
            parts.append(self.filter.description)
        parts.append(f"ends along {self.seam.description}, across {self.seam_across.description}")
        return "; ".join(parts)

    @property
    def prepared(self) -> Array:
        """Heights (x, y) [m] without missing points, less their trend, and filtered."""
        return _completed(self)

    def write(self, path: str | PathLike[str]) -> None:
        """Write the heights to a netCDF file that :meth:`read` reads."""
        measurement.write(self.heights, self.extent, path)

    def cut(self, tile: preparation.Tile) -> Self:
        """Return a tile of this surface: fewer points, from the same file."""
        points = tile.of(self.heights)
        extent = self.extent
        if extent is not None:
            sides = [side * n / m for side, n, m in zip(extent, points.shape, self.heights.shape, strict=True)]
            extent = sides[0], sides[1]
        # a scene file names the file of the heights, a tile and a turn, but no tile of a tile or of a turned surface
        file = None if self.tile or self.is_turned else self.file
        return replace(self, heights=points, extent=extent, file=file, tile=tile)

    def turned(self) -> Self:
        """Return this surface rotated by 90 degrees, from x to y: its length then runs across the contact."""
        extent = None if self.extent is None else (self.extent[1], self.extent[0])
        turned = not self.is_turned  # two quarters are a half turn, for which a scene file has no word
        file = self.file if turned else None
        return replace(self, heights=np.rot90(self.heights), extent=extent, file=file, is_turned=turned)

    def with_extent_of(self, grid: Grid) -> Self:
        """Return this surface with an extent, by the cells of `grid` if it had none, so that other grids can hold it."""
        if self.extent is not None:
            return self
        width, length = grid.extent
        return replace(self, extent=(width / self.seam_across.lengths, length / self.seam.lengths))

    @property
    def length_scales(self) -> LengthScales:
        """Length scales, from the spacing of the points and the highest of them."""
        heights = _completed(self)
        extent = self.extent or heights.shape
        steps = extent[0] / self.heights.shape[0], extent[1] / self.heights.shape[1]
        with np.errstate(over="ignore", invalid="ignore"):  # the solve reports heights that overflow
            height = float(heights.max() - heights.mean())
        if self.extent is None:  # cell for cell: sizes are the grid's
            return LengthScales(height=height)
        varies_along = (heights != heights[:, :1]).any()
        return LengthScales(
            shortest_wavelengths=(2 * steps[0], 2 * steps[1] if varies_along else inf),
            period=self.seam.lengths * extent[1] if varies_along else 0.0,  # zero: any
            height=height,
            known_width=self.seam_across.lengths * extent[0],
            spacing=steps,
        )

    def gap(self, grid: Grid) -> Array:
        """Return depths below height zero [m], of shape (nx, ny), or (nx, 1) if all is one profile."""
        heights = _completed(self)
        is_profile = bool((heights == heights[:, :1]).all())
        if is_profile:
            heights = heights[:, :1]
        if self.extent is None:
            points = self.heights.shape[0] * self.seam_across.lengths, self.heights.shape[1] * self.seam.lengths
            if points != grid.cells and not (is_profile and points[0] == grid.cells[0]):
                raise InvalidInput(
                    f"MeasuredSurface.extent is None, so that its {points[0]} x {points[1]} points must be the cells of "
                    f"the grid, now {grid.cells[0]} x {grid.cells[1]}: give extent, the width and length of all points."
                )
            return self.with_extent_of(grid).gap(grid)
        if not is_profile:
            heights = self._periodic(heights, 1, self.seam, grid)
        if not isinstance(self.seam_across, preparation.AsMeasured):
            return -self._periodic(heights, 0, self.seam_across, grid)
        width = self.extent[0]
        if grid.extent[0] > width * (1 + 1e-9):
            raise InvalidInput(
                f"The grid is {readable(grid.extent[0])} wide, and MeasuredSurface.extent {readable(width)}: give a "
                "narrower grid, or a wider surface."
            )
        return -preparation.cell_means(
            heights, 0, extent=width, cells=grid.cells[0], width=grid.extent[0], ends="not-a-knot"
        )

    def _periodic(self, heights: Array, axis: int, seam: preparation.PeriodicExtension, grid: Grid) -> Array:
        """Return heights (x, y) as means over the cells of a grid along an `axis`, along which the `seam` repeats them.

        A period holds ``seam.lengths`` lengths of the surface, two where it is mirrored. If it does not fit into the
        grid, the middle part of the surface is repeated.
        """
        assert self.extent is not None
        count, length = heights.shape[axis], self.extent[axis]
        piece = grid.extent[axis] / seam.lengths
        if piece < length * (1 - 1e-9):
            # a spacing no larger than measured, independent of the grid's cells
            points = ceil(count * piece / length - 1e-9)
            heights = preparation.cell_means(heights, axis, extent=length, cells=points, width=piece, ends="not-a-knot")
            length = piece
        period = seam.lengths * length
        whole_quotient("The repeat length of a MeasuredSurface", period, grid.extent[axis])
        closed = seam.periodic(heights) if axis else seam.periodic(heights.T).T
        cells, width = grid.cells[axis], grid.extent[axis]
        return preparation.cell_means(closed, axis, extent=period, cells=cells, width=width, ends="periodic")


@lru_cache(maxsize=2)
def _completed(surface: MeasuredSurface) -> Array:
    """Return heights (x, y) [m] without missing points, less their trend, filtered; read-only.

    Those of the last two surfaces, one on either body, are kept, since every grid of a solve asks for them.
    """
    heights = surface.missing.fill(surface.heights)
    heights = preparation.without_trend(surface.trend, heights, surface.extent)
    if surface.filter is not None:
        heights = surface.filter.filtered(heights, surface.extent)
    heights = heights.view()
    heights.flags.writeable = False
    return heights
