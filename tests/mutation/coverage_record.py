"""Which tests pass on the unchanged code, how much processor time each takes, and which lines each executes."""

import ast
import json
import os
import shutil
from collections import defaultdict
from collections.abc import Generator
from dataclasses import dataclass, field
from difflib import SequenceMatcher
from functools import cached_property
from multiprocessing import get_context
from pathlib import Path

import pytest
from coverage import Coverage, CoverageData

from tests.mutation.forked import OPTIONS, enter
from tests.mutation.mutations import Mutation


@dataclass(frozen=True)
class CoverageRecord:
    """What the tests of each folder on the unchanged code, which is kept too, left in ``folder``."""

    folder: Path

    @property
    def _source(self) -> Path:
        return self.folder / "source"

    def measure(self, project: Path) -> None:
        """Run the tests of a copy of the project, but those of folders that were run before."""
        self.folder.mkdir(parents=True, exist_ok=True)
        if not self._source.exists():
            for name in ("contactstudy", "studies"):
                shutil.copytree(project / name, self._source / name)
        files = defaultdict(list)
        for file in sorted(project.glob("tests/**/test_*.py")):
            files[".".join(file.parent.relative_to(project).parts)].append(str(file))
        for name, several in files.items():
            record = self.folder.resolve() / name
            if not record.with_name(f"{name}.json").exists():
                child = get_context("fork").Process(target=_record, args=(record, project, several))
                child.start()
                child.join()

    @cached_property
    def seconds(self) -> dict[str, float]:
        """Of processor time of one case of each test that passed, by its node id without the case."""
        records = [json.loads(file.read_text("utf-8")) for file in self.folder.glob("*.json")]
        return {test: seconds for record in records for test, seconds in record.items()}

    @cached_property
    def _data(self) -> list[CoverageData]:
        several = [CoverageData(str(file)) for file in self.folder.glob("*.coverage")]
        for data in several:
            data.read()
        return several

    def tests_of(self, mutation: Mutation, text: str) -> list[str]:
        """The tests that execute the changed statement, the quickest first; of a statement that is
        executed at the import, those that execute anything in the module.
        """
        of_lines = defaultdict(set)
        for data in self._data:
            for line, tests in data.contexts_by_lineno(mutation.path).items():
                of_lines[line] |= set(tests)
        lines = statement_in_function(text, mutation.line)
        chosen = self._recorded(mutation.path, text, lines) if lines else of_lines
        named = {name for line in chosen for name in of_lines[line]}
        return sorted(named & self.seconds.keys(), key=self.seconds.__getitem__)

    def _recorded(self, path: str, text: str, lines: range) -> list[int]:
        """Lines of the recorded source that the lines of today's text are, or stand in place of."""
        if not (self._source / path).exists():
            return []
        before = (self._source / path).read_text("utf-8").splitlines()
        blocks = SequenceMatcher(None, before, text.splitlines(), autojunk=False).get_opcodes()
        return [
            line
            for _, start, end, new_start, new_end in blocks
            for line in range(start + 1, end + 1)
            if any(new_start < new <= new_end for new in lines)
            and (end - start != new_end - new_start or line - start + new_start in lines)
        ]


def statement_in_function(text: str, line: int) -> range:
    """The lines from the start of the innermost statement around ``line`` to it; none outside of functions."""
    functions = [node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.FunctionDef)]
    starts = [
        node.lineno
        for function in functions
        for statement in function.body
        for node in ast.walk(statement)
        if isinstance(node, ast.stmt) and node.lineno <= line <= (node.end_lineno or 0)
    ]
    return range(max(starts), line + 1) if starts else range(0)


@dataclass(eq=False)
class _Recorder:
    """A pytest plugin: keeps the lines that each test executes, and its processor time."""

    coverage: Coverage
    seconds: dict[str, float] = field(default_factory=lambda: defaultdict(float))
    failed: set[str] = field(default_factory=set)

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Generator[None, object, object]:
        test, start = item.nodeid.partition("[")[0], sum(os.times()[:4])
        self.coverage.switch_context(test)
        result = yield
        self.seconds[test] += sum(os.times()[:4]) - start
        return result

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if not report.passed:
            self.failed.add(report.nodeid.partition("[")[0])


def _record(record: Path, project: Path, files: list[str]) -> None:
    """Run one case of each test of the files."""
    enter(project)
    coverage = Coverage(f"{record}.coverage", include=["contactstudy/*", "studies/*"])
    recorder = _Recorder(coverage)
    coverage.start()
    pytest.main([*OPTIONS, "-q", "--cases", "1", "-p", "no:cov", *files], plugins=[recorder])
    coverage.stop()
    coverage.save()
    passed = {test: s for test, s in recorder.seconds.items() if test not in recorder.failed}
    Path(f"{record}.json").write_text(json.dumps(passed), encoding="utf-8")
