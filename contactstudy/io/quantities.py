"""Quantities of an answer: the one table of its numbers, with units and bounds, and how numbers are written."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import inf, isfinite, pi
from typing import TYPE_CHECKING

import numpy as np

from contactstudy.analytic import dowson_higginson_film, film_asymptotes
from contactstudy.domain.errors import ErrorEstimate, ErrorParts
from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid
from contactstudy.problem.problem import Field
from contactstudy.scene.load import TotalLoad
from contactstudy.scene.scene import PosedScene, Scene
from contactstudy.scene.shapes.shape import Detail
from contactstudy.solvers.fretting_traction import FrettingTraction
from contactstudy.solvers.rolling_traction import RollingTraction
from contactstudy.solvers.solution import CohesiveTraction, Solution, Traction

if TYPE_CHECKING:
    from contactstudy.evolution.evolution import Frame
    from contactstudy.evolution.repeated_rolling import RepeatedRolling
    from contactstudy.evolution.rolling import SteadyRolling
    from contactstudy.lubrication.lubricated_contact import FilmSolution

# Units for display, by the SI unit, largest first: the first one in which the value is at least 1 is used.
READ_AS: Mapping[str, tuple[tuple[float, str], ...]] = {
    "Pa": ((1e9, "GPa"), (1e6, "MPa"), (1e3, "kPa"), (1.0, "Pa")),
    "m": ((1.0, "m"), (1e-3, "mm"), (1e-6, "µm"), (1e-9, "nm")),
    "m2": ((1.0, "m²"), (1e-6, "mm²"), (1e-12, "µm²")),
    "m3": ((1.0, "m³"), (1e-9, "mm³"), (1e-18, "µm³")),
    "m2 m-1": ((1e-3, "mm²/mm"), (1e-6, "µm²/µm")),
    "m3 m-1": ((1e-6, "mm³/mm"), (1e-12, "µm³/µm")),
    "N": ((1e3, "kN"), (1.0, "N")),
    "N m-1": ((1e3, "N/mm"), (1.0, "N/m")),
    "W": ((1e3, "kW"), (1.0, "W"), (1e-3, "mW")),
    "W m-1": ((1.0, "W/m"),),
    "J m-1": ((1.0, "J/m"), (1e-3, "mJ/m"), (1e-6, "µJ/m"), (1e-9, "nJ/m")),
    "rad": ((1.0, "rad"), (1e-3, "mrad")),
    "1": ((1.0, ""),),
}
NO_ESTIMATE = "no estimate is known for it"
FORMULA = "it is the value of a formula"


@dataclass(frozen=True)
class Quantity:
    """Number of an answer.

    Parameters
    ----------
    value
        Value in the SI unit.
    unit
        SI unit, such as ``"Pa"`` or ``"m2 m-1"``.
    label
        Name for display.
    bound
        Upper estimate of the absolute error, in the same unit; infinite where it is not known.
    reason
        Sentence on why the bound is infinite; empty where it is finite.
    place
        Coordinates [m] at which the value is found, by the names of the axes; empty where it has none.
    """

    value: float
    unit: str
    label: str
    bound: float = inf
    reason: str = NO_ESTIMATE
    place: Mapping[str, float] | None = None

    @property
    def relative_bound(self) -> float:
        """Bound over the size of the value."""
        if not self.bound:
            return 0.0
        return self.bound / abs(self.value) if self.value else inf

    def __str__(self) -> str:
        """Return value and bound, such as ``0.427 GPa (error <= 0.1 %)``."""
        return f"{readable(self.value, self.unit)} ({_percent(self)})"


Quantities = Mapping[str, Quantity]


def usual_unit(largest: float, unit: str) -> tuple[float, str]:
    """Return size and name of the unit in which numbers up to `largest`, in the SI unit `unit`, are read best."""
    scales = READ_AS.get(unit, ((1.0, unit),))
    # successive units of areas and volumes differ by 1e6 and more
    least = 1e-3 if unit[:2] in ("m2", "m3") else 1.0
    return next((scale for scale in scales if abs(largest) >= least * scale[0]), scales[-1])


def readable(value: float, unit: str, digits: int = 4) -> str:
    """Return a value as text in a unit with few digits, such as ``"0.5 GPa"``."""
    size, name = usual_unit(value, unit)
    return f"{value / size:.{digits}g} {name}".strip()


def bounded(quantity: Quantity, parts: ErrorParts | None, why: Sequence[str] = ()) -> Quantity:
    """Return a quantity with the bound of its relative error, and the reason where that is infinite.

    Parameters
    ----------
    quantity
        The quantity.
    parts
        Its relative error; None where no estimate is known.
    why
        Sentences of which the first stands for a reason that the parts do not give.
    """
    if parts is None:
        return quantity
    if isfinite(parts.total):
        return replace(quantity, bound=parts.total * abs(quantity.value), reason="")
    return replace(quantity, reason=parts.reason or next(iter(why), NO_ESTIMATE))


def own_length(scene: Scene | None) -> float | None:
    """Return the length [m] of the roller in `scene`; None where the contact goes on for ever."""
    if scene is None:
        return None
    if isinstance(scene.load, TotalLoad):
        return scene.load.length
    details = (shape.detail for shape in scene.shapes if hasattr(shape, "detail"))
    lengths = [detail.roller for detail in details if 0 < detail.roller < inf]
    return min(lengths, default=None)


def scene_of(solution: Solution) -> Scene | None:
    """Return the scene that a solution belongs to; None for a problem that was not made of one."""
    posed = solution.problem.description
    return posed.scene if isinstance(posed, PosedScene) else None


def contact_quantities(
    solution: Solution,
    estimate: ErrorEstimate,
    derived: Mapping[str, Field],
    rolling: "SteadyRolling | None" = None,
) -> dict[str, Quantity]:
    """Return the numbers of a dry contact, those of the effects that its scene names first; none without a pressure.

    Areas and volumes are per length where the scene has no length of its own.

    Parameters
    ----------
    solution
        The contact.
    estimate
        Estimate of its errors.
    derived
        Fields of the outputs that the scene names, such as the von Mises stress.
    rolling
        The steadily rolling contact that it belongs to, or None.
    """
    pressure, gap, grid = solution.pressure, solution.gap, solution.problem.grid
    if not np.isfinite(pressure).all():
        return {}
    scene, touching, why = scene_of(solution), pressure > 0, estimate.warnings
    length = own_length(scene)
    area = float(np.count_nonzero(touching) * grid.cell_area)
    total = float(pressure.sum() * grid.cell_area)
    peak, peak_place = _largest(pressure, {"x": grid.x, "y": grid.y})
    half_width = _half_width(touching, grid.cell[0])
    solved = ErrorParts(residual=solution.residual)
    wide = "" if _wraps(solution) else f", over the grid's width of {readable(grid.extent[0], 'm')}"
    label = f"peak pressure{_mirrored(pressure, grid.y, peak_place)}"
    numbers = {
        "peak_pressure": bounded(
            Quantity(peak, "Pa", label, place=peak_place), estimate.peak_pressure, why
        )
    }
    places = {"x": grid.x, "y": grid.y}
    numbers |= _of_stress(scene, derived, places, estimate)
    if rolling is not None:
        numbers |= _of_rolling(rolling, estimate)
    if solution.traction is not None:
        numbers |= _of_traction(solution.traction, pressure)
        if isinstance(solution.traction, RollingTraction):
            numbers |= _of_creepage(solution.traction, float(pressure.sum()), grid, length)
        if isinstance(solution.traction, FrettingTraction):
            numbers |= _of_cycle(solution.traction, grid, length)
    if solution.adhesion is not None:
        numbers |= _of_adhesion(solution, solution.adhesion, estimate)
    numbers |= {
        "contact_area": bounded(
            _per_length(area, "m2", "contact area", length, grid.period), estimate.contact_area, why
        ),
        "half_width": Quantity(half_width, "m", "half-width, outermost", grid.cell[0], ""),
        "mean_pressure": bounded(
            Quantity(total / area if area else 0.0, "Pa", "mean pressure in contact"),
            estimate.contact_area,
            why,
        ),
        "mean_gap": bounded(
            Quantity(solution.mean_gap, "m", f"mean gap{wide}"), estimate.mean_gap, why
        ),
        "approach": _approach(solution, estimate),
    }
    if scene is not None and scene.hardness < inf:
        depth = max(-float(gap.min()), 0.0)
        numbers["yielded_depth"] = Quantity(depth, "m", "largest depth of yielding")
    carried, of_load = solution.load_per_length * grid.period, estimate.load or solved
    numbers["load_per_length"] = bounded(
        Quantity(carried / (length or grid.period), "N m-1", "load per length"), of_load
    )
    if length is not None:
        numbers["total_load"] = bounded(Quantity(carried, "N", "load"), of_load)
    return numbers


def _approach(solution: Solution, estimate: ErrorEstimate) -> Quantity:
    """Return the approach, which is exact where it is given."""
    if solution.problem.resultant.approach is not None:
        return Quantity(solution.approach, "m", "approach", 0.0, "")
    return bounded(
        Quantity(solution.approach, "m", "approach"), estimate.approach, estimate.warnings
    )


def _of_adhesion(
    solution: Solution, adhesion: CohesiveTraction, estimate: ErrorEstimate
) -> dict[str, Quantity]:
    """Return attraction, energy and load of separation, and what says which state this is and how fine its grid."""
    grid = solution.problem.grid
    attraction = float(adhesion.traction.sum() * grid.cell_area / grid.period)
    touching = bool(solution.pressure.any())
    numbers = {
        "attraction": bounded(
            Quantity(attraction, "N m-1", "attraction per length"), estimate.l1, estimate.warnings
        ),
        "energy": Quantity(adhesion.energy / grid.period, "J m-1", "energy per length"),
        "attraction_range": Quantity(adhesion.range, "m", "range of the attraction", 0.0, ""),
        "cells_in_zone": Quantity(adhesion.cells_in_zone, "1", "cells in the cohesive zone", 0.0, ""),
        "detached": Quantity(float(not touching), "1", "1 if the bodies do not touch", 0.0, ""),
    }  # fmt: skip
    if adhesion.tabor is not None:
        numbers["tabor_parameter"] = Quantity(adhesion.tabor, "1", "Tabor's parameter", 0.0, "")
    if adhesion.lost is not None:
        held = Quantity(-solution.load_per_length, "N m-1", "largest pull that is held")
        numbers = {"pull_off": bounded(held, estimate.pull_off, estimate.warnings)} | numbers
    return numbers


def _of_traction(traction: Traction, pressure: Array) -> dict[str, Quantity]:
    """Return the tangential force over the load, and the part of the contact that sticks."""
    load, touching = float(pressure.sum()), np.count_nonzero(pressure)
    force = float(np.hypot(*traction.shear.sum(axis=(1, 2))))
    stick = float(np.count_nonzero(traction.stick) / touching) if touching else 0.0
    coefficient = Quantity(force / load if load else 0.0, "1", "tangential force over load")
    if isinstance(traction, RollingTraction) and isfinite(traction.force_error):
        coefficient = replace(coefficient, bound=traction.force_error, reason="")
    return {
        "traction_coefficient": coefficient,
        "stick_fraction": Quantity(stick, "1", "fraction of the contact that sticks"),
    }  # fmt: skip


def _of_cycle(traction: FrettingTraction, grid: Grid, length: float | None) -> dict[str, Quantity]:
    """Return the energy that the last cycle of a fretting contact lost, its largest slip, and the largest shear."""
    energy = float(traction.energy.sum() * grid.cell_area)
    return {
        "energy_per_cycle": _per_length(energy, "J", "energy lost per cycle", length, grid.period),
        "largest_slip": Quantity(
            float(traction.slip_distance.max()), "m", "largest distance slipped in a cycle"
        ),
        "largest_shear": Quantity(traction.largest_shear, "Pa", "largest shear of all steps"),
    }


def _of_creepage(
    traction: RollingTraction, load: float, grid: Grid, length: float | None
) -> dict[str, Quantity]:
    """Return what tractive rolling adds to the numbers of a traction: creepage, and power with its bound."""
    total = float(traction.power.sum() * grid.cell_area)
    power = _per_length(total, "W", "frictional power", length, grid.period)
    # power is that of the force: its error, and the part that falls outside the contact
    shear = float(np.abs(traction.shear).sum())
    error = traction.force_error * load / shear if shear else 0.0
    creepage = Quantity(traction.creepage.longitudinal, "1", "longitudinal creepage")
    given = ErrorParts(discretisation=0.0) if traction.creepage_given else None
    return {
        "creepage": bounded(creepage, given),
        "frictional_power": bounded(power, ErrorParts(discretisation=traction.outside + error)),
    }


def _of_rolling(rolling: "SteadyRolling", estimate: ErrorEstimate) -> dict[str, Quantity]:
    """Return the rolling resistance over the load, and the distance of the pressure's centroid from the axis."""
    resistance = Quantity(rolling.resistance, "1", "rolling resistance over load")
    return {
        "rolling_resistance": bounded(resistance, estimate.rolling_resistance, estimate.warnings),
        "pressure_shift": Quantity(rolling.shift, "m", "pressure ahead of the axis"),
    }


def _of_stress(
    scene: Scene | None,
    derived: Mapping[str, Field],
    places: Mapping[str, Array],
    estimate: ErrorEstimate,
) -> dict[str, Quantity]:
    """Return the largest von Mises stress below the surface with its depth, and the margin to yield where known."""
    if scene is None or "von_mises" not in derived:
        return {}
    stress = derived["von_mises"]
    axes = {
        **places,
        **{axis: derived[axis].values for axis in stress.dimensions if axis in derived},
    }
    largest, place = _largest(stress.values, axes, stress.dimensions)
    why = estimate.warnings
    value = Quantity(largest, "Pa", "largest von Mises stress", place=place)
    numbers = {"largest_von_mises": bounded(value, estimate.largest_von_mises, why)}
    if "z" in place:
        depth = Quantity(place["z"], "m", "depth of the largest von Mises stress")
        numbers["largest_von_mises_depth"] = bounded(depth, estimate.largest_von_mises_depth, why)
    solids = (scene.solids[out.solid] for out in scene.outputs if hasattr(out, "solid"))
    strength = min((float(getattr(body, "yield_strength", inf)) for body in solids), default=inf)
    if strength < inf and largest:
        margin = Quantity(strength / largest, "1", "yield strength over von Mises stress")
        numbers["safety_factor"] = margin
    return numbers


def film_quantities(contact: "FilmSolution", estimate: ErrorEstimate) -> dict[str, Quantity]:
    """Return the numbers of a lubricated contact with the `estimate` of its errors."""
    scales, why = contact.scales, estimate.warnings
    numbers = {
        "central_film": Quantity(contact.central_film, "m", "central film"),
        "minimum_film": Quantity(contact.minimum_film, "m", "smallest film"),
        "peak_pressure": Quantity(contact.peak_pressure, "Pa", "peak pressure"),
        "friction_coefficient": Quantity(contact.friction, "1", "friction force over load"),
        "power_loss": Quantity(contact.power_loss, "W m-1", "power lost in the film per length"),
        "sliding_loss": Quantity(
            contact.sliding_loss, "W m-1", "of it by sliding, the rest by the flow in the inlet"
        ),
        "load_per_length": bounded(
            Quantity(contact.load_per_length, "N m-1", "load per length"),
            ErrorParts(residual=contact.residual),
        ),
        "load_parameter": Quantity(scales.load_parameter, "1", "Moes' M", 0.0, ""),
        "viscosity_parameter": Quantity(scales.viscosity_parameter, "1", "Moes' L", 0.0, ""),
        "moes_film": Quantity(
            scales.expected_film * scales.film, "m", "central film by Moes", reason=FORMULA
        ),
        **_of_formulas(contact),
        "flux_spread": Quantity(contact.flux_spread, "1", "flow that the cells do not conserve, relative"),
    }  # fmt: skip
    if scales.lubrication.supply is not None:
        numbers["meniscus"] = Quantity(
            contact.meniscus, "m", "place where lubricant fills the film"
        )
    if contact.contact_pressure is not None:
        numbers["contact_load_fraction"] = Quantity(
            contact.contact_load_fraction, "1", "fraction of the load on asperities"
        )
        numbers["contact_area_fraction"] = Quantity(
            contact.contact_area_fraction, "1", "area of touching asperities over Hertz's"
        )
    errors = dict(estimate)
    return {name: bounded(one, errors.get(name), why) for name, one in numbers.items()}


def _of_formulas(contact: "FilmSolution") -> dict[str, Quantity]:
    """Return the smallest film by Dowson and Higginson, the asymptotes of Moes' film, and the lambda ratio if rough."""
    scales = contact.scales
    load, viscosity = scales.load_parameter, scales.viscosity_parameter
    unit = pi / (8 * load) * scales.film
    label = "smallest film by Dowson and Higginson"
    film = dowson_higginson_film(load, viscosity) * unit
    numbers = {"dowson_higginson_film": Quantity(film, "m", label, reason=FORMULA)}
    for regime, asymptote in film_asymptotes(load, viscosity).items():
        name = f"{regime.replace(', ', '_')}_film"
        numbers[name] = Quantity(asymptote * unit, "m", f"asymptote {regime}", reason=FORMULA)
    rough = [shape for shape in contact.scene.shapes if _rough(shape)]
    heights = sum((shape.gap(contact.grid) for shape in rough), start=np.zeros((1, 1)))
    if rough and (rms := float(np.std(heights))):
        label = f"lambda ratio, film by Moes over the rms height of {readable(rms, 'm', 3)}"
        ratio = scales.expected_film * scales.film / rms
        numbers["lambda_ratio"] = Quantity(ratio, "1", label, reason=FORMULA)
    return numbers


def _rough(shape: object) -> bool:
    """Return whether a shape is roughness, a texture or a measurement, with heights of its own on either body."""
    return not getattr(shape, "curvature", 1.0) and getattr(shape, "detail", Detail()).height > 0


def evolution_quantities(
    frames: Sequence[Mapping[str, Quantity]],
    times: Sequence[float],
    last: "Frame | None",
    length: float | None,
    cell: tuple[float, float],
    strained: Mapping[str, Field],
) -> dict[str, Quantity]:
    """Return the extreme numbers over time with their instants, the numbers at the end, and what is left behind.

    Parameters
    ----------
    frames
        Quantities of each recorded instant.
    times
        The instants [s].
    last
        The last frame of a dry contact, whose fields hold wear and dent; None for a film.
    length
        Length of the roller [m]; None where the contact goes on for ever.
    cell
        Cell area [m^2] and period [m] of the grid.
    strained
        Residual stress (time, component, z, x, y) [Pa] of the bodies that yielded, at the last instant.
    """
    numbers: dict[str, Quantity] = {}
    extremes: tuple[tuple[str, Callable[[list[float]], float], str], ...] = (
        ("peak_pressure", max, "largest peak pressure in time"),
        ("central_film", min, "smallest central film in time"),
        ("minimum_film", min, "smallest film in time"),
        ("friction_coefficient", max, "largest friction force over load in time"),
    )
    for name, extreme, words in extremes:
        if name in frames[0]:
            values = [frame[name].value for frame in frames]
            number = values.index(extreme(values))
            place = {"time": float(times[number])}
            numbers[name] = replace(frames[number][name], label=words, place=place)
    kept = "peak_pressure", "contact_area", "approach", "central_film", "minimum_film"
    for name in (*kept, "friction_coefficient"):
        if name in frames[-1]:
            final = frames[-1][name]
            numbers[f"final_{name}"] = replace(final, label=f"{final.label} at the end", place=None)
    fields = {} if last is None else last.fields
    if "worn_depth" in fields:
        worn, (area, period) = fields["worn_depth"].values, cell
        volume = float(worn.sum() * area)
        numbers["worn_volume"] = _per_length(volume, "m3", "worn volume", length, period)
        numbers["largest_worn_depth"] = Quantity(float(worn.max()), "m", "largest worn depth")
    if "residual_displacement" in fields:
        dent = float(np.abs(fields["residual_displacement"].values).max())
        numbers["dent_depth"] = Quantity(dent, "m", "depth of the dent at the end")
    for name, stress in strained.items():
        if name.startswith("residual_stress"):
            of = f" of solids[{name[-1]}]" if name[-1].isdigit() else ""
            for end, extreme in (("highest", np.max), ("lowest", np.min)):
                label = f"{end} residual stress{of}, across or along"
                across_and_along = float(extreme(stress.values[-1, :2]))
                numbers[f"{end}_{name}"] = Quantity(across_and_along, "Pa", label)
    return numbers


def cycle_quantities(
    lost_work: tuple[float, float], separation: tuple[float, float] | None
) -> dict[str, Quantity]:
    """Return what a history of an adhesive contact says: the pull-off load where contact is lost, and the work lost.

    Parameters
    ----------
    lost_work
        Work lost [J/m], and its error by the instants.
    separation
        Last load held and first load lost [N/m]; None where contact is not lost.
    """
    work, error = lost_work
    numbers = {"work_lost": Quantity(work, "J m-1", "work lost per length", error, "")}
    if separation is not None:
        held, lost = separation
        pull = Quantity(-held, "N m-1", "largest pull that is held", abs(held - lost), "")
        numbers = {"pull_off": pull} | numbers
    return numbers


def passes_quantities(rolled: "RepeatedRolling") -> dict[str, Quantity]:
    """Return what the last pass of a repeatedly rolling contact leaves behind."""
    stress = rolled.residual_stress[-1, 0]
    lowest = int(stress.argmin())
    depth = {"z": float(rolled.depths[lowest])}
    moved = float(rolled.forward_displacement[-1])
    return {
        "lowest_residual_stress": Quantity(
            float(stress[lowest]), "Pa", "lowest residual stress along the travel", place=depth
        ),
        "equivalent_plastic_strain": Quantity(
            float(rolled.equivalent_plastic_strain[-1].max()), "1", "largest equivalent plastic strain"
        ),
        "last_yielding": Quantity(
            float(rolled.yielding[-1]), "1", "largest plastic strain that the last pass adds"
        ),
        "forward_displacement": Quantity(moved, "m", "surface moved against the travel by the last pass"),
    }  # fmt: skip


def _per_length(
    value: float, unit: str, label: str, length: float | None, period: float
) -> Quantity:
    """Return an area or a volume of a roller; per length where the contact goes on for ever."""
    if length is not None:
        return Quantity(value, unit, label)
    return Quantity(value / period, f"{unit} m-1", f"{label} per length")


def _wraps(solution: Solution) -> bool:
    """Return whether the surface repeats across, so that its width is its own."""
    paddings = solution.problem.paddings
    return paddings is not None and paddings[0].wraps


def _half_width(touching: np.ndarray, dx: float) -> float:
    """Return half the distance between the outer edges of the outermost cells in contact [m]."""
    rows = np.flatnonzero(touching.any(axis=1))
    return float((rows[-1] - rows[0] + 1) * dx / 2) if len(rows) else 0.0


def _largest(
    values: Array, axes: Mapping[str, Array], dimensions: Sequence[str] = ("x", "y")
) -> tuple[float, dict[str, float]]:
    """Return the largest value and where it is, of equal ones the one nearest to the middle; one cell has no place."""
    largest = values.max()
    places = np.argwhere(values >= largest * (1 - 1e-9) if largest > 0 else values == largest)
    middle = np.array([(size - 1) / 2 for size in values.shape])
    index = places[np.abs(places - middle).sum(axis=1).argmin()]
    place = {
        name: float(axes[name][at])
        for name, at in zip(dimensions, index, strict=True)
        if name in axes and len(axes[name]) > 1
    }
    return float(largest), place


def _mirrored(values: Array, y: Array, place: Mapping[str, float]) -> str:
    """Return the mirrored place along the length where a largest value stands again, within a thousandth, as text."""
    if abs(at := place.get("y", 0.0)) < 0.1 * float(np.ptp(y)):
        return ""
    mirrored = values[:, int(np.abs(y + at).argmin())].max()
    return f", as high at y = {readable(-at, 'm', 3)}" if mirrored > 0.999 * values.max() else ""


def as_text(quantities: Quantities) -> str:
    """Return quantities as a table: label, value with unit, error, place; those by formulas in one line."""
    rows = [
        (
            one.label,
            readable(one.value, one.unit),
            _percent(one),
            ", ".join(_place(axis, at) for axis, at in (one.place or {}).items()),
        )
        for one in quantities.values()
        if one.reason != FORMULA
    ]
    widths = [max((len(row[column]) for row in rows), default=0) for column in range(3)]
    lines = []
    for label, value, error, place in rows:
        line = f"  {label:<{widths[0]}}  {value:>{widths[1]}}  {error:<{widths[2]}}"
        lines.append(f"{line}  at {place}" if place else line.rstrip())
    formulas = [
        f"{one.label} {readable(one.value, one.unit)}"
        for one in quantities.values()
        if one.reason == FORMULA
    ]
    lines += [f"  by formulas: {'; '.join(formulas)}"] * bool(formulas)
    return "\n".join(lines)


def _place(axis: str, at: float) -> str:
    return f"{at:.3g} s" if axis == "time" else f"{axis} = {readable(at, 'm', 3)}"


def _percent(one: Quantity) -> str:
    if isfinite(one.relative_bound):
        return f"error <= {100 * one.relative_bound:.2g} %"
    return "error not estimated" if one.reason == NO_ESTIMATE else "error not bounded"


def as_json(quantities: Quantities) -> dict[str, dict[str, object]]:
    """Return quantities in SI units by their names; a bound that is not known is None, with its reason."""
    return {
        name: {
            "value": one.value,
            "unit": one.unit,
            "bound": one.bound if isfinite(one.bound) else None,
            **({"reason": one.reason} if one.reason else {}),
            "label": one.label,
            **({"at": dict(one.place)} if one.place else {}),
        }
        for name, one in quantities.items()
    }
