"""Tests in a fork of this process, which has numpy and the like imported and the project's modules not."""

import importlib
import os
import signal
import sys
import time
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


@dataclass(eq=False)
class _Chosen:
    """A pytest plugin: runs the chosen tests, or files of them, in their order; keeps the first that fails."""

    tests: list[str]
    without: set[str]
    failed: str = ""

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        places = {test: place for place, test in enumerate(self.tests)}
        found = []
        for item in items:
            names = {item.nodeid, item.nodeid.partition("::")[0]}
            if names & places.keys() and item.nodeid not in self.without:
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


def first_failure(tests: list[str], without: set[str], copy: Path, seconds: float) -> str | None:
    """The first of the tests (node ids, or files) that fails in the copy of the project, or the first file
    that cannot be read, or "" where all pass; None where they are not through after so many seconds.
    """
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        os.setsid()
        try:
            os.write(writer, f"{ENDED}{_run(tests, without, copy)}".encode())
        finally:
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


def _run(tests: list[str], without: set[str], copy: Path) -> str:
    for name in [name for name in sys.modules if name.partition(".")[0] == "tests"]:
        del sys.modules[name]
    os.chdir(copy)
    sys.path.insert(0, str(copy))
    sys.dont_write_bytecode = True
    os.environ |= {"PYTHONPATH": str(copy), "PYTHONDONTWRITEBYTECODE": "1"}
    os.environ.pop("PYTEST_ADDOPTS", None)  # one process, whatever the one around it was given
    silent = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1, 2):
        os.dup2(silent, stream)
    chosen = _Chosen(tests, without)
    files = list(dict.fromkeys(test.partition("::")[0] for test in tests))
    options = [
        "-x",
        "-n",
        "0",
        "-p",
        "no:cacheprovider",
        "-W",
        "ignore::pytest.PytestAssertRewriteWarning",
    ]
    code = pytest.main([*options, *files], plugins=[chosen])
    return chosen.failed or ("" if code in (0, 5) else tests[0])
