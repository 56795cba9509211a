"""What a notebook shows of a value: a few rows in a fixed-width font."""

from collections.abc import Mapping
from dataclasses import Field, fields, is_dataclass
from enum import Enum
from html import escape
from typing import Any

import numpy as np

from contactstudy.domain.checks import is_default

# Letters of a value in a row, and rows of a field that holds several.
WIDTH, ROWS = 90, 6


class InNotebook:
    """Value that a notebook shows as a few rows, by default the fields of a dataclass that are not at their default."""

    def _rows(self) -> str:
        entries = [entry for field in _given(self) for entry in _entries(self, field)]
        width = max((len(name) for name, _ in entries), default=0)
        return "\n".join((type(self).__name__, *(f"  {name:<{width}}  {text}" for name, text in entries)))

    def _repr_html_(self) -> str:
        return f"<pre style='font-family: monospace'>{escape(self._rows())}</pre>"


def _given(value: Any) -> list[Field[Any]]:
    """Return the fields of a dataclass that are shown: those that are not functions and not at their default."""
    return [
        field
        for field in fields(value)
        if field.repr and not callable(entry := getattr(value, field.name)) and not is_default(field, entry)
    ]


def _entries(value: Any, field: Field[Any]) -> list[tuple[str, str]]:
    """Return names and texts of the rows of a field: one of each of the first entries of a tuple."""
    entry = getattr(value, field.name)
    if isinstance(entry, InNotebook):
        return [row for inner in _given(entry) for row in _entries(entry, inner)]
    if not isinstance(entry, tuple) or all(isinstance(part, int | float) for part in entry):
        return [(field.name, _short(_text(entry)))]
    shown = [(f"{field.name}[{n}]", _short(_text(part))) for n, part in enumerate(entry[:ROWS])]
    return shown + [("", f"... {len(entry)} in all")] * (len(entry) > ROWS)


def _short(text: str) -> str:
    line = " ".join(text.split())
    return line if len(line) <= WIDTH else f"{line[: WIDTH - 4]} ..."


def _text(value: object) -> str:
    """Return a value in short: fields that differ from their defaults, arrays by their shapes."""
    if is_dataclass(value) and not isinstance(value, type):
        given = (f"{field.name}={_text(getattr(value, field.name))}" for field in _given(value))
        return f"{type(value).__name__}({', '.join(given)})"
    if isinstance(value, Enum):
        return value.name
    if isinstance(value, np.ndarray):
        return f"array {' x '.join(map(str, value.shape))}"
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, tuple | list):
        return f"({', '.join(map(_text, value))})"
    if isinstance(value, Mapping):
        return ", ".join(f"{name}: {_text(entry)}" for name, entry in value.items())
    return str(value)
