"""Line contacts that creep or wear by given steps."""

from math import inf, pi
from typing import Any

import numpy as np

import contactstudy as cs
from contactstudy.domain.grid import Array
from contactstudy.evolution.evolve import evolve
from contactstudy.evolution.time_stepper import Trajectory

EXACT = cs.ExactPeriodicity()
RIGID = cs.HalfSpace(inf, 0.3)
LOAD = 0.01 * pi / 4  # a = 0.1 and p0 = 0.05 for E* = 1
# J = 1 + 1.5 (1 - exp(-t))
SOLID = cs.ViscoelasticHalfSpace(0.4, 0.0, ((0.6, 0.4),))


def rolling_cylinder(body: cs.HalfSpace | cs.ViscoelasticHalfSpace, load: Any = None, **named: Any) -> cs.Scene:
    """A rigid cylinder of radius 1 on ``body``."""
    return cs.Scene(load or cs.LineLoad(LOAD), (body, RIGID), (cs.Cylinder(1.0),), **named)


def evolved(
    scene: cs.Scene, grid: cs.Grid, times: Any, *, padding: Any = EXACT, tolerance: float = 1e-8, **more: Any
) -> Trajectory:
    """By the given steps alone, whose error is not asked for."""
    options = cs.SolveOptions(tolerance)
    return evolve(scene, grid, padding, times=times, options=options, error_estimator="none", **more)


def relative(pressure: Array, true: Array) -> float:
    """Return the difference of two pressures in L1, over that of the true one."""
    return float(np.abs(pressure - true).sum() / true.sum())


def by_steps(found: Trajectory) -> float:
    """Return the largest time-discretisation error in L1 of all instants."""
    return max(frame.errors_by_steps["l1"] for frame in found.frames)


def pressures(found: Trajectory) -> Array:
    """Return the pressure (time, x, y) at all instants."""
    return np.stack([frame.pressure for frame in found.frames])
