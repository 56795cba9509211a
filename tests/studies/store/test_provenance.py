"""Whose revision a file names, and whose processor."""

import pytest

from studies.store import provenance


def test_the_history_is_the_command_as_a_shell_takes_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(provenance.sys, "argv", ["/opt/bin/contactstudy", "run", "my study.py"])
    attributes = provenance.provenance()
    assert attributes["history"].partition(" ")[2] == "contactstudy run 'my study.py'"
    assert attributes["threads"] == "1"
