import sys
from dataclasses import fields
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent / "docs" / "_ext"))
from key_meanings import meanings
from page_problems import problems

from contactstudy.io.scene_files.scene_schema import KINDS, PlanSettings, SceneDocument

GOOD = (
    '<h1 id="top">T</h1><h2>U</h2><img src="a.png" alt="A curve."><a href="#top">t</a><a href="https://x.org/y">o</a>'
)


def test_a_problem_of_a_page_is_found(tmp_path: Path) -> None:
    (tmp_path / "a.png").touch()
    (tmp_path / "other.html").write_text('<h1 id="here">O</h1>')
    for added, found in (
        ("", None),
        ('<img src="a.png" alt=" ">', "without a text"),
        ('<a href="other.html#here">o</a>', None),
        ('<a href="other.html#there">o</a>', "anchor that does not exist"),
        ('<a href="gone.html">o</a>', "file that does not exist"),
        ("<h4>V</h4>", "a heading of level 4 follows one of level 2"),
    ):
        (tmp_path / "page.html").write_text(GOOD + added)
        messages = problems(tmp_path)
        assert len(messages) == (found is not None)
        assert all(found in message for message in messages)


def test_every_key_of_a_scene_file_has_a_meaning() -> None:
    described = (kind for kinds in KINDS.values() for kind in kinds.values())
    for kind in (SceneDocument, PlanSettings, *described):
        found = meanings(kind)
        assert not [one.name for one in fields(kind) if one.init and not found.get(one.name)], kind
    assert meanings(SceneDocument)["hardness"].startswith("Largest pressure [Pa]")
