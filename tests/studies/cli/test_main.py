"""The entry point of the command."""

import pytest

from studies.cli import main as module


def ended(raised: BaseException, monkeypatch: pytest.MonkeyPatch) -> SystemExit:
    from studies.cli import commands

    def run() -> None:
        raise raised

    monkeypatch.setattr(commands, "main", run)
    with pytest.raises(SystemExit) as found:
        module.main()
    return found.value


def test_ctrl_c_before_the_command_started_ends_as_by_a_signal(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """With 128 and the number of the signal, which is 2."""
    assert ended(KeyboardInterrupt(), monkeypatch).code == 128 + 2
    assert capsys.readouterr().err == "contactstudy: stopped before the command started.\n"


def test_a_package_that_is_missing_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    missing = ModuleNotFoundError("No module named 'xarray'", name="xarray")
    code = ended(missing, monkeypatch).code
    assert isinstance(code, str)
    assert code.startswith("contactstudy: ")
    assert "xarray" in code
