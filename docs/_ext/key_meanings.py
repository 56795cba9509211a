"""Meanings of the keys of a scene file, from the docstrings of what they describe."""

import re
from inspect import getdoc

from contactstudy.io.scene_files.scene_schema import DESCRIPTIONS, SceneDocument
from contactstudy.scene.scene import Scene


def meanings(kind: type) -> dict[str, str]:
    """The meaning of each field: its text among the parameters of the docstring, also of what a table describes."""
    described = [one for one, table in DESCRIPTIONS.items() if table is kind]
    found: dict[str, str] = {}
    for one in (*(Scene,) * (kind is SceneDocument), *described, *reversed(kind.__mro__)):
        parameters = ((one.__doc__ and getdoc(one)) or "").partition("Parameters\n----------\n")[2]
        parts = re.split(r"^(\w[\w, ]*)\n(?=    )", re.split(r"\n\w+\n-+\n", parameters)[0], flags=re.M)
        for listed, text in zip(parts[1::2], parts[2::2], strict=True):
            plain = re.sub(r":\w+:`~?(?:\w+\.)*(\w+)`", r"`\1`", " ".join(text.split())).replace("``", "`")
            found |= dict.fromkeys(listed.split(", "), plain.replace("|", "\\|"))
    return found
