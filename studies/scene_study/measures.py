"""Quantities recorded of every contact of a sweep."""

from collections.abc import Mapping

import numpy as np
import xarray as xr

import contactstudy as cs
from contactstudy.domain.fields import Array, inner
from studies.model.case import error_estimates, number
from studies.scene_study.scene_case import SceneCase, Solved

# The error of the stiffness is the square of the relative error of the iteration.
RESIDUAL = 3e-2
MOST = 60


def normal_stiffness(solution: cs.Solution) -> float:
    """d load / d approach [N/m per m of length] of the contact as it stands: its cells stay the same.

    The increment of the pressure that carries a unit of load and moves all cells in contact alike, found
    by projected conjugate gradients (Hestenes & Stiefel 1952), which do not see the rigid shift of the
    operator. Cells that yield carry no more. nan where no cell can.
    """
    problem = solution.problem
    free = problem.constraint.free(solution.pressure) > 0
    count = int(free.sum())
    if not count:
        return float("nan")
    cells = free.astype(np.float64)
    operator = problem.operator
    precondition = operator.approximate_inverse()

    def moved(pressure: Array) -> Array:
        return np.asarray(np.where(free, operator(pressure), 0.0))

    def level(field: Array) -> Array:
        return np.asarray(np.where(free, field - field[free].sum() / count, 0.0))

    pressure = np.where(free, 1 / count, 0.0)
    displacement = moved(pressure)
    residual = -level(displacement)
    first = np.abs(displacement - displacement.sum() / count)[free].mean()
    direction: Array | None = None
    size = 0.0
    for _ in range(MOST):
        if count < 2 or np.abs(residual).sum() / count <= RESIDUAL * first:
            break
        closing = level(precondition(residual, cells))
        before, size = size, inner(residual, closing)
        direction = closing if direction is None else closing + direction * (size / before)
        response = moved(direction)
        length = size / inner(direction, response)
        pressure += length * direction
        displacement += length * response
        residual = -level(displacement)
    # the energy of a unit of load [m per unit of summed pressure]
    compliance = inner(pressure, displacement)
    grid = problem.grid
    return float(grid.cell_area / grid.period / compliance)


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
