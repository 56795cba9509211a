"""Which tests pass on the unchanged code, how long each takes, and which lines each executes."""

import ast
import os
import subprocess
import sys
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from xml.etree import ElementTree

from coverage import CoverageData

from tests.mutation.mutations import Mutation


@dataclass(frozen=True)
class CoverageRecord:
    """What one run of the suite on the unchanged code left in ``folder``."""

    folder: Path

    @property
    def _outcomes(self) -> Path:
        return self.folder / "outcomes.xml"

    @property
    def _lines(self) -> Path:
        return self.folder / "lines.coverage"

    def measure(self, copy: Path, jobs: int) -> None:
        """Run the suite of a copy of the project, unless that was done before."""
        if self._outcomes.exists():
            return
        self.folder.mkdir(parents=True, exist_ok=True)
        command = [sys.executable, *f"-m pytest -q -n {jobs} -p no:cacheprovider".split()]
        measured = ["--cov=contactstudy", "--cov=studies", "--cov-context=test", "--cov-report="]
        environment = os.environ | {"PYTHONPATH": str(copy), "COVERAGE_FILE": str(self._lines)}
        subprocess.run(
            [*command, *measured, f"--junitxml={self._outcomes}"], cwd=copy, env=environment
        )

    @cached_property
    def seconds(self) -> dict[str, float]:
        """Of each test that passed, by its node id."""
        return {
            f"{case.attrib['classname'].replace('.', '/')}.py::{case.attrib['name']}": float(
                case.attrib["time"]
            )
            for case in ElementTree.parse(self._outcomes).iter("testcase")
            if all(case.find(kind) is None for kind in ("failure", "error", "skipped"))
        }

    @cached_property
    def _data(self) -> CoverageData:
        data = CoverageData(str(self._lines))
        data.read()
        return data

    def tests_of(self, mutation: Mutation, text: str) -> list[str]:
        """The tests that execute the changed statement, the quickest first; of a statement that is
        executed at the import, those that execute anything in the module.
        """
        of_lines = self._data.contexts_by_lineno(mutation.path)
        lines = statement_in_function(text, mutation.line) or of_lines
        named = {name.partition("|")[0] for line in lines for name in of_lines.get(line, ())}
        return sorted(named & self.seconds.keys(), key=self.seconds.__getitem__)


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
