"""Changes the code in one place at a time and tells which changes no test notices.

``python -m tests.mutation.campaign --count 70 --seed 1`` collects the tests once. Each change is made in a fork of that
process, which runs the tests of the changed module and then those that call the changed function, the quickest first.
A test counts only if it passes on the unchanged code.
"""

import argparse
import json
import os
import random
import resource
import select
import signal
import sys
from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from types import FrameType

import pytest

from tests.mutation.in_place import changed_function, put_in_place
from tests.mutation.mutations import Mutation, chosen

ROOT = Path(__file__).parents[2]
SURVIVED, NOT_TRIED = "survived", "cannot be made in a loaded module"
BUSY = 30  # times the processor time passes on a busy machine


def forked(run: Callable[[], str], seconds: float) -> str:
    """What a function says in a fork; or that it ended, as after so many seconds of processor time."""
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        os.setsid()
        silent = os.open(os.devnull, os.O_RDWR)
        for stream in (0, 1, 2):
            os.dup2(silent, stream)
        try:
            limit = int(spent() + seconds) + 1
            resource.setrlimit(resource.RLIMIT_CPU, (limit, limit))
            os.write(writer, run().encode() or b"\0")
        finally:
            os._exit(0)
    os.close(writer)
    select.select([reader], [], [], BUSY * seconds)
    os.killpg(child, signal.SIGKILL)
    os.waitpid(child, 0)
    os.set_blocking(reader, False)
    with os.fdopen(reader, "rb") as said:
        return (said.read() or b"the end of the process").decode().strip("\0")


def spent() -> float:
    """Processor time [s] of this process and of those that it started and that ended."""
    return sum(os.times()[:4])


@dataclass(eq=False)
class Campaign:
    """A pytest plugin: tries the changes in place of running the tests; ``seconds`` of tests on each."""

    changes: list[Mutation]
    seconds: float
    record: Path
    failed: str = ""
    tests: dict[str, list[pytest.Item]] = field(default_factory=lambda: defaultdict(list))
    green: set[str] = field(default_factory=set)  # on the unchanged code

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.failed:
            self.failed = self.failed or report.nodeid

    def pytest_runtestloop(self, session: pytest.Session) -> bool:
        for item in session.items:
            self.tests[item.nodeid.partition("[")[0]].append(item)
        known = self._known()
        survivors = []
        for change in self.changes:
            fate = self._fate(change, known)
            print(f"{change}: {fate}", flush=True)
            survivors += [change] * (fate == SURVIVED)
        print(f"{len(survivors)} of {len(self.changes)} changes survived", end=" ")
        print(f"in {spent():.0f} s of processor time:", *survivors, sep="\n", flush=True)
        return True

    def _known(self) -> dict[str, list]:
        """Processor time [s] of one case of each test, and the functions that it calls."""
        if not self.record.exists():
            noted: dict[str, list] = {}
            for test, items in self.tests.items():
                said = forked(partial(self._calls, items[0]), 600)
                noted[test] = json.loads(said) if said.startswith("[") else [600.0, []]
            self.record.write_text(json.dumps(noted), encoding="utf-8")
        return json.loads(self.record.read_text(encoding="utf-8"))

    def _calls(self, item: pytest.Item) -> str:
        called = {}

        def note(frame: FrameType, event: str, _: object) -> None:
            called[id(frame.f_code)] = frame.f_code

        before = spent()
        sys.setprofile(note)
        self._first_failure([item])
        sys.setprofile(None)
        inside = f"{ROOT}{os.sep}"
        names = {
            f"{code.co_filename.removeprefix(inside)}:{code.co_qualname}"
            for code in called.values()
            if code.co_filename.startswith((f"{inside}contactstudy", f"{inside}studies"))
        }
        return json.dumps([spent() - before, sorted(names)])

    def _first_failure(self, items: list[pytest.Item]) -> str:
        for item, following in zip(items, [*items[1:], None], strict=True):
            item.config.hook.pytest_runtest_protocol(item=item, nextitem=following)
            if self.failed:
                break
        return self.failed

    def _fate(self, change: Mutation, known: dict[str, list]) -> str:
        """What noticed the change, if anything did."""
        text = (ROOT / change.path).read_text(encoding="utf-8")

        def under_change(items: list[pytest.Item]) -> str:
            return self._first_failure(items) if put_in_place(change, text) else NOT_TRIED

        for tests in self._stages(change, text, known):
            limit = 60 + 10 * sum(known.get(test, [0.0])[0] for test in tests)
            left = [item for test in tests for item in self.tests[test]]
            while left and (failed := forked(partial(under_change, left), limit)):
                if failed == NOT_TRIED:
                    return NOT_TRIED
                alone = [item for item in left if item.nodeid == failed] or left
                # in a process of its own, so that no test before it counts
                if forked(partial(under_change, alone), limit) and self._passes(alone, limit):
                    return f"noticed by {failed}"
                left = [item for item in left if item not in alone]
        return SURVIVED

    def _passes(self, items: list[pytest.Item], limit: float) -> bool:
        names = {item.nodeid for item in items}
        if not names <= self.green and not forked(partial(self._first_failure, items), limit):
            self.green |= names
        return names <= self.green

    def _stages(self, change: Mutation, text: str, known: dict[str, list]) -> list[list[str]]:
        """The module's own files of tests, then the tests that call the function, the quickest first.

        Of what no test is known to call, as of what is executed at the import, those of the module's folder.
        """
        folder = Path("tests", change.path).parent
        while not (ROOT / folder).is_dir():
            folder = folder.parent
        own = f"{folder.as_posix()}/test_{Path(change.path).stem}"
        first = [test for test in self.tests if test.startswith((f"{own}.py", f"{own}_"))]
        function = changed_function(change, text)
        calling = [test for test, (_, names) in known.items() if function in names]
        if not calling:
            calling = [test for test in self.tests if test.startswith(f"{folder.as_posix()}/")]
        left, quickest = self.seconds, []
        for test in sorted(calling, key=lambda test: known.get(test, [0.0])[0]):
            if test in self.tests and test not in first and left > 0:
                left -= known.get(test, [0.0])[0]
                quickest.append(test)
        return [stage for stage in (first, quickest) if stage]


def main() -> None:
    """Run the campaign that the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=70)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="", help="modules whose path begins so")
    parser.add_argument(
        "--seconds", type=float, default=30.0, help="of processor time of tests on each change"
    )
    parser.add_argument("--tier", choices=("default", "whole"), default="default", help="of tests")
    parser.add_argument(
        "--record", type=Path, default=ROOT / ".mutation", help="file of which test calls what"
    )
    parser.add_argument("--list", action="store_true", help="list the changes and run nothing")
    asked = parser.parse_args()
    changes = chosen(ROOT, asked.count, asked.seed, asked.only)
    # in no order, so that a campaign that is stopped has been everywhere
    changes = random.Random(asked.seed).sample(changes, len(changes))
    if asked.list:
        print(*changes, sep="\n")
        return
    os.chdir(ROOT)
    os.environ |= {"TESTS": asked.tier, "PYTHONPATH": str(ROOT)}
    options = ["-q", "-s", "-n", "0", "-p", "no:cacheprovider", "tests"]
    pytest.main(options, plugins=[Campaign(changes, asked.seconds, asked.record)])


if __name__ == "__main__":
    main()
