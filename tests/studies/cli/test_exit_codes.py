"""How the command ends: its exit codes, the cost that it announces and the times that it says."""

from pathlib import Path
from types import SimpleNamespace

import click
import pytest
from click.testing import CliRunner

import contactstudy as cs
from studies.cli import commands
from tests.studies.scene_study.conftest import SMOOTH


@pytest.mark.parametrize(
    ("error", "code", "said"),
    [
        (cs.InvalidInput("radius is 0."), 2, "contactstudy: radius is 0.\n"),
        (click.ClickException("no"), 1, "Error: no\n"),
        (KeyboardInterrupt(), 130, "contactstudy: stopped; what a study had stored is kept.\n"),
        (click.Abort(), 130, "contactstudy: stopped; what a study had stored is kept.\n"),
        (BrokenPipeError(), 141, ""),
        (ModuleNotFoundError("No module named 'x'", name="x"), 1, "contactstudy: "),
        (OSError(28, "No space left on device", "a.nc"), 1, "No space left on device: a.nc\n"),
        (MemoryError(), 1, "contactstudy: there is not enough memory"),
    ],
    ids=lambda part: type(part).__name__,
)
def test_each_way_to_end_has_its_exit_code(
    error: BaseException,
    code: int,
    said: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    def fails(**_: object) -> None:
        raise error

    monkeypatch.setattr(commands.cli, "main", fails)
    # the last thing that a broken pipe does is to leave its output
    monkeypatch.setattr("sys.stdout", SimpleNamespace())
    with pytest.raises(SystemExit) as ended:
        commands.main()
    assert ended.value.code == code
    assert said in capsys.readouterr().err


def test_a_command_ends_with_one_where_a_solve_did_not_converge(tmp_path: Path) -> None:
    path = tmp_path / "smooth.toml"
    path.write_text(SMOOTH + "\n[solve]\nmax_iterations = 1\ntolerance = 1e-12\n", encoding="utf-8")
    result = CliRunner().invoke(commands.cli, ["solve", str(path), "--out", str(tmp_path / "out")])
    assert result.exit_code == 1
    assert "ITERATION_LIMIT" in result.output
    assert (tmp_path / "out" / "smooth.nc").is_file()
