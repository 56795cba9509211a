"""Times of a scene file that are given in cycles of its load or revolutions of its wearing body."""

import re
from collections.abc import Mapping
from typing import Annotated, Any

from contactstudy.domain.checks import InvalidInput
from contactstudy.domain.units import Metres, MetresPerSecond, PerSecond, Seconds
from contactstudy.domain.validation import ANY_SIGN, valid

# A number and what it counts, such as "3 cycles" or "1e4 revolutions".
COUNTED = re.compile(r"\s*(\d+\.?\d*(?:[eE]\+?\d+)?)\s*(cycle|rev|revolution|turn)s?\s*")
SPEED = Annotated[MetresPerSecond, ANY_SIGN]


def with_cycles(raw: Mapping[str, Any]) -> dict[str, Any]:
    """Return the tables of a scene file with the times of ``time_steps`` in seconds.

    A cycle is that of a sinusoidal load or of fretting with a period. A revolution of the wearing body is its
    circumference over the speed of rolling, friction or wear.
    """
    steps = raw.get("time_steps")
    if not isinstance(steps, Mapping):
        return dict(raw)

    def seconds(name: str, value: object) -> object:
        if isinstance(value, list):
            return [seconds(f"{name}[{number}]", entry) for number, entry in enumerate(value)]
        counted = COUNTED.fullmatch(value) if isinstance(value, str) else None
        if counted is None:
            return value
        turn = _cycle(raw) if counted[2] == "cycle" else _revolution(raw)
        if not turn:
            needed = "load.frequency, or friction.period"
            if counted[2] != "cycle":
                needed = "wear.circumference, and a speed of rolling, friction or wear above 0 m/s"
            raise InvalidInput(f"time_steps.{name} is {value!r}: give {needed}, or the time in s.")
        return float(counted[1]) * turn

    return dict(raw) | {"time_steps": {name: seconds(name, value) for name, value in steps.items()}}


def _entry(raw: Mapping[str, Any], table: str, key: str, hint: Any) -> float:
    """Return an entry of a table in SI, 0 where there is none."""
    value = raw[table].get(key) if isinstance(raw.get(table), Mapping) else None
    return 0.0 if value is None else float(valid(f"{table}.{key}", value, hint))


def _cycle(raw: Mapping[str, Any]) -> float:
    """Return the duration of a cycle [s]; 0 if it is not known."""
    frequency = _entry(raw, "load", "frequency", PerSecond)
    return 1 / frequency if frequency else _entry(raw, "friction", "period", Seconds)


def _revolution(raw: Mapping[str, Any]) -> float:
    """Return the duration of a revolution of the wearing body [s]; 0 if it is not known."""
    speeds = (_entry(raw, table, "speed", SPEED) for table in ("rolling", "friction", "wear"))
    speed = next(filter(None, speeds), 0.0)
    return _entry(raw, "wear", "circumference", Metres) / abs(speed) if speed else 0.0
