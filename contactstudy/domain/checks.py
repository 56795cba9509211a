"""Checks of user input; the message of each error is one sentence."""

from collections.abc import Iterable
from dataclasses import MISSING, Field, fields
from difflib import get_close_matches
from typing import Any


class InvalidInput(ValueError):
    """Error for a value that cannot be used; the message names the field, the value and the remedy."""


class UnknownField(InvalidInput, TypeError):
    """Error for a keyword that a constructor does not have; the message names the most similar one."""


class NotDefined(InvalidInput):
    """Error for a quantity that this contact does not have, such as the Hertz half-width of a flat body.

    The input is admissible; the message says what the contact lacks.
    """


def parameters(cls: Any) -> list[str]:
    """Return the names of the parameters of a dataclass."""
    return [field.name for field in fields(cls) if field.init]


def is_default(field: Field[Any], value: object) -> bool:
    """Return whether the value of a field of a dataclass is its default; False of an array."""
    default = field.default if field.default_factory is MISSING else field.default_factory()
    return default is not MISSING and not getattr(value, "ndim", 0) and bool(value == default)


def set_fields(instance: object, **values: object) -> None:
    """Replace values of a frozen dataclass by checked ones, in its ``__post_init__``."""
    for name, value in values.items():
        object.__setattr__(instance, name, value)


def suggestion(name: str, known: Iterable[str]) -> str:
    """Return a suggestion for an unknown `name`: a `known` one that begins so, the most similar one, or all of them."""
    choices = list(known)
    begun = [choice for choice in choices if len(name) > 3 and choice.startswith(name)]
    close = begun or get_close_matches(name, choices, n=1)
    return f"did you mean {close[0]!r}" if close else "choose from " + ", ".join(choices)
