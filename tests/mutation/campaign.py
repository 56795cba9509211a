"""Changes the code in one place at a time and tells which changes no test notices.

``python -m tests.mutation.campaign --count 70 --seed 1`` runs, in a copy of the project and on each change,
the tests of the changed module and then those that execute the changed statement, the quickest first. A test
counts only if it passes on the unchanged code, run in the same manner.
"""

import argparse
import os
import random
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass, field
from functools import partial
from multiprocessing import get_context
from pathlib import Path

from tests.mutation.coverage_record import CoverageRecord, statement_in_function
from tests.mutation.forked import first_failure, import_libraries
from tests.mutation.mutations import Mutation, chosen, mutations

ROOT = Path(__file__).parents[2]
FOLDERS = ("contactstudy", "studies", "tests", "docs", "examples")
FILES = (
    "README.md", "CONTRIBUTING.md", "CHANGELOG.md", "CITATION.cff", "LICENSE", "pyproject.toml",
)  # fmt: skip
KILLED, SURVIVED, OUT_OF_TIME = "killed by", "survived", "ran out of time"


@dataclass
class Campaign:
    """In a copy of the project; on each change, tests that take so many seconds together."""

    record: CoverageRecord
    copy: Path
    seconds: float
    red: set[str] = field(default_factory=set)  # on the unchanged code
    green: set[str] = field(default_factory=set)

    def fate(self, mutation: Mutation) -> str:
        """What noticed the change, if anything did."""
        for tests in self._stages(mutation):
            while tests:
                failed = self._first_failure(tests, mutation)
                if failed is None:
                    return OUT_OF_TIME
                if not failed:
                    break
                if self._passes_unchanged(failed):
                    return f"{KILLED} {failed}"
                tests = [one for one in tests if not self.red & {one, one.partition("::")[0]}]
        return SURVIVED

    def _stages(self, mutation: Mutation) -> list[list[str]]:
        """The module's own files of tests, then the tests that execute the statement, the quickest first.

        Of a statement that is executed at the import, those of the module's folder too.
        """
        folder = Path("tests", mutation.path).parent
        while not (self.copy / folder).is_dir():
            folder = folder.parent
        files = sorted((self.copy / folder).glob(f"test_{Path(mutation.path).stem}*.py"))
        text = (self.copy / mutation.path).read_text(encoding="utf-8")
        executing = self.record.tests_of(mutation, text)
        if not statement_in_function(text, mutation.line):
            # the import was noted for the test that was the first to import the module
            own_folder = {
                one for one in self.record.seconds if one.startswith(f"{folder.as_posix()}/")
            }
            executing = sorted(own_folder.union(executing), key=self.record.seconds.__getitem__)
        if not executing:  # by another process, or by nothing when that was measured
            files += sorted(set((self.copy / folder).glob("test_*.py")) - set(files))
        own = [str(file.relative_to(self.copy)) for file in files]
        passed = self.record.seconds
        left = self.seconds
        stages: list[list[str]] = [own, [], []]
        for test in executing:
            if test.partition("::")[0] not in own and left > 0:
                left -= passed[test]
                stages[1 if left > 0.9 * self.seconds else 2].append(test)
        return stages

    def _first_failure(self, tests: list[str], mutation: Mutation) -> str | None:
        target = self.copy / mutation.path
        text, times = target.read_text(encoding="utf-8"), target.stat()
        for compiled in target.parent.glob(f"__pycache__/{target.stem}.*.pyc"):
            compiled.unlink()
        target.write_text(mutation.applied(text), encoding="utf-8")
        try:
            return first_failure(tests, self.red, self.copy, self._patience(tests))
        finally:
            target.write_text(text, encoding="utf-8")
            os.utime(target, ns=(times.st_atime_ns, times.st_mtime_ns))

    def _passes_unchanged(self, test: str) -> bool:
        if test not in self.green | self.red:
            failed = first_failure([test], set(), self.copy, self._patience([test]))
            if failed != "":
                print(f"{test} is red on the unchanged code and does not count", flush=True)
            (self.green if failed == "" else self.red).add(test)
        return test in self.green

    def _patience(self, tests: list[str]) -> float:
        known = self.record.seconds
        return 60.0 + 10 * sum(known[one] for one in known if one.startswith(tuple(tests)))


def _compiled_copy(folder: Path) -> Path:
    """The project, its modules and tests compiled, so that no fork has to."""
    folder.mkdir()
    for name in FOLDERS:
        shutil.copytree(ROOT / name, folder / name)
    for name in FILES:
        shutil.copy2(ROOT / name, folder)
    command = [
        sys.executable,
        *["-m", "pytest", "-q", "--collect-only", "-n", "0", "-p", "no:cacheprovider"],
    ]
    environment = os.environ | {"PYTHONPATH": str(folder)}
    subprocess.run(command, cwd=folder, env=environment, stdout=subprocess.DEVNULL)
    return folder


_campaign: Campaign


def _begin(record: CoverageRecord, unchanged: Path, seconds: float) -> None:
    global _campaign
    copy = unchanged.with_name(str(os.getpid()))
    _campaign = Campaign(record, shutil.copytree(unchanged, copy), seconds)


def _fate(mutation: Mutation) -> tuple[Mutation, str]:
    return mutation, _campaign.fate(mutation)


def _asked_for(asked: argparse.Namespace, root: Path) -> list[Mutation]:
    """In no order, so that a campaign that is stopped has been everywhere."""
    if asked.again:
        lines = set(asked.again.read_text(encoding="utf-8").splitlines())
        paths = sorted({line.partition(":")[0] for line in lines if ".py:" in line})
        texts = {path: (root / path).read_text(encoding="utf-8") for path in paths}
        return [one for path in paths for one in mutations(path, texts[path]) if str(one) in lines]
    changes = chosen(root, asked.count, asked.seed, asked.only)
    return random.Random(asked.seed).sample(changes, len(changes))


def main() -> None:
    """Run the campaign that the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=70)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="", help="modules whose path begins so")
    parser.add_argument("--again", type=Path, help="a file with the changes to try, one a line")
    parser.add_argument("--seconds", type=float, default=60.0, help="of tests on each change")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="processes")
    parser.add_argument("--tier", choices=("default", "whole"), default="whole", help="of tests")
    parser.add_argument(
        "--record", type=Path, default=ROOT / ".mutation", help="folder of which test executes what"
    )
    parser.add_argument("--list", action="store_true", help="list the changes and run nothing")
    asked = parser.parse_args()
    if asked.list:
        print(*_asked_for(asked, ROOT), sep="\n")
        return
    os.environ["TESTS"] = asked.tier
    record = CoverageRecord(asked.record / asked.tier)
    fates = []
    with tempfile.TemporaryDirectory() as name:
        unchanged = _compiled_copy(Path(name, "unchanged"))
        record.measure(unchanged, asked.jobs)
        changes = _asked_for(asked, unchanged)
        import_libraries()
        begin = partial(_begin, record, unchanged, asked.seconds)
        with get_context("fork").Pool(asked.jobs, initializer=begin) as pool:
            for mutation, fate in pool.imap_unordered(_fate, changes):
                print(f"{mutation}: {fate}", flush=True)
                fates.append((mutation, fate))
    conclusive = [(one, fate) for one, fate in fates if fate != OUT_OF_TIME]
    survivors = [one for one, fate in conclusive if fate == SURVIVED]
    print(f"{len(conclusive) - len(survivors)} of {len(conclusive)} changes were noticed,", end=" ")
    print(f"{len(fates) - len(conclusive)} ran out of time; these survived:")
    print(*survivors, sep="\n")


if __name__ == "__main__":
    main()
