"""Heights of points and the sizes they come with, from an array, a DataArray or a file."""

import warnings
from os import PathLike, fspath
from pathlib import Path
from typing import Any

import numpy as np

from contactstudy.domain.checks import InvalidInput
from contactstudy.domain.fields import Array
from contactstudy.domain.imports import import_for

# Points and their sizes (x, y) [m], if they have any.
Measurement = tuple[Array, tuple[float, float] | None]

DIMENSIONS = (("x", "y"), ("width", "length"))
METRES = (None, "", "m", "metre", "metres", "meter", "meters")


def measurement(heights: Any) -> Measurement:
    """Return points of an array, an xarray.DataArray or a file, nan where one is missing, and their sizes [m].

    Dimensions of a DataArray are put in the order (x, y) or (width, length) where they have these names; sizes come
    from equidistant coordinates. Raises :class:`~contactstudy.InvalidInput` unless the heights are a plane field of
    real numbers in metres.
    """
    if isinstance(heights, str | PathLike):
        points, extent = read(heights)
        return _plane(points), extent
    if hasattr(heights, "physical_sizes") and hasattr(heights, "heights"):
        return _topography("MeasuredSurface.heights", heights)
    if hasattr(heights, "dims") and hasattr(heights, "coords"):
        return _labelled(heights)
    return _plane(heights), None


def read(path: str | PathLike[str]) -> Measurement:
    """Return points and sizes of a file in any format that SurfaceTopography reads: X3P, OPD, SUR and some thirty more.

    Raises :class:`~contactstudy.InvalidInput` for a file in none of them, or without sizes or a unit.
    """
    if Path(path).suffix == ".nc" and (ours := _written(path)) is not None:
        return ours
    with warnings.catch_warnings():
        # that there is no MPI, for which nobody asked
        warnings.simplefilter("ignore", ImportWarning)
        topography = import_for("MeasuredSurface.read", "SurfaceTopography")
    name = fspath(path)
    try:
        with topography.open_topography(name) as file:
            channel = file.default_channel
            if channel.dim != 2:
                raise InvalidInput(f"path is {name!r}: give a file of a surface, not of a profile.")
            if channel.unit is None or channel.physical_sizes is None:
                raise InvalidInput(
                    f"path is {name!r}, which has no sizes or no unit: read it yourself, and give the "
                    "heights and extent in m."
                )
            return _topography(f"path {name!r}", channel.topography())
    except topography.Exceptions.ReadFileError as unreadable:
        raise InvalidInput(
            f"path is {name!r}: give a file in a format that SurfaceTopography reads ({unreadable})."
        ) from unreadable


def _topography(field: str, surface: Any) -> Measurement:
    """Return points and sizes of a ``Topography`` of the library SurfaceTopography."""
    if surface.dim != 2 or surface.unit is None or surface.physical_sizes is None:
        raise InvalidInput(
            f"{field} is a topography of {surface.dim} dimension(s) with the unit {surface.unit!r} and the "
            f"sizes {surface.physical_sizes!r}: give a surface with sizes and a unit."
        )
    surface = surface.to_unit("m")
    points = np.ma.filled(np.ma.asarray(surface.heights(), dtype=np.float64), np.nan)
    width, length = (float(size) for size in surface.physical_sizes)
    return _plane(points), (width, length)


def write(points: Array, extent: tuple[float, float] | None, path: str | PathLike[str]) -> None:
    """Write points [m] as the variable ``heights`` (x, y) of a netCDF file, with coordinates if they have sizes."""
    xr = import_for("MeasuredSurface.write", "xarray")
    coords = {}
    if extent is not None:
        for name, size, count in zip(("x", "y"), extent, points.shape, strict=True):
            centres = (2 * np.arange(count) + 1) * (size / count / 2)
            coords[name] = (name, centres, {"units": "m", "axis": name.upper()})
    attributes = {"units": "m", "long_name": "measured height"}
    xr.DataArray(points, coords, ("x", "y"), "heights", attributes).to_netcdf(path)


def _written(path: str | PathLike[str]) -> Measurement | None:
    """Return the points that :func:`write` wrote; None for a file of another kind."""
    xr = import_for("MeasuredSurface.read of a .nc file", "xarray")
    try:
        with xr.open_dataset(path) as dataset:
            return _labelled(dataset["heights"].load())
    except (OSError, KeyError, ValueError):
        return None


def _plane(heights: Any) -> Array:
    """Return the heights as a read-only array of floats, a copy."""
    remedy = "give an array (width, length) of real numbers, heights in m"
    try:
        values = np.ma.asarray(heights) if np.ma.isMaskedArray(heights) else np.asarray(heights)
    except ValueError:  # rows of different lengths
        raise InvalidInput(f"MeasuredSurface.heights has no one shape: {remedy}.") from None
    if values.dtype.kind not in "iuf" or values.ndim != 2 or values.size == 0:
        raise InvalidInput(
            f"MeasuredSurface.heights has the shape {values.shape} and the type {values.dtype}: {remedy}."
        )
    points = np.ma.filled(values.astype(np.float64), np.nan)
    points = np.array(points, dtype=np.float64, order="C")
    points[~np.isfinite(points)] = np.nan
    points.setflags(write=False)
    return points


def _labelled(heights: Any) -> Measurement:
    if heights.ndim != 2:
        return _plane(heights), None
    for names in DIMENSIONS:
        if set(heights.dims) == set(names):
            heights = heights.transpose(*names)
    _in_metres("MeasuredSurface.heights", heights)
    sized = [name in heights.coords for name in heights.dims]
    if not any(sized):
        return _plane(heights.data), None
    if not all(sized):
        raise InvalidInput(
            f"MeasuredSurface.heights has coordinates for {sum(sized)} of its dimensions "
            f"{heights.dims!r}: give both or none."
        )
    points, sizes = heights.data, []
    for axis, name in enumerate(heights.dims):
        size, step = _size(name, heights.coords[name])
        sizes.append(size)
        if step < 0:
            points = np.flip(points, axis)
    return _plane(points), (sizes[0], sizes[1])


def _size(name: str, coordinate: Any) -> tuple[float, float]:
    """Return the size [m] of as many cells as there are points, and the step between two points."""
    _in_metres(f"MeasuredSurface.heights.{name}", coordinate)
    positions = _plane(np.asarray(coordinate)[:, None])[:, 0]
    step = (positions[-1] - positions[0]) / max(len(positions) - 1, 1)
    off = np.abs(np.diff(positions) - step).max(initial=0.0)
    if not step or not off <= 1e-6 * abs(step):
        raise InvalidInput(
            f"MeasuredSurface.heights.{name} has coordinates that are not equidistant: resample the "
            "heights, or drop the coordinates and give MeasuredSurface.extent."
        )
    return float(abs(step) * len(positions)), float(step)


def _in_metres(field: str, labelled: Any) -> None:
    unit = labelled.attrs.get("units")
    if unit not in METRES:
        raise InvalidInput(f"{field} has the units {unit!r}: convert to m.")
