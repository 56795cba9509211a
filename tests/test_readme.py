"""Every block of the README and of docs/ runs, in order, and prints what its comments say."""

import re
import shlex
import shutil
from dataclasses import replace
from decimal import Decimal
from pathlib import Path

import pytest

import contactstudy as cs
from studies.cli.commands import cli
from studies.definitions.settings import case_at, measures
from studies.reference.paddings import BY_CLASS
from tests.readme_blocks import BLOCK, SAID

ROOT = Path(__file__).parent.parent
# Pages that the site makes from the program, and those for developers, whose commands test and build.
LEFT_OUT = ("_build", "gallery", "reference", "development")
PAGES = (
    "README.md",
    *sorted(
        str(page.relative_to(ROOT))
        for page in (ROOT / "docs").rglob("*.md")
        if page.relative_to(ROOT / "docs").parts[0] not in LEFT_OUT
    ),
)
# Set-up, which CI does with the README's own commands.
ELSEWHERE = ("python3 -m venv", ".venv/bin/pip")
# What makes a run quick, where its command does not say how often to repeat it.
QUICK = ("--workers", "0", "--repeats", "1")


@pytest.fixture(autouse=True)
def somewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shutil.copytree(ROOT / "examples", tmp_path / "examples")
    monkeypatch.chdir(tmp_path)


def command(line: str) -> None:
    """What a shell would do with ``line``, in this process and with the least of timing."""
    if line.startswith(ELSEWHERE):
        return
    program, *words = shlex.split(line, comments=True)
    assert program == ".venv/bin/contactstudy", line
    quick = QUICK if words[0] == "run" and "--repeats" not in words else ()
    cli.main([*words, *quick], standalone_mode=False)


@pytest.mark.whole
@pytest.mark.parametrize("page", [page for page in PAGES if BLOCK.search((ROOT / page).read_text(encoding="utf-8"))])
def test_every_block_of_a_page_runs_and_its_python_prints_what_it_says(
    page: str, capsys: pytest.CaptureFixture[str]
) -> None:
    known: dict[str, object] = {}
    for kind, block in BLOCK.findall((ROOT / page).read_text(encoding="utf-8")):
        capsys.readouterr()
        if kind == "sh":
            for line in block.splitlines():
                command(line)
        elif "study = Study(" in block:
            Path("radius.py").write_text(block, encoding="utf-8")
        elif kind == "python":  # "py" is for a cluster, or for libraries that are not needed
            exec(compile(block, page, "exec"), known)
            assert capsys.readouterr().out.splitlines() == SAID.findall(block)


NAMED = re.compile(r"^# *(contactstudy .*?)(?:  .*)?$", flags=re.MULTILINE)


@pytest.mark.whole
@pytest.mark.parametrize(
    "path",
    [path for path in sorted((ROOT / "examples").glob("*.toml")) if NAMED.search(path.read_text())],
    ids=lambda path: path.stem,
)
def test_commands_at_the_head_of_an_example_run(path: Path) -> None:
    """Of a range, with its first and its last value."""
    shutil.copy(path, path.name)
    for line in NAMED.findall(path.read_text(encoding="utf-8")):
        line = re.sub(r"(:[\d.]+):\d+", r"\1:2", line)
        quick = " --workers 0 --repeats 0" if " run " in line else ""
        command(f".venv/bin/{line}{quick}")


def test_the_table_of_paddings_has_the_errors_that_are_measured() -> None:
    """To half of the last digit shown, beside what the iteration leaves: some ten times its tolerance."""
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    of_table = re.search(r"cylinder, (\d+) x \1 cells over ([\d.]+) a x \2 a", text)
    assert of_table is not None
    case = case_at({"padding": "exact", "images": 0, "period": float(of_table[2]), "grid": int(of_table[1])})
    rows = re.findall(r"^\| `(\w+)\((.*?)\)`.*? \| (.*) \|$", text, flags=re.MULTILINE)
    rows = [row for row in rows if row[2].count("|") == 2]
    assert {name for name, *_ in rows} == set(BY_CLASS)
    for name, images, cells in rows:
        count = [int(images.removeprefix("images="))] if images else []
        padded = replace(case, padding=getattr(cs, name)(*count))
        found = measures(padded, padded.run(padded.prepare()))
        columns = ("pressure_error_l1", "axis_pressure_error", "length_variation")
        for shown, column in zip(cells.split(" | "), columns, strict=True):
            number = Decimal(shown.removesuffix(" %")) if shown != "none" else Decimal(0)
            half_digit = 10.0 ** int(number.as_tuple().exponent) / 2 if number else 0.0
            measured = abs(100 * float(found[column]))
            assert measured == pytest.approx(
                float(number), rel=0, abs=half_digit + 100 * 10 * case.options.tolerance
            ), f"{name}({images}): {column}"


def test_pages_link_to_what_is_there() -> None:
    for page in PAGES:
        for link in re.findall(r"\]\(([^)#\s]+)\)", (ROOT / page).read_text(encoding="utf-8")):
            if not any(part in link for part in ("gallery/", "reference/", "://")):
                assert (ROOT / page).parent.joinpath(link).exists(), f"{page}: {link}"
