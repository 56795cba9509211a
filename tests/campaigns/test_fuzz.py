import io
import random
import resource
import sys
from collections.abc import Iterator
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path

import pytest

from studies.cli import commands
from tests.campaigns.conftest import case_count
from tests.studies.test_registry import GOOD

ROOT = Path(__file__).parents[2]
# numbers too large, too small or of another script, lists and ranges that are none, paths and commands, and no text
ODD = [
    "1e400", "nan", "-inf", "１２", "٣", "-0", "0", "5e-324", "1e308", "4294967296", "9" * 5000, "0:1e12", "0:99999999",
    "::", "1:0", "0:10:0", "0:10:2:3", ",,", "1,a", "0x10", "1_000", "--", "1;2", "None", "[1,2]", "1j", "%s", "$(id)",
    "../..", "é", "a" * 300, "", " ", "\n", "\udcff",
]  # fmt: skip
# the same as values of a scene, with units and types that are none
SCENE_ODD = [
    "1e400", "nan", "-inf", "-0.0", "5e-324", "1e308", "-1", "0", "''", "'１mm'", "'1e400m'", "true", "[]", "{}",
    "[[1]]", "'nanm'", "1979-05-27", "'10parsec'", "'10degC'", "'0x10m'", "'<script>'", "[1000000,1000000]",
    "[3000000000,1]", "[0,0]", "[1.5,2]", '["1",2]', "1" * 5000, "[" * 3000,
]  # fmt: skip
RETURNED = "measures(case, result): return {"
STUDY = GOOD.replace(RETURNED, f"{RETURNED}'square': result ** 2")


@pytest.fixture(autouse=True)
def _bounded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """What takes all memory fails at 8 GB, and relative paths are the test's own."""
    limits = resource.getrlimit(resource.RLIMIT_AS)
    monkeypatch.chdir(tmp_path)
    resource.setrlimit(resource.RLIMIT_AS, (8 << 30, limits[1]))
    yield
    resource.setrlimit(resource.RLIMIT_AS, limits)


def ends_well(*words: str, given: str = "") -> None:
    """Run the command: it ends with a code, and says something where that is not 0; what else it raises is raised."""
    said, code = io.StringIO(), 0
    with pytest.MonkeyPatch.context() as patch, redirect_stdout(said), redirect_stderr(said):
        patch.setattr(sys, "argv", ["contactstudy", *words])
        try:
            commands.main()
        except SystemExit as end:
            code = end.code or 0
    assert code in (0, 1, 2), (code, words, given)
    assert "Traceback" not in said.getvalue(), (words, given)
    assert not code or said.getvalue().strip(), (words, given)


def command_line(rng: random.Random) -> list[str]:
    axis = rng.choice(["period", "grid", "images", "padding", "perod"])
    option = rng.choice(["--workers", "--repeats", "--time-limit", "--retry", "--scheduler", "--out"])
    odd = rng.choice(ODD)
    return rng.choice(
        [
            ["run", "padding", "--dry-run", "--out", "cf", f"--{axis}={odd}"],
            ["run", "padding", "--dry-run", "--period=2.4", "--grid=16", "--images=0", option, odd],
            ["report", rng.choice(["--error", "--scene"]), odd],
            [rng.choice(["run", "show", "plan", "solve", "studies", "nope", odd]), odd],
            ["show", "padding.nc", "--out", odd],
        ]
    )


def test_no_command_line_ends_in_a_traceback() -> None:
    rng = random.Random(11)
    for _ in range(case_count(whole=1000, thin=12)):
        ends_well(*command_line(rng))


def mangled(text: str, rng: random.Random, odd: list[str]) -> str:
    """``text`` with a value, a line or a few characters changed."""
    lines = text.split("\n")
    at = rng.randrange(len(lines))
    match rng.randrange(5):
        case 0 | 1:
            at = rng.choice([place for place, line in enumerate(lines) if "=" in line])
            lines[at] = lines[at].split("=")[0] + "= " + rng.choice(odd)
        case 2:
            del lines[at]
        case 3:
            lines.insert(rng.randrange(len(lines)), lines[at])
        case 4:
            letters = list(text)
            for _ in range(rng.randrange(1, 4)):
                letters[rng.randrange(len(letters))] = rng.choice("\0\n\"'(=[]0١ÿ😀")
            return "".join(letters)
    return "\n".join(lines)


@pytest.mark.whole
def test_no_scene_file_ends_in_a_traceback() -> None:
    rng = random.Random(12)
    scenes = [path.read_text(encoding="utf-8") for path in sorted((ROOT / "examples").rglob("*.toml"))]
    for _ in range(case_count(whole=1000, thin=12)):
        text = mangled(rng.choice(scenes), rng, SCENE_ODD)
        Path("scene.toml").write_bytes(text.encode("utf-8", "surrogatepass"))
        ends_well("plan", "scene.toml", given=text)


def test_no_study_file_ends_in_a_traceback() -> None:
    rng = random.Random(13)
    for number in range(case_count(whole=1000, thin=20)):
        text = mangled(STUDY, rng, ["None", "()", "5", "'a'", "[1]", "(1, 'a')", "print", "1/0"])
        path = Path(f"study{number}.py")
        path.write_bytes(text.encode("utf-8", "surrogatepass"))
        ends_well("run", str(path), "--out", f"out{number}", "--workers", "0", given=text)
