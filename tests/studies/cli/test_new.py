"""Test the scenes to begin with."""

from pathlib import Path

import pytest
from click.testing import CliRunner, Result

import contactstudy as cs
from studies.cli.commands import cli
from studies.cli.new import new, templates

EXAMPLES = Path(__file__).parents[3] / "examples"
# Examples that are called by another name than their kind.
NAMES = {"film": "oil"}


def said(*words: str) -> Result:
    return CliRunner().invoke(new, words)


@pytest.mark.parametrize("kind", templates())
def test_a_scene_to_begin_with_is_an_example_that_plans(kind: str, tmp_path: Path) -> None:
    path = tmp_path / f"{NAMES.get(kind, kind)}.toml"
    assert said(kind, "--out", str(path)).exit_code == 0
    assert path.read_text(encoding="utf-8") == (EXAMPLES / path.name).read_text(encoding="utf-8")
    assert cs.read_scene(path).plan().grid.cells[0] > 1


@pytest.mark.parametrize("kind", ["coated", "fretting"])
def test_a_scene_to_begin_with_solves(kind: str, tmp_path: Path) -> None:
    (tmp_path / "scene.toml").write_text(templates()[kind], encoding="utf-8")
    done = CliRunner().invoke(cli, ["solve", str(tmp_path / "scene.toml"), "--out", str(tmp_path)])
    assert done.exit_code == 0, done.output


def test_the_kinds_are_listed_with_what_they_are() -> None:
    lines = said("--list").output.splitlines()
    assert [line.split()[0] for line in lines] == list(templates())
    described = dict(line.split(maxsplit=1) for line in lines)
    assert described["film"].startswith("Steel cylinders in mineral oil")


def test_no_file_is_replaced(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert said("rough").exit_code == 0
    again = said("rough")
    assert isinstance(again.exception, cs.InvalidInput)
    assert "is there already: give another file" in str(again.exception)


def test_another_kind_is_answered_with_a_known_one() -> None:
    assert "did you mean 'roller'" in str(said("rollers").exception)
    assert "choose from coated, film" in str(said().exception)
