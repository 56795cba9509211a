"""Heights of points and the sizes they come with, from an array, a DataArray or a file."""

import logging
import re
import warnings
from dataclasses import KW_ONLY
from os import PathLike, fspath
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, NamedTuple

import numpy as np

from contactstudy.domain.checks import InvalidInput
from contactstudy.domain.fields import Array
from contactstudy.domain.imports import import_for
from contactstudy.domain.units import Metres, Number, readable
from contactstudy.domain.validation import FINITE, validated
from contactstudy.scene.surfaces.text_file import Header, TextTable, decoded, length_unit, table

# Points and their sizes (x, y) [m], if they have any.
Measurement = tuple[Array, tuple[float, float] | None]

DIMENSIONS = (("x", "y"), ("width", "length"))
# Units that a message offers; points along each side of a matrix, of which a table of something else has fewer.
UNITS = {"nm": 1e-9, "um": 1e-6, "mm": 1e-3, "m": 1.0}
MIN_POINTS = 8
# Numbers, of either sign, that instruments write for a point that was not measured; any from VOID on is one.
MARKS = (999, 9999, 99999, 999999, 32767, 32768, 65535, 2147483648)
VOID = 1e30
# Text files that the library reads: surface data formats of ISO 25178-71 and BCR, and Wyko's.
OF_LIBRARY = ("aISO", "aBCR", "Wyko ASCII")
# First words of the names of columns.
COLUMNS = {
    "x": ("x", "dx", "lateral", "distance", "position", "length", "weg", "scan"),
    "y": ("y", "dy"),
    "z": ("z", "height", "heights", "raw", "profile", "h", "höhe", "value", "level"),
}
# A column of angles, times or voltages, by its unit or its name.
NO_LENGTH = re.compile(
    r"°|[\[(](?!(?:[xyz]|lateral|unitless)?[\])])[^\])]+[\])]|\b(deg\w*|grad|m?rad|sec\w*|[mu]?s|m?v|angle|winkel|time|zeit|index|frame)\b",
    re.I,
)
SQUARE = "points are taken as square"
METRES = (None, "", "m", "metre", "metres", "meter", "meters")


# Reversed directions of a measured surface, and the reversed axes.
Flip = Literal["none", "across", "along", "both"]
REVERSED: dict[Flip, tuple[int, ...]] = {"none": (), "across": (0,), "along": (1,), "both": (0, 1)}
# Whether sizes and heights of a file are checked for plausibility and against the keys beside it.
Sizes = Literal["checked", "confirmed"]


@validated
class Reading:
    """What is said beside a file of a measured surface, where the file itself leaves it open.

    Parameters
    ----------
    extent
        Size (width, length) [m] of all points, of a file without sizes.
    unit
        Unit of the numbers, of a file without units, such as ``"um"``.
    invalid
        Number in the file that stands for a point that was not measured, such as -9999.
    decimal
        Decimal sign of a text file, ``","`` or ``"."``, where it can be read both ways.
    transpose
        Whether across and along are exchanged.
    flip
        Directions that are reversed.
    sizes
        Whether implausible sizes are refused. ``"confirmed"`` takes them, and keys that contradict the file.
    """

    called: ClassVar[str] = "MeasuredSurface"

    _: KW_ONLY
    extent: tuple[Metres, Metres] | None = None
    unit: str | None = None
    invalid: Annotated[Number, FINITE] | None = None
    decimal: Literal[",", "."] | None = None
    transpose: bool = False
    flip: Flip = "none"
    sizes: Sizes = "checked"

    def check_together(self) -> None:
        """Check that the unit is one of length."""
        if self.unit is not None and length_unit(self.unit) is None:
            raise InvalidInput(
                f"MeasuredSurface.unit is {self.unit!r}: give a unit of length, such as {', '.join(UNITS)}."
            )

    @property
    def metre(self) -> float | None:
        """The given unit [m], if any."""
        return None if self.unit is None else length_unit(self.unit)


class FileContent(NamedTuple):
    """Numbers of a file (x, y), nan where one is missing, their unit [m], the sizes [m], and notes on them.

    `assumed` is a note on sizes that the file leaves open, which a given extent replaces.
    """

    values: Array
    unit: float
    sizes: tuple[float, float] | None
    notes: tuple[str, ...] = ()
    invalid: float | None = None
    is_own: bool = False
    assumed: str = ""


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
    path: str | PathLike[str], reading: Reading
) -> tuple[Array, tuple[float, float] | None, tuple[str, ...]]:
    """Return points (x, y) [m] and sizes [m] of a file, and notes on what was done to them.

    The content decides on the format, not the name. Raises :class:`~contactstudy.InvalidInput` for a file that cannot
    be read, lacks a unit, contradicts `reading`, or has implausible sizes.
    """
    name = fspath(path)
    with Path(path).open("rb") as file:
        head = file.read(65536)
    text = None if head.startswith((b"\x93NUMPY", b"CDF", b"\x89HDF", b"PK")) else decoded(head)
    if head.startswith(b"\x93NUMPY"):
        content = FileContent(_array(name), _unit(name, reading), None)
    elif head.startswith((b"CDF", b"\x89HDF")) and (written := _written(path)) is not None:
        _unit(name, reading, 1.0)
        content = FileContent(written[0], 1.0, written[1], is_own=True)
    elif text is not None and not text.startswith(OF_LIBRARY):
        text = decoded(Path(path).read_bytes()) or ""
        content = _of_text(name, table(name, text, reading.decimal), reading)
    else:
        content = _of_library(name, reading)
    values, notes = _measured(name, content, reading)
    points, sizes = values * content.unit, content.sizes
    if reading.transpose:
        points, sizes = points.T, None if sizes is None else (sizes[1], sizes[0])
    points = np.flip(points, REVERSED[reading.flip])
    notes += ["across and along were exchanged (transpose)"] * reading.transpose
    if reading.flip != "none":
        notes.append(f"reversed (flip {reading.flip})")
    is_open = reading.sizes == "confirmed"
    if reading.extent is not None and sizes is not None and content.assumed:
        agrees = np.isclose(sizes, reading.extent, rtol=0.01, atol=0)
        is_open = is_open or content.assumed != SQUARE or bool(agrees.any())
    if reading.extent is not None and is_open:
        sizes = None
    elif content.assumed:
        notes.append(content.assumed)
    sizes = agreed_extent(sizes, reading.extent)
    if reading.sizes == "checked" and not content.is_own:
        _check_plausible(name, points, sizes, content.unit)
    notes = [*content.notes, *notes, *_steps(points)]
    if content.sizes is None and sizes is not None and 1 not in points.shape:
        steps = sizes[0] / points.shape[0], sizes[1] / points.shape[1]
        turned = sizes[0] / points.shape[1], sizes[1] / points.shape[0]
        if not np.isclose(*steps, rtol=0.05) and np.isclose(*turned, rtol=0.01):
            square = f"{readable(turned[0])} apart both ways with transpose = true"
            notes.append(
                f"points {readable(steps[0])} apart across and {readable(steps[1])} along, but {square}"
            )
    return _plane(points), sizes, tuple(notes)


def agreed_extent(
    sizes: tuple[float, float] | None, extent: tuple[float, float] | None
) -> tuple[float, float] | None:
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
    return f"{readable(sizes[0])} x {readable(sizes[1])} (across x along)"


def _unit(
    name: str, reading: Reading, own: float | None = None, unknown: str | None = None
) -> float:
    """Return the unit [m] of heights: that of the file, which a given one must not contradict, or the given one."""
    given = reading.metre
    if own is None and given is None:
        fault = "is None" if unknown is None else f"is None, and its heights are in {unknown!r}"
        raise InvalidInput(
            f"MeasuredSurface.unit of {name!r} {fault}: give the unit of its numbers, one of {', '.join(UNITS)}."
        )
    if given is None or (own is not None and reading.sizes == "checked"):
        assert own is not None
        if given is not None and not np.isclose(given, own, rtol=1e-9, atol=0):
            raise InvalidInput(
                f"MeasuredSurface.unit of {name!r} is {reading.unit!r}: leave it out, since its heights are in "
                f'{_named(own)}; or give sizes = "confirmed" too, if the file is wrong.'
            )
        return own
    return given


def _named(unit: float) -> str:
    """Return the name of a unit [m]."""
    return next(
        (name for name, size in UNITS.items() if np.isclose(size, unit, atol=0)), readable(unit)
    )


def _array(name: str) -> Array:
    """Return the array of an npy file."""
    try:
        return np.array(_plane(np.load(name, allow_pickle=False)))
    except (OSError, ValueError) as error:
        raise InvalidInput(f"path is {name!r}: give a file with numbers ({error}).") from None


def _of_library(name: str, reading: Reading) -> FileContent:
    """Return the default channel of a file that the library SurfaceTopography reads."""
    logging.getLogger("SurfaceTopography").addHandler(logging.NullHandler())
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        library = import_for("MeasuredSurface.read", "SurfaceTopography")
        try:
            with library.open_topography(name) as file:
                if file.format() == "hgt":  # terrain, for which any file of such a length passes
                    raise ValueError("no known format")
                channel = file.default_channel
                known = {"unit": channel.unit, "physical_sizes": channel.physical_sizes}
                given = {"unit": reading.unit or "m", "physical_sizes": channel.nb_grid_pts}
                lacking = {key: given[key] for key, value in known.items() if value is None}
                surface = channel.topography(**lacking)
                values = np.ma.filled(np.ma.asarray(surface.heights(), dtype=np.float64), np.nan)
                side = length_unit(str(surface.unit))
                sizes = tuple(float(size) * (side or 1.0) for size in surface.physical_sizes)
        except Exception as unreadable:
            why = f"{type(unreadable).__name__}: {' '.join(str(unreadable).split())[:80]}"
            raise InvalidInput(
                f"path is {name!r}, in which SurfaceTopography finds no surface ({why}): give a "
                "file in a format that it reads, complete, or export the heights as x3p, txt or csv."
            ) from unreadable
    if values.ndim != 2:
        raise InvalidInput(
            f"path is {name!r}, a profile: export it as text, in columns x and z, or give a file of a surface."
        )
    if channel.unit is not None and side is None:
        raise InvalidInput(
            f"path is {name!r}, with heights in {channel.unit!r}: give a file of heights."
        )
    unit = _unit(name, reading, None if channel.unit is None else side)
    return FileContent(values, unit, None if "physical_sizes" in lacking else (sizes[0], sizes[1]))


def _of_text(name: str, text: TextTable, reading: Reading) -> FileContent:
    """Return heights and sizes of a text file: a matrix, or points in columns."""
    header = Header.of(text.header, text.values.shape)
    columns = _columns(name, text)
    own = {**header.units, **{axis: unit for axis, (_, unit) in columns.items() if unit}}
    unit = _unit(name, reading, own.get("z"), header.unknown.get("z"))
    content = _matrix(text, header, unit)
    if reading.sizes == "checked":
        if len(header.sizes) == len(header.steps) == 2 and not header.is_bare and not columns:
            header.doubts += [
                f"{axis} {header.sizes[axis]:g} and {count} times {header.steps[axis]:g}"
                for axis, count in zip("yx", content.values.shape, strict=True)
                if abs(header.steps[axis] * count - header.sizes[axis]) > 1.5 * header.steps[axis]
            ]
        _check_header(name, text, header, unit, reading, is_matrix=not columns)
    said = header.counts.get("x", 0) * header.counts.get("y", 0)
    if said not in (0, content.values.size) and not columns and reading.sizes == "checked":
        raise InvalidInput(
            f"path is {name!r}, of {content.values.size} numbers, where its header says {said}: give the whole file, or "
            'sizes = "confirmed" if the header is wrong.'
        )
    if columns:
        for place, own_unit in (columns[axis] for axis in "xy" if axis in columns):
            other = NO_LENGTH.search(text.names[place])
            if other and not own_unit:
                raise InvalidInput(
                    f"path is {name!r}, whose column {text.names[place]!r} is no length: give positions in mm "
                    "or the like."
                )
        places = [
            (text.values[:, columns[axis][0]], own.get(axis, unit))
            for axis in "xy"
            if axis in columns
        ]
        content = _gridded(name, places, text.values[:, columns["z"][0]])
    notes = list(content.notes)
    if header.factor != 1:
        notes.append(f"numbers times the factor {header.factor:g} of the header")
    if header.unused:
        notes.append(
            f"these lines of the header were not used: {', '.join(map(repr, header.unused))}"
        )
    return content._replace(unit=unit * header.factor, invalid=header.invalid, notes=tuple(notes))


def _check_header(
    name: str, text: TextTable, header: Header, unit: float, reading: Reading, *, is_matrix: bool
) -> None:
    """Raise :class:`~contactstudy.InvalidInput` for a header or a table with two readings."""
    remedy = 'give the right one, or extent and sizes = "confirmed"'
    fault = ""
    if is_matrix and text.blocks > 1 and header.counts.get("x", 0) * header.counts.get("y", 0) == 0:
        fault = f"with {text.blocks} blocks of numbers between blank lines"
        remedy = 'give a file of one map, or sizes = "confirmed" if they are one'
    elif is_matrix and header.doubts:
        fault = f"whose header has two sizes for one: {header.doubts[0]} m"
    elif lost := [axis for axis in "xy" if axis in header.unknown]:
        fault = f"whose {lost[0]} is in {header.unknown[lost[0]]!r}, which is no length"
    elif is_matrix and header.is_bare and reading.extent is None and unit < 1e-7:
        fault = f"whose header has sizes without a unit, and heights in {_named(unit)}"
        remedy = "give extent, or the unit of the sizes in the header"
    if fault:
        raise InvalidInput(f"path is {name!r}, {fault}: {remedy}.")


def _columns(name: str, text: TextTable) -> dict[str, tuple[int, float | None]]:
    """Return place and unit [m] of the columns x, y and z of a text file; none for a matrix or a single column."""
    rows, count = text.values.shape
    named: dict[str, tuple[int, float | None]] = {}
    for place, label in enumerate(text.names):
        words = re.split(r"[\s/\[\](),_]+", label.lower())
        kind = next(
            (word for word in words if word in COLUMNS), words[0].strip("-:#").removesuffix("pos")
        )
        for axis, starts in COLUMNS.items():
            if kind in starts and axis not in named:
                named[axis] = place, column_unit(label)
    if {"x", "z"} <= named.keys():
        return named
    units = [column_unit(label) for label in text.names]
    if count in (2, 3) and rows >= MIN_POINTS - 4 * (count == 3):
        return {
            axis: (place, units[place]) for place, axis in enumerate("xz" if count == 2 else "xyz")
        }
    if rows < MIN_POINTS or 1 < count < MIN_POINTS:
        raise InvalidInput(
            f"path is {name!r}, of {rows} rows of {count} numbers: give a surface of at least {MIN_POINTS} x "
            f"{MIN_POINTS} points, columns named x, y and z, columns x and z, or a profile of one column."
        )
    return {}


def column_unit(label: str) -> float | None:
    """Return the last unit of length [m] in the name of a column, if any."""
    words = [word for word in re.split(r"[\s/\[\](),_]+", label) if word]
    if words[-1:] != ["in"]:  # which is no unit between words
        words = [word for word in words if word != "in"]
    return next(filter(None, map(length_unit, reversed(words))), None)


def _matrix(text: TextTable, header: Header, unit: float) -> FileContent:
    """Return a matrix, whose rows run along the contact, with sizes of its header or of places on its margins."""
    values, places = _without_margins(text.values, np.array(text.above))
    pair = header.counts.get("y", 0), header.counts.get("x", 0)
    if pair[0] * pair[1] == values.size and sorted(pair) != sorted(values.shape):
        values = values.reshape(pair)  # lines that are broken, or one number a line
    rows, columns = values.shape
    counts, notes = {"x": columns, "y": rows}, []
    assumed = f"sizes of the header, which have no unit, count in {_named(unit)}" * bool(
        header.is_bare
    )
    found: dict[str, float] = {}
    for axis, count in counts.items():
        bare = unit if axis in header.is_bare else 1.0
        step = abs(np.diff(places[axis]).mean()) if len(places[axis]) else 0.0
        if step and (step != 1 or places[axis][0] not in (0, 1)):
            found[axis] = float(step) * count * header.units.get(axis, unit)
        elif axis in header.steps or axis in header.sizes:
            found[axis] = header.steps.get(axis, 0.0) * count * bare or header.sizes[axis] * bare
        if step and axis not in found:
            notes.append(f"numbers that count the points in {axis} are left out")
    if columns == 1 and found:  # a profile, whose places may be called x
        size = found.get("x", 0.0) * (rows if "x" in header.steps else 1) or found["y"]
        found = {"y": size, "x": size / rows}
    if len(found) == 2 and found["x"] == found["y"] and rows != columns and not header.steps:
        notes.append("the one size of the header counts both ways")
    ratio = (
        [found["x"] / found["y"] * rows / columns] if len(found) == 2 and not header.steps else []
    )
    if ratio and abs(ratio[0] - 1) > 0.05 and abs(ratio[0] * (columns / rows) ** 2 - 1) < 0.01:
        found = {"x": found["y"], "y": found["x"]}  # points are square for x from row to row
    if len(found) == 1:  # a lone width or length may be that of the part
        steps = [
            found[axis] / counts[axis]
            for axis in found
            if axis in header.steps or any(places[axis])
        ]
        found = {axis: step * count for step in steps for axis, count in counts.items()}
        assumed = SQUARE * len(steps)
    sizes = (found["y"], found["x"]) if found else None
    return FileContent(values, unit, sizes, tuple(notes), assumed=assumed * bool(found))


def _without_margins(values: Array, above: Array) -> tuple[Array, dict[str, Array]]:
    """Return a matrix without positions in its first column and first row or above it, and these, by axis."""
    left = top = np.array([])
    if min(values.shape) > 2 and _is_even(values[1:, 0]) and not _is_even(values[1:, 1]):
        left, values = values[:, 0], values[:, 1:]
    count = values.shape[1]
    if 2 < count <= len(above) and _is_even(above[-count:]):
        top = above[-count:]
    elif min(values.shape) > 2 and _is_even(values[0]) and not _is_even(values[1]):
        top, left, values = values[0], left[1:], values[1:]
    falling = [
        axis for axis, places in ((0, left), (1, top)) if len(places) and places[0] > places[-1]
    ]
    return np.flip(values, tuple(falling)), {"x": top, "y": left}


def _is_even(places: Array) -> bool:
    """Return whether numbers rise or fall in equal steps."""
    steps = np.diff(places)
    return len(steps) > 0 and bool(np.ptp(steps) <= 0.01 * abs(steps.mean())) and steps.mean() != 0


def _gridded(name: str, places: list[tuple[Array, float]], z: Array) -> FileContent:
    """Return heights (x, y) and sizes [m] of points with places (positions, unit) near those of a regular grid."""
    remedy = "give points on a rectangular grid, in columns x, y and height, or x and height of a profile"
    keep = np.isfinite(np.sum([positions for positions, _ in places], axis=0))
    indices, sizes, shift = [], [], 0.0
    for positions, unit in places:
        index, step, off = _on_line(positions[keep])
        if off > 0.1:
            raise InvalidInput(
                f"path is {name!r}, whose points are not equidistant: they are up to {off:.2g} of a step beside a "
                f"regular grid, and 0.1 is the most: {remedy}."
            )
        indices.append(index)
        sizes.append(step * (index.max() + 1) * unit)
        shift = max(shift, off * step * unit)
    if len(places) == 1:
        indices.append(0 * indices[0])
        sizes.append(sizes[0] / (indices[0].max() + 1))
    heights = np.full((indices[0].max() + 1, indices[1].max() + 1), np.nan)
    if heights.size > 2 * len(z):
        raise InvalidInput(
            f"path is {name!r}, whose points fill less than half of a grid: {remedy}."
        )
    heights[indices[0], indices[1]] = z[keep]
    if not np.array_equal(heights[indices[0], indices[1]], z[keep], equal_nan=True):
        raise InvalidInput(f"path is {name!r}, which has two heights at one place: {remedy}.")
    notes = (
        (f"points moved by up to {readable(shift)} onto a regular grid",)
        if shift > 1e-3 * min(sizes) / max(heights.shape)
        else ()
    )
    return FileContent(heights, 1.0, (sizes[0], sizes[1]), notes)


def _on_line(positions: Array) -> tuple[Any, float, float]:
    """Return the indices of positions on a regular line, its step, and the largest distance from it in steps."""
    order = np.sort(positions)
    floor = 1e-6 * (order[-1] - order[0] or 1.0)
    gaps = np.diff(order)
    falling = np.append(np.sort(gaps[gaps > floor])[::-1], floor)
    if len(falling) == 1:
        return np.zeros(len(positions), dtype=int), 1.0, 0.0
    # gaps between lines of points are the ones above a limit: the limit, at a jump, that gives the most regular line
    ratios = falling[:-1] / falling[1:]
    jumps = [jump for jump in np.argsort(ratios)[::-1][:8] if ratios[jump] > 1.5]
    lines = [_regular(positions, order, gaps > 1.1 * falling[jump + 1]) for jump in jumps]
    none = np.zeros(len(positions), dtype=int), 1.0, 1.0
    return min(lines, key=lambda line: line[2], default=none)


def _regular(positions: Array, order: Array, is_between: Any) -> tuple[Any, float, float]:
    """Return what :func:`_on_line` does, for lines of points that are divided at some of the gaps in their order."""
    line = np.concatenate([[0], np.cumsum(is_between)])
    centres = np.bincount(line, order) / np.bincount(line)
    between = np.diff(centres)
    number = np.concatenate([[0.0], np.cumsum(np.round(between / np.median(between)))])
    step, start = np.polyfit(number, centres, 1)
    index = np.round((positions - start) / step)
    off = np.abs(positions - start - step * index).max() / step
    return index.astype(int), float(step), float(off)


def _measured(name: str, content: FileContent, reading: Reading) -> tuple[Array, list[str]]:
    """Return the numbers of a file, nan at each point that was not measured, and notes on these."""
    values, notes = np.array(content.values, dtype=np.float64), []
    number = content.invalid if reading.invalid is None else reading.invalid
    if number != content.invalid is not None and reading.sizes == "checked":
        raise InvalidInput(
            f"MeasuredSurface.invalid of {name!r} is {number!r}: leave it out, since the file says {content.invalid!r}."
        )
    with np.errstate(invalid="ignore"):
        values[~(np.abs(values) < VOID)] = np.nan
        if number is not None:
            values[np.isclose(values, number, rtol=1e-6, atol=0)] = np.nan
    while reading.sizes == "checked":
        heights, counts = np.unique(values[np.isfinite(values)], return_counts=True)
        if len(heights) < 4:
            break
        gaps = np.diff(heights)
        spread = heights[-2] - heights[0], heights[-1] - heights[1]
        lone = [
            place
            for place, gap, rest in ((-1, gaps[-1], spread[0]), (0, gaps[0], spread[1]))
            if gap > rest
        ]
        second, most = (int(place) for place in np.argsort(counts)[-2:])
        marks = [place for place in lone if abs(heights[place]) in MARKS]
        if marks:
            values[values == heights[marks[0]]] = np.nan
            notes.append(
                f"{counts[marks[0]]} points of {heights[marks[0]]:g} in the file count as not measured"
            )
            continue
        repeated = [place for place in lone if counts[place] > 1]
        if counts[most] >= max(8, 10 * counts[second]) and 0 < most < len(heights) - 1:
            repeated.append(most)
        if repeated:
            height = heights[repeated[0]] + 0.0
            raise InvalidInput(
                f"path is {name!r}, in which {counts[repeated[0]]} points have the one height {height:g}, as points "
                f'that were not measured: give invalid = {height:g}, or sizes = "confirmed" if they were measured.'
            )
        break
    return values, notes


def _check_plausible(
    name: str, points: Array, sizes: tuple[float, float] | None, unit: float
) -> None:
    """Raise :class:`~contactstudy.InvalidInput` if no rough surface has these sizes, with the unit that is likely."""
    level = _levelled(points)
    if not (fault := _fault(level, sizes)):
        return
    powers = (1e-3, 1e-6, 1e-9, 1e3, 1e6, 1e9)
    trials = [(power, 1.0) for power in powers] + [(1.0, power) for power in powers]
    trials += [(power, power) for power in powers]
    likely = ""
    calm = np.clip(level, *np.nanquantile(level, (0.005, 0.995)))
    if not _fault(calm, sizes):
        steps = "; ".join(_steps(points)) or "a few points far from the others"
        likely, trials = f" ({steps}: spikes, or points that were not measured)", []
    for up, side in trials:
        if not _fault(level * up, sizes and (sizes[0] * side, sizes[1] * side)):
            what = (
                "heights" if side == 1 else "sizes across and along" if up == 1 else "all numbers"
            )
            likely = f" (likely {what} {side:g} times these)"
            if side == 1 or side == up:
                likely = f" (likely {what} in {_named(unit * up)}, not {_named(unit)})"
            break
    raise InvalidInput(
        f'path is {name!r}, with {fault}{likely}: give unit and extent that are right, with sizes = "confirmed" if the '
        "file itself is wrong, or if they are right."
    )


def _levelled(points: Array) -> Array:
    """Return heights less the plane through the measured points."""
    x, y = np.asarray(np.indices(points.shape), dtype=np.float64)
    measured: Any = np.isfinite(points)
    if not measured.any():
        return points
    basis = np.stack([np.ones(len(x[measured])), x[measured], y[measured]], axis=1)
    plane: Array = np.linalg.lstsq(basis, points[measured], rcond=None)[0]
    level = np.asarray(points - plane[0] - plane[1] * x - plane[2] * y)
    return np.asarray(np.where(np.abs(level) < 1e-12 * np.nanmax(np.abs(points)), 0.0, level))


def _fault(level: Array, sizes: tuple[float, float] | None) -> str:
    """Return what is implausible about levelled heights and sizes [m], nothing if they are plausible."""
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


def _steps(points: Array) -> list[str]:
    """Return a note on steps between neighbours that no surface of these slopes has."""
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
