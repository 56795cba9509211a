import os
import signal
import subprocess
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from types import SimpleNamespace

import click
import pytest
import xarray as xr

import contactstudy as cs
from studies.cli import commands
from studies.cli import main as module
from studies.cli.commands import main
from studies.cli.scenes import templates
from studies.model.outcome import CaseStatus
from tests.studies.cli.conftest import said
from tests.studies.conftest import POSIX
from tests.studies.scene_study.conftest import SMOOTH
from tests.studies.test_study_file import GOOD

EXAMPLES = Path(__file__).parents[3] / "examples"
COMMAND = str(Path(sys.executable).with_name("contactstudy"))

Call = Callable[..., subprocess.CompletedProcess[str]]


@pytest.fixture
def call(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]) -> Call:
    """The command, run in this process in an empty folder."""
    monkeypatch.chdir(tmp_path)

    def called(*arguments: str) -> subprocess.CompletedProcess[str]:
        monkeypatch.setattr(sys, "argv", ["contactstudy", *arguments])
        capfd.readouterr()
        try:
            main()
            code = 0
        except SystemExit as ended:
            code = ended.code
        return subprocess.CompletedProcess(sys.argv, code, *capfd.readouterr())

    return called


def test_a_run_leaves_its_dataset_and_the_figures_that_need_no_times(call: Call, tmp_path: Path) -> None:
    few = (
        "--repeats",
        "0",
        "--workers",
        "0",
        "--out",
        "here",
        "--vary",
        "grid=16",
        "--vary",
        "period=2.4",
    )
    done = call("run", "padding", *few)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "here" / "padding.nc").is_file()
    assert [path.name for path in tmp_path.glob("here/padding/*")] == ["paddings.png"]


@POSIX
@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["run", "paddin"], "Study 'paddin' is not known: did you mean 'padding', or give a .py file."),
        (
            ["run", "padding", "--vary", "period=nan"],
            "period is nan: give numbers such as 0.6,2.4, or n values of a range such as 0.6:2.4:4 or 1:100:3:log.",
        ),
        (
            ["run", "padding", "--vary", "grid=16", "--vary", "grid=24"],
            "--vary names grid twice: write all its values in one list.",
        ),
        (
            ["run", "padding", "--out", "/dev/null/x"],
            "Output folder '/dev/null/x' cannot be written to (Not a directory): give another with --out.",
        ),
        (
            ["run", "creep", "--repeats", "5"],
            "--repeats is for studies whose cases are timed, which creep does not do: leave it out.",
        ),
        (
            ["run", str(EXAMPLES / "rough.toml"), "--vary", "plan.error=0.1:0.2:1000001"],
            "plan.error has 1000001 values, more than 1000000: give fewer.",
        ),
    ],
    ids=lambda part: " ".join(part) if isinstance(part, list) else "",
)  # fmt: skip
def test_bad_input_is_one_sentence_and_leaves_nothing(
    arguments: list[str], sentence: str, call: Call, tmp_path: Path
) -> None:
    done = call(*arguments)
    assert done.returncode == 2
    assert done.stderr == f"contactstudy: {sentence}\n"
    assert list(tmp_path.iterdir()) == []


def test_fields_that_are_not_named_are_varied_as_the_file_says(call: Call, tmp_path: Path) -> None:
    own = 'load.per_length = "50,100 N/mm"\nshapes.0.radius = "8,10,12 mm"\n'
    (tmp_path / "own.toml").write_text(f"{SMOOTH}[vary]\n{own}", encoding="utf-8")
    once = "run", "own.toml", "--workers", "0"
    assert "6 points" in call(*once).stdout
    done = call(*once, "--vary", "load.per_length=70 N/mm", "--vary", "radius=8,10 mm")
    assert done.returncode == 0, done.stderr
    assert "2 points" in done.stdout
    assert "own-sweep.nc held 6 other cases, which stay in cases.jsonl" in done.stdout


@pytest.mark.cases(9)
@pytest.mark.parametrize(
    ("arguments", "remedy"),
    [
        (["nothing"], "No such command"), (["report", "--workers", "-1"], "not in the range"),
        (["run"], "Missing argument 'STUDY'"), (["report", "--sideways"], "No such option"),
        (["run", "padding", "--vary"], "requires an argument"), (["run", "padding", "more"], "extra argument (more)"),
        (["run", "x.toml", "--ot", "y"], "'--out'"),
    ],
)  # fmt: skip
def test_a_wrong_word_is_an_error_with_its_remedy(arguments: list[str], remedy: str, call: Call) -> None:
    done = call(*arguments)
    assert done.returncode == 2
    assert "Error: " in done.stderr
    assert remedy in done.stderr
    assert "Traceback" not in done.stderr


OWN = GOOD.replace("result): return {}", 'result): return {"peak": result.MAX}')
RIGHT = OWN.replace("MAX", "real")


def test_a_study_of_ones_own_runs_under_any_name_and_fails_in_a_sentence(call: Call, tmp_path: Path) -> None:
    path = tmp_path / "json.py"
    path.write_text(RIGHT, encoding="utf-8")
    done = call("run", "json.py", "--workers", "1", "--repeats", "0")
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "outputs" / "numbers.nc").is_file()
    assert call("show", "outputs/numbers.nc").returncode == 0
    path.write_text(OWN, encoding="utf-8")
    done = call("run", "json.py", "--workers", "0", "--repeats", "0")
    assert done.returncode == 1
    assert "2 of 2 cases failed, the first with AttributeError in measures" in done.stdout
    assert done.stderr == "numbers: no case gave numbers, so there is nothing to draw.\n"
    done = call("show", "outputs/numbers.nc")
    assert done.returncode == 2
    assert "2 of 2 cases failed, the first with AttributeError" in done.stderr


@POSIX
@pytest.mark.whole
@pytest.mark.parametrize("written", ["status", "time"], ids=["solving", "timing"])
def test_an_interrupt_ends_in_one_sentence_and_leaves_nothing_half_written(written: str, tmp_path: Path) -> None:
    journal = tmp_path / "here" / "cases.jsonl"
    axes = ["--vary", "padding=exact", "--vary", "grid=64,512"]
    running = subprocess.Popen(
        [COMMAND, "run", "grid", *axes, "--repeats", "99", "--out", "here"], cwd=tmp_path,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True,
    )  # fmt: skip
    assert "distinct cases" in running.stdout.readline()
    while not (journal.exists() and f'"{written}":' in journal.read_text(encoding="utf-8")):
        with suppress(subprocess.TimeoutExpired):
            running.wait(timeout=0.01)
            raise AssertionError(running.communicate())
    os.killpg(running.pid, signal.SIGINT)  # a terminal sends Ctrl-C to the whole group
    _, err = running.communicate()
    assert running.returncode == 130, err
    assert err.splitlines()[-1].startswith("contactstudy: stopped")
    assert "Traceback" not in err
    assert not list((tmp_path / "here").glob("*.partial*"))
    for path in (tmp_path / "here").glob("*.nc"):
        assert set(xr.load_dataset(path)["case_status"].values.flat) <= {
            CaseStatus.NOT_RUN,
            CaseStatus.OK,
        }


FEW = ["--vary", "padding=exact", "--vary", "period=2.4", "--vary", "images=6", "--workers", "0"]


@pytest.mark.whole
def test_options_of_a_run_do_what_they_say(tmp_path: Path) -> None:
    here = ["run", "period", *FEW, "--out", tmp_path]
    dry = said(*here, "--vary", "grid=16,24", "--dry-run")
    assert "2 distinct cases, 0 stored, 2 to compute" in dry
    assert list(tmp_path.iterdir()) == []
    said(*here, "--vary", "grid=16", "--repeats", "1", "--fields")
    assert len(list((tmp_path / "period.fields").iterdir())) == 1
    dry = said(*here, "--vary", "grid=16,24", "--dry-run")
    assert "1 stored, 1 to compute" in dry
    assert "s to compute" in dry
    grown = said(*here, "--vary", "grid=16,24", "--repeats", "3", "--retry", "times", "--retry", "failed")
    assert "1 case is stored, 1 to compute" in grown
    assert xr.load_dataset(tmp_path / "period.nc").sizes["repeat"] == 3


def test_there_are_eight_commands_with_forty_one_options_at_most() -> None:
    assert set(commands.cli.commands) == {
        "new", "plan", "solve", "run", "report", "show", "compare", "studies"
    }  # fmt: skip
    options = [
        part for command in commands.cli.commands.values() for part in command.params
        if isinstance(part, click.Option)
    ]  # fmt: skip
    assert len(options) <= 41
    # one name has one meaning: a flag, a number, a folder
    kinds: dict[str, set[str]] = {}
    for part in options:
        kinds.setdefault(part.opts[0], set()).add(str(part.type.name))
    assert all(len(types) == 1 for types in kinds.values()), kinds


def test_the_studies_are_listed_with_their_axes_and_units() -> None:
    listed = said("studies")
    assert "  period: period length over Hertz half-width: 0.6, 2.4\n" in listed
    assert "  time_steps_end: end of time_steps [s]: 0.05, 0.1, " in listed


@pytest.mark.parametrize(
    ("error", "code", "said"),
    [
        (cs.InvalidInput("radius is 0."), 2, "contactstudy: radius is 0.\n"),
        (click.ClickException("no"), 1, "Error: no\n"),
        (KeyboardInterrupt(), 130, "contactstudy: stopped; no file is half-written.\n"),
        (click.Abort(), 130, "contactstudy: stopped; no file is half-written.\n"),
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
    assert "ITERATION_LIMIT" in said("solve", path, "--out", tmp_path / "out", code=1)
    assert (tmp_path / "out" / "smooth.nc").is_file()


@pytest.mark.parametrize(
    ("raised", "said"),
    [
        (KeyboardInterrupt(), "contactstudy: stopped before the command started.\n"),
        (ModuleNotFoundError("No module named 'xarray'", name="xarray"), "xarray"),
    ],
)  # fmt: skip
def test_what_ends_a_command_before_it_started_is_said(
    raised: BaseException,
    said: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    def run() -> None:
        raise raised

    monkeypatch.setattr(commands, "main", run)
    with pytest.raises(SystemExit) as ended:
        module.main()
    # Ctrl-C ends as by its signal; Python prints a text that is given as a code, and ends with 1
    code = ended.value.code
    assert code == 128 + 2 or str(code).startswith("contactstudy: ")
    assert said in f"{capsys.readouterr().err}{code}"


def test_a_plan_says_whether_a_profiled_roller_needs_an_end(tmp_path: Path) -> None:
    text = (EXAMPLES / "edge-stress.toml").read_text(encoding="utf-8")
    for period, is_said in (("10 mm", False), ("12.5 mm", True)):
        longer = text.replace('["0.6 mm", "10 mm"]', f'["0.6 mm", "{period}"]')
        (tmp_path / "roller.toml").write_text(longer, encoding="utf-8")
        plan = said("plan", tmp_path / "roller.toml")
        assert ("add the shape FiniteLength(length=0.01)" in plan) == is_said


# Examples that are called by another name than their kind.
NAMES = {"film": "oil"}


@pytest.mark.parametrize("kind", templates())
def test_a_scene_to_begin_with_is_an_example_that_plans(kind: str, tmp_path: Path) -> None:
    path = tmp_path / f"{NAMES.get(kind, kind)}.toml"
    said("new", kind, "--out", path)
    assert path.read_text(encoding="utf-8") == (EXAMPLES / path.name).read_text(encoding="utf-8")
    assert cs.read_scene(path).plan().grid.cells[0] > 1


@pytest.mark.parametrize("kind", ["coated", pytest.param("fretting", marks=pytest.mark.whole)])
def test_a_scene_to_begin_with_solves(kind: str, tmp_path: Path) -> None:
    (tmp_path / "scene.toml").write_text(templates()[kind], encoding="utf-8")
    said("solve", tmp_path / "scene.toml", "--out", tmp_path)


def test_a_scene_is_begun_by_a_known_name_and_replaces_no_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    said("new", "rough")
    for words, remedy in (
        (["rough"], "exists already: give another file"),
        (["rollers"], "did you mean 'roller'"),
        ([], "choose from"),
    ):
        with pytest.raises(cs.InvalidInput, match=remedy):
            said("new", *words)
