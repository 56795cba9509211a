"""The house: imports run downwards, and no module goes unplaced."""

import re
from pathlib import Path

ROOT = Path(__file__).parent.parent


# The one place of the core and the one of the studies that find a module by a name.
BY_NAME = {"contactstudy/domain/imports.py", "studies/registry.py"}


def test_modules_above_are_found_by_name_in_one_place() -> None:
    """Methods that label or draw a value call upwards, as do studies for their figures; nothing else does."""
    by_name = re.compile(r'import_(?:module|for)\((?:[^()]*, )?f?"(contactstudy|studies)\.[\w.]*\.')
    for package in ("contactstudy", "studies"):
        for file in sorted((ROOT / package).rglob("*.py")):
            place = file.relative_to(ROOT)
            for call in by_name.finditer(file.read_text(encoding="utf-8")):
                below = ".".join(place.parts[:2]).removesuffix(".py")
                assert below in call[0] or place.as_posix() in BY_NAME, (place, call[0])


def test_the_files_that_contributors_are_led_to_are_there() -> None:
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    paths = re.findall(r"`((?:contactstudy|studies|tests)/[\w/.]+)`", text.replace("NAME.py", ""))
    for path in paths:
        assert (ROOT / path).exists(), path
    for name, path in re.findall(r"`(\w+)` (?:in|of) `([\w/]+\.py)`", text):
        assert re.search(rf"\b{name}\b", (ROOT / path).read_text(encoding="utf-8")), (name, path)
