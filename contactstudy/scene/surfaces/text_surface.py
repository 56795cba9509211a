"""Heights and sizes of a surface in a text file, a matrix or points in columns, and what is said beside the file.

Rows of a matrix run along the contact (y) and follow one another across it (x), although headers call the direction of a
row x: the header's "x" is the second axis of the heights (x, y) here, its "y" the first.
"""

import re
from dataclasses import KW_ONLY
from typing import Annotated, ClassVar, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from contactstudy.domain.grid import Array
from contactstudy.domain.validation import FINITE, InvalidInput, Metres, Number, readable, validated
from contactstudy.scene.surfaces.text_file import Header, TextTable, length_unit

# Units [m] that messages name.
UNITS = {"nm": 1e-9, "um": 1e-6, "mm": 1e-3, "m": 1.0}
# What a message offers where a file may be right all the same.
CONFIRMED = 'sizes = "confirmed"'
# Directions in which a measured surface is reversed, and the axes of its heights (x, y) that are.
Flip = Literal["none", "across", "along", "both"]
REVERSED: dict[Flip, tuple[int, ...]] = {"none": (), "across": (0,), "along": (1,), "both": (0, 1)}
# Whether sizes and heights of a file are checked for plausibility and against the keys beside it.
Sizes = Literal["checked", "confirmed"]


@validated
class Reading:
    """Values that are given beside a file of a measured surface, for what the file leaves open.

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

    called: ClassVar[str] = "MeasuredSurface"  # in messages, since the fields are keywords of MeasuredSurface.read

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


class FileContent(NamedTuple):
    """Numbers of a file and what it says of them.

    Attributes
    ----------
    values
        Numbers (x, y), nan where one is missing.
    unit
        Unit of the numbers [m].
    sizes
        Width and length (x, y) [m] of all points, each standing for an equal cell; None if the file does not say.
    notes
        Sentences on what was done to the numbers.
    invalid
        Number that stands for a point that was not measured, if the file names one.
    is_own
        Whether this program wrote the file, so that its sizes need no check.
    """

    values: Array
    unit: float
    sizes: tuple[float, float] | None
    notes: tuple[str, ...] = ()
    invalid: float | None = None
    is_own: bool = False


def unit_of_heights(name: str, reading: Reading, own: float | None = None, unknown: str | None = None) -> float:
    """Return the unit [m] of the heights of a file; of two, that beside the file.

    Parameters
    ----------
    name
        Path of the file.
    reading
        What is said beside the file, whose unit must not contradict that of the file unless it is confirmed.
    own
        Unit that the file states [m], if any.
    unknown
        What the file states as the unit of its heights, if that is no length.

    Raises
    ------
    InvalidInput
        If there is no unit, or two.
    """
    given = None if reading.unit is None else length_unit(reading.unit)
    if own is None and given is None:
        fault = "is None" if unknown is None else f"is None, and its heights are in {unknown!r}"
        raise InvalidInput(
            f"MeasuredSurface.unit of {name!r} {fault}: give the unit of its numbers, one of {', '.join(UNITS)}."
        )
    if own is not None and given not in (None, own) and reading.sizes == "checked":
        stated = next((unit for unit, size in UNITS.items() if size == own), readable(own))
        raise InvalidInput(
            f"MeasuredSurface.unit of {name!r} is {reading.unit!r}: leave it out, since its heights are in {stated}; or "
            f"give {CONFIRMED} too, if the file is wrong."
        )
    return given or own or 1.0  # one of the first two is known


# Fewest points along each side of a matrix and of a profile, and fewest rows of columns x, y and height: a smaller table
# is taken for something else.
MIN_POINTS, MIN_COLUMN_POINTS = 8, 4
# First words of the names of columns, by axis.
COLUMNS = {
    "x": ("x", "dx", "lateral", "distance", "position", "length", "weg", "scan"),
    "y": ("y", "dy"),
    "z": ("z", "height", "heights", "raw", "profile", "h", "höhe", "value", "level"),
}
# Name of a column of angles, times or voltages: a word of such a quantity, or in brackets anything but an axis,
# "lateral" and "unitless". It is asked only of names without a unit of length.
NO_LENGTH = re.compile(
    r"°|[\[(](?!(?:[xyz]|lateral|unitless)?[\])])[^\])]+[\])]|"
    r"\b(deg\w*|grad|m?rad|sec\w*|[mu]?s|m?v|angle|winkel|time|zeit|index|frame)\b",
    re.I,
)
# Largest distance of a point from a regular grid, in steps, with which it is put onto the grid. Positions written with
# few digits, or measured by a stage, lie within it; those of a scan of changing speed do not.
MAX_SHIFT = 0.1


def surface_of_text(name: str, text: TextTable, reading: Reading) -> FileContent:
    """Return heights and sizes of a text file: a matrix, or points in columns.

    Raises :class:`~contactstudy.InvalidInput`, which says what is missing or contradictory, for a file that has two
    readings.
    """
    header = Header.of(text.header, text.values.shape)
    columns = _columns(name, text)
    own = {**header.units, **{axis: unit for axis, (_, unit) in columns.items() if unit}}
    unit = unit_of_heights(name, reading, own.get("z"), header.unknown.get("z"))
    lost = [axis for axis in "xy" if axis in header.unknown]
    if lost and reading.sizes == "checked":
        raise InvalidInput(
            f"path is {name!r}, whose {lost[0]} is in {header.unknown[lost[0]]!r}, which is no length: give the right "
            f"one, or extent and {CONFIRMED}."
        )
    if columns:
        for place, own_unit in (columns[axis] for axis in "xy" if axis in columns):
            if not own_unit and NO_LENGTH.search(text.names[place]):
                raise InvalidInput(
                    f"path is {name!r}, whose column {text.names[place]!r} is no length: give positions in mm."
                )
        places = [(text.values[:, columns[axis][0]], own.get(axis, unit)) for axis in "xy" if axis in columns]
        values, sizes, notes = _gridded(name, places, text.values[:, columns["z"][0]])
    else:
        values, sizes, notes = _matrix(name, text, header, unit, reading)
    if header.factor != 1:
        notes.append(f"numbers times the factor {header.factor:g} of the header")
    if header.unused:
        notes.append(f"these lines of the header were not used: {', '.join(map(repr, header.unused))}")
    return FileContent(values, unit * header.factor, sizes, tuple(notes), header.invalid)


def _columns(name: str, text: TextTable) -> dict[str, tuple[int, float | None]]:
    """Return number and unit [m], None if it has none, of each of the columns "x", "y" and "z" of a text file.

    Of a matrix and of a single column there are none. Raises InvalidInput for a table too small for a surface.
    """
    rows, count = text.values.shape
    named: dict[str, tuple[int, float | None]] = {}
    for place, label in enumerate(text.names):
        words = re.split(r"[\s/\[\](),_]+", label.lower())
        # a word of the axes anywhere counts before the first word, of which "xpos" is x
        kind = next((word for word in words if word in COLUMNS), words[0].strip("-:#").removesuffix("pos"))
        for axis, starts in COLUMNS.items():
            if kind in starts and axis not in named:
                named[axis] = place, column_unit(label)
    if {"x", "z"} <= named.keys():
        return named
    if count in (2, 3) and rows >= (MIN_POINTS if count == 2 else MIN_COLUMN_POINTS):
        return {
            axis: (place, column_unit(text.names[place])) for place, axis in enumerate("xz" if count == 2 else "xyz")
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
    if words[-1:] != ["in"]:  # "in" is inches at the end alone
        words = [word for word in words if word != "in"]
    return next(filter(None, map(length_unit, reversed(words))), None)


# Heights (x, y) in the unit of the file, their sizes (x, y) [m], None if they are not known, and notes on them.
Heights = tuple[Array, tuple[float, float] | None, list[str]]


def _matrix(name: str, text: TextTable, header: Header, unit: float, reading: Reading) -> Heights:
    """Return a matrix, whose rows run along the contact, with sizes of its header or of positions on its margins."""
    values, steps = _without_margins(text.values)
    stated = header.counts.get("y", 0), header.counts.get("x", 0)
    if stated[0] * stated[1] == values.size and sorted(stated) != sorted(values.shape):
        values = values.reshape(stated)  # lines that are broken, or one number a line
    rows, columns = values.shape
    if columns == 1:  # a profile, whose length may be called that along x or y
        length = header.length("x", rows) or header.length("y", rows)
        sizes = [] if length is None else [length, length / rows]  # of square cells
    else:
        lengths = [header.length("y", rows), header.length("x", columns)]
        for axis, step in enumerate(steps):
            if step:
                lengths[axis] = step * values.shape[axis] * header.units.get("yx"[axis], unit)
        sizes = [length for length in lengths if length is not None]
    if reading.sizes == "checked":
        _check_matrix(name, text.blocks, header, values, sizes, reading)
    if len(sizes) < 2 or not np.isfinite(sizes).all():
        return values, None, []
    is_one_size = sizes[0] == sizes[1] and rows != columns and ("step", "x") not in header.lengths
    return values, (sizes[0], sizes[1]), ["the one size of the header counts both ways"] * is_one_size


def _check_matrix(name: str, blocks: int, header: Header, values: Array, sizes: list[float], reading: Reading) -> None:
    """Raise :class:`~contactstudy.InvalidInput` for a matrix that has two readings by its header.

    Parameters
    ----------
    name
        Path of the file.
    blocks
        Number of parts of the matrix between blank lines.
    header
        Statements of the file.
    values
        Matrix (x, y).
    sizes
        Sizes [m] that the file gives, fewer than two where it gives none of an axis, nan where one has no unit.
    reading
        What is said beside the file.
    """
    count = header.counts.get("x", 0) * header.counts.get("y", 0)
    doubts = list(header.doubts)
    if len(header.lengths) == 4:  # sizes and steps of both axes
        for axis, points in zip("yx", values.shape, strict=True):
            step, size = header.lengths["step", axis], header.lengths["size", axis]
            # a size from the first to the last point is one step less, and its digits are rounded
            if abs(step * points - size) > 1.5 * step:
                doubts.append(f"{axis} {size:g} and {points} times {step:g}")
    fault, remedy = "", f"give the right one, or extent and {CONFIRMED}"
    if blocks > 1 and not count:
        fault = f"with {blocks} blocks of numbers between blank lines"
        remedy = f"give a file of one map, or {CONFIRMED} if they are one"
    elif doubts:
        fault = f"whose header has two sizes for one: {doubts[0]} m"
    elif reading.extent is None and (len(sizes) == 1 or np.isnan(sizes).any()):
        fault = "whose sizes have no unit" if np.isnan(sizes).any() else "which has a size along one axis alone"
        remedy = "give extent, or sizes with a unit for both axes in the header"
    elif count not in (0, values.size):
        fault = f"of {values.size} numbers, where its header says {count}"
        remedy = f"give the whole file, or {CONFIRMED} if the header is wrong"
    if fault:
        raise InvalidInput(f"path is {name!r}, {fault}: {remedy}.")


def _without_margins(values: Array) -> tuple[Array, list[float]]:
    """Return a matrix without positions in its first column and row, and their step along either axis.

    A step is zero without positions, and where they are the numbers of the points. Where positions fall the matrix is
    reversed.
    """
    # a plane is even in all its rows and columns, margins in the first alone
    left = top = np.array([])
    if min(values.shape) > 2 and _is_even(values[1:, 0]) and not _is_even(values[1:, 1]):
        left, values = values[:, 0], values[:, 1:]
    if min(values.shape) > 2 and _is_even(values[0]) and not _is_even(values[1]):
        top, left, values = values[0], left[1:], values[1:]
    falling = [axis for axis, places in enumerate((left, top)) if len(places) and places[0] > places[-1]]
    steps = [float(abs(np.diff(places).mean())) if len(places) else 0.0 for places in (left, top)]
    are_numbers = [step == 1 and places[0] in (0, 1) for step, places in zip(steps, (left, top), strict=True)]
    return np.flip(values, tuple(falling)), [
        step * (not is_number) for step, is_number in zip(steps, are_numbers, strict=True)
    ]


def _is_even(places: Array) -> bool:
    """Return whether numbers rise or fall in steps that are equal to 1 %, as rounded positions do and heights do not."""
    steps = np.diff(places)
    return len(steps) > 0 and bool(np.ptp(steps) <= 0.01 * abs(steps.mean())) and steps.mean() != 0


def _gridded(name: str, places: list[tuple[Array, float]], z: Array) -> Heights:
    """Return heights of points near a regular grid.

    Parameters
    ----------
    name
        Path of the file.
    places
        Positions of all points along x, and along y if there are any, each with its unit [m].
    z
        Heights of all points.
    """
    remedy = "give points on a rectangular grid, in columns x, y and height, or x and height of a profile"
    keep = np.isfinite(np.sum([positions for positions, _ in places], axis=0))
    indices, sizes, shift = [], [], 0.0
    for positions, unit in places:
        index, step, off = _on_line(positions[keep])
        if off > MAX_SHIFT:
            raise InvalidInput(
                f"path is {name!r}, whose points are not equidistant: they are up to {off:.2g} of a step beside a "
                f"regular grid, and {MAX_SHIFT} is the most: {remedy}."
            )
        indices.append(index)
        sizes.append(step * (index.max() + 1) * unit)
        shift = max(shift, off * step * unit)
    if len(places) == 1 or not indices[1].any():  # a profile, also one whose points all have one y: of square cells
        indices[1:] = [0 * indices[0]]
        sizes[1:] = [sizes[0] / (indices[0].max() + 1)]
    heights = np.full((indices[0].max() + 1, indices[1].max() + 1), np.nan)
    if heights.size > 2 * len(z):
        raise InvalidInput(f"path is {name!r}, whose points fill less than half of a grid: {remedy}.")
    heights[indices[0], indices[1]] = z[keep]
    if not np.array_equal(heights[indices[0], indices[1]], z[keep], equal_nan=True):
        raise InvalidInput(f"path is {name!r}, which has two heights at one place: {remedy}.")
    # less than a thousandth of a step is what rounded digits leave
    is_moved = bool(shift > 1e-3 * min(sizes) / max(heights.shape))
    return heights, (sizes[0], sizes[1]), [f"points moved by up to {readable(shift)} onto a regular grid"] * is_moved


def _on_line(positions: Array) -> tuple[NDArray[np.intp], float, float]:
    """Return the indices of positions on a regular line, its step, and the largest distance from it in steps.

    Sorted positions with gaps up to a limit between them have one index; a larger gap leads to the next, or across a
    hole by as many as it has median gaps. Since the largest gap may be a hole, limits of 1/2, 1/4 ... 1/1024 of it are
    tried, and the one that gives the most regular line counts. Where all positions are one, the indices are 0, and the
    step is 1, since none is known.
    """
    order = np.sort(positions)
    gaps = np.diff(order)
    if gaps.max(initial=0.0) <= 1e-6 * (order[-1] - order[0]):
        return np.zeros(len(positions), dtype=int), 1.0, 0.0

    def fitted(limit: float) -> tuple[NDArray[np.intp], float, float]:
        line = np.concatenate([[0], np.cumsum(gaps > limit)])
        centres = np.bincount(line, order) / np.bincount(line)
        between = np.diff(centres)
        number = np.concatenate([[0.0], np.cumsum(np.round(between / np.median(between)))])
        step, start = np.polyfit(number, centres, 1)
        index = np.round((positions - start) / step)
        return index.astype(int), float(step), float(np.abs(positions - start - step * index).max() / step)

    return min(map(fitted, gaps.max() / 2.0 ** np.arange(1, 11)), key=lambda line: line[2])
