"""Whose revision a file names, and whose processor."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from studies.store import provenance

ROOT = Path(__file__).parents[3]


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """What git is asked; a checkout is wherever one is looked for."""
    found: list[Any] = []

    def run(command: list[str], **_: object) -> SimpleNamespace:
        found.append(command)
        return SimpleNamespace(stdout="abc-dirty\n")

    monkeypatch.setattr(provenance.subprocess, "run", run)
    monkeypatch.setattr(Path, "exists", lambda path: found.append(path) is None)
    provenance._revision.cache_clear()
    return found


def test_the_revision_is_that_of_the_folder_that_holds_the_program(asked: list[Any]) -> None:
    try:
        assert provenance._revision() == "abc-dirty"
    finally:
        provenance._revision.cache_clear()
    where, command = asked
    assert where == ROOT / ".git"
    assert command[:3] == ["git", "-C", str(ROOT)]
    assert (ROOT / "studies").is_dir()


def test_the_processor_is_named_as_the_system_does(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    said = tmp_path / "cpuinfo"
    said.write_text("processor: 0\nmodel name\t: A: fast one\nmodel name : other\n")
    monkeypatch.setattr(provenance, "Path", lambda _: said)
    assert provenance.cpu() == "A: fast one"


def test_the_history_is_the_command_as_a_shell_takes_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(provenance.sys, "argv", ["/opt/bin/contactstudy", "run", "my study.py"])
    attributes = provenance.provenance()
    assert attributes["history"].partition(" ")[2] == "contactstudy run 'my study.py'"
    assert attributes["threads"] == "1"
