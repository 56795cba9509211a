"""Labelled datasets (xarray) of contacts, dry and lubricated, and of evolutions and repeated rolling.

They follow the CF conventions for netCDF: each variable has its unit and long name, and a status is a flag, the index
of the status with all names as attributes. What may differ between two contacts is a variable; what does not is an
attribute, such as the scene as TOML.
"""

import shlex
import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from datetime import UTC, datetime
from enum import Enum
from functools import partial
from math import inf, isfinite, isnan, nan
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from contactstudy.analytic import HertzLine
from contactstudy.domain.errors import ErrorEstimate
from contactstudy.domain.grid import Array, Grid
from contactstudy.domain.imports import VERSION
from contactstudy.domain.validation import InvalidInput
from contactstudy.elasticity.kernels.stress import COMPONENTS
from contactstudy.io.quantities.quantity import Quantities, per_length, roller_length
from contactstudy.io.scene_files.structuring import scene_text
from contactstudy.problem.problem import Field
from contactstudy.scene.loads import ChangingLoad, ConstantLoad
from contactstudy.scene.scene import PosedScene
from contactstudy.scene.shapes.roller import Crown, EndRelief, LundbergProfile, ProfilePoints
from contactstudy.scene.shapes.shape import Tilt, with_extent_of
from contactstudy.scene.surfaces.measured_surface import MeasuredSurface
from contactstudy.solvers.fretting import FrettingShear
from contactstudy.solvers.solution import Solution

if TYPE_CHECKING:
    from contactstudy.evolution.repeated_rolling import RepeatedRolling
    from contactstudy.evolution.time_stepper import Frame, Trajectory
    from contactstudy.lubrication.lubricated_contact import FilmSolution

# Attributes of the coordinates. The time is that of the histories of a scene and no date.
X = {"units": "m", "axis": "X", "long_name": "position across the contact"}
Y = {"units": "m", "axis": "Y", "long_name": "position along the contact"}
Z = {"units": "m", "long_name": "depth", "axis": "Z", "positive": "down"}
TIME = {"long_name": "time", "units": "s"}
# Shapes that drop along a roller.
PROFILES = (Crown, LundbergProfile, EndRelief, ProfilePoints, Tilt)


def labelled(
    dimensions: str | Sequence[str], values: object, units: str, long_name: str, **attributes: str
) -> xr.Variable:
    """Return `values` over some `dimensions` as a variable with `units`, `long_name` and further `attributes`."""
    return xr.Variable(dimensions, values, {"units": units, "long_name": long_name} | attributes)


# The same over (x, y), and of a number without dimensions.
_plane, _number = partial(labelled, ("x", "y")), partial(labelled, ())


def flags(dimensions: Sequence[str], values: object, meanings: Sequence[str], long_name: str) -> xr.Variable:
    """Return `values`, indices into `meanings`, as a variable with the flag attributes of the CF conventions."""
    attributes = {
        "long_name": long_name,
        "flag_values": np.arange(len(meanings), dtype=np.int8),
        "flag_meanings": " ".join(meanings),
    }
    return xr.Variable(tuple(dimensions), np.asarray(values, dtype=np.int8), attributes)


def field_variables(fields: Mapping[str, Field]) -> dict[str, xr.Variable]:
    """Return `fields` as variables with their units, long names and attributes, by name."""
    return {
        name: labelled(field.dimensions, field.values, field.units, field.long_name, **field.attributes)
        for name, field in fields.items()
    }


def title_attributes(title: str) -> dict[str, str]:
    """Return the attributes of a dataset with this `title`: its conventions, and this program as the source."""
    return {"Conventions": "CF-1.11", "title": title, "source": f"contactstudy {VERSION}"}


def contact_fields(solution: Solution) -> xr.Dataset:
    """Return pressure, displacement, gap and tractions of a solution over (x, y), with the numbers of its solver."""
    variables = {
        "pressure": _plane(solution.pressure, "Pa", "contact pressure"),
        "displacement": _plane(solution.displacement, "m", "surface displacement"),
        "gap": _plane(solution.gap, "m", "gap after deformation"),
        "convolutions": _number(solution.convolutions, "1", "FFT convolutions of the full grid"),
    }
    for part in solution.parts:
        variables |= field_variables(part.fields(solution.pressure))
    if solution.problem.constraint.hardness < inf:
        variables["dent"] = _plane(solution.dent, "m", "depth of yielding under the hardness")
    return _over_plane(solution.problem.grid, variables, solution)


def _over_plane(grid: Grid, variables: Mapping[str, xr.Variable], solved: "Solution | FilmSolution") -> xr.Dataset:
    """Return `variables` over the cells of a grid, with residual, iterations and status of what was `solved`."""
    of_solver = {
        "residual": _number(solved.residual, "1", "residual of the solver"),
        "iterations": _number(solved.iterations, "1", "solver iterations"),
        "status": _statuses((), [solved.status], "how the solver ended"),
    }
    return xr.Dataset({**variables, **of_solver}, {"x": ("x", grid.x, X), "y": ("y", grid.y, Y)})


def contact_dataset(
    solution: Solution, error: ErrorEstimate, quantities: Quantities, derived: Mapping[str, Field]
) -> xr.Dataset:
    """Return a contact as a dataset over (x, y) with units, long names and its scene.

    Coordinates are cell centres [m]. Values that may differ between contacts are variables without dimensions: the
    quantities with their bounds, load, Hertz's values, ``status`` (a CF flag). The attribute ``scene`` is the scene as
    TOML with its grid and padding, which :func:`~contactstudy.read_scene` reads back, unless heights were given as an
    array or a shape is the user's own.

    Parameters
    ----------
    solution
        The contact.
    error
        Estimate of its errors, labelled along a dimension ``cause`` over which they add up.
    quantities
        Its numbers.
    derived
        Fields of the outputs that its scene names.
    """
    description = solution.problem.description
    dataset = contact_fields(solution)
    history = f"{datetime.now(UTC).isoformat(timespec='seconds')} {shlex.join(sys.argv)}"
    dataset.attrs = title_attributes("line contact") | {"history": history}
    if isinstance(description, PosedScene):
        scene = description.scene
        # Hertz's values are those of the load, which neither an approach nor an attraction gives
        if scene.adhesion is None and isinstance(scene.load, ConstantLoad | ChangingLoad):
            dataset = dataset.assign(_hertz(scene.hertz))
        dataset.attrs |= scene_attributes(description)
        dataset = dataset.assign(_profile(description))
    return with_quantities(_with_errors(dataset.assign(field_variables(derived)), error), quantities)


def _profile(posed: PosedScene) -> dict[str, xr.Variable]:
    """Return the variable ``drop`` (y,) [m] of profiles, crowns and tilt along a roller; none for a scene without.

    The drop counts from the highest place of the roller; beyond its ends it is NaN.
    """
    length, grid = posed.scene.roller_length, posed.grid
    drops = [shape.gap(grid) for shape in posed.scene.shapes if isinstance(shape, PROFILES)]
    along = [drop[0] for drop in drops if drop.shape[0] == 1]
    if not along or length is None:
        return {}
    drop = np.sum(along, axis=0) * np.ones(grid.cells[1])
    drop = np.where(np.abs(grid.y) <= length / 2, drop - drop.min(), np.nan)
    return {"drop": labelled("y", drop, "m", "drop of the profile along the roller")}


def fretting_loop(solution: Solution) -> dict[str, xr.Variable]:
    """Return the loop of force over displacement of a contact that frets, by further solves; none without fretting.

    The variables along the dimension ``loop`` are the tangential force, the rigid displacement and the slip.
    """
    friction, posed = solution.problem.friction, solution.problem.description
    if not isinstance(friction, FrettingShear) or not isinstance(posed, PosedScene):
        return {}
    forces, displacements, slips = friction.loop(solution)
    unit_force = per_length(1.0, "N", "tangential force", roller_length(posed), posed.grid.length)
    rigid = "rigid-body displacement of the second against the first body"
    return {
        "loop_force": labelled("loop", forces * unit_force.value, unit_force.unit, unit_force.label),
        "loop_displacement": labelled("loop", displacements, "m", rigid),
        "loop_slip": labelled("loop", slips, "m", f"{rigid}, less that of full stick"),
    }


def with_quantities(dataset: xr.Dataset, quantities: Quantities) -> xr.Dataset:
    """Return `dataset` with quantities as variables without dimensions, each beside its ``<name>_bound``.

    A bound that is not known is NaN, with the reason as its ``comment``. A name that the dataset has already, such as
    that of a coordinate, is left as it is.
    """
    variables: dict[str, xr.Variable] = {}
    for name, quantity in quantities.items():
        if name in dataset:
            continue
        unit, bound = quantity.unit, f"{name}_bound"
        variables[name] = _number(quantity.value, unit, quantity.label, ancillary_variables=bound)
        known = known_or_nan(quantity.bound)
        comment = {"comment": quantity.reason} if isnan(known) else {}
        variables[bound] = _number(known, unit, f"bound of the error: {quantity.label}", **comment)
    return dataset.assign(variables)


def known_or_nan(bound: float) -> float:
    """Return a bound for a file, where one that is not known is NaN and not infinite."""
    return bound if isfinite(bound) else nan


def _hertz(hertz: HertzLine | None) -> dict[str, xr.Variable]:
    """Return the variables of half-width and peak pressure of `hertz`, the line contact of a scene; none for None."""
    if hertz is None:
        return {}
    return {
        "hertz_half_width": _number(hertz.half_width, "m", "half-width of Hertz's line contact"),
        "hertz_peak_pressure": _number(hertz.peak_pressure, "Pa", "peak pressure of Hertz's line contact"),
    }


def _statuses(dimensions: tuple[str, ...], statuses: Sequence[Enum], long_name: str) -> xr.Variable:
    """Return the statuses of solves as CF flags; a single one without dimensions has its sentence as the comment."""
    kind = type(statuses[0])
    values = [list(kind).index(status) for status in statuses]
    flag = flags(dimensions, values if dimensions else values[0], list(kind.__members__), long_name)
    if not dimensions:
        flag.attrs = {"units": "1", **flag.attrs, "comment": str(statuses[0])}
    return flag


def scene_attributes(posed: PosedScene) -> dict[str, str]:
    """Return the attributes ``scene`` and, where it has any, ``measured_surfaces``.

    The scene is TOML with the extents of its surfaces, or Python in comments where a part of it cannot be written. The
    other attribute says what was done to each measured surface, with its file and digest.
    """
    scene = replace(posed.scene, shapes=with_extent_of(posed.scene.shapes, posed.grid))
    try:
        text = scene_text(scene, grid=posed.grid, padding=posed.padding)
    except InvalidInput as error:
        text = f"# {error}\n# {posed!r}\n"
    surfaces = [
        f"shapes[{number}]: {shape.file or 'no file'}, digest {shape.digest}: {shape.description}"
        for number, shape in enumerate(posed.scene.shapes)
        if isinstance(shape, MeasuredSurface)
    ]
    return {"scene": text} | ({"measured_surfaces": "\n".join(surfaces)} if surfaces else {})


def _with_errors(dataset: xr.Dataset, estimate: ErrorEstimate) -> xr.Dataset:
    """Return `dataset` with the estimated errors by cause, and their warnings as one text.

    Each quantity has a variable along the dimension ``cause``. A cause that does not apply to a quantity is 0; an error
    that is not known is NaN, with the reason as ``comment``.
    """
    causes = list(dict.fromkeys(cause for _, parts in estimate for cause in parts.by_cause))
    dataset = dataset.assign_coords(cause=("cause", causes, {"units": "1", "long_name": "cause of the error"}))
    for name, parts in estimate:
        key, words = ("pressure_l1", "pressure in L1") if name == "l1" else (name, name.replace("_", " "))
        values = [known_or_nan(parts.by_cause.get(cause, 0.0)) for cause in causes]
        comment = {} if isfinite(parts.total) else {"comment": parts.reason}
        label = f"estimated relative error of the {words}"
        dataset[f"{key}_error_estimate"] = labelled("cause", values, "1", label, **comment)
    if estimate.warnings:
        dataset.attrs["warnings"] = " ".join(estimate.warnings)
    return dataset


# Fields (x, y) of a film by attribute, with unit and label; one that the film does not have is None.
OF_FILM = {
    "pressure": ("Pa", "pressure of the lubricant"),
    "film": ("m", "film thickness"),
    "film_fraction": ("1", "fractional film content, below 1 where cavitated"),
    "shear": ("Pa", "shear stress in the middle of the film"),
    "contact_pressure": ("Pa", "pressure of asperities"),
    "wear_depth": ("m", "wear depth"),
}


def film_dataset(contact: "FilmSolution", error: ErrorEstimate, quantities: Quantities) -> xr.Dataset:
    """Return a lubricated contact over (x, y), as :func:`contact_dataset` does a dry one."""
    fields = {
        name: _plane(values, *said) for name, said in OF_FILM.items() if (values := getattr(contact, name)) is not None
    }
    variables = fields | _hertz(contact.scales.hertz) | field_variables(contact.derived)
    variables["mean_speed"] = _number(contact.mean_speed, "m s-1", "mean speed of the surfaces")
    if contact.contact_pressure is not None:
        variables["pressure"].attrs["long_name"] = "pressure of lubricant and asperities together"
    if (heat := contact.temperatures) is not None:
        variables["film_temperature_rise"] = _plane(heat.film, "K", "temperature rise of the film")
        for number, rise in enumerate(heat.surface, start=1):
            label = f"temperature rise of surface {number}"
            variables[f"surface_temperature_rise_{number}"] = _plane(rise, "K", label)
    dataset = _over_plane(contact.grid, variables, contact)
    posed = PosedScene(contact.scene, contact.grid, contact.padding)
    dataset.attrs = title_attributes("lubricated line contact") | scene_attributes(posed)
    return with_quantities(_with_errors(dataset, error), quantities)


# Numbers of an instant beside its quantities, with unit and label, by attribute of its frame.
NUMBERS = {
    "load": ("N m-1", "load per length"),
    "residual": ("1", "residual of the solver"),
    "solves": ("1", "contact solves since the previous instant"),
    "iterations": ("1", "iterations since the previous instant"),
    "convolutions": ("1", "FFT convolutions since the previous instant"),
}


def evolution_dataset(evolution: "Trajectory", contacts: Sequence[Any]) -> xr.Dataset:
    """Return the instants of a dry scene along time, with the (coupled) plastic strain of bodies that yield.

    The `contacts` are the answers at the instants of the `evolution`.
    """
    frames, posed = evolution.frames, evolution.description
    # the last one has no outputs where a coating is worn through
    highest = max(contacts, key=lambda contact: (len(contact.problem.outputs), contact.peak_pressure))
    instants = [_instant(*pair, highest) for pair in zip(frames, contacts, strict=True)]
    dataset = over_time(evolution.times, instants)
    dataset.attrs = title_attributes("evolution of a line contact") | scene_attributes(posed)
    statuses = [frame.status for frame in frames]
    dataset["status"] = _statuses(("time",), statuses, "worst status since the previous instant")
    if evolution.coupled is None:
        return dataset
    return dataset.assign(field_variables(evolution.coupled.over_time([frame.coupled_state for frame in frames])))


def _instant(frame: "Frame", contact: Any, highest: Any) -> xr.Dataset:
    """Return one instant of a dry scene: fields of the `contact`, its state and its outputs, and numbers of the `frame`.

    The displacement is left out, which follows from gap and approach. Depths of outputs are those of the contact with
    the `highest` pressure, an answer as the `contact` is.
    """
    variables = field_variables(contact.state | contact.derived_at_depths_of(highest))
    for name in ("approach", "peak_pressure", "contact_area"):
        if (number := contact.quantities.get(name)) is not None:
            variables[name] = _number(number.value, number.unit, number.label)
    variables |= {name: _number(getattr(frame, name), unit, label) for name, (unit, label) in NUMBERS.items()}
    error, known = contact.error.l1, {"comment": "NaN where it is not known"}
    steps, cells = known_or_nan(error.steps or 0.0), known_or_nan(replace(error, steps=None).total)
    variables |= {
        "time_discretisation_error": _number(steps, "1", "estimated time-discretisation error in L1", **known),
        "grid_error": _number(cells, "1", "estimated discretisation error in L1", **known),
    }
    return contact_fields(contact).drop_vars("displacement").assign(variables)


def over_time(times: Array, instants: Sequence[xr.Dataset]) -> xr.Dataset:
    """Return the datasets of instants along the dimension ``time``, at their `times` (time,) [s].

    A field that an instant lacks is there 0 if the instant has no pressure, else NaN.
    """
    everywhere = {name: variable for instant in reversed(instants) for name, variable in instant.items()}

    def completed(instant: xr.Dataset) -> xr.Dataset:
        lacking = np.nan if instant["pressure"].any() else 0.0
        missing = {name: variable for name, variable in everywhere.items() if name not in instant}
        return instant.assign({name: xr.full_like(variable, lacking) for name, variable in missing.items()})

    dataset = xr.concat(
        map(completed, instants), xr.Variable("time", times, TIME), data_vars="all", coords="minimal",
        compat="override", join="exact", combine_attrs="override",
    )  # fmt: skip
    dataset["status"].attrs.pop("comment", None)  # it would be that of the first instant
    return dataset


FORWARD = "forward displacement of the surface, opposite to the travel of the contact, by the pass"
# What each pass leaves behind, by attribute: dimensions beside that of the passes, unit and label.
OF_PASSES: Mapping[str, tuple[tuple[str, ...], str, str]] = {
    "plastic_strain": (("component", "z"), "1", "plastic strain"),
    "equivalent_plastic_strain": (("z",), "1", "equivalent plastic strain"),
    "residual_stress": (("component", "z"), "Pa", "stress far behind the contact, tension positive"),
    "shear_strain_increment": (("z",), "1", "engineering plastic shear strain added by the pass"),
    "forward_displacement": ((), "m", FORWARD),
    "plastic_strain_increment": ((), "1", "largest equivalent plastic strain added by the pass"),
    "peak_pressure": ((), "Pa", "peak pressure at the end of the pass"),
}


def passes_dataset(rolling: "RepeatedRolling") -> xr.Dataset:
    """Return the state after each pass over (pass_number, component, z), and that around the last contact.

    The latter, over (component, z, x), is the pressure, strain and residual stress in the window of the grid, which
    moves with the contact.
    """
    passes, track, volume = rolling.passes, rolling.track, rolling.track.operator.volume
    window = "component", "z", "x"
    pressure = passes[-1].solution.pressure[:, 0]
    # from the components c of the strain to those t of a tensor, in the layers l
    strain = np.einsum("ct,cl...->tl...", track.operator.basis, track.strain)[..., 0]
    below = "plastic strain below the contact in the last pass"
    stress = rolling.unloaded.residual_stress()[..., 0]
    unloaded = "residual stress after unloading, tension positive"
    variables = {
        name: labelled(("pass_number", *dimensions), getattr(rolling, name), unit, label)
        for name, (dimensions, unit, label) in OF_PASSES.items()
    } | {
        "distance": labelled("pass_number", np.array([each.distance for each in passes]), "m", "distance rolled"),
        "status": _statuses(("pass_number",), [each.status for each in passes], "worst status of the steps"),
        "pressure": labelled("x", pressure, "Pa", "contact pressure in the last pass"),
        "window_plastic_strain": labelled(window, strain, "1", below),
        "window_residual_stress": labelled(window, stress, "Pa", unloaded),
    }
    coordinates = {
        "pass_number": ("pass_number", np.arange(1, len(passes) + 1), {"long_name": "number of the pass"}),
        "component": ("component", list(COMPONENTS)),
        "z": ("z", volume.depths, Z),
        "x": ("x", volume.grid.x, X),
    }
    attributes = title_attributes("repeated rolling of a line contact") | scene_attributes(rolling.description)
    return xr.Dataset(variables, coordinates, attributes)
