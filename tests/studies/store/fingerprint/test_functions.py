import functools
import types
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np
import pytest

from contactstudy import InvalidInput
from contactstudy.domain.identity import text
from studies.store.fingerprint.functions import States

Measures = Callable[..., Any]


def state(measures: Any) -> str:
    return text(States().state_of(measures))


def over(value: object) -> Measures:
    return lambda case, result: value


def noted(value: Any, scale: float) -> Any:
    vars(value)["more"] = scale
    return value


@dataclass(frozen=True)
class Frozen:
    scale: float
    inner: Measures | None = None

    def __call__(self, case: object, result: float) -> float:
        return self.scale * result


class Named(list[float]):
    """A list that has attributes."""


def local_class(scale: float) -> Measures:
    @dataclass(frozen=True)
    class Local:
        offset: float = 0.0

        def __call__(self, case: object, result: float) -> float:
            return scale * result + self.offset

    return Local()


def class_with_a_made_default(scale: float) -> Measures:
    made = partial(float, scale)

    @dataclass(frozen=True)
    class Part:
        factor: float = field(default_factory=made)

    return over(Part)


KINDS: dict[str, Callable[[float], Any]] = {
    "closure": over,
    "closure of a function": lambda scale: over(over(scale)),
    "closure of a table": lambda scale: over({"k": [scale]}),
    "closure of functions": lambda scale: over({"k": (over(scale),)}),
    "default": lambda scale: lambda case, result, *, factor=scale: factor * result,
    "attribute": lambda scale: noted(over(1.0), scale),
    "decorated": lambda scale: functools.wraps(over)(over(scale)),
    "list with an attribute": lambda scale: over(noted(Named(), scale)),
    "frozen dataclass with more than its fields": lambda scale: noted(Frozen(1.0), scale),
    "class with a made default": class_with_a_made_default,
    "partial with an attribute": lambda scale: noted(partial(pow, 2), scale),
    "partial": lambda scale: partial(pow, scale),
    "frozen dataclass": Frozen,
    "method of a frozen dataclass": lambda scale: Frozen(scale).__call__,
    "frozen dataclass with a function": lambda scale: Frozen(1.0, over(scale)),
    "class in a function": local_class,
    "cached": lambda scale: functools.lru_cache(over(scale)),
}


@pytest.mark.cases(100)
@pytest.mark.parametrize("kind", KINDS)
def test_what_a_function_holds_tells_it_from_another(kind: str) -> None:
    first, again, other = (state(KINDS[kind](scale)) for scale in (1.0, 1.0, 2.0))
    assert first == again
    assert first != other


class Plain:
    def __init__(self, scale: float) -> None:
        self.scale = scale

    def measure(self, case: object, result: float) -> float:
        return self.scale * result

    __call__ = measure


@dataclass
class Changeable:
    scale: float = 1.0
    more: list[float] = field(default_factory=list)

    def __call__(self, case: object, result: float) -> float:
        return self.scale * result


@pytest.mark.cases(100)
@pytest.mark.parametrize(
    "measures",
    [
        Plain(1.0), Plain(1.0).measure, over(Plain(1.0)), over([Plain(1.0)]), partial(pow, Plain(1.0)),
        Changeable(), over(np.frompyfunc(over(1.0), 2, 1)), over(types.SimpleNamespace(k=1.0)), over(iter([1])),
    ],
)  # fmt: skip
def test_an_object_whose_state_cannot_be_seen_is_refused_with_the_remedy(measures: Any) -> None:
    with pytest.raises(InvalidInput, match="a partial of one, or a frozen dataclass with __call__"):
        state(measures)


def test_a_function_that_names_itself_has_a_state() -> None:
    def measures(case: object, result: int) -> int:
        return 1 if result == 0 else result * measures(case, result - 1)

    assert state(measures) == state(measures)
