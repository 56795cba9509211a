"""A viscoelastic contact under a constant load: cost of accuracy in time."""

from collections.abc import Mapping, Sequence
from math import inf, pi

import numpy as np
import xarray as xr

import contactstudy as cs
from contactstudy.domain.checks import whole_number
from studies.model.axis import Axis
from studies.model.case import SceneCase, TimedAnswer, dimensionless
from studies.model.study import Point

# In units of the radius, of E* under a sudden load, and of the retardation time; HALF_WIDTH is under a sudden load.
RADIUS, HALF_WIDTH, END = 1.0, 0.1, 2.0
LOAD = pi * HALF_WIDTH**2 / (4 * RADIUS)
# Creep compliance over its instantaneous value: 1 + 1.5 (1 - exp(-t)).
BODY = cs.ViscoelasticHalfSpace(0.4, 0.0, ((0.6, 0.4),))
SCENE = cs.Scene(cs.LineLoad(LOAD), (BODY, cs.HalfSpace(inf, 0.3)), (cs.Cylinder(RADIUS),))
LEE_RADOK = cs.analytic.LeeRadok(LOAD, RADIUS, 0.4, ((0.6, 0.4),), BODY.creep)
WIDTH = 0.36
INSTANTS = 10  # stored, for any number of steps

axes = (
    Axis("steps", (10, 20, 40, 80, 160), "steps over two retardation times"),
    Axis("grid", (64, 256), "cells across the width"),
)

# not timed: the cost is counted in FFT convolutions
times = "none"


def case_at(point: Point) -> SceneCase:
    """Return an evolution under the constant load, with equal steps."""
    steps = whole_number("steps", point["steps"], 2, "give at least 2 steps")
    cells = whole_number("grid", point["grid"], 4, "give at least 4 cells across the width")
    times = tuple(np.linspace(0, END, steps + 1).tolist())
    grid = cs.Grid((cells, 1), (WIDTH, 1.0))
    return SceneCase(SCENE, grid, cs.ExactPeriodicity(), time_steps=cs.TimeSteps(times))


def measures(case: SceneCase, result: TimedAnswer) -> Mapping[str, xr.Variable]:
    """Return half-width and peak pressure over time, and errors against the closed form."""
    x = case.grid.x
    recorded = result.trajectory.frames
    time = np.linspace(0, END, INSTANTS + 1)

    def series(values: Sequence[float], long_name: str) -> xr.Variable:
        """Return values of the steps at the stored instants, linear between steps; nan after the last step."""
        stored = np.interp(time, [frame.time for frame in recorded], values, right=np.nan)
        return dimensionless(stored, long_name, "time")

    indices = np.unique(np.linspace(0, len(recorded) - 1, INSTANTS + 1).round().astype(int))
    # the first instant is left out, because it follows the jump of the load
    frames = [recorded[index] for index in indices[1:]]

    def largest(error: str) -> float:
        return max(float(getattr(frame, error)) for frame in frames)

    errors = []
    for frame in frames:
        exact = LEE_RADOK.pressure(x, frame.time)
        errors.append(float(np.abs(frame.pressure[:, 0] - exact).sum() / exact.sum()))
    cell = case.grid.cell_size[0]
    widths = [np.count_nonzero(frame.pressure) * cell / 2 / HALF_WIDTH for frame in recorded]
    peaks = [frame.peak_pressure / (HALF_WIDTH / 2) for frame in recorded]
    return {
        "time": dimensionless(time, "time over the retardation time", "time"),
        "half_width": series(widths, "half-width over that of a sudden load"),
        "peak_pressure": series(peaks, "peak pressure over that of a sudden load"),
        "pressure_error_l1": dimensionless(
            max(errors), "largest relative L1 error of the pressure"
        ),
        "time_discretisation_error": dimensionless(
            largest("time_discretisation_error"), "estimated time-discretisation error in L1"
        ),
        "grid_error": dimensionless(
            largest("grid_error"), "estimated spatial discretisation error in L1"
        ),
    }
