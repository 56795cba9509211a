"""How commands begin and end, and what ``run`` and ``studies`` do."""

from pathlib import Path
from types import SimpleNamespace

import click
import pytest

import contactstudy as cs
from studies.cli import commands
from studies.cli import main as module
from tests.studies.cli.conftest import said
from tests.studies.test_registry import GOOD


def test_a_run_leaves_its_dataset_and_the_figures_that_need_no_times(tmp_path: Path) -> None:
    few = ("--repeats", 0, "--workers", 0, "--vary", "grid=16", "--vary", "period=2.4")
    said("run", "padding", "--out", tmp_path, *few)
    assert (tmp_path / "padding.nc").is_file()
    assert [path.name for path in tmp_path.glob("padding/*")] == ["paddings.png"]


def test_bad_input_is_one_sentence_and_leaves_nothing(tmp_path: Path) -> None:
    with pytest.raises(cs.InvalidInput, match=r"^Study 'paddin' is not known: did you mean 'padding', or give a .py"):
        said("run", "paddin", "--out", tmp_path)
    (tmp_path / "file").touch()
    with pytest.raises(cs.InvalidInput, match=r"cannot be written to .*: give another with --out"):
        said("run", "padding", "--out", tmp_path / "file" / "x")
    assert "Error: Missing argument 'STUDY'" in said("run", "--out", tmp_path, code=2)
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


def test_a_study_of_ones_own_runs_under_any_name_and_fails_in_a_sentence(tmp_path: Path) -> None:
    path, run = tmp_path / "json.py", ("run", tmp_path / "json.py", "--repeats", 0, "--out", tmp_path, "--workers")
    right = GOOD.replace("result): return {}", 'result): return {"peak": result.real}')
    path.write_text(right, encoding="utf-8")
    said(*run, 1)
    said("show", tmp_path / "numbers.nc")
    path.write_text(right.replace("result.real", "result.MAX"), encoding="utf-8")
    failed = said(*run, 0, code=1)
    assert "2 of 2 cases failed, the first with AttributeError in measures" in failed
    assert "numbers: no case gave numbers, so there is nothing to draw.\n" in failed
    with pytest.raises(cs.InvalidInput, match="2 of 2 cases failed, the first with AttributeError"):
        said("show", tmp_path / "numbers.nc")


def test_there_are_eight_commands_with_forty_options_at_most() -> None:
    every = commands.cli.commands
    assert set(every) == {"new", "plan", "solve", "run", "report", "show", "compare", "studies"}
    options = [part for command in every.values() for part in command.params if isinstance(part, click.Option)]
    assert len(options) <= 40
    # one name has one meaning: a flag, a number, a folder
    assert len({(part.opts[0], part.type.name) for part in options}) == len({part.opts[0] for part in options})


def test_the_studies_are_listed_with_their_axes_and_units() -> None:
    listed = said("studies")
    assert "  period: period length over Hertz half-width: 0.6, 2.4\n" in listed
    assert "  time_steps_end: end of time_steps [s]: 0.05, 0.1, " in listed


@pytest.mark.cases(100)
@pytest.mark.parametrize(
    ("error", "code", "said"),
    [
        (cs.InvalidInput("radius is 0."), 2, "contactstudy: radius is 0.\n"),
        (click.ClickException("no"), 1, "Error: no\n"),
        (KeyboardInterrupt(), 130, "contactstudy: stopped; no file is half-written.\n"),
        (BrokenPipeError(), 141, ""),
        (ModuleNotFoundError("No module named 'x'", name="x"), 1, "contactstudy: "),
        (OSError(28, "No space left on device", "a.nc"), 1, "No space left on device: a.nc\n"),
        (MemoryError(), 1, "contactstudy: there is not enough memory"),
    ],
    ids=lambda part: type(part).__name__,
)
def test_each_way_to_end_has_its_exit_code(
    error: BaseException, code: int, said: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
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


@pytest.mark.parametrize(
    ("raised", "said"),
    [
        (KeyboardInterrupt(), "contactstudy: stopped before the command started.\n130"),
        (ModuleNotFoundError("No module named 'xarray'", name="xarray"), "contactstudy: "),
    ],
)
def test_what_ends_a_command_before_it_started_is_said(
    raised: BaseException, said: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def run() -> None:
        raise raised

    monkeypatch.setattr(commands, "main", run)
    with pytest.raises(SystemExit) as ended:
        module.main()
    # Python prints a text that is given as a code, and ends with 1
    assert said in f"{capsys.readouterr().err}{ended.value.code}"
