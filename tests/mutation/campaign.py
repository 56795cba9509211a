"""Changes the code in one place at a time and tells which changes no test notices.

``python -m tests.mutation.campaign --count 70 --seed 1`` runs the tests of each changed module in a copy of
the project, the nearest first, and lists the survivors; with ``--wide``, those of the whole package as well. A
change that makes them run ten times as long as any of them should has been noticed too, and is told apart.
"""

import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from tests.mutation.mutations import Mutation, chosen

ROOT = Path(__file__).parents[2]
COPIED = ("contactstudy", "studies", "tests", "docs", "examples", "README.md", "pyproject.toml")
# Modules whose numbers are seen by the tests of others first.
NEXT = {
    "contactstudy/domain": ("tests/contactstudy/scene", "tests/contactstudy/elasticity"),
    "contactstudy/scene": ("tests/contactstudy/planning/test_grid_requirements.py",),
    "contactstudy/problem": ("tests/contactstudy/solvers", "tests/hard_cases/test_material.py"),
    "contactstudy/solvers": ("tests/contactstudy/problem", "tests/hard_cases/test_solver.py"),
    "contactstudy/elasticity": ("tests/contactstudy/domain/test_padding.py",),
    "contactstudy/accuracy": ("tests/contactstudy/planning",),
    "studies/reference": ("tests/hard_cases/test_load.py", "tests/hard_cases/test_perturbation.py"),
    "studies/store": ("tests/studies/engine/test_run.py",),
    "studies/model": ("tests/studies/engine/test_run.py", "tests/studies/engine/test_timing.py"),
}
MINUTES = 10.0
SURVIVED = "survived"


def stages(path: str, *, wide: bool = False) -> list[list[str]]:
    """The tests that may notice a change at ``path``: its own, those of its folder, those of its package."""
    module = Path(path)
    folder = Path("tests") / module.parent
    own = [
        str(test.relative_to(ROOT)) for test in sorted((ROOT / folder).glob(f"test_{module.stem}*"))
    ]
    while not (ROOT / folder).is_dir():
        folder = folder.parent
    package = "tests/contactstudy" if path.startswith("contactstudy") else "tests/studies"
    near = [str(folder)] if str(folder) != package else []
    more = [test for start, tests in NEXT.items() if path.startswith(start) for test in tests]
    found = [own, near + more, [package] if wide or not near else []]
    return [tests for tests in found if tests]


def fate(mutation: Mutation, copy: Path, *, wide: bool) -> str:
    """Whether the change was noticed, at the first of the stages that does."""
    target = copy / mutation.path
    before = target.read_text(encoding="utf-8")
    target.write_text(mutation.applied(before))
    try:
        for tests in stages(mutation.path, wide=wide):
            if (ended := _ended(tests, copy)) != SURVIVED:
                return ended
    finally:
        target.write_text(before)
    return SURVIVED


def _ended(tests: list[str], copy: Path) -> str:
    command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", *tests]
    environment = os.environ | {"PYTHONPATH": str(copy), "PYTHONDONTWRITEBYTECODE": "1"}
    try:
        done = subprocess.run(
            command, cwd=copy, env=environment, capture_output=True, text=True, timeout=60 * MINUTES
        )
    except subprocess.TimeoutExpired:
        return "timed out"
    if done.returncode in (0, 5):  # 5: no tests in there
        return SURVIVED
    failed = re.search(r"^(?:FAILED|ERROR) (\S+)", done.stdout, flags=re.MULTILINE)
    return f"killed by {failed[1]}" if failed else "killed"


def main() -> None:
    """Run the campaign that the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=70)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="", help="modules whose path begins so")
    parser.add_argument(
        "--wide", action="store_true", help="run the tests of the whole package too"
    )
    parser.add_argument("--list", action="store_true", help="list the changes and run nothing")
    asked = parser.parse_args()
    mutations = chosen(ROOT, asked.count, asked.seed, asked.only)
    if asked.list:
        print(*mutations, sep="\n")
        return
    survivors = []
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder)
        for name in COPIED:
            source = ROOT / name
            (shutil.copytree if source.is_dir() else shutil.copy)(source, copy / name)
        for mutation in mutations:
            ended = fate(mutation, copy, wide=asked.wide)
            survivors += [mutation] if ended == SURVIVED else []
            print(f"{mutation}: {ended}", flush=True)
    killed = len(mutations) - len(survivors)
    print(f"{killed} of {len(mutations)} changes were noticed; these were not:")
    print(*survivors, sep="\n")


if __name__ == "__main__":
    main()
