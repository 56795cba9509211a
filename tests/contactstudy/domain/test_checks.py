import re
from collections.abc import Iterator
from dataclasses import is_dataclass
from inspect import getdoc, isclass, signature
from math import nan
from typing import Any, get_args, get_origin

import pytest

import contactstudy as cs
from contactstudy.domain.validation import hint_of, kind_of, parameters, valid


def test_a_misspelt_keyword_is_answered_with_the_right_one() -> None:
    with pytest.raises(TypeError, match=r"Cylinder\.radious is not known: did you mean 'radius'") as refused:
        cs.Cylinder(radious=1)  # type: ignore[call-arg]
    assert isinstance(refused.value, cs.InvalidInput)
    with pytest.raises(cs.InvalidInput, match=r"LineLoad\.force is not known: choose from per_length"):
        cs.LineLoad(force=1.0)  # type: ignore[call-arg]
    assert list(signature(cs.Cylinder).parameters) == ["radius"]


def test_of_a_long_history_a_message_has_the_first_numbers() -> None:
    times = (*map(float, range(500)), 0.0)
    with pytest.raises(
        cs.InvalidInput, match=r"^SpeedHistory\.times is \(0\.0, 1\.0, .*, \.\.\.\): give asc"
    ) as refused:
        cs.SpeedHistory(times, times)
    assert len(str(refused.value)) < 120
    with pytest.raises(cs.InvalidInput, match=r"is \(0\.0, 1\.0, 0\.5\): give"):
        cs.SpeedHistory((0.0, 1.0, 0.5), (1.0, 1.0, 1.0))


# What a docstring says of a number: above or at least 0, and what it is below, or goes up to.
LIMITS = re.compile(r"(above|at least) (?:zero|0)\b(?: and (below|up to) (\d(?:\.\d+)?))?")


def numbers() -> Iterator[tuple[str, Any, str]]:
    """Name, annotation and meaning of each number of the public classes whose constructors check their fields."""
    for cls in (getattr(cs, name) for name in cs.__all__):
        if not (isclass(cls) and is_dataclass(cls) and hasattr(cls.__init__, "__wrapped__")):
            continue
        for name in parameters(cls):
            hint, doc = hint_of(cls, name), f"{getdoc(cls)}\n"
            kinds = map(kind_of, (hint, *get_args(hint)))
            if get_origin(hint) is not tuple and {int, float}.intersection(kinds):
                meaning = re.search(rf"^(?:\w+, )*{name}(?:, \w+)*\n((?:    .*\n?)+)", doc, re.M)
                yield f"{cls.__name__}.{name}", hint, " ".join(meaning[1].split()) if meaning else ""


def test_a_number_outside_the_limits_that_its_docstring_says_is_refused() -> None:
    limited = 0
    for name, hint, meaning in numbers():
        bad: list[object] = [nan, "much", object()]
        if (limits := LIMITS.search(meaning)) and "of any sign" not in meaning:
            limited += 1
            low, high, end = limits.groups()
            bad.append(0.0 if low == "above" else -1.0)
            bad += [float(end) + 0.1 * (high == "up to")] if high else []
        for value in bad:
            with pytest.raises(cs.InvalidInput, match=rf"^{name} is .*: (give|choose) "):
                valid(name, value, hint)
    assert limited > 50
