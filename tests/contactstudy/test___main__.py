import runpy
import sys

import pytest

import contactstudy as cs


def test_the_package_is_the_command_when_it_is_run_and_not_when_it_is_imported(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", ["contactstudy", "--version"])
    runpy.run_module("contactstudy", run_name="imported")
    assert capsys.readouterr().out == ""
    runpy.run_module("contactstudy", run_name="__main__")
    assert cs.__version__ in capsys.readouterr().out
