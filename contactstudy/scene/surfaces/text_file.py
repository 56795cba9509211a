"""Numbers and header of a text file that holds a measured surface: its table, and what the lines around it state.

The file may be in any usual encoding, with blanks, tabs, semicolons or commas between numbers and a decimal point or
comma. What the table means, a matrix or points in columns, is decided in the module `text_surface`.
"""

import codecs
import csv
import re
import unicodedata
from collections import Counter
from dataclasses import dataclass, field
from itertools import pairwise, zip_longest
from math import nan

import numpy as np

from contactstudy.domain.grid import Array
from contactstudy.domain.validation import InvalidInput

# Units of length [m] by their names in lower case, with u for the micro sign and m for "metre" and the like. The s of a
# plural is left off, which makes "inche" of "inches".
LENGTHS = {
    "m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "micron": 1e-6, "nm": 1e-9, "å": 1e-10, "angstrom": 1e-10, "pm": 1e-12,
    "in": 25.4e-3, "inch": 25.4e-3, "inche": 25.4e-3, "mil": 25.4e-6, "uin": 25.4e-9,
}  # fmt: skip
# Words for a missing point, without their asterisks, hyphens, signs and quotes; an empty cell is one too.
MISSING = re.compile(
    r"|nan(\(\w+\))?|#?n/?a|null|none|bad|inf(inity|inite)?|no ?data|not measured|void|invalid|missing|masked|"
    r"undefined|1\.#(qnan|inf|ind)|#[a-z/]+[!?]?|n\.a\.?|\?"
)
# A number in its usual form, also with the exponent letter D of Fortran.
NUMERAL = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eEdD][-+]?\d+)?")
# Whole numbers in groups of three digits, by the mark between the groups: they may also be decimal numbers.
GROUPED = {mark: re.compile(rf"[-+]?[1-9]\d{{0,2}}(?:\{mark}\d{{3}})+") for mark in ",."}
# Number of lines from the end of a file that decide on its separator and its decimal sign. Headers stand before them,
# and so many lines of a rough surface hold numbers of every form that the file has.
SAMPLE_LINES = 80
# Number of lines above a table in which its columns may be named: names, units, and a line of dashes or of numbers.
NAME_LINES = 3


@dataclass(frozen=True)
class TextTable:
    """Table of numbers in a text file.

    Attributes
    ----------
    values
        Numbers (rows, columns), nan where one is missing.
    header
        Lines before and after the table, with a point as decimal sign.
    names
        Name of each column, empty texts without names.
    blocks
        Number of parts between which blank lines stand.
    """

    values: Array
    header: list[str]
    names: list[str]
    blocks: int = 1


def decoded(data: bytes) -> str | None:
    """Return the text of a file in UTF-8, UTF-16 or Windows-1252; None for a binary file.

    UTF-16 is known by its byte order mark. No text has bytes below 7, the bell. Characters that look alike become one:
    all dashes a hyphen, full-width and half-width forms plain ones, the Greek letter of "µm" an u, and a quotation mark
    in brackets "in" for inches.
    """
    is_utf16 = data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
    if not is_utf16 and re.search(rb"[\0-\6]", data):
        return None
    try:
        text = data.decode("utf-16" if is_utf16 else "utf-8-sig")
    except UnicodeDecodeError:
        text = data.decode("cp1252", errors="replace")
    text = re.sub("[\u2010-\u2015\u2212]", "-", unicodedata.normalize("NFKC", text))
    return re.sub(r'(?<=[\[(])"(?=[\])])', "in", text).replace("\u03bc", "u")


def length_unit(text: str) -> float | None:
    """Return the unit of length [m] that `text` names, None for any other text."""
    text = unicodedata.normalize("NFKC", text).replace("\u03bc", "u").strip(" []().'\"").lower()
    text = re.sub(r"met(re|er)$", "m", re.sub(r"(?<=\w{3})s$", "", text)).replace("microm", "um")
    return LENGTHS.get(re.sub(r"^(milli|nano|centi)m$", lambda prefix: f"{prefix[1][0]}m", text))


def table(name: str, text: str, decimal: str | None) -> TextTable:
    """Return the table of the `text` of a file, whose rows have the length with the most numbers.

    Parameters
    ----------
    name
        Path of the file, for messages.
    text
        Content of the file.
    decimal
        Decimal sign, "," or "."; None where the file decides.

    Raises
    ------
    InvalidInput
        If the file has no table of numbers, several, uneven rows, or two readings.
    """
    numbered = [(number, line) for number, line in enumerate(text.splitlines()) if line.strip()]
    lines = [line for _, line in numbered]
    separator, decimal = _marks(name, lines, decimal)
    rows = [_cells(line, separator) for line in lines]
    if not any(row[-1] for row in rows if len(row) > 1):  # each line ends with a separator
        rows = [row[:-1] or row for row in rows]
    values = [[_number(cell, decimal) for cell in row] for row in rows]
    first, last = _place_of_table(name, lines, rows, values)
    around = [*lines[:first], *lines[last:]]
    if decimal == ",":
        around = [re.sub(r"(?<=\d),(?=\d)", ".", line) for line in around]
    numbers = np.array(values[first:last], dtype=float)
    # blank lines separate parts of the table, unless one follows every line
    blocks = 1 + sum(after - before > 1 for (before, _), (after, _) in pairwise(numbered[first:last]))
    return TextTable(
        np.where(np.isfinite(numbers), numbers, nan),
        around,
        _column_names(lines[max(first - NAME_LINES, 0) : first], numbers.shape[1], separator),
        blocks if blocks <= len(numbers) / 2 else 1,
    )


def _place_of_table(
    name: str, lines: list[str], rows: list[list[str]], values: list[list[float | None]]
) -> tuple[int, int]:
    """Return the numbers of the first line of the table and of the line after its last one.

    Parameters
    ----------
    name
        Path of the file, for messages.
    lines
        Lines of the file that are not blank.
    rows
        Cells of each of these lines.
    values
        Their numbers, nan for a missing point and None for what is no number.

    Raises
    ------
    InvalidInput
        If no line holds numbers alone, or one between the first and the last that do has other or fewer numbers.
    """
    is_numeric = [None not in row for row in values]
    numeric = zip(rows, is_numeric, lines, strict=True)
    lengths = Counter(len(row) for row, fits, line in numeric if fits and re.search(r"\d", line))
    if not lengths:
        raise InvalidInput(
            f"path is {name!r}, without rows of numbers: give rows of equally many numbers, separated by commas, "
            "semicolons, tabs or blanks, with no marks between thousands."
        )
    count = max(lengths, key=lambda length: (lengths[length] * length, length))
    fitting = [fits and len(row) == count for fits, row in zip(is_numeric, rows, strict=True)]
    # one or two numbers above the table may be a count or a size; a longer line of another length is a faulty row of it
    first = next(n for n, row in enumerate(rows) if is_numeric[n] and (fitting[n] or (len(row) > 2 and any(row))))
    # a line of digits and marks is one of the table, even if its numbers cannot be read
    last = max(n for n, line in enumerate(lines) if is_numeric[n] or re.fullmatch(r"[\d\s.,;+-]+", line))
    if not all(fitting[first : last + 1]):
        number = fitting.index(False, first)
        fault = f"has {len(rows[number])} numbers beside {count}"
        if len(rows[number]) == count:
            bad = rows[number][values[number].index(None)]
            fault = f"has {bad[:40]!r}, which stands for a height (nan if missing)"
        raise InvalidInput(
            f"path is {name!r}, whose row {number + 1} {fault}: give rows of equally many numbers in one table, with "
            "one decimal sign and no marks between thousands."
        )
    return first, last + 1


def _column_names(lines: list[str], count: int, separator: str | None) -> list[str]:
    """Return the names of `count` columns, each from the words in its place of all `lines` with so many words.

    A second line often holds the units of the columns.
    """
    names = [""] * count
    for line in lines:
        bare = line.strip("#%/ \t")
        for row in (_cells(bare, separator), re.findall(r"[^\s\[(,;]+\s*(?:[\[(][^\])]*[\])])?", bare)):
            if len(row) == count:
                names = [f"{name} {word}".strip() for name, word in zip(names, row, strict=True)]
                break
    return names


def _cells(line: str, separator: str | None) -> list[str]:
    """Return the cells of a line between separators (None for blanks); a separator within quotes is none."""
    if separator and '"' in line:
        return [cell.strip() for cell in next(csv.reader([line], delimiter=separator[0], skipinitialspace=True))]
    return [cell.strip() for cell in line.strip(" ").split(separator)]


def _number(cell: str, decimal: str) -> float | None:
    """Return the number in a cell, nan for a missing point, None for any other text."""
    text = cell.replace(".", "?").replace(",", ".") if decimal == "," else cell  # a point then makes no number
    try:
        return float(text)
    except ValueError:
        if NUMERAL.fullmatch(text):  # with the exponent letter D
            return float(text.lower().replace("d", "e"))
        return nan if MISSING.fullmatch(cell.strip("*-+'\" ").lower()) else None


def _marks(name: str, lines: list[str], decimal: str | None) -> tuple[str | None, str]:
    """Return the separator of a file, None for blanks, and its decimal sign, from its last lines with digits.

    They are the pair with which the most lines hold numbers alone, the first tried of several. A `decimal` sign that is
    given is kept. Raises InvalidInput where numbers can be read in two ways.
    """
    sample = [line for line in lines if re.search(r"\d", line)][-SAMPLE_LINES:]
    frequent = [mark for mark in (";", "\t", ", ", ",") if 2 * sum(mark in line for line in sample) > len(sample)]
    # a comma alone may be the decimal sign between blanks; the others are separators wherever most lines have them
    separators = frequent[:1] if frequent and frequent[0] != "," else [*frequent * (decimal != ","), None]
    best: tuple[str | None, str] = separators[0], decimal or "."
    rows: list[list[str]] = []
    for separator in separators:
        split = [_cells(line, separator) for line in sample]
        for sign in decimal or ".,":
            good = [row for row in split if all(_number(cell, sign) is not None for cell in row)]
            if len(good) > len(rows):
                best, rows = (separator, sign), good
    separator, sign = best
    cells = [cell for row in rows for cell in row]
    remedy = 'give decimal = "," or decimal = "."'
    if rows and separator == "," and not decimal and not any("." in cell for cell in cells):
        # a comma in each pair may be a decimal one; of several pairs only where decimals begin with 0, as no number does
        second = [cell for row in rows for cell in row[1::2]]
        is_pair = all(len(row) % 2 == 0 for row in rows) and all(map(str.isdigit, second))
        if is_pair and (len(rows[0]) == 2 or any(re.match(r"0\d", cell) for cell in second)):
            raise InvalidInput(
                f"path is {name!r}, in which {rows[0][0] + ',' + rows[0][1]!r} is two numbers or one with a decimal "
                f"comma: {remedy}, or separate numbers by semicolons."
            )
    marked = [cell for cell in cells if sign in cell]
    if not decimal and marked and all(map(GROUPED[sign].fullmatch, marked)):
        # decimals that a program writes have one number of digits: a column with and without them has thousands
        for column in zip_longest(*rows, fillvalue=""):
            if len({sign in cell for cell in column if cell.strip("+-").isdigit() or sign in cell}) > 1:
                what = "point" if sign == "." else "comma"
                raise InvalidInput(
                    f"path is {name!r}, in which {marked[0]!r} has a decimal {what} or one between thousands: {remedy}."
                )
    return separator, sign


# Words of a header, in English and as Gwyddion, MountainsMap and others translate them. Those of `x` (along a row), `y`
# (from row to row) and `z` (the height) name an axis, those of `unit` a unit alone. The others say what a number is: a
# `step` between points, a `size` of all points, a `count` of points, or a `factor` of heights, which `times` is even
# without an axis. A number by `invalid` stands for a missing point, and with a word of `number` says how many there are.
# A number by a word of `other` is not used.
WORDS = {
    "x": "x dx nx w width columns cols ncols breite largeur ancho anchura larghezza horizontal fast "
    "column point punkt spalten",
    "y": "y dy ny h height length rows lines profiles nrows höhe hauteur länge altura altezza vertical slow "
    "row line zeilen",
    "z": "z dz value values data heights wert werte",
    "unit": "unit units einheit einheiten unité unités unidades",
    "step": "pixel spacing step pas paso passo increment pitch interval delta dx dy cellsize sampling resolution scale "
    "abstand calibration",
    "size": "size width height length range extent field dimension dimensions breite largeur höhe hauteur länge anchura "
    "altura larghezza altezza fov größe grösse taille tamaño feld champ real",
    "factor": "factor scale conversion multiplier mult faktor dz",
    "times": "factor faktor multiplier mult conversion",
    "invalid": "nodata invalid missing bad void undefined masked dummy fill novalue",
    "other": "radius tip speed force cutoff cut wavelength working objective filter offset origin position start date "
    "time optical magnification evaluation traverse min max version intensity xllcorner yllcorner",
    "count": "nx ny points pixels lines rows columns cols ncols nrows profiles w h",
    "number": "points pixels count number percent ratio samples",
}
WORDS_OF = {name: frozenset(words.split()) for name, words in WORDS.items()}
# Words that name z beside a word of a unit or a factor, and elsewhere y, the height of a picture.
HEIGHT_OR_SIDE = frozenset(("height", "höhe", "hauteur", "altura", "altezza", "vertical"))
# "nm/count", "um per LSB": heights are whole numbers, and the number before it is their factor.
COUNTED = re.compile(r"\s*(?:/|\bper )\s*(?:count|lsb|bit|digit|inc)\w*", re.I)
# A number within a line, and what may be a unit after it: no word before a colon, and no "in" before another word.
NUMBER = re.compile(r"(?<![\w.])" + NUMERAL.pattern + r"(?![\d.])")
UNIT = re.compile(r"[\s,;\t]*[\[(]?(?!in\s+(?:\d|\w\w))([^\W\d_]+)[\])]?(?!\s*[=:]|\w|/)")
# The part of a unit that a step between points may have, "2 um/px".
PER_PIXEL = re.compile(r"\s*/\s*(?:px|pixel|pt|point)s?\b", re.I)
# Parts of a word of a header that are words of their own, such as "xsize" and "pixelsize".
JOINED = re.compile(
    r"\b([xyz](?=size|pixel|length|range|unit|scale|step|spacing|calibration|res|real)|"
    r"(?:pixel|punkt|zeilen|spalten|bild|mess|scan)(?=\w{4}))"
)
# Words that may stand between two numbers of one statement on both axes: "2 um (X), 3 um (Y)", "2 um by 3 um".
BETWEEN = frozenset(("x", "y", "by"))


@dataclass
class Header:
    """Statements in the header of a text file, by axis: "x" along a row, "y" from row to row, "z" the height.

    Attributes
    ----------
    counts
        Numbers of points by axis.
    stated
        Lengths in the order of the file: "size" of all points or "step" between two, axis, number, and its unit [m],
        None where the number has none of its own.
    lengths
        First of these lengths [m] by kind and axis, nan without any unit.
    units
        Units [m] of the numbers along an axis, from a line that names the unit alone.
    unknown
        Units that are no length, by axis.
    factor
        Factor of all heights.
    invalid
        Number that stands for a point that was not measured, if any.
    doubts
        Two statements of one length that differ, as texts.
    unused
        Lines with lengths that nothing uses.
    """

    counts: dict[str, int] = field(default_factory=dict)
    stated: list[tuple[str, str, float, float | None]] = field(default_factory=list)
    lengths: dict[tuple[str, str], float] = field(default_factory=dict)
    units: dict[str, float] = field(default_factory=dict)
    unknown: dict[str, str] = field(default_factory=dict)
    factor: float = 1.0
    invalid: float | None = None
    doubts: list[str] = field(default_factory=list)
    unused: list[str] = field(default_factory=list)

    @classmethod
    def of(cls, lines: list[str], shape: tuple[int, ...]) -> "Header":
        """Return what the `lines` around a table of the `shape` (rows, columns) state."""
        header = cls()
        for line in lines:
            line = PER_PIXEL.sub("", line.replace('"', " "))
            words = _words(line)
            if len(_axes(words)) == 1 or words & WORDS_OF["times"]:  # one number: a comma in it is a decimal one
                line = re.sub(r"(?<=\d),(?=\d)", ".", line)
            before = repr(header)
            header._read(re.sub(r"(?<=[a-zß-ÿ])(?=[A-Z])|_", " ", line), shape)
            lengths = [UNIT.match(line, number.end()) for number in NUMBER.finditer(line)]
            # nothing was taken up of a line that names a length
            if repr(header) == before and any(unit and length_unit(unit[1]) for unit in lengths):
                header.unused.append(" ".join(line.split())[:60])
        if "x" in header.units:
            header.units.setdefault("y", header.units["x"])
        for kind, axis, number, unit in header.stated:
            length = number * (unit or header.units.get(axis, nan))
            first = header.lengths.setdefault((kind, axis), length)
            if abs(first - length) > 0.01 * length:  # more than rounded digits
                header.doubts.append(f"{axis} {first:g} and {length:g}")
        return header

    def length(self, axis: str, count: int) -> float | None:
        """Return the length [m] of `count` points along an axis; nan if it has no unit, None if nothing is stated."""
        if ("step", axis) in self.lengths:
            return self.lengths["step", axis] * count
        return self.lengths.get(("size", axis))

    def _read(self, line: str, shape: tuple[int, ...]) -> None:
        """Take up each number of a line under the words before it, and a unit without a number at its end.

        "bit2nm" is the factor of BCR files. Arrows are those of "factor (-> m)". Of two numbers of which the second has
        no words of its own, the first is that of x and the second that of y, unless the line names y first.
        """
        line, counted = COUNTED.subn("", re.sub(r"\bbit2(\w+)", r"z factor [\1]", line))
        letters = re.findall(r"\b[XYxy]\b", re.split(r"\d", line)[0]) or re.findall(r"\(([XYxy])\)", line)
        order = "yx" if letters and letters[0] in "Yy" else "xy"
        statements: list[tuple[frozenset[str], float, float | None]] = []
        end = 0
        for number in NUMBER.finditer(line):
            key = line[end : number.start()]
            words = _words(key + " factor" * (counted > 0))
            following = UNIT.match(line, number.end())
            unit = length_unit(following[1]) if following else None
            end = following.end() if following and unit else number.end()
            bracketed = map(length_unit, re.findall(r"[\[(](?:->)?([^\])]*)[\])]", key))
            unit = unit or next(filter(None, bracketed), None)
            if statements and words <= BETWEEN and key != ",":
                before, first, first_unit = statements[-1]
                if len(_axes(before)) != 1 or (_axes(before) == ["x"] and "y" in words):
                    statements[-1] = before - {order[1]} | {order[0]}, first, first_unit or unit
                    words = before - {order[0]} | {order[1]}
            statements.append((words, float(number[0].lower().replace("d", "e")), unit))
        for statement in statements:
            self._take(*statement, shape)
        key, _, word = re.sub(r"[\[(:=,;\t]+|\bin\b", ":", line[end:].strip(" #%\t;,:=")).rpartition(":")
        words, unit = _words(key), length_unit(word)
        if not words & WORDS_OF["other"] and (unit or words & WORDS_OF["unit"]):
            for axis in _axes(words | {"unit"}) or ["z"]:
                if unit:
                    self.units[axis] = unit
                elif word.strip():
                    self.unknown[axis] = word.strip()

    def _take(self, words: frozenset[str], value: float, unit: float | None, shape: tuple[int, ...]) -> None:
        """Take up one number under the words of a key.

        The first of these that it can be counts: the value of invalid points, a factor of heights, a count of points, a
        number that is not used, a step or a size. A "pixel size" is a step and no count, and a "sampling length", which
        is of roughness (ISO 4287), not used.
        """
        axes = _axes(words)
        lateral = [axis for axis in axes if axis != "z"] or (["x", "y"] if "z" not in axes else [])
        is_whole = unit is None and value.is_integer()
        is_count = is_whole and (value in (*shape, shape[0] * shape[-1]) or words & WORDS_OF["count"])
        kind = next((kind for kind in ("step", "size") if words & WORDS_OF[kind]), "")
        if words & WORDS_OF["invalid"]:
            self.invalid = self.invalid if words & WORDS_OF["number"] else value
        elif ("z" in axes and words & WORDS_OF["factor"]) or (not axes and words & WORDS_OF["times"]):
            self.factor = value
            self.units |= {"z": unit} if unit else {}
        elif is_count and not {"pixel", "size"} <= words:
            self.counts |= {axis: int(value) for axis in lateral if axes}
        elif kind and value > 0 and not words & WORDS_OF["other"] and not {"sampling", "length"} <= words:
            self.stated += [(kind, axis, value, unit) for axis in lateral]


def _words(key: str) -> frozenset[str]:
    """Return the words of a key in lower case, "no data" as one, "pixelsize" as two."""
    key = re.sub(r"\bno (?=data|value)", "no", JOINED.sub(r"\1 ", key.lower()))
    return frozenset(re.findall(r"[^\W\d_]+", key))


def _axes(words: frozenset[str]) -> list[str]:
    """Return the axes "x", "y" or "z" that the words of a key name.

    "Height" names z with a unit, a factor or a range, and y as the side of a picture; "x length" names x alone.
    """
    is_of_height = words & (WORDS_OF["factor"] | {"unit", "units", "range", "resolution"})
    if words & WORDS_OF["z"] or (words & HEIGHT_OR_SIDE and is_of_height):
        return ["z"]
    if "line" in words and words & {"per", "length"}:
        return ["x"]
    named = words - WORDS_OF["size"] or words
    if words & {"lateral", "xy"} and not named & (WORDS_OF["x"] | WORDS_OF["y"]):
        return ["x", "y"]
    if not named & (WORDS_OF["x"] | WORDS_OF["y"]):
        named = words
    return [axis for axis in "xy" if named & WORDS_OF[axis]]
