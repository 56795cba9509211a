"""Main quantities of a contact with their errors and units: as a table, as JSON, in a notebook."""

from base64 import b64encode
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from io import BytesIO
from math import inf, isfinite, nan
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from contactstudy.accuracy.estimate import ErrorEstimate
from contactstudy.domain.fields import Array
from contactstudy.scene.scene import PosedScene
from contactstudy.solvers.solution import Solution

if TYPE_CHECKING:
    from contactstudy.evolution.evolution import Evolution
    from contactstudy.evolution.rolling import SteadyRolling
    from contactstudy.lubrication.evolve_lubricated import FilmEvolution
    from contactstudy.lubrication.lubricated_contact import LubricatedContact

# Units for display, by the SI unit, largest first: the first one in which the value is at least 1 is used.
READ_AS: Mapping[str, tuple[tuple[float, str], ...]] = {
    "Pa": ((1e9, "GPa"), (1e6, "MPa"), (1e3, "kPa"), (1.0, "Pa")),
    "m": ((1.0, "m"), (1e-3, "mm"), (1e-6, "µm"), (1e-9, "nm")),
    "m2": ((1.0, "m²"), (1e-6, "mm²"), (1e-12, "µm²")),
    "m3": ((1.0, "m³"), (1e-9, "mm³"), (1e-18, "µm³")),
    "N": ((1e3, "kN"), (1.0, "N")),
    "N m-1": ((1e3, "N/mm"), (1.0, "N/m")),
    "1": ((1.0, ""),),
}


@dataclass(frozen=True)
class Quantity:
    """Number of a contact.

    Parameters
    ----------
    name
        Name in a dataset.
    long_name
        Name for display.
    value
        Value in the SI unit.
    units
        SI unit.
    error
        Estimated relative error, nan where there is no estimate.
    place
        Coordinates [m] at which the value is found, by the names of the axes.
    """

    name: str
    long_name: str
    value: float
    units: str
    error: float = nan
    place: Mapping[str, float] | None = None


def readable(value: float, units: str, digits: int = 4) -> str:
    """Return a value as text in a unit with few digits, such as ``"0.5 GPa"``."""
    scales = READ_AS.get(units, ((1.0, units),))
    least = (
        1e-3 if units in ("m2", "m3") else 1.0
    )  # successive units of areas and volumes differ by 1e6 and more
    size = next((scale for scale in scales if abs(value) >= least * scale[0]), scales[-1])
    return f"{value / size[0]:.{digits}g} {size[1]}".strip() if value else f"0 {size[1]}".strip()


def quantities(
    solution: Solution, estimate: ErrorEstimate | None = None, von_mises: Any = None
) -> list[Quantity]:
    """Return the main quantities of a solution.

    Parameters
    ----------
    solution
        Solution of a problem.
    estimate
        Estimate of its errors, or None.
    von_mises
        Von Mises stress (z, x, y) [Pa] as a labelled array, or None.
    """
    pressure, gap, grid = solution.pressure, solution.gap, solution.problem.grid
    touching = pressure > 0
    area = float(np.count_nonzero(touching) * grid.cell_area)
    errors = {} if estimate is None else {
        "peak": estimate.peak_pressure.total,
        "area": estimate.contact_area.total,
        "gap": estimate.mean_gap.total,
    }  # fmt: skip
    half_width = _half_width(touching, grid.cell[0])
    one_line = grid.cells[1] == 1
    edge = errors.get("area", nan) if one_line else grid.cell[0] / (half_width or nan)
    total = float(pressure.sum() * grid.cell_area)
    peak = _largest(pressure, {"x": grid.x, "y": grid.y})
    numbers = [
        Quantity("peak_pressure", "peak pressure", *peak[:1], "Pa", errors.get("peak", nan), peak[1]),
        Quantity("mean_pressure", "mean pressure", total / area if area else 0.0, "Pa", errors.get("area", nan)),
        Quantity("half_width", "half-width, outermost", half_width, "m", edge if estimate else nan),
        Quantity("contact_area", "contact area", area, "m2", errors.get("area", nan)),
        Quantity("mean_gap", "mean gap", solution.mean_gap, "m", errors.get("gap", nan)),
        Quantity("smallest_gap", "smallest gap", float(gap.min()), "m"),
        Quantity("approach", "approach", solution.approach, "m"),
        Quantity("total_load", "load", total, "N", solution.residual),
        Quantity("load_per_length", "load per length", total / _length(solution), "N m-1", solution.residual),
    ]  # fmt: skip
    if von_mises is not None:
        stress, place = _largest(
            von_mises.values, {axis: von_mises[axis].values for axis in von_mises.dims}
        )
        numbers.append(
            Quantity("von_mises_max", "largest von Mises stress", stress, "Pa", nan, place)
        )
        if (strength := _yield_strength(solution)) < inf and stress:
            numbers.append(
                Quantity("safety_factor", "yield strength over von Mises", strength / stress, "1")
            )
    return numbers


def _yield_strength(solution: Solution) -> float:
    """Return the yield strength [Pa] of the body whose stress is an output; infinite if it is not known."""
    posed = solution.problem.description
    if not isinstance(posed, PosedScene):
        return inf
    bodies = (
        posed.scene.solids[output.solid]
        for output in posed.scene.outputs
        if hasattr(output, "solid")
    )
    return min((float(getattr(body, "yield_strength", inf)) for body in bodies), default=inf)


def rolling_quantities(rolling: "SteadyRolling") -> list[Quantity]:
    """Return the rolling resistance over the load, and the distance of the pressure's centroid from the axis."""
    resistance, error = rolling.resistance, rolling.resistance_error
    return [
        Quantity("resistance", "rolling resistance over load", resistance, "1", error),
        Quantity("shift", "pressure ahead of the axis", rolling.shift, "m"),
    ]


def march_quantities(evolution: "Evolution") -> list[Quantity]:
    """Return the main quantities of a march: largest values over time, and the state at its end."""
    last, area = evolution.frames[-1], evolution.grid.cell_area
    error = evolution.step_error + evolution.grid_error
    numbers = [
        Quantity("largest_pressure", "largest pressure in time", float(evolution.peak_pressure.max()), "Pa", error),
        Quantity("final_pressure", "peak pressure at the end", float(last.pressure.max()), "Pa", error),
        Quantity("final_contact_area", "contact area at the end", float(evolution.contact_area[-1]), "m2"),
        Quantity("final_approach", "approach at the end", last.approach, "m"),
        Quantity("step_error", "error by steps in time", evolution.step_error, "1"),
        Quantity("grid_error", "error by cells", evolution.grid_error, "1"),
    ]  # fmt: skip
    fields = dict(last.fields)
    if evolution.joint is not None:
        states = [frame.joint_state for frame in evolution.frames]
        fields |= evolution.joint.over_time(states, list(evolution.pressure))
    if "worn_depth" in fields:
        worn = fields["worn_depth"].values
        numbers += [
            Quantity("worn_volume", "worn volume", float(worn.sum() * area), "m3"),
            Quantity("largest_worn_depth", "largest worn depth", float(worn.max()), "m"),
        ]
    if "residual_displacement" in fields:
        dent = float(np.abs(fields["residual_displacement"].values[-1]).max())
        numbers.append(Quantity("dent_depth", "depth of the dent at the end", dent, "m"))
    return numbers


def film_quantities(contact: "LubricatedContact") -> list[Quantity]:
    """Return the main quantities of a lubricated contact."""
    scales = contact.scales

    def error(name: str) -> float:
        return nan if contact.error is None else float(getattr(contact.error, name).total)

    return [
        Quantity("central_film", "central film", contact.central_film, "m", error("central_film")),
        Quantity("minimum_film", "smallest film", contact.minimum_film, "m", error("minimum_film")),
        Quantity(
            "peak_pressure", "peak pressure", contact.peak_pressure, "Pa", error("peak_pressure")
        ),
        Quantity("friction", "friction force over load", contact.friction, "1", error("friction")),
        Quantity("power_loss", "power lost per length", contact.power_loss, "W m-1"),
        Quantity("load_parameter", "Moes' M", scales.load_parameter, "1"),
        Quantity("viscosity_parameter", "Moes' L", scales.viscosity_parameter, "1"),
        Quantity("flux_spread", "spread of the flow over x", contact.flux_spread, "1"),
    ]


def film_march_quantities(evolution: "FilmEvolution") -> list[Quantity]:
    """Return the numbers of a film's march: extreme values over time, and the state at its end."""
    contacts, last = evolution.contacts, evolution.contacts[-1]
    highest = max(contact.peak_pressure for contact in contacts)
    return [
        Quantity("lowest_film", "smallest film in time", float(evolution.minimum_film.min()), "m"),
        Quantity("lowest_central_film", "smallest central film in time", float(evolution.central_film.min()), "m"),
        Quantity("final_central_film", "central film at the end", last.central_film, "m"),
        Quantity("largest_pressure", "largest pressure in time", highest, "Pa"),
        Quantity("final_friction", "friction force over load at the end", last.friction, "1"),
        Quantity("step_error", "largest error of a step in time", evolution.step_error, "1"),
    ]  # fmt: skip


def _length(solution: Solution) -> float:
    """Return the length [m] over which the load is spread: of the roller if it is known, else of the grid."""
    posed = solution.problem.description
    load = posed.scene.load if isinstance(posed, PosedScene) else None
    return getattr(load, "length", None) or solution.problem.grid.period


def _half_width(touching: NDArray[np.bool_], dx: float) -> float:
    """Return half the distance between the outer edges of the outermost cells in contact [m]."""
    rows = np.flatnonzero(touching.any(axis=1))
    return float((rows[-1] - rows[0] + 1) * dx / 2) if len(rows) else 0.0


def _largest(values: Array, axes: Mapping[str, Array]) -> tuple[float, dict[str, float]]:
    """Return the largest value and the coordinates where it is; an axis of one cell has no place."""
    indices = np.unravel_index(int(np.argmax(values)), values.shape)
    place = {
        name: float(axis[index])
        for (name, axis), index in zip(axes.items(), indices, strict=True)
        if len(axis) > 1
    }
    return float(values[indices]), place


def as_text(numbers: Sequence[Quantity]) -> str:
    """Return numbers as a table: name, value with unit, error, place."""
    rows = [
        (
            number.long_name,
            readable(number.value, number.units),
            "" if number.name.endswith("_error") else _percent(number.error),
            ", ".join(
                f"{axis} = {readable(at, 'm', 3)}" for axis, at in (number.place or {}).items()
            ),
        )
        for number in numbers
    ]
    widths = [max((len(row[column]) for row in rows), default=0) for column in range(3)]
    lines = []
    for name, value, error, place in rows:
        line = f"  {name:<{widths[0]}}  {value:>{widths[1]}}  {error:<{widths[2]}}"
        lines.append(f"{line}  at {place}" if place else line.rstrip())
    return "\n".join(lines)


def _percent(error: float) -> str:
    if np.isnan(error):
        return "error not estimated"
    return f"error <= {100 * error:.2g} %" if isfinite(error) else "error not bounded"


def as_json(numbers: Sequence[Quantity]) -> dict[str, dict[str, object]]:
    """Return numbers in SI units by their names; an error that is not estimated or not bounded is None."""
    return {
        number.name: {
            "value": number.value,
            "units": number.units,
            "error": number.error if isfinite(number.error) else None,
            "long_name": number.long_name,
            **({"at": dict(number.place)} if number.place else {}),
        }
        for number in numbers
    }


def as_html(solution: Solution) -> str:
    """Return a solution as a small table with a picture, for notebooks."""
    nx, ny = solution.pressure.shape
    rows = {
        "status": str(solution.status),
        "grid": f"{nx} x {ny} cells",
        **{
            number.long_name: readable(number.value, number.units, 5)
            for number in quantities(solution)
        },
        "solver": f"{solution.iterations} iterations, residual {solution.residual:.1e}",
    }
    if solution.note:
        rows["note"] = solution.note
    cells = "".join(
        f"<tr><th style='text-align:left'>{name}</th><td style='text-align:left'>{escape(text)}</td></tr>"
        for name, text in rows.items()
    )
    return f"<table>{cells}</table>{_picture(solution)}"


def _picture(solution: Solution) -> str:
    """Return an image; nothing if there are no numbers to draw, or no library that draws."""
    if not np.isfinite(solution.pressure).all():
        return ""
    file = BytesIO()
    try:
        solution.plot().savefig(file, format="png", dpi=60)
    except ModuleNotFoundError:
        return ""
    data = b64encode(file.getvalue()).decode()
    return f"<img alt='pressure and gap of the contact' src='data:image/png;base64,{data}'>"
