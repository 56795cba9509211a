"""Tests in a fork of this process, which has numpy and the like imported and the project's modules not."""

import importlib
import os
import resource
import select
import signal
import sys
from dataclasses import dataclass
from operator import itemgetter
from pathlib import Path

import pytest

IMPORTED = [
    "numpy.testing", "scipy.fft", "scipy.integrate", "scipy.interpolate", "scipy.linalg", "scipy.optimize",
    "scipy.signal", "scipy.sparse.linalg", "scipy.special", "scipy.stats", "xarray", "netCDF4", "pandas",
    "matplotlib.pyplot", "hypothesis", "hypothesis.strategies", "hypothesis.extra.numpy", "cattrs", "click.testing",
    "ducc0", "mpmath", "pint", "distributed",
]  # fmt: skip
ENDED = "ended "  # a process that dies does not say so
OPTIONS = ["-n", "0", "-p", "no:cacheprovider", "-W", "ignore::pytest.PytestAssertRewriteWarning"]
BUSY = 20  # times the processor time passes on a busy machine


@dataclass(eq=False)
class _Chosen:
    """A pytest plugin: runs the chosen tests, all their cases, or files of them, in their order; keeps the first
    that fails.
    """

    tests: list[str]
    without: set[str]
    failed: str = ""

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        places = {test: place for place, test in enumerate(self.tests)}
        found = []
        for item in items:
            names = {item.nodeid, item.nodeid.partition("[")[0], item.nodeid.partition("::")[0]}
            if names & places.keys() and not names & self.without:
                found.append((min(places[name] for name in names & places.keys()), item))
        items[:] = [item for _, item in sorted(found, key=itemgetter(0))]

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


def first_failure(tests: list[str], without: set[str], copy: Path, seconds: int) -> str:
    """The first of the tests (node ids, or files) that fails in the copy of the project, or the first file
    that cannot be read, or "" where all pass; the first test where they take more seconds of processor time.
    """
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        os.setsid()
        try:
            resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))
            os.write(writer, f"{ENDED}{_run(tests, without, copy)}".encode())
        finally:
            os._exit(0)
    os.close(writer)
    select.select([reader], [], [], BUSY * seconds)
    os.killpg(child, signal.SIGKILL)
    os.waitpid(child, 0)
    os.set_blocking(reader, False)
    with os.fdopen(reader, "rb") as said:
        return (said.read() or tests[0].encode()).decode().removeprefix(ENDED)


def enter(copy: Path) -> None:
    """Import the project and its tests from the copy from now on."""
    for name in [name for name in sys.modules if name.partition(".")[0] == "tests"]:
        del sys.modules[name]
    os.chdir(copy)
    sys.path.insert(0, str(copy))
    os.environ["PYTHONPATH"] = str(copy)
    os.environ.pop("PYTEST_ADDOPTS", None)  # one process, whatever the one around it was given


def _run(tests: list[str], without: set[str], copy: Path) -> str:
    enter(copy)
    silent = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1, 2):
        os.dup2(silent, stream)
    chosen = _Chosen(tests, without)
    files = list(dict.fromkeys(test.partition("::")[0] for test in tests))
    code = pytest.main([*OPTIONS, "-x", *files], plugins=[chosen])
    return chosen.failed or ("" if code in (0, 5) else tests[0])
