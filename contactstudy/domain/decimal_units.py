"""SI units with decimal prefixes, their powers, products and quotients.

These units occur most. A table reads them faster than the library for all other units, whose import is slow.
"""

import re
from functools import cache

# Power of ten of each prefix. The micro sign and the Greek letter mu, two characters, both stand for micro.
PREFIXES = {"G": 9, "M": 6, "k": 3, "": 0, "c": -2, "m": -3, "u": -6, "µ": -6, "μ": -6, "n": -9}
# Powers of metre, kilogram, second and kelvin in each unit.
UNITS = {
    "m": (1, 0, 0, 0), "s": (0, 0, 1, 0), "K": (0, 0, 0, 1), "rad": (0, 0, 0, 0), "Hz": (0, 0, -1, 0),
    "N": (1, 1, -2, 0), "Pa": (-1, 1, -2, 0), "J": (2, 1, -2, 0), "W": (2, 1, -3, 0),
}  # fmt: skip
# A power of ten, and powers of metre, kilogram, second and kelvin.
Scale = tuple[int, tuple[int, ...]]
# Scale of a number without unit.
ONE: Scale = (0, (0, 0, 0, 0))
# Scale of every prefix and unit together.
KNOWN: dict[str, Scale] = {"": ONE, "1": ONE} | {
    prefix + unit: (power, powers)
    for prefix, power in PREFIXES.items()
    for unit, powers in UNITS.items()
}


@cache
def decimal_unit(symbol: str) -> Scale | None:
    """Return the power of ten of a unit such as ``N/mm``, and its powers of metre, kilogram, second and kelvin.

    None for a unit that is not in the table.
    """
    factors = re.split(r"\s*([*/])\s*", symbol.replace("**", "^").replace("·", "*"))
    total, totals = ONE
    for sign, factor in zip(("*", *factors[1::2]), factors[::2], strict=True):
        name, _, exponent = factor.partition("^")
        if name.strip() not in KNOWN:
            return None
        power, powers = KNOWN[name.strip()]
        times = int(exponent or 1) * (1 if sign == "*" else -1)
        total += times * power
        totals = tuple(
            before + times * unit_power for before, unit_power in zip(totals, powers, strict=True)
        )
    return total, totals
