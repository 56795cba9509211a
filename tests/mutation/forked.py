"""Tests in a fork of this process, which has numpy and the like imported and the project's modules not."""

import importlib
import os
import signal
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path

import pytest

IMPORTED = (
    *("numpy.testing", "scipy.fft", "scipy.integrate", "scipy.interpolate", "scipy.linalg"),
    *("scipy.optimize", "scipy.signal", "scipy.sparse.linalg", "scipy.special", "scipy.stats"),
    *("xarray", "netCDF4", "pandas", "matplotlib.pyplot", "hypothesis", "hypothesis.strategies"),
    *(
        "hypothesis.extra.numpy",
        "cattrs",
        "click.testing",
        "ducc0",
        "mpmath",
        "pint",
        "distributed",
    ),
)
ENDED = "ended "  # a process that dies does not say so


@dataclass
class _Chosen:
    """A pytest plugin: runs the chosen tests in their order, and keeps the first that fails."""

    tests: dict[str, int]
    failed: str = ""
    errors: list[str] = field(default_factory=list)

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        items[:] = sorted(
            (item for item in items if item.nodeid in self.tests),
            key=lambda item: self.tests[item.nodeid],
        )

    def pytest_collectreport(self, report: pytest.CollectReport) -> None:
        if report.failed:
            self.failed = self.failed or report.nodeid

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.failed:
            self.failed = self.failed or report.nodeid


def import_libraries() -> None:
    """Once, so that no fork has to."""
    for name in IMPORTED:
        importlib.import_module(name)


def first_failure(tests: list[str], copy: Path, seconds: float) -> str | None:
    """The first of the tests that fails in the copy of the project, or the first file that cannot be read, or
    "" where all pass; None where they are not through after so many seconds.
    """
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        os.setsid()
        os.write(writer, f"{ENDED}{_run(tests, copy)}".encode())
        os._exit(0)
    os.close(writer)
    os.set_blocking(reader, False)
    until = time.monotonic() + seconds
    while os.waitpid(child, os.WNOHANG) == (0, 0):
        if time.monotonic() > until:
            os.killpg(child, signal.SIGKILL)
            os.waitpid(child, 0)
            os.close(reader)
            return None
        time.sleep(0.02)
    with os.fdopen(reader, "rb") as said:
        return (said.read() or tests[0].encode()).decode().removeprefix(ENDED)


def _run(tests: list[str], copy: Path) -> str:
    for name in [name for name in sys.modules if name.partition(".")[0] == "tests"]:
        del sys.modules[name]
    os.chdir(copy)
    sys.path.insert(0, str(copy))
    sys.dont_write_bytecode = True
    os.environ |= {"PYTHONPATH": str(copy), "PYTHONDONTWRITEBYTECODE": "1"}
    silent = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1, 2):
        os.dup2(silent, stream)
    chosen = _Chosen({test: place for place, test in enumerate(tests)})
    files = list(dict.fromkeys(test.partition("::")[0] for test in tests))
    code = pytest.main(["-x", "-q", "-p", "no:cacheprovider", *files], plugins=[chosen])
    return chosen.failed or ("" if code in (0, 5) else tests[0])
