"""What the package says of itself: its dependencies and the README that an index shows."""

import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).parent.parent
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


def test_the_page_on_installing_says_what_each_dependency_and_extra_is_for() -> None:
    page = (ROOT / "docs/start/install.md").read_text(encoding="utf-8")
    named = {
        name.strip("` ")
        for row in re.findall(r"^\| ([^|]*) \|", page, flags=re.MULTILINE)
        for name in row.split(",")
    }
    wanted = {re.split(r"[<>=\[]", one)[0] for one in PROJECT["dependencies"]}
    assert wanted <= named
    peers = {name for name in PROJECT["optional-dependencies"] if name.startswith("peer-")}
    assert set(PROJECT["optional-dependencies"]) - peers <= named
