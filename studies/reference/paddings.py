"""Paddings by their names, with a number of images where they have one."""

from collections.abc import Callable

import contactstudy as cs
from studies.model.axis import one_of

PADDINGS: dict[str, Callable[[int], cs.Padding]] = {
    "zero": lambda images: cs.ZeroPadding(),
    "duplicated": lambda images: cs.DuplicatedPadding(),
    "superposed": cs.Superposition,
    "circular": cs.CircularSuperposition,
    "exact": lambda images: cs.ExactPeriodicity(),
}
HAS_IMAGES = frozenset(name for name, make in PADDINGS.items() if make(0) != make(1))
BY_CLASS = {type(make(0)).__name__: name for name, make in PADDINGS.items()}


def padding_at(padding: str, images: int) -> cs.Padding:
    """Return the padding of a name, with a number of images where it has one."""
    make = PADDINGS[one_of("padding", padding, PADDINGS)]
    return make(images)


def padding_label(padding: str, images: int) -> str:
    """Return the name of a padding, with its n where it has one."""
    return f"{padding}, n = {images}" if padding in HAS_IMAGES else padding


def padding_text(value: object) -> str:
    """Return the name of a padding of a scene as the report has it, such as "superposed, n = 6"; others as they are."""
    name, _, images = str(value).removesuffix(")").removesuffix("(").partition("(images=")
    return padding_label(BY_CLASS[name], int(images or 0)) if name in BY_CLASS else str(value)
