"""A smooth line contact that many tests share, and random examples that are the same on every machine."""

import os
import signal
from dataclasses import dataclass

import pytest
from hypothesis import HealthCheck, settings

import contactstudy as cs

# No clock decides. HYPOTHESIS_PROFILE=random looks for new examples.
steady = settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.register_profile("random", steady, derandomize=False)
settings.register_profile("steady", steady, derandomize=True)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "steady"))

# A length in metres may be below 1e-12, which is what approx takes for nothing beside any number but zero.
type(pytest.approx(1.0)).DEFAULT_ABSOLUTE_TOLERANCE = property(
    lambda self: 1e-12 if self.expected == 0 else 0.0
)

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


@pytest.fixture(scope="session")
def line_contact() -> LineContact:
    scene = cs.Scene(
        load=cs.LineLoad(1e5), solids=(STEEL, STEEL), shapes=(cs.Cylinder(radius=0.01),)
    )
    hertz = scene.hertz
    assert hertz is not None
    return LineContact(scene, hertz)
