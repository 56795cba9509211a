import re
import runpy
import sys
import tomllib
from dataclasses import fields
from pathlib import Path

import pytest

import contactstudy as cs
from contactstudy.io.scene_files.scene_schema import KINDS, PlanSettings, SceneDocument

ROOT = Path(__file__).parent.parent
sys.path.insert(0, str(ROOT / "docs" / "_ext"))
from key_meanings import meanings  # noqa: E402

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


def test_the_page_on_installing_says_what_each_dependency_and_extra_is_for() -> None:
    page = (ROOT / "docs/start/install.md").read_text(encoding="utf-8")
    named = {
        name.strip("` ") for row in re.findall(r"^\| ([^|]*) \|", page, flags=re.MULTILINE) for name in row.split(",")
    }
    wanted = {re.split(r"[<>=\[]", one)[0] for one in PROJECT["dependencies"]}
    assert wanted <= named
    peers = {name for name in PROJECT["optional-dependencies"] if name.startswith("peer-")}
    assert set(PROJECT["optional-dependencies"]) - peers <= named


def test_the_citation_is_of_this_version_and_this_place() -> None:
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    said = dict(re.findall(r"^([\w-]+): *([^#\n]*?) *(?:#.*)?$", citation, flags=re.MULTILINE))
    assert said["version"] == PROJECT["version"] == cs.__version__
    assert said["repository-code"] == PROJECT["urls"]["Repository"]
    assert said["license"] == PROJECT["license"]


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
    pages = [ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs/development").glob("*.md"))]
    text = "\n".join(page.read_text(encoding="utf-8") for page in pages)
    paths = re.findall(r"`((?:contactstudy|studies|tests|docs)/[\w/.]+)`", text.replace("NAME.py", ""))
    for path in paths:
        assert (ROOT / path).exists(), path
    for name, path in re.findall(r"`(\w+)` (?:in|of) `([\w/]+\.py)`", text):
        assert re.search(rf"\b{name}\b", (ROOT / path).read_text(encoding="utf-8")), (name, path)


def test_every_key_of_a_scene_file_has_a_meaning() -> None:
    described = (kind for kinds in KINDS.values() for kind in kinds.values())
    for kind in (SceneDocument, PlanSettings, *described):
        found = meanings(kind)
        assert not [one.name for one in fields(kind) if one.init and not found.get(one.name)], kind
    assert meanings(SceneDocument)["hardness"].startswith("Largest pressure [Pa]")


def test_every_kind_of_a_scene_file_is_on_the_page_of_scene_files() -> None:
    page = (ROOT / "docs/how-to/scene-files.md").read_text(encoding="utf-8")
    rows = "".join(line for line in page.partition("## Kinds")[2].splitlines() if line.startswith("|"))
    assert not [kind for kinds in KINDS.values() for kind in kinds if kind and f"`{kind}`" not in rows]


def test_the_package_is_the_command_when_it_is_run_and_not_when_it_is_imported(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", ["contactstudy", "--version"])
    runpy.run_module("contactstudy", run_name="imported")
    assert capsys.readouterr().out == ""
    runpy.run_module("contactstudy", run_name="__main__")
    assert cs.__version__ in capsys.readouterr().out
