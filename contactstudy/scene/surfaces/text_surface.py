"""Heights and sizes of a surface in a text file, a matrix or points in columns, and what is said beside the file."""

import re
from dataclasses import KW_ONLY
from math import inf
from typing import Annotated, Any, ClassVar, Literal, NamedTuple

import numpy as np

from contactstudy.domain.grid import Array
from contactstudy.domain.validation import FINITE, InvalidInput, Metres, Number, readable, validated
from contactstudy.scene.surfaces.text_file import Header, TextTable, length_unit

# Units that a message offers [m].
UNITS = {"nm": 1e-9, "um": 1e-6, "mm": 1e-3, "m": 1.0}
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


class FileContent(NamedTuple):
    """Numbers of a file (x, y), nan where one is missing, their unit [m], the sizes [m], and notes on them.

    `invalid` is the number that stands for a missing one, if the file says so. `is_own` says whether this program wrote
    the file. `assumed` is a note on sizes that the file leaves open, which a given extent replaces.
    """

    values: Array
    unit: float
    sizes: tuple[float, float] | None
    notes: tuple[str, ...] = ()
    invalid: float | None = None
    is_own: bool = False
    assumed: str = ""


def unit_of_heights(name: str, reading: Reading, own: float | None = None, unknown: str | None = None) -> float:
    """Return the unit [m] of heights: that of the file, which a given one must not contradict, or the given one."""
    given = None if reading.unit is None else length_unit(reading.unit)
    if own is None and given is None:
        fault = "is None" if unknown is None else f"is None, and its heights are in {unknown!r}"
        raise InvalidInput(
            f"MeasuredSurface.unit of {name!r} {fault}: give the unit of its numbers, one of {', '.join(UNITS)}."
        )
    if own is not None and given is not None and reading.sizes == "checked" and not np.isclose(given, own, atol=0):
        raise InvalidInput(
            f"MeasuredSurface.unit of {name!r} is {reading.unit!r}: leave it out, since its heights are in "
            f'{unit_name(own)}; or give sizes = "confirmed" too, if the file is wrong.'
        )
    return given or own or 1.0


def unit_name(unit: float) -> str:
    """Return the name of a unit [m]."""
    return next((name for name, size in UNITS.items() if np.isclose(size, unit, atol=0)), readable(unit))


# Points along each side of a matrix, of which a table of something else has fewer.
MIN_POINTS = 8
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
# What a message offers where a file may be right all the same.
CONFIRMED = 'sizes = "confirmed"'


def surface_of_text(name: str, text: TextTable, reading: Reading) -> FileContent:
    """Return heights and sizes of a text file: a matrix, or points in columns."""
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
        content = _gridded(name, places, text.values[:, columns["z"][0]])
    else:
        content = _matrix(text, header, unit)
        if reading.sizes == "checked":
            _check_matrix(name, text.blocks, header, content, reading)
    notes = list(content.notes)
    if header.factor != 1:
        notes.append(f"numbers times the factor {header.factor:g} of the header")
    if header.unused:
        notes.append(f"these lines of the header were not used: {', '.join(map(repr, header.unused))}")
    return content._replace(unit=unit * header.factor, invalid=header.invalid, notes=tuple(notes))


def _check_matrix(name: str, blocks: int, header: Header, content: FileContent, reading: Reading) -> None:
    """Raise :class:`~contactstudy.InvalidInput` for a matrix, in so many blocks, that has two readings by its header."""
    rows_and_columns, unit = content.values.shape, content.unit
    stated = header.counts.get("x", 0) * header.counts.get("y", 0)
    doubts = list(header.doubts)
    if len(header.sizes) == len(header.steps) == 2 and not header.bare:
        for axis, count in zip("yx", rows_and_columns, strict=True):
            if abs(header.steps[axis] * count - header.sizes[axis]) > 1.5 * header.steps[axis]:
                doubts.append(f"{axis} {header.sizes[axis]:g} and {count} times {header.steps[axis]:g}")
    fault, remedy = "", f"give the right one, or extent and {CONFIRMED}"
    if blocks > 1 and not stated:
        fault = f"with {blocks} blocks of numbers between blank lines"
        remedy = f"give a file of one map, or {CONFIRMED} if they are one"
    elif doubts:
        fault = f"whose header has two sizes for one: {doubts[0]} m"
    elif header.bare and reading.extent is None and unit < 1e-7:
        fault = f"whose header has sizes without a unit, and heights in {unit_name(unit)}"
        remedy = "give extent, or the unit of the sizes in the header"
    elif stated not in (0, content.values.size):
        fault = f"of {content.values.size} numbers, where its header says {stated}"
        remedy = f"give the whole file, or {CONFIRMED} if the header is wrong"
    if fault:
        raise InvalidInput(f"path is {name!r}, {fault}: {remedy}.")


def _columns(name: str, text: TextTable) -> dict[str, tuple[int, float | None]]:
    """Return place and unit [m] of the columns x, y and z of a text file; none for a matrix or a single column."""
    rows, count = text.values.shape
    named: dict[str, tuple[int, float | None]] = {}
    for place, label in enumerate(text.names):
        words = re.split(r"[\s/\[\](),_]+", label.lower())
        kind = next((word for word in words if word in COLUMNS), words[0].strip("-:#").removesuffix("pos"))
        for axis, starts in COLUMNS.items():
            if kind in starts and axis not in named:
                named[axis] = place, column_unit(label)
    if {"x", "z"} <= named.keys():
        return named
    units = [column_unit(label) for label in text.names]
    if count in (2, 3) and rows >= MIN_POINTS - 4 * (count == 3):
        return {axis: (place, units[place]) for place, axis in enumerate("xz" if count == 2 else "xyz")}
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


def _matrix(text: TextTable, header: Header, unit: float) -> FileContent:
    """Return a matrix, whose rows run along the contact, with sizes of its header or of places on its margins."""
    values, places = _without_margins(text.values, np.array(text.above))
    pair = header.counts.get("y", 0), header.counts.get("x", 0)
    if pair[0] * pair[1] == values.size and sorted(pair) != sorted(values.shape):
        values = values.reshape(pair)  # lines that are broken, or one number a line
    rows, columns = values.shape
    counts, notes = {"x": columns, "y": rows}, []
    assumed = f"sizes of the header, which have no unit, count in {unit_name(unit)}" * bool(header.bare)
    lengths: dict[str, float] = {}
    for axis, count in counts.items():
        bare = unit if axis in header.bare else 1.0
        step = abs(np.diff(places[axis]).mean()) if len(places[axis]) else 0.0
        if step and (step != 1 or places[axis][0] not in (0, 1)):
            lengths[axis] = float(step) * count * header.units.get(axis, unit)
        elif axis in header.steps or axis in header.sizes:
            lengths[axis] = header.steps.get(axis, 0.0) * count * bare or header.sizes[axis] * bare
    if columns == 1 and lengths:  # a profile, whose places may be called x
        size = lengths.get("x", 0.0) * (rows if "x" in header.steps else 1) or lengths["y"]
        lengths = {"y": size, "x": size / rows}
    if len(lengths) == 2 and lengths["x"] == lengths["y"] and rows != columns and not header.steps:
        notes.append("the one size of the header counts both ways")
    if len(lengths) == 1:  # a lone width or length may be that of the part
        steps = [lengths[axis] / counts[axis] for axis in lengths if axis in header.steps or any(places[axis])]
        lengths = {axis: step * count for step in steps for axis, count in counts.items()}
        assumed = SQUARE * len(steps)
    sizes = (lengths["y"], lengths["x"]) if lengths else None
    return FileContent(values, unit, sizes, tuple(notes), assumed=assumed * bool(lengths))


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
    falling = [axis for axis, places in ((0, left), (1, top)) if len(places) and places[0] > places[-1]]
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
        raise InvalidInput(f"path is {name!r}, whose points fill less than half of a grid: {remedy}.")
    heights[indices[0], indices[1]] = z[keep]
    if not np.array_equal(heights[indices[0], indices[1]], z[keep], equal_nan=True):
        raise InvalidInput(f"path is {name!r}, which has two heights at one place: {remedy}.")
    is_moved = bool(shift > 1e-3 * min(sizes) / max(heights.shape))
    notes = (f"points moved by up to {readable(shift)} onto a regular grid",) * is_moved
    return FileContent(heights, 1.0, (sizes[0], sizes[1]), notes)


def _on_line(positions: Array) -> tuple[Any, float, float]:
    """Return the indices of positions on a regular line, its step, and the largest distance from it in steps."""
    order = np.sort(positions)
    gaps = np.diff(order)
    best: tuple[Any, float, float] = np.zeros(len(positions), dtype=int), 1.0, inf
    if gaps.max(initial=0.0) <= 1e-6 * (order[-1] - order[0]):
        return best[0], 1.0, 0.0
    # gaps between lines of points are the ones above a limit: that which gives the most regular line
    for limit in gaps.max() / 2.0 ** np.arange(1, 11):
        line = np.concatenate([[0], np.cumsum(gaps > limit)])
        centres = np.bincount(line, order) / np.bincount(line)
        between = np.diff(centres)
        number = np.concatenate([[0.0], np.cumsum(np.round(between / np.median(between)))])
        step, start = np.polyfit(number, centres, 1)
        index = np.round((positions - start) / step)
        off = float(np.abs(positions - start - step * index).max() / step)
        if off < best[2]:
            best = index.astype(int), float(step), off
    return best
