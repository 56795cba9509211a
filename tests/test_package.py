"""What the package says of itself: its dependencies and the README that an index shows."""

import re
import tomllib
from pathlib import Path

import contactstudy as cs

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


def test_links_and_pictures_of_the_readme_work_in_a_clone() -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    found = re.findall(r"(!?)\[[^\]]*\]\(([^)\s]+)\)", text)
    assert {"!", ""} == {mark for mark, _ in found}
    for _, link in found:
        assert (ROOT / link).is_file(), link
    for link in PROJECT["urls"].values():
        path = link.removeprefix(PROJECT["urls"]["Repository"]).removeprefix("/blob/main/")
        assert (ROOT / path).exists(), link


def test_the_citation_is_of_this_version_and_this_place() -> None:
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    fields = dict(re.findall(r"^([\w-]+): *([^#\n]*?) *(?:#.*)?$", citation, flags=re.MULTILINE))
    assert fields["version"] == PROJECT["version"] == cs.__version__
    assert fields["repository-code"] == PROJECT["urls"]["Repository"]
    assert fields["license"] == PROJECT["license"]
