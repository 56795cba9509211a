"""Numbers and header of a text file, whatever its encoding, separators and decimal sign."""

import codecs
import csv
import re
import unicodedata
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise, zip_longest
from math import nan

import numpy as np

from contactstudy.domain.grid import Array
from contactstudy.domain.validation import InvalidInput

# Units of length [m] by their names in lower case and without the s of a plural (that of "inches" leaves "inche"), the
# micro sign written u, "metre" and the like written m.
LENGTHS = {
    "m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "micron": 1e-6, "nm": 1e-9, "å": 1e-10, "angstrom": 1e-10, "pm": 1e-12,
    "in": 25.4e-3, "inch": 25.4e-3, "inche": 25.4e-3, "mil": 25.4e-6, "uin": 25.4e-9,
}  # fmt: skip
# Words for a missing point, without their asterisks, hyphens, signs and quotes.
MISSING = re.compile(
    r"|nan(\(\w+\))?|#?n/?a|null|none|bad|inf(inity|inite)?|no ?data|not measured|void|invalid|missing|masked|"
    r"undefined|1\.#(qnan|inf|ind)|#[a-z/]+[!?]?|n\.a\.?|\?"
)
NUMERAL = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eEdD][-+]?\d+)?")
# An integer in groups of three digits, which is a decimal number where the mark between them is the decimal sign.
GROUPED = {mark: re.compile(rf"[-+]?[1-9]\d{{0,2}}(?:\{mark}\d{{3}})+") for mark in ",."}


# Words of a header, in English and as Gwyddion, MountainsMap and others translate them. Axes come first. A number is
# a step between points, a size of all, a `factor` of heights (by `times` even where no axis is named), the value of
# `invalid` points, or a count of points if whole and by a word of `count`. One by a word of `other` is not used, nor
# the `number` of invalid points.
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
    "time optical magnification evaluation traverse range min max version intensity xllcorner yllcorner",
    "count": "nx ny points pixels lines rows columns cols ncols nrows profiles w h",
    "number": "points pixels count number percent ratio samples",
}
WORDS_OF = {name: frozenset(words.split()) for name, words in WORDS.items()}
# "nm/count", "um per LSB": heights are integers, and the number before it is their factor.
COUNTED = re.compile(r"\s*(?:/|\bper )\s*(?:count|lsb|bit|digit|inc)\w*", re.I)
# A number within a line, what may be a unit after it, and two numbers such as "2 um x 3 um".
NUMBER = re.compile(r"(?<![\w.])" + NUMERAL.pattern + r"(?![\d.])")
UNIT = re.compile(r"[\s,;\t]*[\[(]?(?!in\s+(?:\d|\w\w))([^\W\d_]+)[\])]?(?!\s*[=:]|\w|/(?!p))")
PAIR = re.compile(rf"({NUMERAL.pattern})\s*([^\W\d_]*)\s*[x×*]\s*({NUMERAL.pattern})\s*([^\W\d_]*)")
# Parts of a word of a header that are words of their own, such as "xsize" and "pixelsize".
JOINED = re.compile(
    r"\b([xyz](?=size|pixel|length|range|unit|scale|step|spacing|calibration|res|real)|"
    r"(?:pixel|punkt|zeilen|spalten|bild|mess|scan)(?=\w{4}))"
)
# Two numbers after one key, such as "size X/Y: 2 um / 3 um" and "size: 2 um (X), 3 um (Y)" without X and Y.
TWO = re.compile(
    rf"({NUMERAL.pattern}[^\W\d_]*(?:\s*[num]?m\b)?)(?:/[a-z]+)?(?:\s*/\s*|(?:\s*\(\))?,?\s+)(?={NUMERAL.pattern})"
)


@dataclass
class Header:
    """Statements of the header of a text file by axis: x (along a row), y (from row to row), z (the height).

    `counts` are numbers of points. `sizes` of all points and `steps` between them are in metres, or on the `bare` axes
    in a unit that the header leaves open. `units` [m] are those of values along an axis, which a line or a number names;
    `unknown` those that are no length. Heights are numbers of the table times `factor`, and missing where the number is
    `invalid`. `doubts` are lines that contradict others, `unused` ones with lengths that nothing uses.
    """

    counts: dict[str, int] = field(default_factory=dict)
    sizes: dict[str, float] = field(default_factory=dict)
    steps: dict[str, float] = field(default_factory=dict)
    units: dict[str, float] = field(default_factory=dict)
    bare: set[str] = field(default_factory=set)
    factor: float = 1.0
    invalid: float | None = None
    unknown: dict[str, str] = field(default_factory=dict)
    doubts: list[str] = field(default_factory=list)
    unused: list[str] = field(default_factory=list)

    @classmethod
    def of(cls, lines: list[str], shape: tuple[int, ...]) -> "Header":
        """Return what the lines around a table of that shape say."""
        header = cls()
        for line in lines:
            line = line.replace('"', " ")
            if len(_axes(_words(line))) == 1:  # 2,5 um is one number
                line = re.sub(r"(?<=\d),(?=\d+\s*[\[(]?[num]?m\b)", ".", line)
            before = repr(header)
            header._read(re.sub(r"(?<=[a-zß-ÿ])(?=[A-Z])|_", " ", line), shape)
            lengths = [UNIT.match(line, number.end()) for number in NUMBER.finditer(line)]
            if repr(header) == before and any(unit and length_unit(unit[1]) for unit in lengths):
                header.unused.append(" ".join(line.split())[:60])
        if "x" in header.units:
            header.units.setdefault("y", header.units["x"])
        for name in header.bare & header.units.keys():  # a line of its own has given the unit
            for values in (header.sizes, header.steps):
                if name in values:
                    values[name] *= header.units[name]
        header.bare -= header.units.keys()
        return header

    def _read(self, line: str, shape: tuple[int, ...]) -> None:
        """Take up what one line says: each number under the words before it, and a unit without a number at its end.

        "bit2nm" is the factor of BCR files. Arrows are those of "factor (-> m)".
        """
        line, counted = COUNTED.subn("", re.sub(r"\bbit2(\w+)", r"z factor [\1]", line))
        without_axes = re.sub(r"\b[XYxy]\b", "", line)
        if TWO.search(without_axes) and len(_axes(_words(line))) != 1:
            line = TWO.sub(r"\1 x ", without_axes)
        line = PAIR.sub(r" x \1 \4 y \3 \4", line)
        end, before = 0, ""
        for number in NUMBER.finditer(line):
            key = line[end : number.start()]
            if _words(key) == {"y"} and "x" in _words(before):  # the second number of a pair, as in "X/Y: 2 um / 3 um"
                key = re.sub(r"\bx\b", "y", before)
            following = UNIT.match(line, number.end())
            unit = length_unit(following[1]) if following else None
            end, before = following.end() if following and unit else number.end(), key
            bracketed = map(length_unit, re.findall(r"[\[(](?:->)?([^\])]*)[\])]", key))
            words = _words(key + " factor" * (counted > 0))
            self._take(words, float(number[0]), unit or next(filter(None, bracketed), None), shape)
        key, _, word = re.sub(r"[\[(:=,;\t]+|\bin\b", ":", line[end:].strip(" #%\t;,:=")).rpartition(":")
        words, unit = _words(key), length_unit(word)
        if not words & WORDS_OF["other"] and (unit or words & WORDS_OF["unit"]):
            for axis in _axes(words | {"unit"}) or ["z"]:
                if unit:
                    self.units[axis] = unit
                elif word.strip():
                    self.unknown[axis] = word.strip()

    def _take(self, words: frozenset[str], value: float, unit: float | None, shape: tuple[int, ...]) -> None:
        """Take up one number under the words of a key, in metres if it has a unit.

        The first of these that it can be counts: the value of invalid points, a factor of heights, a count of points, a
        number that is not used, a step or a size.
        """
        axes = _axes(words)
        if words & WORDS_OF["invalid"] or {"no", "data"} <= words or {"no", "value"} <= words:
            if not words & WORDS_OF["number"]:
                self.invalid = value
            return
        if ("z" in axes and words & WORDS_OF["factor"]) or (not axes and words & WORDS_OF["times"]):
            self.factor = value
            self.units |= {"z": unit} if unit else {}
            return
        lateral = [axis for axis in axes if axis != "z"] or (["x", "y"] if "z" not in axes else [])
        is_whole = unit is None and value == int(value)
        is_count = is_whole and (value in (*shape, shape[0] * shape[-1]) or words & WORDS_OF["count"])
        if is_count and not {"pixel", "size"} <= words:
            self.counts |= {axis: int(value) for axis in lateral if axes}
        elif words & WORDS_OF["other"] - {"range"} or {"sampling", "length"} <= words or value <= 0:
            return
        elif words & (WORDS_OF["step"] | WORDS_OF["size"]):
            target = self.steps if words & WORDS_OF["step"] else self.sizes
            for axis in lateral:
                size = value * (unit or 1.0)
                if abs(target.setdefault(axis, size) - size) > 0.01 * size:
                    self.doubts.append(f"{axis} {target[axis]:g} and {size:g}")
            self.bare |= set() if unit else set(lateral)


def _words(key: str) -> frozenset[str]:
    """Return the words of a key in lower case."""
    return frozenset(re.findall(r"[^\W\d_]+", JOINED.sub(r"\1 ", key.lower())))


def _axes(words: frozenset[str]) -> list[str]:
    """Return the axes that the words of a key name: a "height unit" is one of z, the "height" of a picture one of y."""
    heights = words & frozenset(("height", "höhe", "hauteur", "altura", "altezza", "vertical"))
    if words & WORDS_OF["z"] or (heights and words & (WORDS_OF["factor"] | {"unit", "units", "range", "resolution"})):
        return ["z"]
    if "line" in words and words & {"per", "length"}:
        return ["x"]
    named = words - WORDS_OF["size"] or words  # "x length" names x
    if words & {"lateral", "xy"} and not named & (WORDS_OF["x"] | WORDS_OF["y"]):
        return ["x", "y"]
    if not named & (WORDS_OF["x"] | WORDS_OF["y"]):
        named = words
    return [axis for axis in "xy" if named & WORDS_OF[axis]]


@dataclass(frozen=True)
class TextTable:
    """Table of numbers in a text file.

    It has `values` (rows, columns), nan where one is missing, the lines around them as `header`, `names` of the columns
    (empty texts without), the numbers in the line `above`, which may be positions, and the number of `blocks` between
    blank lines.
    """

    values: Array
    header: list[str]
    names: list[str]
    above: list[float]
    blocks: int = 1


def decoded(data: bytes) -> str | None:
    """Return the text of a file in UTF-8, UTF-16 or Windows-1252, with look-alikes as one; None for a binary file."""
    # in UTF-16 one byte of nearly every pair is zero; no text has control characters below 7, the bell
    zeros = [data[start:4096:2].count(0) for start in (0, 1)]
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        text = data.decode("utf-16", errors="replace")
    elif max(zeros) > 0.7 * len(data[:4096:2]) and min(zeros) == 0:
        text = data.decode("utf-16-be" if zeros[0] else "utf-16-le", errors="replace")
    elif any(byte < 7 for byte in data[:65536]):
        return None
    else:
        try:
            text = data.decode("utf-8-sig")
        except UnicodeDecodeError:
            text = data.decode("cp1252", errors="replace")
    text = re.sub("[\u2010-\u2015\u2212]", "-", unicodedata.normalize("NFKC", text))
    text = re.sub(r'(?<=[\[(])"(?=[\])])', "in", text)
    return text.replace("\u03bc", "u").replace("\ufeff", "").replace("\0", "")


def length_unit(text: str) -> float | None:
    """Return the unit of length [m] that `text` names, None for any other text."""
    text = unicodedata.normalize("NFKC", text).replace("\u03bc", "u").strip(" []().'\"").lower()
    text = re.sub(r"met(re|er)$", "m", re.sub(r"(?<=\w{3})s$", "", text)).replace("microm", "um")
    return LENGTHS.get(re.sub(r"^(milli|nano|centi)m$", lambda prefix: f"{prefix[1][0]}m", text))


def table(name: str, text: str, decimal: str | None) -> TextTable:
    """Return the table of a text file and its header; `decimal` is the decimal sign where the file leaves it open.

    Raises
    ------
    InvalidInput
        If the file has no table of numbers, several, uneven rows, or two readings.
    """
    numbered = [(number, line) for number, line in enumerate(text.splitlines()) if line.strip()]
    lines = [line for _, line in numbered]
    separator, decimal = _marks(name, lines, decimal)
    rows = [_cells(line, separator) for line in lines]
    if rows and not any(row[-1] for row in rows if len(row) > 1):  # each line ends with a separator
        rows = [row[:-1] if len(row) > 1 else row for row in rows]
    values = [_values(row, decimal) for row in rows]
    whole = [None not in row for row in values]
    numeric = zip(rows, whole, lines, strict=True)
    lengths = Counter(len(row) for row, fits, line in numeric if fits and re.search(r"\d", line))
    if not lengths:
        raise InvalidInput(
            f"path is {name!r}, without rows of numbers: give rows of equally many numbers, separated by commas, "
            "semicolons, tabs or blanks."
        )
    # rows of the length with the most numbers are the table's
    count = max(lengths, key=lambda length: (lengths[length] * length, length))
    fitting = [fits and len(row) == count for fits, row in zip(whole, rows, strict=True)]
    first = fitting.index(True)
    last = max(n for n, line in enumerate(lines) if whole[n] or re.fullmatch(r"[\d\s.,;+-]+", line))
    if not all(fitting[first : last + 1]):
        number = fitting.index(False, first)
        fault = f"has {len(rows[number])} numbers beside {count}"
        if len(rows[number]) == count:
            bad = rows[number][values[number].index(None)]
            fault = f"has {bad[:40]!r}, which stands for a height (nan if missing)"
        raise InvalidInput(
            f"path is {name!r}, whose row {number + 1} {fault}: give rows of equally many numbers in one table, with "
            "one decimal sign (a comma between semicolons, tabs or blanks)."
        )
    around = [*lines[:first], *lines[last + 1 :]]
    if decimal == ",":
        around = [re.sub(r"(?<=\d),(?=\d)", ".", line) for line in around]
    names = [""] * count
    for line in lines[max(first - 3, 0) : first]:
        bare = line.strip("#%/ \t")
        for row in (_cells(bare, separator), re.findall(r"[^\s\[(,;]+\s*(?:[\[(][^\])]*[\])])?", bare)):
            if len(row) == count:
                names = [f"{name} {word}".strip() for name, word in zip(names, row, strict=True)]
                break
    above = [value for value in values[first - 1] if value is not None] if first else []
    numbers = np.array(values[first : last + 1], dtype=float)
    # blank lines separate parts of the table, unless one follows every line
    blocks = 1 + sum(after - before > 1 for (before, _), (after, _) in pairwise(numbered[first : last + 1]))
    blocks = blocks if blocks <= len(numbers) / 2 else 1
    return TextTable(np.where(np.isfinite(numbers), numbers, nan), around, names, above, blocks)


def _cells(line: str, separator: str | None) -> list[str]:
    """Return the cells of a line; a separator within quotes is none."""
    if separator and '"' in line:
        return [cell.strip() for cell in next(csv.reader([line], delimiter=separator[0], skipinitialspace=True))]
    return [cell.strip() for cell in line.strip(" ").split(separator)]


def _values(row: list[str], decimal: str) -> Sequence[float | None]:
    """Return the numbers of a row, as :func:`_value` does; most rows hold nothing else."""
    try:
        # "?" is no number: its ValueError leaves the row to `_value`
        return [float("?" if decimal == "," and "." in word else word) for word in row]
    except ValueError:
        return [_value(word, decimal) for word in row]


def _value(word: str, decimal: str) -> float | None:
    """Return the number that a word is, nan for a missing point, None for any other word."""
    word = re.sub(r"(?<=\d)['’ ](?=\d{3}(?!\d))", "", word)
    between = "." if decimal == "," else ","
    if GROUPED[between].fullmatch(word.partition(decimal)[0]):
        word = word.replace(between, "")
    if decimal == ",":
        word = word.replace(".", "?").replace(",", ".")
    if NUMERAL.fullmatch(word):
        return float(word.lower().replace("d", "e"))
    return nan if MISSING.fullmatch(word.strip("*-+'\" ").lower()) else None


def _marks(name: str, lines: list[str], decimal: str | None) -> tuple[str | None, str]:
    """Return the separator of a file (None for blanks) and its decimal sign, from its last lines with digits.

    With them most lines are numbers; of several the first tried counts. A `decimal` that is given is kept. Raises
    InvalidInput where both readings of a sign fit.
    """
    sample = [line for line in lines if re.search(r"\d", line)][-80:]
    best: tuple[int, str | None, str, list[list[str]]] = (0, None, ".", [])
    for separator in (";", "\t", ", ", ",", None):
        rows = [_cells(line, separator) for line in sample]
        has_comma = any("," in cell for row in rows for cell in row)
        signs = (",", ".") if has_comma else (".",)
        for sign in (decimal,) if decimal else signs:
            good = sum(all(_value(cell, sign) is not None for cell in row) for row in rows)
            if good > best[0] and (separator is None or any(separator in line for line in sample)):
                best = good, separator, sign, rows
    _, separator, sign, rows = best
    cells = [cell for row in rows for cell in row]
    remedy = 'give decimal = "," or decimal = "."'
    if separator == "," and not any("." in cell or "," in cell for cell in cells) and decimal != ".":
        second = [cell for row in rows for cell in row[1::2]]
        is_pair = all(len(row) % 2 == 0 for row in rows) and all(map(str.isdigit, second))
        # decimals of one column, or of more where some begin with 0; positions at even steps begin lines of a trace
        is_single = is_pair and len(rows[0]) == 2 and not _has_even_steps([_value(row[0], ".") or 0.0 for row in rows])
        if is_single and decimal == ",":
            return None, ","
        if is_single or (is_pair and len(rows[0]) > 2 and any(re.match(r"0\d", cell) for cell in second)):
            raise InvalidInput(
                f"path is {name!r}, in which {rows[0][0] + ',' + rows[0][1]!r} is two numbers or one with a decimal "
                f"comma: {remedy}, or separate numbers by semicolons."
            )
    for mark, what in ((",", "comma"), (".", "point")):
        marked = [cell for cell in cells if mark in cell]
        if decimal or not marked or not all(map(GROUPED[mark].fullmatch, marked)):
            continue
        is_mixed = any(
            len({mark in cell for cell in column if cell.strip("+-").isdigit() or mark in cell}) > 1
            for column in zip_longest(*rows, fillvalue="")
        )
        if is_mixed and (mark == "." or sign == ",") and not any({",": ".", ".": ","}[mark] in cell for cell in cells):
            raise InvalidInput(
                f"path is {name!r}, in which {marked[0]!r} has a decimal {what} or one between thousands: {remedy}."
            )
    return separator, sign


def _has_even_steps(positions: list[float]) -> bool:
    """Return whether steps between two or more `positions` differ by less than a fifth of their mean."""
    steps = np.diff(positions)
    return len(steps) > 0 and bool(np.ptp(steps) < 0.2 * abs(steps.mean()))
