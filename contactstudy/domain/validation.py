"""Checks of user input, each with a message of one sentence: types, limits, quantities in SI units or with a unit.

A class made by :func:`validated` says in the annotation of each field what the field accepts: its type, and in
``Annotated`` its :class:`Unit` and its :class:`Limits`. :func:`valid` checks a value by an annotation, and
:func:`remedy` says in words what an annotation accepts. Numbers are in SI units; a text such as "10 mm" is converted.
"""

import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import MISSING, Field, dataclass, field, fields
from decimal import Decimal
from difflib import get_close_matches
from functools import cache, wraps
from importlib import import_module
from math import inf
from numbers import Integral, Real
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, TypeVar, Union, dataclass_transform, get_args, get_origin, get_type_hints

import numpy as np
from numpy.typing import ArrayLike

from contactstudy.domain.imports import import_for

# A list of numbers in brackets: its first 40 to 60 characters up to a comma, and its closing bracket.
LONG_LIST = re.compile(r"([(\[][-+.,:e\s\dnaif]{40,60}?, )[-+.,:e\s\dnaif]{20,}([)\]])")


class InvalidInput(ValueError):
    """Error for a value that cannot be used; the message names the field, the value and the remedy.

    Of a long list of numbers in it the first ones are kept.
    """

    def __init__(self, message: str = "") -> None:
        super().__init__(LONG_LIST.sub(r"\1...\2", message))


class UnknownField(InvalidInput, TypeError):
    """Error for a keyword that a constructor does not have; the message names the most similar one."""


class NotDefined(InvalidInput):
    """Error for a quantity that this contact does not have, such as the Hertz half-width of a flat body.

    The input is admissible; the message says what the contact lacks.
    """


def parameters(cls: Any) -> list[str]:
    """Return the names of the fields of a dataclass that its constructor takes."""
    return [member.name for member in fields(cls) if member.init]


def is_default(field: Field[Any], value: object) -> bool:
    """Return whether the value of a field of a dataclass is its default; False of an array."""
    default = field.default if field.default_factory is MISSING else field.default_factory()
    return default is not MISSING and not getattr(value, "ndim", 0) and bool(value == default)


def set_fields(instance: object, **values: object) -> None:
    """Replace fields of a frozen dataclass by checked values, while it is constructed."""
    for name, value in values.items():
        object.__setattr__(instance, name, value)


def shortened(value: object) -> str:
    """Return a value in a message: as Python writes it, and up to 60 characters of it."""
    text = " ".join(repr(value).split())
    return text if len(text) <= 60 else text[:57] + "..."


def suggestion(name: str, known: Iterable[str]) -> str:
    """Return a suggestion for an unknown `name`: a `known` one that begins so, the most similar one, or all of them."""
    choices = list(known)
    begun = [choice for choice in choices if len(name) > 3 and choice.startswith(name)]
    close = begun or get_close_matches(name, choices, n=1)
    return f"did you mean {close[0]!r}" if close else "choose from " + ", ".join(choices)


@dataclass(frozen=True)
class Unit:
    """Unit of a number, with what messages say of the quantity.

    Attributes
    ----------
    symbol
        Symbol of the SI unit, empty for a number without one.
    quantity
        Name of the quantity, with its article.
    example
        Value of it as a user may write it.
    """

    symbol: str
    quantity: str
    example: str


Metres = Annotated[float, Unit("m", "a length", "10 mm")]
Pascals = Annotated[float, Unit("Pa", "a pressure", "1.2 GPa")]
HARDNESS = Unit("Pa", "a hardness", "700 HV")
Hardness = Annotated[float, HARDNESS]
NewtonsPerMetre = Annotated[float, Unit("N/m", "a load per length", "100 N/mm")]
JoulesPerSquareMetre = Annotated[float, Unit("J/m^2", "a work per area", "50 mJ/m^2")]
Newtons = Annotated[float, Unit("N", "a load", "2 kN")]
Spin = Annotated[float, Unit("1/m", "a spin", "0.5 1/m")]
SpecificWearRate = Annotated[float, Unit("1/Pa", "a specific wear rate", "1e-6 mm3/(N m)")]
Compressibility = Annotated[float, Unit("1/Pa", "a compressibility", "0.6 1/GPa")]
PressureViscosity = Annotated[float, Unit("1/Pa", "a pressure-viscosity coefficient", "20 1/GPa")]
ThermalConductivity = Annotated[float, Unit("W/(m*K)", "a thermal conductivity", "46 W/(m*K)")]
VolumetricHeatCapacity = Annotated[float, Unit("J/(m^3*K)", "a volumetric heat capacity", "3.6 MJ/(m^3*K)")]
Kelvins = Annotated[float, Unit("K", "a temperature", "333 K")]
TemperatureCoefficient = Annotated[float, Unit("1/K", "a temperature coefficient", "0.04 1/K")]
PascalSeconds = Annotated[float, Unit("Pa*s", "a viscosity", "40 mPa*s")]
MetresPerSecond = Annotated[float, Unit("m/s", "a speed", "100 mm/s")]
Seconds = Annotated[float, Unit("s", "a time", "2 min")]
Frequency = Annotated[float, Unit("Hz", "a frequency", "50 Hz")]
Radians = Annotated[float, Unit("rad", "an angle", "1 degree")]
Number = Annotated[float, Unit("", "a number", "0.3")]

# Units for display, each with its size in SI units, by the SI unit as files name it. They are tried in this order, the
# largest first, but 1/GPa, of coefficients of oils, before 1/Pa, of wear rates.
DISPLAY_UNITS: Mapping[str, tuple[tuple[float, str], ...]] = {
    "Pa": ((1e9, "GPa"), (1e6, "MPa"), (1e3, "kPa"), (1.0, "Pa")),
    "m": ((1.0, "m"), (1e-3, "mm"), (1e-6, "µm"), (1e-9, "nm")),
    "m2": ((1.0, "m²"), (1e-6, "mm²"), (1e-12, "µm²")),
    "m3": ((1.0, "m³"), (1e-9, "mm³"), (1e-18, "µm³")),
    "m2 m-1": ((1e-3, "mm²/mm"),),
    "m3 m-1": ((1e-6, "mm³/mm"), (1e-15, "µm³/mm")),
    "N": ((1e3, "kN"), (1.0, "N")),
    "N m-1": ((1e3, "N/mm"), (1.0, "N/m")),
    "N m-2": ((1e6, "N/mm per mm"),),
    "W": ((1e3, "kW"), (1.0, "W"), (1e-3, "mW")),
    "W m-1": ((1.0, "W/m"),),
    "J m-1": ((1.0, "J/m"), (1e-3, "mJ/m"), (1e-6, "µJ/m"), (1e-9, "nJ/m")),
    "1/Pa": ((1e-9, "1/GPa"), (1.0, "1/Pa")),
    "rad": ((1.0, "rad"), (1e-3, "mrad")),
    "1": ((1.0, ""),),
}


def display_unit(largest: float, unit: str) -> tuple[float, str]:
    """Return size and name of the unit for display of numbers up to `largest`, in the SI unit `unit`.

    It is the largest one in which that number is at least 1, an area at least 1e-3 and a volume at least 1e-4.
    """
    scales = DISPLAY_UNITS.get(unit, ((1.0, unit),))
    # successive units of areas and volumes differ by 1e6, 1e9 and more
    least = {"m2": 1e-3, "m3": 1e-4}.get(unit[:2], 1.0)
    return next((scale for scale in scales if abs(largest) >= least * scale[0]), scales[-1])


def display_unit_of(values: ArrayLike, unit: str) -> tuple[float, str]:
    """Return size and name of the unit for display of the largest finite number of `values`, in the SI unit `unit`."""
    sizes = np.abs(np.asarray(values))
    return display_unit(float(np.max(sizes, where=np.isfinite(sizes), initial=0.0)), unit)


def readable(value: float, unit: str = "m", digits: int = 4) -> str:
    """Return a value as text in a unit with few digits, such as ``"0.5 GPa"``, by default a length."""
    size, name = display_unit(value, unit)
    return f"{value / size + 0.0:.{digits}g} {name}".strip()  # without the sign of -0.0


def whole_quotient(field: str, length: float, period: float) -> int:
    """Return how often a `length` [m], which messages call `field`, fits into the `period` [m] of a grid.

    Raises :class:`InvalidInput` unless that is a whole number, but for rounding.
    """
    times = period / length
    if abs(times - round(times)) > 1e-9 * max(times, 1):
        raise InvalidInput(
            f"{field} is {readable(length, digits=10)}, and the grid's {readable(period, digits=10)} is no multiple of "
            "it: give a multiple of it in grid.extent or plan.period, or another length."
        )
    return round(times)


# SI units with decimal prefixes, which occur most: a table reads them faster than pint, whose import is slow.
# Power of ten of each prefix. The micro sign and the Greek letter mu, two characters, both stand for micro.
PREFIXES = {"G": 9, "M": 6, "k": 3, "": 0, "c": -2, "m": -3, "u": -6, "µ": -6, "μ": -6, "n": -9}
# Powers of metre, kilogram, second and kelvin in each unit.
UNITS = {
    "m": (1, 0, 0, 0), "s": (0, 0, 1, 0), "K": (0, 0, 0, 1), "rad": (0, 0, 0, 0), "Hz": (0, 0, -1, 0),
    "N": (1, 1, -2, 0), "Pa": (-1, 1, -2, 0), "J": (2, 1, -2, 0), "W": (2, 1, -3, 0),
}  # fmt: skip
# Powers of ten, metre, kilogram, second and kelvin of every prefix and unit together.
KNOWN: Mapping[str, tuple[int, ...]] = {"": (0, 0, 0, 0, 0), "1": (0, 0, 0, 0, 0)} | {
    prefix + unit: (power, *powers) for prefix, power in PREFIXES.items() for unit, powers in UNITS.items()
}
# A text of a number, the first group, and what stands behind it, the second.
NUMBER = re.compile(r"\s*([-+]?(?:inf|(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?))\s*(.*?)\s*")
# What stands between a number and its tolerance.
PLUS_MINUS = re.compile(r"\s*(?:\+/?-|±)\s*")
# A number with its tolerance in brackets, and their unit behind them.
IN_BRACKETS = re.compile(r"^\(([^()]*)\)(.*)")
# Patterns of powers and products that lack a sign, and how units write them: m3 is m^3, Pas is Pa*s.
REPLACED = (
    (r"²", "^2"), (r"³", "^3"), (r"([mM])([23])(?![\d])", r"\1^\2"), (r"\b(m?)Pas\b", r"\1Pa*s"), (r"\bNm\b", "N*m"),
    (r"^°$", "degree"),
)  # fmt: skip
# Rockwell C and the Vickers hardness of steels [kgf/mm^2] that goes with it (ISO 18265:2013, table A.1; ASTM E140).
ROCKWELL = (
    (20, 238), (25, 266), (30, 302), (35, 345), (40, 392), (45, 446), (50, 513), (55, 595), (58, 653), (60, 697),
    (62, 746), (64, 800), (66, 865), (68, 940),
)  # fmt: skip
VICKERS = 9.80665e6  # [Pa], a kgf/mm^2, in which Vickers hardness counts
# Units: names, powers, products, quotients also of 1 and by products in brackets, and no other expressions.
POWER = r"°?[^\W\d_]+\d?(?:\s*(?:\*\*|\^)\s*-?\d)?"
FACTOR = rf"(?:{POWER}|\(\s*{POWER}(?:\s*[*·]\s*{POWER}|\s+{POWER})*\s*\))"
SYMBOLS = re.compile(rf"(?:1\s*/\s*)?{FACTOR}(?:\s*[*/·]\s*{FACTOR}|\s+{POWER})*")


def in_si(field: str, text: str, unit: Unit) -> float:
    """Return the number of a `text` with a unit in the SI unit `unit`, without its tolerance.

    Raises :class:`~contactstudy.InvalidInput`, which names `field`, for any other text and for a unit of another
    quantity.
    """
    value = text
    if PLUS_MINUS.search(text):
        number, symbol, _ = parted(field, text)
        value = f"{number} {symbol}"
    refused = InvalidInput(f"{field} is {value!r}: {remedy_of(unit)}{', with a decimal point' * (',' in value)}.")
    match = NUMBER.fullmatch(_usual(value))
    if match and unit == HARDNESS and match[2] in ("HV", "HRC"):
        return _of_hardness(field, value, float(match[1]), match[2])
    if match and match[2] == "%" and not unit.symbol:
        return float(Decimal(match[1]) / 100)
    if match is None or (match[2] and not SYMBOLS.fullmatch(match[2])):
        raise refused
    if not match[2] and match[1].endswith("inf"):  # infinite in any unit
        return float(match[1])
    source, target = decimal_unit(match[2]), decimal_unit(unit.symbol)
    is_angular = unit.symbol == "Hz" and "rad" in match[2]  # rad/s, of which 2 pi are 1 Hz
    if source is not None and target is not None and not is_angular:
        if source[1:] == target[1:]:
            with suppress(ArithmeticError):
                return float(Decimal(match[1]).scaleb(source[0] - target[0]))
        raise refused
    pint = import_for("a unit", "pint")  # slow to import, and needed only here
    registry = _registry()
    try:
        parsed = registry.Quantity(Decimal(match[1]), registry.parse_units(match[2].replace("·", "*")))
        if unit.symbol == "Hz" and "radian" in dict(parsed.to_root_units().unit_items()):
            parsed /= registry.turn  # cycles per second, as of rpm
        return float(parsed.to(unit.symbol).magnitude)
    except (pint.PintError, ArithmeticError, LookupError, ValueError, TypeError, AttributeError) as error:
        raise refused from error


def parted(field: str, text: str) -> tuple[str, str, float | None]:
    """Return number and unit of a text, and in this unit the tolerance behind it; None of a text without one.

    A tolerance has the unit of its number, another one of the same quantity, or is in per cent of the number, such as
    ``10 mm +- 0.05 mm``, ``10 mm +- 50 um`` or ``10 mm ± 1 %``. A unit at the end alone is that of both: ``10 +- 0.05
    mm``, ``(10 ± 0.05) mm``.

    Raises
    ------
    InvalidInput
        For a text without a number, and for a tolerance that is not a number of at least 0.
    """
    first, *others = PLUS_MINUS.split(IN_BRACKETS.sub(r"\1 \2", text.strip()))
    match, tolerance = NUMBER.fullmatch(first), NUMBER.fullmatch(others[0] if others else "0")
    if match is None or tolerance is None or len(others) > 1 or not 0 <= float(tolerance[1]) < inf:
        raise InvalidInput(
            f"{field} is {text!r}: give a number, and behind it one tolerance of at least 0, such as '10 mm +- 0.05 mm'."
        )
    number, unit = match.groups()
    if not others:
        return number, unit, None
    size, symbol = tolerance.groups()
    unit = unit or symbol.replace("%", "")
    if symbol in ("", unit):
        return number, unit, float(size)
    if symbol == "%":
        return number, unit, abs(float(number)) * float(size) / 100
    of_number = Unit(unit, "a tolerance in the unit of its number", f"{size} {unit}")
    return number, unit, in_si(f"The tolerance of {field}", others[0], of_number)


def _usual(text: str) -> str:
    """Return a `text` of a number and a unit with powers and products written out, ``mm^3/(N*m)`` for ``mm3/Nm``."""
    number, unit = (match[1], match[2]) if (match := NUMBER.fullmatch(text)) else (text, "")
    for pattern, replacement in REPLACED:
        unit = re.sub(pattern, replacement, unit)
    # what stands behind a stroke as one word is divided by as a whole
    return f"{number} {re.sub(r'/N[*]m$', '/(N*m)', unit) if '*' not in text else unit}".strip()


def _of_hardness(field: str, value: object, number: float, scale: str) -> float:
    """Return the indentation hardness [Pa] of a `number` on the `scale` "HV" (Vickers) or, of steel, "HRC" (Rockwell C).

    `field` and `value` are named in the message about a number beyond the scale.
    """
    if scale == "HRC":
        rockwell, vickers = zip(*ROCKWELL, strict=True)
        if not rockwell[0] <= number <= rockwell[-1]:
            raise InvalidInput(
                f"{field} is {value!r}: give {rockwell[0]} to {rockwell[-1]} HRC, or the hardness in HV."
            )
        number = float(np.interp(number, rockwell, vickers))
    return number * VICKERS


def remedy_of(unit: Unit, limits: str = "") -> str:
    """Return what to give in place of a value that is not of `unit`, or not within the `limits`."""
    if not unit.symbol and limits:  # the example need not lie within them
        return f"give {unit.quantity}{limits}"
    number = f", or a number in {unit.symbol}" * bool(unit.symbol)
    return f"give {unit.quantity}{limits}, such as {unit.example!r}{number}"


@cache
def _registry() -> Any:
    """Return pint's units, which compute in decimals, so that 30 um is exactly the float 3e-5 m."""
    from pint import UnitRegistry

    return UnitRegistry(non_int_type=Decimal)


@cache
def decimal_unit(symbol: str) -> tuple[int, ...] | None:
    """Return the powers of ten, metre, kilogram, second and kelvin of a unit such as ``N/mm``; None for other units."""
    factors = re.split(r"\s*([*/])\s*", symbol.replace("**", "^").replace("·", "*"))
    total = KNOWN[""]
    for sign, factor in zip(("*", *factors[1::2]), factors[::2], strict=True):
        name, _, exponent = factor.partition("^")
        if name.strip() not in KNOWN:
            return None
        times = int(exponent or 1) * (1 if sign == "*" else -1)
        total = tuple(power + times * own for power, own in zip(total, KNOWN[name.strip()], strict=True))
    return total


Class = TypeVar("Class", bound=type)


@dataclass(frozen=True)
class Limits:
    """Limits of a number. A number with a unit is above 0 where no others are given.

    Attributes
    ----------
    text
        Words of a message, behind "a number", or of a whole number in place of it if they begin with a digit.
    hold
        Function that returns whether a number lies within them.
    """

    text: str
    hold: Callable[[float], bool] = field(repr=False)


@dataclass(frozen=True)
class Example:
    """Example of a value, in Python, for messages about a field whose type alone does not say what it holds."""

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
# Limits of a number without a unit, unless it has others.
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
        for name in named:
            if name not in (names := parameters(made)):
                raise UnknownField(f"{called(made)}.{name} is not known: {suggestion(name, names)}.")
        construct(self, *values, **named)
        for member in fields(made):
            value = getattr(self, member.name, None)
            if member.init and not (value is None and member.default is None):
                value = valid(f"{called(made)}.{member.name}", value, hint_of(made, member.name))
                object.__setattr__(self, member.name, value)
        getattr(self, "check_together", lambda: None)()

    made.__init__ = __init__
    return made  # type: ignore[no-any-return]


def called(cls: type) -> str:
    """Return the name of a class in messages on its fields: its own, or that by which users give the fields."""
    return getattr(cls, "called", cls.__name__)


@cache
def hint_of(cls: type, name: str) -> Any:
    """Return the annotation of the field `name` of a class.

    A class in it that the module imports for type checkers alone is a public one of its package, and is imported here:
    a field that nothing is given for costs no import.
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
    if origin is Mapping:  # no field has another table than one of errors
        return checked_errors(name, value)
    if origin is Literal:
        if not isinstance(value, str) or value not in options:
            raise InvalidInput(f"{name} is {shortened(value)}: {suggestion(str(value), options)}.")
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
    raise InvalidInput(f"{name} is {shortened(value)}: {remedy(hint)}{_sizes(value)}.")


def checked_errors(field: str, value: object) -> float | dict[str, float]:
    """Return a relative error, or errors by the names of numbers, in a table or a text ``"name = 2 %, other = 1 %"``.

    Raises :class:`InvalidInput`, which names the `field`, for errors that are not above 0 and below 1.
    """
    if isinstance(value, str) and "=" in value:
        parts = (part.partition("=") for part in value.split(","))
        named = [(name.strip(), error.strip()) for name, _, error in parts]
        if twice := [name for name, count in Counter(name for name, _ in named).items() if count > 1]:
            raise InvalidInput(f"{field} names {twice[0]} twice: give one error of it.")
        value = dict(named)
    if not isinstance(value, Mapping):
        return float(valid(field, value, RelativeError))
    if not value:
        raise InvalidInput(f"{field} is empty: give an error, or some by the names of numbers.")
    return {name: valid(f"{field}[{name!r}]", error, RelativeError) for name, error in value.items()}


def _sizes(value: object) -> str:
    """Return words on the limits of all sizes for a number beyond them, else an empty text."""
    number = _float(value)
    is_size = not number or MIN_SIZE <= abs(number) <= MAX_SIZE or abs(number) == inf
    return "" if is_size or number != number else f", between {MIN_SIZE:g} and {MAX_SIZE:g}"


def _one_of(name: str, value: Any, hint: Any) -> Any:
    """Return `value` as the first of the annotations that it fits, of a union of them.

    Where it fits none, the error is that of the first it was meant for: a text for a unit, several values for a tuple.
    """
    refused: InvalidInput | None = None
    for option in get_args(hint):
        try:
            return valid(name, value, option)
        except InvalidInput as error:
            is_meant = isinstance(value, str) and notes(option)[0] is not None
            is_several = isinstance(value, tuple | list | Mapping) or getattr(value, "ndim", 0) > 0
            if is_meant or (is_several and get_origin(option) in (tuple, Mapping)):
                refused = refused or error
    raise refused or InvalidInput(f"{name} is {shortened(value)}: {remedy(hint)}{_sizes(value)}.")


def _entries(name: str, value: Any, options: tuple[Any, ...], hint: Any) -> tuple[Any, ...]:
    """Return a tuple, a list or a flat array as a tuple of valid entries: of one kind, or one for each."""
    if getattr(value, "ndim", None) == 1 and hasattr(value, "tolist"):
        value = value.tolist()
    any_number = options[-1] is ...
    if not isinstance(value, tuple | list) or not (any_number or len(value) == len(options)):
        raise InvalidInput(f"{name} is {shortened(value)}: {remedy(hint)}.")
    kinds = [options[0]] * len(value) if any_number else options
    pairs = enumerate(zip(value, kinds, strict=True))
    return tuple(valid(f"{name}[{n}]", entry, kind) for n, (entry, kind) in pairs)


def kind_of(hint: Any) -> Any:
    """Return the type that an annotation is about, without its unit and limits."""
    return get_args(hint)[0] if get_origin(hint) is Annotated else hint


def notes(hint: Any) -> tuple[Unit | None, Limits]:
    """Return the unit of an annotation, None without one, and its limits, by default those of its kind of number."""
    marks = getattr(hint, "__metadata__", ())
    unit = next((note for note in marks if isinstance(note, Unit)), None)
    default = FINITE if unit is None else ABOVE_ZERO
    return unit, next((note for note in marks if isinstance(note, Limits)), default)


def _is(value: object, kind: Any) -> bool:
    """Return whether a value is of a kind of numbers, of which True and False are none."""
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
        yield f"[{', '.join(entries)}{', ...' * (options[-1] is ...)}]"
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
        yield plain.get(kind, f"{'an' if word[0] in 'AEIOU' else 'a'} {word}") + example
