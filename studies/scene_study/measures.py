"""Quantities recorded of every contact of a sweep."""

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr

import contactstudy as cs
from contactstudy.domain.fields import Array, inner
from contactstudy.io.dataset import labelled
from contactstudy.io.summary import (
    Quantity,
    film_march_quantities,
    march_quantities,
    rolling_quantities,
)
from contactstudy.scene.load import ConstantLoad
from studies.model.case import error_estimates, number
from studies.scene_study.scene_case import FileCase, SceneCase, Solved

# The error of the stiffness is the square of the relative error of the iteration.
RESIDUAL = 3e-2
MOST = 60


def normal_stiffness(solution: cs.Solution) -> float:
    """Return the normal stiffness d load / d approach [N/m per m of length], with the cells in contact fixed.

    It follows from the pressure increment that carries a unit of load and displaces all cells in contact equally, by
    projected conjugate gradients (Hestenes & Stiefel 1952), in which a rigid shift of the operator has no effect.
    Cells at the hardness carry no increment. The result is nan if no cell carries one.
    """
    problem = solution.problem
    free = problem.constraint.free(solution.pressure) > 0
    count = int(free.sum())
    if not count:
        return float("nan")
    cells = free.astype(np.float64)
    operator = problem.operator
    extension = operator.approximate_inverse().extension(cells)

    def displaced(pressure: Array) -> Array:
        return np.asarray(np.where(free, operator(pressure), 0.0))

    def level(field: Array) -> Array:
        return np.asarray(np.where(free, field - field[free].sum() / count, 0.0))

    pressure = np.where(free, 1 / count, 0.0)
    displacement = displaced(pressure)
    residual = -level(displacement)
    first_deviation = np.abs(displacement - displacement.sum() / count)[free].mean()
    direction: Array | None = None
    size = 0.0
    for _ in range(MOST):
        if count < 2 or np.abs(residual).sum() / count <= RESIDUAL * first_deviation:
            break
        correction = level(extension.closing(extension(residual)))
        previous_size, size = size, inner(residual, correction)
        direction = (
            correction if direction is None else correction + direction * (size / previous_size)
        )
        response = displaced(direction)
        step_length = size / inner(direction, response)
        pressure += step_length * direction
        displacement += step_length * response
        residual = -level(displacement)
    # the energy of a unit of load [m per unit of summed pressure]
    compliance = inner(pressure, displacement)
    grid = problem.grid
    return float(grid.cell_area / grid.period / compliance)


def measures(
    case: SceneCase | FileCase,
    result: Solved | cs.SteadyRolling | cs.Evolution | cs.FilmEvolution,
) -> Mapping[str, xr.Variable]:
    """Return the numbers of a contact: of a solution, of steady rolling, or of a march in time."""
    if isinstance(result, cs.FilmEvolution):
        return _of_quantities(film_march_quantities(result))
    if isinstance(result, cs.Evolution):
        return _of_quantities(march_quantities(result))
    if isinstance(result, cs.SteadyRolling):
        numbers = _of_quantities(rolling_quantities(result))
        return {**_of_solution(case.scene, result.solution), **numbers}
    measured = _of_solution(case.scene, result.solution)
    if result.datum is not None:
        measured["approach"].attrs["description"] = (
            f"counted from {result.datum:.4g} m beside the contact"
        )
    description = (
        "wall time of set-up and solve, beside other cases with which it shares coefficients"
    )
    measured["wall_time"] = labelled((), result.seconds, "s", "wall time", description=description)
    if result.solution.pressure.any():
        stiffness = normal_stiffness(result.solution)
        measured["stiffness"] = labelled(
            (), stiffness, "N m-2", "normal stiffness", description="d load / d approach"
        )
    return measured


def _of_quantities(numbers: Sequence[Quantity]) -> dict[str, xr.Variable]:
    """Return labelled variables of quantities, by name."""
    return {
        quantity.name: labelled((), quantity.value, quantity.units, quantity.long_name)
        for quantity in numbers
    }


def _of_solution(scene: cs.Scene, solution: cs.Solution) -> dict[str, xr.Variable]:
    """Return load, area, pressures, mean gap, error estimates and the largest von Mises stress."""
    grid, pressure = solution.problem.grid, solution.pressure
    touching = pressure > 0
    area = float(np.count_nonzero(touching) * grid.cell_area)
    load = scene.load.over(grid.period) if isinstance(scene.load, ConstantLoad) else 0.0
    mean = load * grid.period / area if area else 0.0
    perimeter = _perimeter(touching, grid, solution.problem.paddings)
    measured = {
        "load": labelled((), load, "N m-1", "load per length"),
        "contact_area": labelled((), area, "m2", "contact area"),
        "contact_share": number(float(touching.mean()), "share in contact"),
        "contact_perimeter": labelled(
            (),
            perimeter,
            "m",
            "contact perimeter",
            description="edges of cells at which contact ends",
        ),
        "peak_pressure": labelled((), float(pressure.max()), "Pa", "peak pressure"),
        "mean_pressure": labelled((), mean, "Pa", "mean pressure in contact"),
        "approach": labelled((), solution.approach, "m", "approach"),
        "mean_gap": labelled((), solution.mean_gap, "m", "mean gap"),
    }
    if (hertz := scene.hertz) is not None:
        share = area / (2 * hertz.half_width * grid.period)
        measured["contact_area_over_hertz"] = number(share, "contact area over Hertz's")
    return {**measured, **_von_mises(solution), **error_estimates(solution)}


def _perimeter(touching: np.ndarray, grid: cs.Grid, paddings: cs.Paddings | None) -> float:
    """Return the length [m] of the edges between cells in and out of contact, across the ends of a periodic axis too."""
    total = 0.0
    for axis in (0, 1):
        edge = grid.cell[1 - axis]
        total += edge * np.count_nonzero(np.diff(touching, axis=axis))
        if paddings is not None and _repeats(paddings[axis]):
            first, last = touching.take(0, axis), touching.take(-1, axis)
            total += edge * np.count_nonzero(first != last)
    return float(total)


def _repeats(padding: cs.Padding) -> bool:
    """Return whether an axis repeats."""
    return padding.window is None or len(padding.window) > 1


def _von_mises(solution: cs.Solution) -> Mapping[str, xr.Variable]:
    """Return the largest von Mises stress of the outputs that the scene names, and its depth."""
    measured = {}
    for output in solution.problem.outputs:
        fields = output.fields(solution.pressure)
        if "von_mises" not in fields or "z" not in fields:
            continue
        values, depths = fields["von_mises"].values, fields["z"].values
        level = int(np.unravel_index(values.argmax(), values.shape)[0])
        measured["von_mises_max"] = labelled(
            (), float(values.max()), "Pa", "largest von Mises stress"
        )
        measured["von_mises_max_depth"] = labelled(
            (),
            float(depths[level]),
            "m",
            "depth of the largest stress",
            description="of the depths named",
        )
    return measured
