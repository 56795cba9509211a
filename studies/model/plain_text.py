"""Text that a terminal, JSON and netCDF can hold, and the place in a study's code where an error was raised."""

import re
import sysconfig
import traceback
import unicodedata
from collections.abc import Callable
from functools import cache, lru_cache
from pathlib import Path
from typing import SupportsInt

Log = Callable[[str], object]  # takes a message of a run
LONGEST = 2000  # characters of an error or a title
# control characters without tab and line feed, and lone surrogates
_CONTROL = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\ud800-\udfff]")


def two_digits(number: float) -> str:
    """Return a number with two significant digits and without an exponent up to a million, such as "120"."""
    return f"{float(f'{number:.2g}'):g}"


def one_line(text: object, longest: int = LONGEST) -> str:
    """Return `text` in one line of at most `longest` characters, with control characters escaped."""
    try:
        raw = str(text)
    except Exception as error:  # noqa: BLE001 (an error whose own __str__ raises)
        return f"(no text: its __str__ raises {type(error).__name__})"
    raw, is_cut = raw[:longest], len(raw) > longest
    shown = _CONTROL.sub(lambda match: ascii(match[0])[1:-1], re.sub(r"\s*[\n\r\t]\s*", " ", raw))
    return shown + (" ..." if is_cut else "")


def shortened(value: object) -> str:
    """Return the representation of any object in one line of at most 60 characters."""
    try:
        shown = repr(value)
    except Exception:  # noqa: BLE001 (any object may come here; a whole number may be too long to be written)
        shown = f"an object of {type(value).__name__}"
    return one_line(shown, 60)


def quoted(path: object) -> str:
    """Return a path in quotes, cut off after 100 characters."""
    return repr(one_line(path, 100))


def is_storable(text: str) -> bool:
    """Return whether netCDF returns `text` unchanged, and a terminal shows it as text."""
    return _CONTROL.search(text) is None


@lru_cache(4096)
def name_problem(name: object) -> str:
    """Return why netCDF cannot hold a variable, dimension or attribute with the name `name`; empty if it can."""
    is_plain = (
        isinstance(name, str)
        and (name[:1].isalnum() or name[:1] == "_" or ord(name[:1] or " ") > 127)
        and name == name.strip()
        and name.isprintable()
        and "/" not in name  # which is for a group
        and unicodedata.normalize("NFC", name) == name  # netCDF composes accents
        and len(name.encode()) <= 250
    )
    return (
        ""
        if is_plain
        else (
            "give a name of at most 250 bytes that begins with a letter, a digit or an underscore, without '/', with "
            "printable characters only and accents in the composed form (NFC)"
        )
    )


def counted(number: SupportsInt, one: str, several: str = "") -> str:
    """Return a number with a noun for `one` thing or `several`, by default with an s, such as "2 threads"."""
    return f"{int(number)} {one if int(number) == 1 else several or f'{one}s'}"


def place_of(error: BaseException, *libraries: str) -> str:
    """Return the innermost place of an error outside libraries, as `` in function (file, line n)``; empty without one.

    The files `libraries` count as libraries too.
    """
    frames = traceback.extract_tb(error.__traceback__, limit=-50)
    study = [frame for frame in frames if not frame.filename.startswith((*_libraries(), *libraries))]
    if not study:
        return ""
    innermost = study[-1]
    return one_line(f" in {innermost.name} ({Path(innermost.filename).name}, line {innermost.lineno})", 300)


@cache
def _libraries() -> tuple[str, ...]:
    """Return the folders of installed libraries."""
    paths = sysconfig.get_paths()
    return paths["stdlib"], paths["purelib"], paths["platlib"], "<"
