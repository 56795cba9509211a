"""A number in SI units from a number or a text with a unit: 0.01 or "10 mm"."""

import re
from decimal import Decimal
from functools import cache
from typing import Any

from contactstudy.domain.checks import InvalidInput
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
