"""Checks of user input; the message of each error is one sentence."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import fields
from difflib import get_close_matches
from numbers import Integral, Real
from typing import Any


class InvalidInput(ValueError):
    """Error for a value that cannot be used; the message names the field, the value and the remedy."""


class UnknownField(InvalidInput, TypeError):
    """Error for a keyword that a constructor does not have; the message names the most similar one."""


class NotDefined(InvalidInput):
    """Error for a quantity that this contact does not have, such as the Hertz half-width of a flat body.

    The input is admissible; the message says what the contact lacks.
    """


def called(cls: type) -> str:
    """Return the name of a class in messages on its fields: its own, or that by which users give the fields."""
    return getattr(cls, "called", cls.__name__)


def refuse_unknown(cls: type, named: Iterable[str]) -> None:
    """Raise :class:`UnknownField` for a name that is no parameter of a dataclass, with the most similar one."""
    names = parameters(cls)
    for name in named:
        if name not in names:
            raise UnknownField(f"{called(cls)}.{name} is not known: {suggestion(name, names)}.")


def parameters(cls: Any) -> list[str]:
    """Return the names of the parameters of a dataclass."""
    return [field.name for field in fields(cls) if field.init]


def checked_relative_error(field: str, value: object) -> float:
    """Return a relative error above 0 and below 1, given as a number or as a text such as ``"1 %"``."""
    remedy = "give a relative error above 0 and below 1, such as 1e-2 or '1 %'"
    number = value
    if isinstance(value, str):
        text = value.strip()
        try:
            number = float(text.removesuffix("%")) / (100 if text.endswith("%") else 1)
        except ValueError:
            raise InvalidInput(f"{field} is {value!r}: {remedy}.") from None
    if positive(field, number, remedy) >= 1:
        raise InvalidInput(f"{field} is {value!r}: {remedy}.")
    return float(number)  # type: ignore[arg-type]


def checked_errors(field: str, value: object) -> float | dict[str, float]:
    """Return a relative error, or those of the numbers that are named, as a table or a text ``"name = 2 %, ..."``."""
    if isinstance(value, str) and "=" in value:
        parts = (part.partition("=") for part in value.split(","))
        value = {name.strip(): error for name, _, error in parts}
    if not isinstance(value, Mapping):
        return checked_relative_error(field, value)
    if not value:
        raise InvalidInput(f"{field} is empty: give an error, or some by the names of numbers.")
    return {name: checked_relative_error(f"{field}[{name!r}]", one) for name, one in value.items()}


def finite(field: str, value: object, remedy: str) -> float:
    """Return `value` as a finite float, or raise :class:`InvalidInput` with `field` and `remedy`."""
    if isinstance(value, bool) or not isinstance(value, Real):
        raise InvalidInput(f"{field} is {value!r}: {remedy}.")
    try:
        number = float(value)
    except OverflowError:  # an int beyond any float
        number = math.inf
    if not math.isfinite(number):
        raise InvalidInput(f"{field} is {value!r}: {remedy}.")
    return number


def positive(field: str, value: object, remedy: str) -> float:
    """Return `value` as a finite float above zero, or raise :class:`InvalidInput` with `field` and `remedy`."""
    number = finite(field, value, remedy)
    if number <= 0:
        raise InvalidInput(f"{field} is {value!r}: {remedy}.")
    return number


def whole_number(
    field: str, value: object, at_least: int, remedy: str, at_most: float = math.inf
) -> int:
    """Return `value` as an int within the limits, or raise :class:`InvalidInput` with `field` and `remedy`."""
    if isinstance(value, bool) or not isinstance(value, Integral):
        raise InvalidInput(f"{field} is {value!r}: {remedy}.")
    if not at_least <= int(value) <= at_most:
        raise InvalidInput(f"{field} is {value!r}: {remedy}.")
    return int(value)


def instance(field: str, value: object, kind: Any, remedy: str) -> None:
    """Raise :class:`InvalidInput` unless `value` is an instance of `kind`, which may be a protocol."""
    if isinstance(value, type) or not isinstance(value, kind):
        raise InvalidInput(f"{field} is {value!r}: {remedy}.")


def whole_quotient(field: str, length: float, period: float) -> int:
    """Return ``period / length``, which must be a whole number, or raise :class:`InvalidInput`."""
    times = period / length
    if abs(times - round(times)) > 1e-9 * max(times, 1):
        raise InvalidInput(
            f"{field} is {length!r}: give a length that divides the period {period!r} m, or change the period."
        )
    return round(times)


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
