"""Nested tables of a file as frozen dataclasses, and texts with a unit as numbers in SI units."""

import re
from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass
from decimal import Decimal
from enum import Enum
from functools import cache
from types import NoneType, UnionType
from typing import Annotated, Any, TypeVar, Union, get_args, get_origin

import cattrs
from cattrs.errors import ForbiddenExtraKeysError
from cattrs.gen import make_dict_structure_fn

from contactstudy.domain.checks import InvalidInput, suggestion
from contactstudy.domain.imports import import_for
from contactstudy.domain.units import Unit

NUMBER = re.compile(r"\s*([-+]?(?:inf|(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?))\s*(.*?)\s*")
# Units: names, powers, products, quotients, and no other expressions.
SYMBOL = r"[^\W\d_]+\d?"
SYMBOLS = re.compile(rf"{SYMBOL}(?:\s*(?:\*\*|\^)\s*-?\d|\s*[*/·]\s*{SYMBOL}|\s+{SYMBOL})*")


def quantity(field: str, value: object, unit: Unit) -> float:
    """``value``, a number or a text with a unit, in the SI unit ``unit``.

    Raises :class:`~contactstudy.InvalidInput` for what is neither, and for a unit of another quantity.
    """
    remedy = (
        f"give {unit.quantity}, such as {unit.example!r}"
        + f", or a number in {unit.symbol}" * bool(unit.symbol)
    )
    if isinstance(value, int | float) and not isinstance(value, bool):
        try:
            return float(value)
        except OverflowError:
            raise InvalidInput(f"{field} is beyond any float: {remedy}.") from None
    found = NUMBER.fullmatch(value) if isinstance(value, str) else None
    if found is None or (found[2] and not SYMBOLS.fullmatch(found[2])):
        raise InvalidInput(f"{field} is {value!r}: {remedy}.")
    if not found[2] and found[1].endswith("inf"):  # infinite in any unit
        return float(found[1])
    pint = import_for("a unit", "pint")  # heavier than all else here
    registry = _registry()
    try:
        read = registry.Quantity(
            Decimal(found[1]), registry.parse_units(found[2].replace("·", "*"))
        )
        return float(read.to(unit.symbol).magnitude)
    except (
        pint.PintError,
        ArithmeticError,
        LookupError,
        ValueError,
        TypeError,
        AttributeError,
    ) as error:
        raise InvalidInput(f"{field} is {value!r}: {remedy}.") from error


@cache
def _registry() -> Any:
    from pint import UnitRegistry

    # in decimals, so that 30 um is exactly the float 3e-5 m
    return UnitRegistry(non_int_type=Decimal)


# By the type that is wanted, what may be named as its kind; NO_KIND names what a table without one is.
NO_KIND = ""
Kinds = Mapping[Any, Mapping[str, type]]
Wanted = TypeVar("Wanted")


def structured(raw: object, wanted: type[Wanted], kinds: Kinds, source: str) -> Wanted:
    """``raw`` tables, lists, texts and numbers as a ``wanted`` dataclass.

    Where a type in ``kinds`` is wanted, or one of several dataclasses, a table says which by its key
    ``kind``; a name alone stands for a table with nothing else. Raises
    :class:`~contactstudy.InvalidInput` with a line for every key that cannot be used, each beginning
    with ``source`` and the key.
    """
    try:
        return _converter(kinds).structure(raw, wanted)
    except cattrs.BaseValidationError as error:
        raise InvalidInput(_sentences(source, error)) from error


def _converter(kinds_of: Kinds) -> cattrs.Converter:
    converter = cattrs.Converter(forbid_extra_keys=True)

    def number(value: object, wanted: Any) -> float:
        unit = next(note for note in wanted.__metadata__ if isinstance(note, Unit))
        return quantity("it", value, unit)

    def whole(value: object, _: Any) -> int:
        if isinstance(value, bool) or not isinstance(value, int):
            raise InvalidInput(f"it is {value!r}: give a whole number.")
        return value

    def text(value: object, _: Any) -> str:
        if not isinstance(value, str):
            raise InvalidInput(f"it is {value!r}: give a text.")
        return value

    def name(value: object, wanted: Any) -> Enum:
        names: dict[str, Enum] = {one.name.lower(): one for one in wanted}
        if not isinstance(value, str) or value.lower() not in names:
            raise InvalidInput(f"it is {value!r}: {suggestion(str(value), names)}.")
        return names[value.lower()]

    def several(value: object, wanted: Any) -> tuple[Any, ...]:
        each, *others = get_args(wanted)
        if not isinstance(value, list):
            raise InvalidInput(f"it is {value!r}: give a list.")
        if others != [...] and len(value) != 1 + len(others):
            raise InvalidInput(f"it has {len(value)} entries: give {1 + len(others)}.")
        if others != [...] and len({each, *others}) > 1:
            kinds = zip(value, (each, *others), strict=True)
            return tuple(converter.structure(one, kind) for one, kind in kinds)
        listed: Any = list.__class_getitem__(each)
        return tuple(converter.structure(value, listed))

    def either(value: object, wanted: Any) -> Any:
        """One of several types: a table or a name for a kind, anything else for what is none."""
        kinds = dict(kinds_of.get(wanted, {}))
        others = []
        for one in (one for one in get_args(wanted) if one is not NoneType):
            kinds |= kinds_of.get(one) or _itself(one)
            others += [] if one in kinds_of or is_dataclass(one) else [one]
        if not kinds or (others and not isinstance(value, Mapping)):
            return converter.structure(value, others[0])
        if isinstance(value, str):
            value = {"kind": value}
        if not isinstance(value, Mapping):
            raise InvalidInput(f"it is {value!r}: give a table with a kind.")
        without = kinds.pop(NO_KIND, None)
        if without is not None and "kind" not in value:
            return converter.structure(value, without)
        chosen = value.get("kind", next(iter(kinds)) if len(kinds) == 1 else None)
        if not isinstance(chosen, str) or chosen not in kinds:
            what = f"its kind is {chosen!r}" if "kind" in value else "it has no kind"
            raise InvalidInput(f"{what}: {suggestion(str(chosen), kinds)}.")
        rest = {key: one for key, one in value.items() if key != "kind"}
        return converter.structure(rest, kinds[chosen])

    def table(wanted: type) -> Any:
        base: Any = make_dict_structure_fn(wanted, converter)

        def read(value: object, _: Any) -> Any:
            if not isinstance(value, Mapping):
                raise InvalidInput(f"it is {value!r}: give a table.")
            if value.get("kind") == wanted.__name__:  # said, though there is only one
                value = {key: one for key, one in value.items() if key != "kind"}
            return base(value, wanted)

        return read

    hooks: tuple[tuple[Callable[[Any], bool], Callable[[Any, Any], Any]], ...] = (
        (lambda wanted: get_origin(wanted) is Annotated, number),
        (lambda wanted: isinstance(wanted, type) and issubclass(wanted, Enum), name),
        (lambda wanted: get_origin(wanted) is tuple, several),
        (lambda wanted: wanted in kinds_of or get_origin(wanted) in (Union, UnionType), either),
    )
    converter.register_structure_hook_factory(is_dataclass, table)
    converter.register_structure_hook(int, whole)
    converter.register_structure_hook(str, text)
    for applies, hook in hooks:
        converter.register_structure_hook_func(applies, hook)
    return converter


def _itself(wanted: Any) -> dict[str, type]:
    return {wanted.__name__: wanted} if isinstance(wanted, type) and is_dataclass(wanted) else {}


def _sentences(source: str, error: cattrs.BaseValidationError) -> str:
    """A sentence for every key that cannot be used."""
    found = []
    for line in cattrs.transform_error(error, path="", format_exception=_said):
        said, _, place = line.rpartition(" @ ")
        found.append(f"{source}: {place.lstrip('.') or 'all of it'}: {said}")
    return "\n".join(found)


def _said(error: BaseException, wanted: type | None) -> str:
    if isinstance(error, ForbiddenExtraKeysError):
        known = [one.name for one in fields(error.cl)]
        unknown = sorted(error.extra_fields)
        return "; ".join(f"{key!r} is not known, {suggestion(key, known)}" for key in unknown) + "."
    if isinstance(error, KeyError):
        return "it is missing."
    return str(error)
