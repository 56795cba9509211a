"""The two tiers of tests, a smooth line contact that many share, and random examples that are always the same.

``pytest`` runs the default tier: every promise once. It leaves out tests marked ``whole``, and of a test with more than
two cases it runs the first and the last, or as many as its mark ``cases`` says. ``pytest --whole`` runs all,
``pytest --rest`` what the default tier leaves out, ``pytest --cases 1`` one case of each test of the default tier, and
``pytest tests/test_x.py::test_y`` the test that is named.
"""

import os
import signal
import sys
from collections import defaultdict
from dataclasses import dataclass, replace
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

import contactstudy as cs

MOST_CASES = 2  # of one test in the default tier


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--cases", type=int, help="most of one test in the default tier, whatever its mark says")
    parser.addoption("--rest", action="store_true", help="run what is left out without --whole")
    parser.addoption("--whole", action="store_true", help="run all tests, also the slow and the repeated ones")


def pytest_configure(config: pytest.Config) -> None:
    config.addinivalue_line("markers", "whole: runs with --whole, or where it is named on the command line")
    config.addinivalue_line("markers", "cases(most): so many of its cases are in the default tier")


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    # those beside this file run whole examples and pages: last, one of them would run while other processes wait
    items.sort(key=lambda item: item.path.parent != Path(__file__).parent)
    is_whole = config.getoption("--whole") or os.environ.get("TESTS") == "whole"
    if is_whole or any("::" in word for word in config.args):
        return
    cases: dict[str, list[pytest.Item]] = defaultdict(list)
    for item in items:
        if item.get_closest_marker("whole") is None:
            cases[item.nodeid.partition("[")[0]].append(item)
    chosen = {id(item) for several in cases.values() for item in spread(several, config.getoption("--cases"))}
    if config.getoption("--rest"):
        chosen = {id(item) for item in items} - chosen
    config.hook.pytest_deselected(items=[item for item in items if id(item) not in chosen])
    items[:] = [item for item in items if id(item) in chosen]


def spread(cases: list[pytest.Item], limit: int | None) -> list[pytest.Item]:
    """As many cases as the test is marked with, or two, or at most the limit, evenly from the first to the last."""
    mark = cases[0].get_closest_marker("cases")
    most = min(mark.args[0] if mark else MOST_CASES, limit or len(cases))
    if len(cases) <= most or most == 1:
        return cases[:most]
    return [cases[round(k * (len(cases) - 1) / (most - 1))] for k in range(most)]


# No clock decides. HYPOTHESIS_PROFILE=random looks for new examples.
steady = settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.register_profile("random", steady, derandomize=False)
settings.register_profile("steady", steady, derandomize=True)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "steady"))

# A length in metres may be below 1e-12, which is what approx takes for nothing beside any number but zero.
type(pytest.approx(1.0)).DEFAULT_ABSOLUTE_TOLERANCE = property(lambda self: 1e-12 if self.expected == 0 else 0.0)

# Processes of the tests share the cores, on which threads of linear algebra would wait for each other; and what one of
# them has compiled, no other compiles.
os.environ["OPENBLAS_NUM_THREADS"] = "1"
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False

# A shell without job control starts what runs in the background deaf to Ctrl-C, and its children with it.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

# Seconds after which a process that still runs hangs. On a machine ten times too busy, none takes five minutes.
HANGS = 1800.0

STEEL = cs.HalfSpace(youngs_modulus=210e9, poisson_ratio=0.3)


@dataclass(frozen=True)
class LineContact:
    """Steel on steel, 100 N/mm, R = 10 mm."""

    scene: cs.Scene
    hertz: cs.analytic.HertzLine

    def grid(self, cells: int | tuple[int, int], period: float, width: float = 2.4) -> cs.Grid:
        """Cells over extents given in Hertz half-widths."""
        cells = cells if isinstance(cells, tuple) else (cells, cells)
        a = self.hertz.half_width
        return cs.Grid(cells=cells, extent=(width * a, period * a))

    def with_shapes(self, *more: cs.Shape) -> cs.Scene:
        """The scene with more shapes on its cylinder."""
        return replace(self.scene, shapes=(*self.scene.shapes, *more))


@pytest.fixture(scope="session")
def line_contact() -> LineContact:
    scene = cs.Scene(load=cs.LineLoad(1e5), solids=(STEEL, STEEL), shapes=(cs.Cylinder(radius=0.01),))
    hertz = scene.hertz
    return LineContact(scene, hertz)
