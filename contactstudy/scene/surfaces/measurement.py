"""Heights of points and the sizes they come with, from an array, a DataArray or a file."""

import re
import warnings
from math import nan
from os import PathLike, fspath
from pathlib import Path
from typing import Any

import numpy as np

from contactstudy.domain.checks import InvalidInput, width_and_length
from contactstudy.domain.fields import Array
from contactstudy.domain.imports import import_for

# Points and their sizes (x, y) [m], if they have any.
Measurement = tuple[Array, tuple[float, float] | None]

DIMENSIONS = (("x", "y"), ("width", "length"))
# Files of plain numbers, and the units that they may be in.
ROWS = (".npy", ".csv", ".txt", ".asc", ".xyz")
LENGTHS = {"m": 1.0, "mm": 1e-3, "um": 1e-6, "µm": 1e-6, "nm": 1e-9}
# Points of a text file along each side, of which a table of something else has fewer; words for a missing point.
MIN_POINTS = 8
MISSING = ("", "nan", "na", "n/a", "null", "none", "bad", "inf")
NUMERAL = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
DECIMAL_COMMA = re.compile(r"[-+]?\d+(?:,\d+)?(?:[eE][-+]?\d+)?")
METRES = (None, "", "m", "metre", "metres", "meter", "meters")


def measurement(heights: Any) -> Measurement:
    """Return points of an array, an xarray.DataArray or a topography, nan where one is missing, and their sizes [m].

    Dimensions of a DataArray are put in the order (x, y) or (width, length) where they have these names; sizes come
    from equidistant coordinates. Raises :class:`~contactstudy.InvalidInput` unless the heights are a plane field of
    real numbers in metres.
    """
    if isinstance(heights, str | PathLike):
        raise InvalidInput(
            f"MeasuredSurface.heights is the path {fspath(heights)!r}: give MeasuredSurface.read(path), which says "
            "what it subtracts."
        )
    if hasattr(heights, "physical_sizes") and hasattr(heights, "heights"):
        return _topography("MeasuredSurface.heights", heights)
    if hasattr(heights, "dims") and hasattr(heights, "coords"):
        return _labelled(heights)
    return _plane(heights), None


def read(
    path: str | PathLike[str], extent: tuple[float, float] | None = None, unit: str | None = None
) -> Measurement:
    """Return points and sizes [m] of a file.

    Numbers in rows (npy, csv, txt, asc) and points in columns x, y, height (xyz) are read here, and need a `unit`.
    X3P, OPD, SUR and some thirty more formats are read by SurfaceTopography; `extent` [m] and `unit` are for files
    that lack them. Raises :class:`~contactstudy.InvalidInput` for a file that cannot be read or lacks a unit, and for
    an extent or a unit that is not that of the file.
    """
    extent = agreed_extent(None, extent)
    points, sizes = _points_and_sizes(path, extent, unit)
    return points, agreed_extent(sizes, extent)


def agreed_extent(
    sizes: tuple[float, float] | None, extent: tuple[float, float] | None
) -> tuple[float, float] | None:
    """Return the sizes (width, length) [m] of heights: those that they come with, or else the given `extent`.

    Raises :class:`~contactstudy.InvalidInput` for an extent that is no size, or that differs from the sizes.
    """
    if extent is None:
        return sizes
    remedy = "give two lengths, (width, length) [m]"
    extent = width_and_length("MeasuredSurface.extent", extent, remedy)
    if sizes is not None and not np.allclose(extent, sizes, rtol=1e-6, atol=0):
        raise InvalidInput(
            f"MeasuredSurface.extent is {extent!r}: leave it out, since the heights come with the sizes {sizes!r} m."
        )
    return extent


def _points_and_sizes(
    path: str | PathLike[str], extent: tuple[float, float] | None, unit: str | None
) -> Measurement:
    """Return points and sizes [m] of a file as :func:`read`, the sizes None where it has none."""
    suffix, name = Path(path).suffix.lower(), fspath(path)
    if suffix == ".nc" and (written := _written(path)) is not None:
        _check_unit(name, unit, "m")
        return written
    if suffix in ROWS and (values := _numbers(name, suffix)) is not None:
        if unit not in LENGTHS:
            raise InvalidInput(
                f"MeasuredSurface.unit of {name!r} is {unit!r}: give the unit of its numbers, one of "
                f"{', '.join(LENGTHS)}."
            )
        points, sizes = _gridded(name, values) if suffix == ".xyz" else (values, None)
        if sizes is not None:
            sizes = sizes[0] * LENGTHS[unit], sizes[1] * LENGTHS[unit]
        return _plane(points * LENGTHS[unit]), sizes
    with warnings.catch_warnings():
        # the library warns that MPI is missing, which is not needed
        warnings.simplefilter("ignore", ImportWarning)
        topography = import_for("MeasuredSurface.read", "SurfaceTopography")
    try:
        with topography.open_topography(name) as file:
            channel = file.default_channel
            if channel.dim != 2:
                raise InvalidInput(f"path is {name!r}: give a file of a surface, not of a profile.")
            lacking: dict[str, object] = {}
            if channel.unit is None:
                lacking["unit"] = unit
            else:
                _check_unit(name, unit, channel.unit)
            if channel.physical_sizes is None:
                metre = LENGTHS.get(channel.unit or unit or "", 0.0)
                lacking["physical_sizes"] = (
                    tuple(side / metre for side in extent) if extent and metre else None
                )
            if None in lacking.values():
                raise InvalidInput(
                    f"path is {name!r}, which has no sizes or no unit: give MeasuredSurface.extent [m] and unit, "
                    "such as 'um'."
                )
            return _topography(f"path {name!r}", channel.topography(**lacking))
    except topography.Exceptions.ReadFileError as unreadable:
        raise InvalidInput(
            f"path is {name!r}: give a file in a format that SurfaceTopography reads, or numbers in rows as npy or csv."
        ) from unreadable


def _check_unit(name: str, unit: str | None, own: str) -> None:
    """Raise :class:`~contactstudy.InvalidInput` if a `unit` is given that is not the file's `own`."""
    if unit not in (None, own) and LENGTHS.get(unit or "", nan) != LENGTHS.get(own):
        raise InvalidInput(
            f"MeasuredSurface.unit of {name!r} is {unit!r}: leave it out, since its heights are in {own!r}."
        )


def _numbers(name: str, suffix: str) -> Array | None:
    """Return the numbers of a file in rows, nan where one is missing.

    It is None for an ``.asc`` file that is no plain table: such files have one of many kinds of headers, which
    SurfaceTopography reads. Raises :class:`~contactstudy.InvalidInput` for any other file that is no table of numbers.
    """
    if suffix == ".npy":
        try:
            return np.asarray(np.load(name, allow_pickle=False))
        except (OSError, ValueError) as error:
            raise InvalidInput(f"path is {name!r}: give a file with numbers ({error}).") from None
    try:
        values = _table(name)
        if suffix != ".xyz" and (len(values) < MIN_POINTS or 1 < values.shape[1] < MIN_POINTS):
            raise InvalidInput(
                f"path is {name!r}, of {len(values)} rows of {values.shape[1]} numbers: give a surface of at least "
                f"{MIN_POINTS} x {MIN_POINTS} points, or a profile of one column."
            )
    except InvalidInput:
        if suffix == ".asc":
            return None
        raise
    return values


def _table(name: str) -> Array:
    """Return the rows of numbers of a text file, after at most one line of heading."""
    try:
        lines = Path(name).read_text(encoding="utf-8-sig").splitlines()
    except (OSError, ValueError) as error:
        raise InvalidInput(f"path is {name!r}: give a file with numbers ({error}).") from None
    lines = [line for line in lines if line.strip() and not line.lstrip().startswith(("#", "%"))]
    separator = next(
        (mark for mark in (";", "\t", ",") if any(mark in line for line in lines)), None
    )
    words = lines[-1].split() if lines else []
    if separator == "," and len(words) > 1 and all(map(DECIMAL_COMMA.fullmatch, words)):
        separator = None
    if separator != ",":  # as a spreadsheet writes it where the decimal sign is a comma
        lines = [line.replace(",", ".") for line in lines]
    rows = [[word.strip() for word in line.split(separator)] for line in lines]
    if rows and not any(NUMERAL.fullmatch(word) for word in rows[0]):  # names of columns
        del rows[0]
    if rows and not any(row[-1] for row in rows):  # each line ends with a separator
        rows = [row[:-1] for row in rows]
    uneven = next((number for number, row in enumerate(rows) if len(row) != len(rows[0])), None)
    if not rows or uneven is not None:
        fault = (
            f", whose row {uneven + 1} has {len(rows[uneven])} numbers beside {len(rows[0])}"
            if uneven
            else ""
        )
        raise InvalidInput(
            f"path is {name!r}{fault}: give rows of equally many numbers, separated by commas, semicolons, tabs or "
            "blanks."
        )
    return np.array([[_value(name, word) for word in row] for row in rows])


def _value(name: str, word: str) -> float:
    """Return the number that `word` is, nan where it marks a missing point."""
    if NUMERAL.fullmatch(word):
        return float(word)
    if word.strip("*-").lower() in MISSING:
        return nan
    raise InvalidInput(
        f"path is {name!r}, in which {word[:40]!r} stands for a height: give numbers with a decimal point (a decimal "
        "comma between semicolons, tabs or blanks), after at most one line of heading."
    )


def _gridded(name: str, columns: Array) -> Measurement:
    """Return heights (x, y) and sizes, in the unit of the file, of points in columns x, y, height."""
    remedy = "give columns x, y and height of points on a rectangular grid"
    if columns.shape[1] != 3 or len(columns) < 4 or np.isnan(columns[:, :2]).any():
        raise InvalidInput(f"path is {name!r}, of {columns.shape[1]} columns: {remedy}.")
    indices, sizes = [], []
    for positions in columns[:, :2].T:
        span = float(np.ptp(positions)) or 1.0
        values = np.unique(np.round(positions / span, 6)) * span
        step = span / max(len(values) - 1, 1)
        index = (positions - positions.min()) / step
        if np.abs(index - np.round(index)).max() > 0.01:
            raise InvalidInput(f"path is {name!r}, whose points are not equidistant: {remedy}.")
        indices.append(np.round(index).astype(int))
        sizes.append(step * len(values))
    heights = np.full((indices[0].max() + 1, indices[1].max() + 1), np.nan)
    heights[indices[0], indices[1]] = columns[:, 2]
    if not np.array_equal(heights[indices[0], indices[1]], columns[:, 2], equal_nan=True):
        raise InvalidInput(f"path is {name!r}, which has two heights at one place: {remedy}.")
    return heights, (sizes[0], sizes[1])


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
    remedy = "give an array (x, y) of real numbers, heights in m"
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
    """Return points and sizes of a DataArray, in the order of :data:`DIMENSIONS` and of rising coordinates."""
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
    """Raise :class:`~contactstudy.InvalidInput` unless a DataArray has no unit or is in metres."""
    unit = labelled.attrs.get("units")
    if unit not in METRES:
        raise InvalidInput(f"{field} has the units {unit!r}: convert to m.")
