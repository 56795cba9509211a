"""The entry point of the command."""

from pathlib import Path

import pytest
from click.testing import CliRunner

from studies.cli import main as module
from studies.cli.commands import cli


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


@pytest.mark.parametrize(
    ("period", "sentence"),
    [
        ("10 mm", "no FiniteLength is needed"),
        ("12.5 mm", "add the shape FiniteLength(length=0.01)"),
    ],
)
def test_a_plan_says_whether_a_profiled_roller_needs_an_end(
    period: str, sentence: str, tmp_path: Path
) -> None:
    example = Path(__file__).parents[3] / "examples" / "edge-stress.toml"
    text = example.read_text(encoding="utf-8").replace(
        '["0.6 mm", "10 mm"]', f'["0.6 mm", "{period}"]'
    )
    (tmp_path / "roller.toml").write_text(text, encoding="utf-8")
    shown = CliRunner().invoke(cli, ["plan", str(tmp_path / "roller.toml")])
    assert shown.exit_code == 0, shown.output
    assert sentence in shown.output
