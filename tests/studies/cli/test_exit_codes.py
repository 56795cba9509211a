"""How the command ends: its exit codes, the cost that it announces and the times that it says."""

import os
from pathlib import Path
from types import SimpleNamespace

import click
import pytest
from click.testing import CliRunner

import contactstudy as cs
from studies.cli import commands, scenes, solving
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


def test_two_workers_and_two_repeats_are_the_default() -> None:
    shown = " ".join(CliRunner().invoke(commands.cli, ["report", "--help"]).output.split())
    assert "0 computes in this process alone. [default: 2; 0<=x<=1024]" in shown
    assert "the minimum is used. [default: 2; x>=1]" in shown


class Enough(Exception):
    """Where a test needs no more of a command."""


@pytest.mark.parametrize(
    ("seconds", "size", "said"),
    [(60.0, 4e9, ""), (61.0, 1e6, "61 s and 0.001 GB"), (1.0, 4.1e9, "1 s and 4.1 GB")],
)
def test_a_solve_of_more_than_a_minute_or_four_gigabytes_is_announced(
    seconds: float, size: float, said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "smooth.toml"
    path.write_text(SMOOTH, encoding="utf-8")
    planned = SimpleNamespace(seconds=seconds, bytes=size, warnings=())

    def enough(*_: object, **__: object) -> None:
        raise Enough

    monkeypatch.setattr(cs.SceneFile, "plan", lambda *_, **__: planned)
    monkeypatch.setattr(solving, "solved", enough)
    result = CliRunner().invoke(commands.cli, ["solve", str(path), "--out", str(tmp_path / "out")])
    assert isinstance(result.exception, Enough)
    assert ("estimated cost" in result.output) == bool(said)
    assert said in result.output


def test_one_core_is_there_where_none_is_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr(os, "sched_getaffinity", raising=False)
    monkeypatch.setattr(os, "cpu_count", lambda: None)
    assert scenes._cores() == 1
    monkeypatch.setattr(os, "cpu_count", lambda: 6)
    assert scenes._device("cpu", None) == cs.Cpu(6)


def test_a_command_ends_with_one_where_a_solve_did_not_converge(tmp_path: Path) -> None:
    path = tmp_path / "smooth.toml"
    path.write_text(SMOOTH + "\n[solve]\nmax_iterations = 1\ntolerance = 1e-12\n", encoding="utf-8")
    result = CliRunner().invoke(commands.cli, ["solve", str(path), "--out", str(tmp_path / "out")])
    assert result.exit_code == 1
    assert "ITERATION_LIMIT" in result.output
    assert (tmp_path / "out" / "smooth.nc").is_file()
