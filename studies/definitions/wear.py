"""A cylinder that wears to more than twice its half-width: error against cost of implicit and explicit steps."""

from collections.abc import Mapping
from functools import cache
from math import inf, pi

import numpy as np
import xarray as xr

import contactstudy as cs
from contactstudy.domain.checks import whole_number
from contactstudy.domain.fields import Array
from studies.model.axis import Axis, one_of
from studies.model.case import SceneCase, TimedAnswer, dimensionless, dimensionless_variables
from studies.model.study import Point

RADIUS, HALF_WIDTH = 1.0, 0.1
LOAD = pi * HALF_WIDTH**2 / (4 * RADIUS)
# Half-width of the flat of a rigid cylinder at the end, over Hertz's; it follows a^3 = 3/2 R k P s.
WORN_HALF_WIDTH = 2.0
DISTANCE = (WORN_HALF_WIDTH * HALF_WIDTH) ** 3 / (1.5 * RADIUS * LOAD)
SCENE = cs.Scene(
    cs.LineLoad(LOAD),
    (cs.HalfSpace(1.0, 0.0), cs.HalfSpace(inf, 0.3)),
    (cs.Cylinder(RADIUS),),
    wear=cs.Wear(1.0, 1.0),
)
WIDTH = 0.5
SCHEMES = {
    "implicit": cs.Scheme.IMPLICIT,
    "two-stage": cs.Scheme.TWO_STAGE,
    "explicit": cs.Scheme.EXPLICIT,
}
INSTANTS = 8  # stored, for any number of steps
FINE = 512  # two-stage steps of the reference
# Longest stable explicit step, k E* ds / dx: twice the compliance of a pressure that alternates from cell to cell,
# 16 G / pi^2 with Catalan's constant G.
LONGEST_EXPLICIT = 1.484

axes = (
    Axis("scheme", tuple(SCHEMES), "scheme"),
    Axis("steps", (8, 16, 32, 64, 128), "steps over the distance"),
    Axis("grid", (64,), "cells across the width"),
)

# not timed: the cost is counted in solves
times = "none"


def case_at(point: Point) -> SceneCase:
    """Return an evolution in equal steps from the unworn cylinder."""
    scheme = one_of("scheme", point["scheme"], SCHEMES)
    steps = whole_number("steps", point["steps"], 2, "give at least 2 steps")
    if steps > FINE // 2:
        raise cs.InvalidInput(
            f"steps is {steps}: give at most {FINE // 2}, half of the {FINE} steps of the reference."
        )
    cells = whole_number("grid", point["grid"], 4, "give at least 4 cells across the width")
    return _case(cells, steps, SCHEMES[scheme])


def _case(cells: int, steps: int, scheme: cs.Scheme) -> SceneCase:
    """Return an evolution in equal steps with a scheme."""
    times = tuple(np.linspace(0, DISTANCE, steps + 1).tolist())
    grid = cs.Grid((cells, 1), (WIDTH, 1.0))
    time_steps = cs.TimeSteps(times, scheme=scheme, error_estimator=cs.ErrorEstimator.NONE)
    return SceneCase(SCENE, grid, cs.ExactPeriodicity(), time_steps=time_steps)


@cache
def _fine(cells: int) -> Array:
    """Return the pressure (x, y) at the end of an evolution with many short steps."""
    return _case(cells, FINE, cs.Scheme.TWO_STAGE).run().trajectory.frames[-1].pressure


def measures(case: SceneCase, result: TimedAnswer) -> Mapping[str, xr.Variable]:
    """Return the half-width over distance, the volume, and the error against an evolution with many short steps."""
    frames = result.trajectory.frames
    cell = case.grid.cell_size[0]
    widths = [np.count_nonzero(frame.pressure) * cell / 2 / HALF_WIDTH for frame in frames]
    fraction = np.linspace(0, 1, INSTANTS + 1)
    # linear between steps; nan after the last one
    half_width = np.interp(
        fraction * DISTANCE, [frame.time for frame in frames], widths, right=np.nan
    )
    fine = _fine(case.grid.cells[0])
    last = frames[-1]
    volume = float(last.fields["wear_depth"].values.sum()) * cell
    error = np.abs(last.pressure - fine).sum() / fine.sum()
    volume_error = abs(volume / (LOAD * DISTANCE) - 1)
    peak = last.peak_pressure / (HALF_WIDTH / 2)
    longest = LONGEST_EXPLICIT * cell * (len(frames) - 1) / DISTANCE
    numbers = {
        "pressure_error_l1": (error, "relative L1 error of the pressure at the end"),
        "volume_error": (volume_error, "relative error of the wear volume"),
        "peak_pressure": (peak, "peak pressure over Hertz's at the end"),
        "longest_explicit": (longest, "stability limit of the explicit scheme over the step"),
    }
    along = {
        "distance": dimensionless(fraction, "distance over the whole", "distance"),
        "half_width": dimensionless(half_width, "half-width over Hertz's", "distance"),
    }
    return along | dimensionless_variables(numbers)
