"""Heights of points and the sizes they come with, from an array, a DataArray or a file, and if they are plausible.

Heights (x, y) lie across and along the contact and count out of the body. In the words of this file a surface has
points, each standing for an equal cell, and `sizes`, the width and length of all cells. What is said beside a file is
its :class:`Reading`; a text file is read by the modules `text_file` and `text_surface`, other formats of instruments by
the library SurfaceTopography.
"""

import warnings
from contextlib import redirect_stderr
from io import StringIO
from os import PathLike, fspath
from pathlib import Path
from typing import Any

import numpy as np

from contactstudy.domain.grid import Array
from contactstudy.domain.imports import import_for
from contactstudy.domain.validation import InvalidInput, readable, shortened
from contactstudy.scene.surfaces import text_surface
from contactstudy.scene.surfaces.preparation import polynomial
from contactstudy.scene.surfaces.text_file import decoded, length_unit, table
from contactstudy.scene.surfaces.text_surface import FileContent, Reading

# Numbers, of either sign, that instruments write for a point that was not measured; any from VOID on is one, such as the
# 1.70141e38 of Surfer and the largest float: it is far above a height in any unit.
MARKS = (999, 9999, 99999, 999999, 32767, 32768, 65535, 2147483648)
VOID = 1e30
# With fewer different heights, as of a step or of a plane, no height is unusual.
MIN_HEIGHTS = 4
# A height between others that so many points share, and so many times more than the next frequent one, is that of points
# that were not measured: rounded heights of a rough surface are shared by many, but by similar numbers of points.
# Gaussian ones pass with a last digit of up to 2.8 times their rms (2.1 with half of SHARED_MORE, 3.4 with twice).
MIN_SHARED, SHARED_MORE = 8, 10


def measured_points(name: str, content: FileContent, reading: Reading) -> tuple[Array, list[str]]:
    """Return the numbers of a file, nan at each point that was not measured, and notes on these.

    Parameters
    ----------
    name
        Path of the file, for messages.
    content
        Content of the file.
    reading
        What is said beside the file.

    Raises
    ------
    InvalidInput
        If the file says another number for such points than `reading`, or has one height at many points that may have
        been measured or not.
    """
    values = np.array(content.values, dtype=np.float64)
    notes: list[str] = []
    number = content.invalid if reading.invalid is None else reading.invalid
    if number != content.invalid is not None and reading.sizes == "checked":
        raise InvalidInput(
            f"MeasuredSurface.invalid of {name!r} is {number!r}: leave it out, since the file says {content.invalid!r}."
        )
    with np.errstate(invalid="ignore"):
        values[~(np.abs(values) < VOID)] = np.nan
        if number is not None:
            values[np.isclose(values, number, rtol=1e-6, atol=0)] = np.nan
    if reading.sizes == "confirmed":
        return values, notes
    while True:
        heights, counts = np.unique(values[np.isfinite(values)], return_counts=True)
        if len(heights) < MIN_HEIGHTS:
            return values, notes
        # a lowest or highest one is alone if it is further from the next than all others lie apart
        gaps, spread = np.diff(heights), (heights[-1] - heights[1], heights[-2] - heights[0])
        lone = [place for place in (-1, 0) if gaps[place] > spread[place]]
        marks = [place for place in lone if abs(heights[place]) in MARKS]
        if not marks:
            break
        values[values == heights[marks[0]]] = np.nan
        notes.append(f"not measured, as {heights[marks[0]]:g} in the file says: {counts[marks[0]]} of the points")
    second, most = (int(place) for place in np.argsort(counts)[-2:])
    is_frequent = counts[most] >= max(MIN_SHARED, SHARED_MORE * counts[second]) and 0 < most < len(heights) - 1
    for place in [place for place in lone if counts[place] > 1] + [most] * int(is_frequent):
        height = heights[place] + 0.0  # without the sign of -0.0
        raise InvalidInput(
            f"path is {name!r}, in which {counts[place]} points have the one height {height:g}, as points that were "
            f'not measured: give invalid = {height:g}, or sizes = "confirmed" if they were measured.'
        )
    return values, notes


def check_plausible(name: str, points: Array, sizes: tuple[float, float] | None) -> None:
    """Raise :class:`~contactstudy.InvalidInput` if no rough surface has these heights (x, y) and sizes [m]."""
    level = _levelled(points)
    if not (fault := _fault(level, sizes)):
        return
    spikes = ""
    # half a per cent at each end is far more than there are spikes, and far less than a real surface's heights
    if not _fault(np.clip(level, *np.nanquantile(level, (0.005, 0.995))), sizes):
        steps = "; ".join(steps_between(points)) or "a few points far from the others"
        spikes = f" ({steps}: spikes, or points that were not measured)"
    raise InvalidInput(
        f'path is {name!r}, with {fault}{spikes}: give unit and extent that are right, with sizes = "confirmed" if the '
        "file itself is wrong, or if they are right."
    )


def _levelled(points: Array) -> Array:
    """Return heights less the plane through the measured points; what is left of a plane by rounding is zero."""
    if not np.isfinite(points).any():
        return points
    level = points - polynomial(points, 1)[0]
    return np.asarray(np.where(np.abs(level) < 1e-12 * np.nanmax(np.abs(points)), 0.0, level))


def _fault(level: Array, sizes: tuple[float, float] | None) -> str:
    """Return what is implausible about levelled heights (x, y) and sizes [m], an empty text if they are plausible.

    Heights or points closer than atoms, 0.01 and 0.1 nm here, are no measurement. Surfaces of machine elements are
    measured at points less than 1 mm apart over less than 1 m; their heights are far below a tenth of the width, or
    1 cm, and their rms slope is below 1, which is 45 degrees.
    """
    height = float(np.nanmax(level) - np.nanmin(level)) if np.isfinite(level).any() else 0.0
    if 0 < height < 1e-11:
        return f"heights of {height:.2g} m in all, less than an atom"
    if sizes is None:
        return f"heights of {readable(height)} in all" if height > 1e-2 else ""
    steps = [size / count for size, count in zip(sizes, level.shape, strict=True)]
    if max(steps) > 1e-3 or max(sizes) > 1:
        return f"points {readable(max(steps))} apart over {readable(max(sizes))}"
    if min(steps) < 1e-10:
        return f"points {readable(min(steps))} apart, closer than atoms"
    if height > 0.1 * max(sizes):
        return f"heights of {readable(height)} over {readable(max(sizes))}"
    slopes = [np.diff(level, axis=axis) / steps[axis] for axis in (0, 1) if level.shape[axis] > 1]
    slope = sum(float(np.nanmean(each**2)) for each in slopes if np.isfinite(each).any()) ** 0.5
    return f"an rms slope of {slope:.3g}" if slope > 1 else ""


def steps_between(points: Array) -> list[str]:
    """Return a note on steps between neighbouring points of `points` (x, y) that are far above the usual ones, if any.

    Far above is 50 times the median: of Gaussian heights no step is above 10 times.
    """
    steps = [np.abs(np.diff(points, axis=axis)).ravel() for axis in (0, 1)]
    steps = [step[np.isfinite(step)] for step in steps]
    typical = [float(np.median(step)) if len(step) else 0.0 for step in steps]
    high = [step[step > 50 * usual] for step, usual in zip(steps, typical, strict=True) if usual]
    if not sum(map(len, high)):
        return []
    return [
        f"{sum(map(len, high))} steps between neighbours of up to {readable(float(np.concatenate(high).max()))}, where "
        f"{readable(max(typical))} is typical"
    ]


# Heights (x, y) [m], nan where a point is missing, and the width and length [m] of all points, None if not known.
Measurement = tuple[Array, tuple[float, float] | None]

# Names of the dimensions (across, along) of a DataArray.
DIMENSIONS = (("x", "y"), ("width", "length"))
# Beginnings of text files that the library reads: surface data formats of ISO 25178-71 and BCR, and Wyko's.
OF_LIBRARY = ("aISO", "aBCR", "Wyko ASCII")
# First bytes of files in numpy's format, netCDF, HDF5 and of zipped files, which X3P are.
BINARY = (b"\x93NUMPY", b"CDF", b"\x89HDF", b"PK")
# Units of a DataArray that is in metres, or says nothing.
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


def read(path: str | PathLike[str], reading: Reading) -> tuple[Array, tuple[float, float] | None, tuple[str, ...]]:
    """Return points (x, y) [m] and sizes [m] of a file, and notes on what was done to them.

    The content decides on the format, not the name. Raises :class:`~contactstudy.InvalidInput` for a file that cannot
    be read, lacks a unit, contradicts `reading`, or has implausible sizes.
    """
    name = fspath(path)
    data = Path(path).read_bytes()
    text = None if data.startswith(BINARY) else decoded(data)
    if data.startswith(b"\x93NUMPY"):
        content = FileContent(_array(name), text_surface.unit_of_heights(name, reading), None)
    elif data.startswith((b"CDF", b"\x89HDF")) and (written := _written(path)) is not None:
        text_surface.unit_of_heights(name, reading, 1.0)  # refuses a unit beside the file other than its metres
        content = FileContent(written[0], 1.0, written[1], is_own=True)
    elif text is not None and not text.startswith(OF_LIBRARY):
        content = text_surface.surface_of_text(name, table(name, text, reading.decimal), reading)
    else:
        content = _of_library(name, reading)
    values, notes = measured_points(name, content, reading)
    points, sizes = values * content.unit, content.sizes
    if reading.transpose:
        points, sizes = points.T, None if sizes is None else (sizes[1], sizes[0])
    points = np.flip(points, text_surface.REVERSED[reading.flip])
    notes += ["across and along were exchanged (transpose)"] * reading.transpose
    if reading.flip != "none":
        notes.append(f"reversed (flip {reading.flip})")
    if reading.extent is not None and reading.sizes == "confirmed":
        sizes = None
    sizes = agreed_extent(sizes, reading.extent)
    if reading.sizes == "checked" and not content.is_own:
        check_plausible(name, points, sizes)
    notes = [*content.notes, *notes, *steps_between(points)]
    return _plane(points), sizes, tuple(notes)


def agreed_extent(sizes: tuple[float, float] | None, extent: tuple[float, float] | None) -> tuple[float, float] | None:
    """Return the sizes (width, length) [m] of heights: those that they come with, or else the given `extent`.

    Raises :class:`~contactstudy.InvalidInput` for an extent that differs from the sizes.
    """
    if extent is None:
        return sizes
    if sizes is not None and not np.allclose(extent, sizes, rtol=1e-6, atol=0):
        raise InvalidInput(
            f"MeasuredSurface.extent is {_sides(extent)}: leave it out, since the heights come with {_sides(sizes)}."
        )
    return extent


def _sides(sizes: tuple[float, float]) -> str:
    """Return sizes as a text."""
    return f"{readable(sizes[0])} x {readable(sizes[1])} (across x along)"


def _array(name: str) -> Array:
    """Return the array of an npy file."""
    try:
        return np.array(_plane(np.load(name, allow_pickle=False)))
    except (OSError, ValueError) as error:
        raise InvalidInput(f"path is {name!r}: give a file with numbers ({error}).") from None


def _of_library(name: str, reading: Reading) -> FileContent:
    """Return the default channel of a file that the library SurfaceTopography reads.

    A unit that the file lacks is that of `reading`, and without sizes there are none. Raises InvalidInput for a file
    that the library does not read, a profile, and numbers that are no heights.
    """
    with warnings.catch_warnings(), redirect_stderr(StringIO()):  # it logs the formats that it tries
        warnings.simplefilter("ignore")
        library = import_for("MeasuredSurface.read", "SurfaceTopography")
        try:
            with library.open_topography(name) as file:
                if file.format() == "hgt":  # terrain, for which any file of such a length passes
                    raise ValueError("no known format")
                channel = file.default_channel
                # the library asks for what a file lacks
                lacking = {} if channel.unit is not None else {"unit": reading.unit or "m"}
                lacking |= {} if channel.physical_sizes is not None else {"physical_sizes": channel.nb_grid_pts}
                surface = channel.topography(**lacking)
                values = np.ma.filled(np.ma.asarray(surface.heights(), dtype=np.float64), np.nan)
                own = length_unit(str(surface.unit))
                sizes = tuple(float(size) * (own or 1.0) for size in surface.physical_sizes)
        except Exception as unreadable:
            kind = type(unreadable).__name__
            why = f" ({kind}: {shortened(str(unreadable))})" * (kind != "CannotDetectFileFormat")
            raise InvalidInput(
                f"path is {name!r}, in which SurfaceTopography finds no surface{why}: give a "
                "file in a format that it reads, complete, or export the heights as x3p, or as txt or csv in UTF-8."
            ) from unreadable
    if values.ndim != 2 or len(sizes) != 2:
        raise InvalidInput(
            f"path is {name!r}, a profile: export it as text, in columns x and z, or give a file of a surface."
        )
    if channel.unit is not None and own is None:
        raise InvalidInput(f"path is {name!r}, with heights in {channel.unit!r}: give a file of heights.")
    unit = text_surface.unit_of_heights(name, reading, None if channel.unit is None else own)
    return FileContent(values, unit, None if "physical_sizes" in lacking else (sizes[0], sizes[1]))


def _topography(field: str, surface: Any) -> Measurement:
    """Return points and sizes of a ``Topography`` of the library SurfaceTopography, which messages call `field`."""
    if surface.dim != 2 or surface.unit is None or surface.physical_sizes is None:
        raise InvalidInput(
            f"{field} is a topography of {surface.dim} dimension(s) with the unit {surface.unit!r} and the "
            f"sizes {surface.physical_sizes!r}: give a surface with sizes and a unit."
        )
    surface = surface.to_unit("m")
    width, length = (float(size) for size in surface.physical_sizes)
    return _plane(surface.heights()), (width, length)


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
    """Return the points of a netCDF file that :func:`write` wrote; None for a file of another kind."""
    xr = import_for("MeasuredSurface.read of a .nc file", "xarray")
    try:
        with xr.open_dataset(path) as dataset:
            return _labelled(dataset["heights"].load())
    except (OSError, KeyError, ValueError):
        return None


def _plane(heights: Any) -> Array:
    """Return heights (x, y) as a read-only array of floats, a copy, nan where they are masked or not finite.

    Raises InvalidInput for what is no plane field of real numbers.
    """
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
    """Return the size [m] of as many cells as a coordinate has points, and the step between two, negative if it falls.

    Raises InvalidInput, which names the dimension `name`, unless the points are equidistant.
    """
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
