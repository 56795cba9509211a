"""Where an error was raised, as far as it is a study's own place."""

import json

from studies.model.error_place import place_of


def outer() -> None:
    inner()


def inner() -> None:
    json.loads("{")  # line 13


def deep(times: int) -> None:
    if times:
        deep(times - 1)
    else:
        json.loads("{")


def raised_by(call: object, *words: object) -> BaseException:
    try:
        call(*words)  # type: ignore[operator]
    except ValueError as error:
        return error
    raise AssertionError


def test_it_is_the_innermost_that_is_no_library_s() -> None:
    assert place_of(raised_by(outer)) == " in inner (test_error_place.py, line 13)"
    assert place_of(raised_by(outer), __file__) == ""
    # the last fifty of a deep recursion are looked at
    assert "in deep (" in place_of(raised_by(deep, 200))
