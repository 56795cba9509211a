"""Meanings of the keys of a scene file, from the docstrings of what they describe."""

import re
from inspect import getdoc
from typing import get_type_hints

from contactstudy.io.scene_files.scene_schema import SceneDocument
from contactstudy.scene.scene import Scene


def described_by(kind: type) -> list[type]:
    """The class that a table describes where its keys are not the fields of that class, or none."""
    return [get_type_hints(kind.described)["return"]] if hasattr(kind, "described") else []


def meanings(kind: type) -> dict[str, str]:
    """The meaning of each field: its text among the parameters of the docstring, also of what a table describes."""
    described = described_by(kind)
    found: dict[str, str] = {}
    for one in (*(Scene,) * (kind is SceneDocument), *described, *reversed(kind.__mro__)):
        parameters = ((one.__doc__ and getdoc(one)) or "").partition("Parameters\n----------\n")[2]
        parts = re.split(r"^(\w[\w, ]*)\n(?=    )", re.split(r"\n\w+\n-+\n", parameters)[0], flags=re.M)
        for listed, text in zip(parts[1::2], parts[2::2], strict=True):
            plain = re.sub(r":\w+:`~?(?:\w+\.)*(\w+)`", r"`\1`", " ".join(text.split())).replace("``", "`")
            found |= dict.fromkeys(listed.split(", "), plain.replace("|", "\\|"))
    return found
