import math
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest

import contactstudy as cs
from contactstudy import InvalidInput
from contactstudy.domain.files import Memo, digest
from contactstudy.domain.imports import source_hash
from studies.definitions.settings import case_at

CASE = case_at({"padding": "superposed", "images": 2, "period": 0.3, "grid": 16})


def enclosing(number: float, default: int = 1) -> object:
    return lambda base, exponent=default: number * base**exponent


def test_different_values_have_different_digests() -> None:
    square = np.arange(4.0).reshape(2, 2)
    values = [
        1, 1.0, True, "1", "1.0", np.float32(1), np.float64(1), np.int64(1), 1 + 0j, b"1", None, "None",
        0.0, -0.0, 0.3, 3 * 0.1, (1, 2), [1, 2], {1, 2}, {1: 2}, {"1": 2}, (), "", math.nan,
        Path("u"), "u", cs.Status.STALLED,
        np.array([1.0]), np.array([1]), np.arange(4.0), np.arange(4.0)[::-1], square,
        np.asfortranarray(square),  # a sum may differ in its last bit
        enclosing(1.0), enclosing(2.0), enclosing(1.0, 2), partial(max, 1), partial(min, 1), lambda x: 2 * x,
        CASE, replace(CASE, options=cs.SolveOptions(1e-9)), replace(CASE, padding=cs.Superposition(images=3)),
        replace(CASE, scene=replace(CASE.scene, load=cs.LineLoad(2e5))),
    ]  # fmt: skip
    assert len({digest(value) for value in values}) == len(values)
    again = case_at({"padding": "superposed", "images": 2, "period": 0.3, "grid": 16})
    assert digest(again) == digest(CASE)


def made(number: int) -> type:
    @dataclass(frozen=True)
    class Model:
        factor: float = 1.0

        def value(self) -> int:
            return number

    return Model


def test_classes_of_one_name_differ_by_their_code() -> None:
    assert digest(made(1)()) != digest(made(2)())
    assert digest(made(1)()) == digest(made(1)())


def test_two_classes_of_one_name_are_refused_together() -> None:
    memo: Memo = {}
    digest(made(1)(), memo)
    with pytest.raises(InvalidInput, match="give each a name of its own"):
        digest(made(2)(), memo)


@dataclass
class Several(list):  # type: ignore[type-arg]
    """A container whose content is no field."""


def test_objects_with_hidden_state_are_refused() -> None:
    for value, said in (
        (object(), "make its class a frozen dataclass"),
        (np.array([object()]), "make its class a frozen dataclass"),
        (Several(), "give its content a field"),
    ):
        with pytest.raises(InvalidInput, match=said):
            digest(value)


def test_the_hash_of_the_source_is_of_this_package_alone() -> None:
    assert source_hash() == source_hash(Path(cs.__file__).parent)
