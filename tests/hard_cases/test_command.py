"""A hundred malformed command lines: each a sentence and an exit code, and nothing written."""

import random
import sys
from pathlib import Path

import pytest

from studies.cli.commands import main

JUNK = (
    "", "nan", "-1", "1e999", "0.5.5", "ten", "[1]", "1;2", "é", "0:", "5:1", "--", "1,,2", "inf", "None",
)  # fmt: skip
SIZES = ("-1", "0", "nan", "x", "1.5", "2:1", "é", "", "1e3.5")


def malformed(rng: random.Random) -> list[str]:
    """A command that cannot be carried out, whatever the junk."""
    junk, size = rng.choice(JUNK), rng.choice(SIZES)
    return rng.choice(
        (
            ["run", f"no-{junk}-study"],
            ["run", f"{junk}.py"],
            ["run", "grid", "--grid", size],
            ["run", "grid", f"--grod={size}"],
            ["run", "padding", "--padding", f"un{junk}known"],
            ["run", "padding", "--period", rng.choice(("0", "-2", "nan", "a", "inf", ""))],
            ["run", "grid", "--workers", rng.choice(("-1", "two", "1.5"))],
            ["run", "grid", "--time-limit", rng.choice(("0", "-1", "soon"))],
            ["run", "grid", "--grid", "16", "--grid", "24"],
            ["run", "grid", "grid"],
            ["draw", f"{junk}?"],
            ["plan", f"{junk}.toml"],
            ["solve", f"{junk}.toml"],
            ["recommend", "--error", rng.choice(("0", "-1", "nan", "small", "inf"))],
            ["recommend", "--seconds", rng.choice(("0", "-1", "nan", "soon", "inf"))],
            ["recommend", "--scene", f"{junk}.toml"],
            ["report", "--scene", f"{junk}.toml"],
            [f"no-{junk}-command"],
            ["report", "--repeats", rng.choice(("0", "-3", "twice"))],
        )
    )


@pytest.mark.parametrize("seed", range(100))
def test_a_malformed_command_ends_in_a_sentence_and_leaves_nothing(
    seed: int,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    words = malformed(random.Random(seed))
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", ["contactstudy", *words])
    with pytest.raises(SystemExit) as ended:
        main()
    said = capsys.readouterr().err.strip()
    assert ended.value.code == 2, words
    assert len(said.splitlines()[-1]) > 20, words
    assert said.endswith((".", "?", "'")), said
    assert "Traceback" not in said
    assert not list(tmp_path.iterdir()), words
