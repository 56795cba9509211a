"""Changes the code in one place at a time and tells which changes no test notices.

``python -m tests.mutation.campaign --count 70 --seed 1`` runs, in a copy of the project and on each change,
the tests of the changed module and then those that execute the changed statement, the quickest first. A test
counts only if it passes on the unchanged code, run in the same manner.
"""

import argparse
import os
import random
import shutil
import tempfile
from dataclasses import dataclass, field
from pathlib import Path

from tests.mutation.coverage_record import CoverageRecord, statement_in_function
from tests.mutation.forked import first_failure, import_libraries
from tests.mutation.mutations import Mutation, chosen, mutations

ROOT = Path(__file__).parents[2]
COPIED = (
    "contactstudy", "studies", "tests", "docs", "examples",
    "README.md", "CONTRIBUTING.md", "CHANGELOG.md", "CITATION.cff", "LICENSE", "pyproject.toml",
)  # fmt: skip
SURVIVED = "survived"


@dataclass
class Campaign:
    """In a copy of the project; on each change, tests that take so many seconds of processor time together."""

    record: CoverageRecord
    copy: Path
    seconds: float
    red: set[str] = field(default_factory=set)  # on the unchanged code
    green: set[str] = field(default_factory=set)

    def fate(self, mutation: Mutation) -> str:
        """What noticed the change, if anything did."""
        for tests in self._stages(mutation):
            while tests and (failed := self._first_failure(tests, mutation)):
                if self._passes_unchanged(failed):
                    return f"noticed by {failed}"
                tests = [one for one in tests if one not in self.red]
        return SURVIVED

    def _stages(self, mutation: Mutation) -> tuple[list[str], list[str]]:
        """The module's own files of tests, then the tests that execute the statement, the quickest first.

        Of a statement that is executed at the import, those of the module's folder too; of one that none is known
        to execute, all files of the folder.
        """
        folder = Path("tests", mutation.path).parent
        while not (self.copy / folder).is_dir():
            folder = folder.parent
        files = sorted((self.copy / folder).glob(f"test_{Path(mutation.path).stem}*.py"))
        text = (self.copy / mutation.path).read_text(encoding="utf-8")
        executing = self.record.tests_of(mutation, text)
        seconds = self.record.seconds
        if not statement_in_function(text, mutation.line):
            # the import was noted for the test that was the first to import the module
            own_folder = {one for one in seconds if one.startswith(f"{folder.as_posix()}/")}
            executing = sorted(own_folder.union(executing), key=seconds.__getitem__)
        if not executing:  # by another process, or by nothing when that was measured
            files += sorted(set((self.copy / folder).glob("test_*.py")) - set(files))
        own = [str(file.relative_to(self.copy)) for file in files]
        left, quickest = self.seconds, []
        for test in executing:
            if test.partition("::")[0] not in own and left > 0:
                left -= seconds[test]
                quickest.append(test)
        return own, quickest

    def _first_failure(self, tests: list[str], mutation: Mutation) -> str:
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
            if failed:
                print(f"{test} is red on the unchanged code and does not count", flush=True)
            (self.red if failed else self.green).add(test)
        return test in self.green

    def _patience(self, tests: list[str]) -> int:
        known = self.record.seconds
        return 60 + round(10 * sum(known[one] for one in known if one.startswith(tuple(tests))))


def _copy(folder: Path) -> Path:
    for name in COPIED:
        if (ROOT / name).is_dir():
            shutil.copytree(ROOT / name, folder / name)
        else:
            shutil.copy2(ROOT / name, folder)
    return folder


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
    parser.add_argument(
        "--seconds", type=float, default=30.0, help="of processor time of tests on each change"
    )
    parser.add_argument("--tier", choices=("default", "whole"), default="default", help="of tests")
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
    survivors = []
    with tempfile.TemporaryDirectory() as name:
        copy = _copy(Path(name))
        import_libraries()
        record.measure(copy)
        changes = _asked_for(asked, copy)
        campaign = Campaign(record, copy, asked.seconds)
        for mutation in changes:
            fate = campaign.fate(mutation)
            print(f"{mutation}: {fate}", flush=True)
            survivors += [mutation] * (fate == SURVIVED)
    print(f"{len(changes) - len(survivors)} of {len(changes)} changes were noticed", end=" ")
    print(f"in {sum(os.times()[:4]):.0f} s of processor time; these survived:")
    print(*survivors, sep="\n")


if __name__ == "__main__":
    main()
