"""Numbers that are taken where a user leaves them out."""

from collections.abc import Callable
from inspect import signature
from typing import Any


def check_defaults(made: Callable[..., Any], **numbers: float) -> None:
    """Assert that a class or function takes these numbers where they are not given."""
    parameters = signature(made).parameters
    assert {name: parameters[name].default for name in numbers} == numbers
