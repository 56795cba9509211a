"""Frozen dataclasses whose annotations say what a field may be: its unit, limits and kind."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, fields
from functools import cache, wraps
from importlib import import_module
from math import inf
from numbers import Integral, Real
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, TypeVar, Union, dataclass_transform, get_args, get_origin, get_type_hints

from contactstudy.domain.checks import InvalidInput, UnknownField, parameters, suggestion
from contactstudy.domain.units import Unit, in_si, remedy_of

Class = TypeVar("Class", bound=type)


@dataclass(frozen=True)
class Limits:
    """Limits of a number, and how a message says them. A number with a unit is above 0 where no others are given."""

    text: str
    hold: Callable[[float], bool] = field(repr=False)


@dataclass(frozen=True)
class Example:
    """Value of a kind that its name alone does not say, as it is written in Python."""

    text: str


def at_least(least: int) -> Limits:
    """Return the limits of a number that is not below `least`."""
    return Limits(f"of at least {least}", lambda x: least <= x < inf)


# Limits in SI units: wide enough for any measured value, narrow enough that products and quotients stay finite.
MIN_SIZE, MAX_SIZE = 1e-60, 1e60
ABOVE_ZERO = Limits("above 0", lambda x: MIN_SIZE <= x <= MAX_SIZE)
AT_LEAST_ZERO = Limits("of at least 0", lambda x: x == 0 or MIN_SIZE <= x <= MAX_SIZE)
ANY_SIGN = Limits("that is finite", lambda x: x == 0 or MIN_SIZE <= abs(x) <= MAX_SIZE)
OR_INFINITE = Limits("above 0, or inf", lambda x: x == inf or MIN_SIZE <= x <= MAX_SIZE)
FROM_ZERO_TO_INFINITE = Limits("of at least 0, or inf", lambda x: x in (0, inf) or MIN_SIZE <= x <= MAX_SIZE)
CURVED = Limits(
    "above 0 of a convex body, below 0 of a hollow one, inf of a flat",
    lambda x: x == inf or MIN_SIZE <= abs(x) <= MAX_SIZE,
)
UP_TO_ONE = Limits("above 0 and up to 1", lambda x: MIN_SIZE <= x <= 1)
BELOW_ONE = Limits("above 0 and below 1", lambda x: MIN_SIZE <= x < 1)
FROM_ZERO_BELOW_ONE = Limits("of at least 0 and below 1", lambda x: x == 0 or MIN_SIZE <= x < 1)
# Of a number without a unit, unless it has others.
FINITE = Limits("", lambda x: -inf < x < inf)
# Index of a body in Scene.solids.
BodyIndex = Annotated[int, Limits("0 or 1, the body's index in Scene.solids", lambda x: x in (0, 1))]

RelativeError = Annotated[float, Unit("", "a relative error", "1 %"), BELOW_ONE]


@dataclass_transform(frozen_default=True, field_specifiers=(field,))
def validated(cls: Class) -> Class:
    """Make a frozen dataclass whose constructor checks each field by its annotation, and converts texts with a unit.

    It then calls ``check_together``, if the class has it, for what fields must have in common. An unknown keyword raises
    :class:`~contactstudy.InvalidInput` with the most similar field.
    """
    made: Any = dataclass(frozen=True)(cls)
    construct = made.__init__

    @wraps(construct)
    def __init__(self: Any, *values: object, **named: object) -> None:
        _refuse_unknown(made, named)
        construct(self, *values, **named)
        for one in fields(made):
            value = getattr(self, one.name, None)
            if one.init and not (value is None and one.default is None):
                value = valid(f"{called(made)}.{one.name}", value, hint_of(made, one.name))
                object.__setattr__(self, one.name, value)
        getattr(self, "check_together", lambda: None)()

    made.__init__ = __init__
    return made  # type: ignore[no-any-return]


def called(cls: type) -> str:
    """Return the name of a class in messages on its fields: its own, or that by which users give the fields."""
    return getattr(cls, "called", cls.__name__)


def _refuse_unknown(cls: type, named: Iterable[str]) -> None:
    """Raise :class:`UnknownField` for a name that is no parameter of a dataclass, with the most similar one."""
    names = parameters(cls)
    for name in named:
        if name not in names:
            raise UnknownField(f"{called(cls)}.{name} is not known: {suggestion(name, names)}.")


@cache
def hint_of(cls: type, name: str) -> Any:
    """Return the annotation of a field.

    A name that the module of the class imports for type checkers alone is a public one of its package, which is
    imported here: a field that nothing is given for costs no import.
    """
    owner = next(base for base in cls.__mro__ if name in vars(base).get("__annotations__", {}))
    module = import_module(owner.__module__)
    package = import_module(owner.__module__.partition(".")[0])
    one_field = type(name, (), {"__annotations__": {name: vars(owner)["__annotations__"][name]}})
    known = dict(vars(module))
    while True:
        try:
            return get_type_hints(one_field, known, include_extras=True)[name]
        except NameError as unknown:
            missing = str(unknown.name)
            known[missing] = getattr(package, missing)


def valid(name: str, value: Any, hint: Any) -> Any:
    """Return `value` as the annotation `hint` says it; raise :class:`InvalidInput` with `name` and a remedy."""
    origin, options = get_origin(hint), get_args(hint)
    if origin in (Union, UnionType):
        return _one_of(name, value, hint)
    if origin is tuple:
        return _entries(name, value, options, hint)
    if origin is Literal:
        if not isinstance(value, str) or value not in options:
            raise InvalidInput(f"{name} is {value!r}: {suggestion(str(value), options)}.")
        return value
    if hint is Any:
        return value
    kind, unit, limits = kind_of(hint), *notes(hint)
    if kind is float:
        number = _float(in_si(name, value, unit) if isinstance(value, str) and unit else value)
        if number is not None and limits.hold(number):
            return number
    elif kind is int:
        if _is(value, Integral) and limits.hold(value):
            return int(value)
    elif not isinstance(value, type) and isinstance(value, get_origin(kind) or kind):
        return value
    raise InvalidInput(f"{name} is {value!r}: {remedy(hint)}{_sizes(value)}.")


def checked_errors(field: str, value: object) -> float | dict[str, float]:
    """Return a relative error, or those of the numbers that are named, as a table or a text ``"name = 2 %, ..."``."""
    if isinstance(value, str) and "=" in value:
        parts = (part.partition("=") for part in value.split(","))
        value = {name.strip(): error.strip() for name, _, error in parts}
    if not isinstance(value, Mapping):
        return float(valid(field, value, RelativeError))
    if not value:
        raise InvalidInput(f"{field} is empty: give an error, or some by the names of numbers.")
    return {name: valid(f"{field}[{name!r}]", error, RelativeError) for name, error in value.items()}


def _sizes(value: object) -> str:
    """Return the limits of all sizes, for a number that is beyond them."""
    number = _float(value)
    is_size = not number or MIN_SIZE <= abs(number) <= MAX_SIZE or abs(number) == inf
    return "" if is_size or number != number else f", between {MIN_SIZE:g} and {MAX_SIZE:g}"


def _one_of(name: str, value: Any, hint: Any) -> Any:
    """Return `value` as the first of the annotations that it fits, of a union of them."""
    of_its_kind = []
    for option in get_args(hint):
        try:
            return valid(name, value, option)
        except InvalidInput as error:
            is_meant = isinstance(value, str) and notes(option)[0] is not None
            is_several = isinstance(value, tuple | list) or getattr(value, "ndim", 0) > 0
            if is_meant or (is_several and get_origin(option) is tuple):
                of_its_kind.append(error)
    none_fits = InvalidInput(f"{name} is {value!r}: {remedy(hint)}{_sizes(value)}.")
    raise next(iter(of_its_kind), none_fits)


def _entries(name: str, value: Any, options: tuple[Any, ...], hint: Any) -> tuple[Any, ...]:
    """Return a tuple, a list or a flat array as a tuple of valid entries: of one kind, or one for each."""
    if getattr(value, "ndim", None) == 1 and hasattr(value, "tolist"):
        value = value.tolist()
    any_number = options[-1] is ...
    if not isinstance(value, tuple | list) or not (any_number or len(value) == len(options)):
        raise InvalidInput(f"{name} is {value!r}: {remedy(hint)}.")
    kinds = [options[0]] * len(value) if any_number else options
    pairs = enumerate(zip(value, kinds, strict=True))
    return tuple(valid(f"{name}[{n}]", entry, kind) for n, (entry, kind) in pairs)


def kind_of(hint: Any) -> Any:
    """Return the type that an annotation is about, without its unit and limits."""
    return get_args(hint)[0] if get_origin(hint) is Annotated else hint


def notes(hint: Any) -> tuple[Unit | None, Limits]:
    """Return the unit of an annotation, if it has one, and its limits."""
    marks = getattr(hint, "__metadata__", ())
    unit = next((note for note in marks if isinstance(note, Unit)), None)
    default = FINITE if unit is None else ABOVE_ZERO
    return unit, next((note for note in marks if isinstance(note, Limits)), default)


def _is(value: object, kind: Any) -> bool:
    return isinstance(value, kind) and not isinstance(value, bool)


def _float(value: Any) -> float | None:
    """Return a real number as a float, an int beyond any float as infinite; None for what is no number."""
    if not _is(value, Real):
        return None
    try:
        return float(value)
    except OverflowError:
        return inf


def remedy(hint: Any) -> str:
    """Return a sentence, without its subject, on what an annotation accepts."""
    return "give " + ", or ".join(dict.fromkeys(_accepted(hint)))


def _accepted(hint: Any) -> Iterator[str]:
    """Yield what each alternative of an annotation accepts, such as "None" or "a number above 0"."""
    origin, options = get_origin(hint), get_args(hint)
    unit, limits = notes(hint)
    kind = kind_of(hint)
    if origin in (Union, UnionType):
        for option in options:
            yield from _accepted(option)
    elif hint is NoneType:
        yield "None"
    elif origin is Literal:
        yield from map(repr, options)
    elif origin is tuple:
        entries = [next(_accepted(one)).split(", such as")[0] for one in options if one is not ...]
        yield f"({', '.join(entries)}{', ...' * (options[-1] is ...)})"
    elif unit is not None:
        yield remedy_of(unit, f" {limits.text}".rstrip()).removeprefix("give ")
    elif kind is int and limits.text[:1].isdigit():
        yield limits.text
    elif kind in (int, float):
        yield f"a {'whole ' * (kind is int)}number {limits.text}".strip()
    else:
        plain = {str: "a text", bool: "true or false"}
        word = getattr(kind, "__name__", str(kind))
        examples = (one for one in getattr(hint, "__metadata__", ()) if isinstance(one, Example))
        example = next((f", such as {one.text}" for one in examples), "")
        yield plain.get(kind, f"{'an' if word[0] in 'AEIOU' else 'a'} {word}{example}")
