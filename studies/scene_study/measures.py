"""What is recorded of every contact of a sweep without asking."""

from collections.abc import Mapping

import numpy as np
import xarray as xr

import contactstudy as cs
from studies.model.case import error_estimates, number
from studies.scene_study.scene_case import SceneCase, Solved
from studies.scene_study.stiffness import normal_stiffness


def measures(case: SceneCase, solved: Solved) -> Mapping[str, xr.Variable]:
    """Area, pressures, approach, stiffness, mean gap, load, wall time, error estimates, von Mises stress."""
    solution, grid = solved.solution, case.grid
    pressure = solution.pressure
    touching = pressure > 0
    area = float(np.count_nonzero(touching) * grid.cell_area)
    mean = case.load.per_length * grid.period / area if area else 0.0
    found = {
        "load": _number(case.load.per_length, "N m-1", "load per length"),
        "contact_area": _number(area, "m2", "area of the cells in contact"),
        "contact_share": number(float(touching.mean()), "share of the grid in contact"),
        "contact_perimeter": _number(
            _perimeter(touching, grid, solution.problem.paddings),
            "m",
            "length of the cells' edges at which contact ends",
        ),
        "peak_pressure": _number(float(pressure.max()), "Pa", "peak pressure"),
        "mean_pressure": _number(mean, "Pa", "mean pressure of the cells in contact"),
        "approach": _number(
            solution.approach, "m", "approach of the bodies" + _counted(solved.datum)
        ),
        "mean_gap": _number(float(solution.gap.mean()), "m", "mean gap over the grid"),
        "wall_time": _number(
            solved.seconds, "s", "wall time of set-up and solve, beside other cases"
        ),
    }
    if touching.any():
        long_name = "normal stiffness, d load / d approach"
        found["stiffness"] = _number(normal_stiffness(solution), "N m-2", long_name)
    if (hertz := case.scene.hertz) is not None:
        share = area / (2 * hertz.half_width * grid.period)
        found["contact_area_over_hertz"] = number(
            share, "contact area over that of Hertz's line contact"
        )
    return {**found, **_von_mises(solution), **error_estimates(solution)}


def _counted(datum: float | None) -> str:
    return "" if datum is None else f", counted from {datum:.4g} m beside the contact"


def _number(value: float, units: str, long_name: str) -> xr.Variable:
    return xr.Variable((), value, {"units": units, "long_name": long_name})


def _perimeter(touching: np.ndarray, grid: cs.Grid, paddings: cs.Paddings | None) -> float:
    """Edges between cells in and out of contact [m], round the ends of an axis that is periodic."""
    total = 0.0
    for axis in (0, 1):
        edge = grid.cell[1 - axis]
        total += edge * np.count_nonzero(np.diff(touching, axis=axis))
        if paddings is not None and _repeats(paddings[axis]):
            first, last = touching.take(0, axis), touching.take(-1, axis)
            total += edge * np.count_nonzero(first != last)
    return float(total)


def _repeats(padding: cs.Padding) -> bool:
    return padding.window is None or len(padding.window) > 1


def _von_mises(solution: cs.Solution) -> Mapping[str, xr.Variable]:
    """The highest of the stress that the scene names, and its depth."""
    found = {}
    for output in solution.problem.outputs:
        fields = output.fields(solution.pressure)
        if "von_mises" not in fields or "z" not in fields:
            continue
        values, depths = fields["von_mises"].values, fields["z"].values
        level = int(np.unravel_index(values.argmax(), values.shape)[0])
        found["von_mises_max"] = _number(float(values.max()), "Pa", "highest von Mises stress")
        depth = "depth of the highest von Mises stress, of those named"
        found["von_mises_max_depth"] = _number(float(depths[level]), "m", depth)
    return found
