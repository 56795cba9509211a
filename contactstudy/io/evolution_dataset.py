"""Labelled datasets (xarray) of an evolution, of films in time and of repeated rolling."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from contactstudy.domain.fields import Array
from contactstudy.elasticity.kernels.stress_cell import COMPONENTS
from contactstudy.io.dataset import (
    X,
    Y,
    field_variable,
    flags,
    known_or_nan,
    labelled,
    scene_attributes,
    title_attributes,
    traction_variables,
    with_quantities,
)
from contactstudy.io.quantities.quantity import Quantities, per_length, roller_length
from contactstudy.problem.problem import Field
from contactstudy.solvers.solution import Status

if TYPE_CHECKING:
    from contactstudy.evolution.rolling.repeated_rolling import RepeatedRolling
    from contactstudy.evolution.trajectory import Trajectory

Z = {"units": "m", "long_name": "depth", "axis": "Z", "positive": "down"}
# a time of the scene's histories, not a date
TIME = {"long_name": "time", "units": "s"}


def _statuses(dimension: str, statuses: Sequence[Status], long_name: str) -> xr.Variable:
    """Return the statuses of solves along `dimension`, as CF flags."""
    values = [list(Status).index(status) for status in statuses]
    return flags((dimension,), values, list(Status.__members__), long_name)


def evolution_dataset(evolution: "Trajectory", quantities: Quantities) -> xr.Dataset:
    """Return a dry scene in time with dimensions (time, x, y), units and long names; ``status`` as CF flags.

    The fields of ``Scene.outputs`` are computed here, at every instant.
    """
    frames, grid = evolution.frames, evolution.grid

    def over_time(*labels: tuple[str, ...]) -> dict[str, xr.Variable]:
        stacked = {
            name: np.stack([getattr(frame, name) for frame in frames]) for name, *_ in labels
        }
        return {
            name: labelled(("time", *dimensions), stacked[name], units, long_name)
            for name, units, long_name, *dimensions in labels
        }

    length = roller_length(evolution.description)
    of_one = per_length(1.0, "m2", "contact area", length, grid.length)
    area = labelled("time", evolution.contact_area * of_one.value, of_one.unit, of_one.label)
    loads = np.array([frame.load for frame in frames])
    dataset = xr.Dataset(
        over_time(
            ("pressure", "Pa", "contact pressure", "x", "y"),
            ("gap", "m", "gap after deformation", "x", "y"),
            ("approach", "m", "approach of the bodies"),
            ("peak_pressure", "Pa", "peak pressure"),
        )
        | {"contact_area": area, "load": labelled("time", loads, "N m-1", "load per length")}
        | over_time(
            ("residual", "1", "residual of the solver"),
            ("solves", "1", "contact solves since the previous instant"),
            ("iterations", "1", "iterations since the previous instant"),
            ("convolutions", "1", "FFT convolutions since the previous instant"),
        )
        | {
            name: labelled(
                "time",
                [known_or_nan(getattr(frame, name)) for frame in frames],
                "1",
                f"estimated {of} error in L1",
                comment="NaN where it is not known",
            )
            for name, of in (
                ("time_discretisation_error", "time-discretisation"),
                ("grid_error", "discretisation"),
            )
        }
        | {
            "status": _statuses(
                "time",
                [frame.status for frame in frames],
                "worst status since the previous instant",
            )
        },
        coords={
            "time": ("time", evolution.times, TIME),
            "x": ("x", grid.x, X),
            "y": ("y", grid.y, Y),
        },
        attrs=title_attributes("evolution of a line contact")
        | scene_attributes(evolution.description),
    )
    if not evolution.description.scene.has_approach:
        dataset = dataset.drop_vars("approach")
    for fields in (_states, _tractions, _outputs):
        dataset = dataset.assign(fields(evolution))
    return with_quantities(dataset, quantities)


def _tractions(evolution: "Trajectory") -> dict[str, xr.Variable]:
    """Return tangential traction and stick at every instant, zeros without load; empty without friction."""
    tractions = [traction_variables(evolution.traction(frame)) for frame in evolution.frames]
    loaded: dict[str, xr.Variable] = next(filter(None, tractions), {})
    unloaded = {name: xr.zeros_like(variable) for name, variable in loaded.items()}
    return {
        name: xr.Variable.concat(
            [(traction or unloaded)[name] for traction in tractions],
            "time",
            combine_attrs="override",
        )
        for name in loaded
    }


def _states(evolution: "Trajectory") -> dict[str, xr.Variable]:
    """Return the state variables of bodies and wear, such as wear depth and plastic strain, at every instant."""
    frames = evolution.frames
    fields = _over_time([frame.fields for frame in frames])
    if evolution.coupled is not None:
        states = [frame.coupled_state for frame in frames]
        plastic_fields = evolution.coupled.over_time(states)
        fields |= {name: field_variable(field) for name, field in plastic_fields.items()}
    return fields


def _outputs(evolution: "Trajectory") -> dict[str, xr.Variable]:
    """Return the fields of ``Scene.outputs`` at every instant, at the depths that the highest pressure chooses."""
    fields: dict[str, xr.Variable] = {}
    highest = max(evolution.frames, key=lambda frame: frame.peak_pressure)
    for output in evolution.problem.outputs:
        chosen: Any = output
        if hasattr(output, "depths"):
            worst = evolution.derived(highest, output).fields(highest.net_pressure)
            chosen = replace(chosen, depths=tuple(worst["z"].values))
        instants = [
            evolution.derived(frame, chosen).fields(frame.net_pressure)
            for frame in evolution.frames
        ]
        fields |= _over_time(instants)
    return fields


def _over_time(instants: Sequence[Mapping[str, Field]]) -> dict[str, xr.Variable]:
    """Return fields of several instants along the dimension ``time``; coordinates are taken from the first."""
    fields: dict[str, xr.Variable] = {}
    for name, field in instants[0].items():
        variable = field_variable(field)
        if field.dimensions != (name,):
            values = np.stack([instant[name].values for instant in instants])
            variable = xr.Variable(("time", *field.dimensions), values, variable.attrs)
        fields[name] = variable
    return fields


def passes_dataset(rolling: "RepeatedRolling", quantities: Quantities) -> xr.Dataset:
    """Return the state after each pass over (pass_number, component, z), and the last window over (component, z, x)."""
    passes, track, volume = rolling.passes, rolling.track, rolling.track.operator.volume
    window = "component", "z", "x"
    pressure = passes[-1].solution.pressure[:, 0]
    strain = np.einsum("ct,cl...->tl...", track.operator.basis, track.strain)[..., 0]
    below = "plastic strain below the contact in the last pass"
    stress = rolling.unloaded.residual_stress()[..., 0]
    unloaded = "residual stress after unloading, tension positive"
    dataset = xr.Dataset(
        {
            **_pass_variables(rolling),
            "pressure": labelled("x", pressure, "Pa", "contact pressure in the last pass"),
            "window_plastic_strain": labelled(window, strain, "1", below),
            "window_residual_stress": labelled(window, stress, "Pa", unloaded),
        },
        coords={
            "pass_number": (
                "pass_number",
                np.arange(1, len(passes) + 1),
                {"long_name": "number of the pass"},
            ),
            "component": ("component", list(COMPONENTS)),
            "z": ("z", volume.depths, Z),
            "x": ("x", volume.grid.x, X),
        },
        attrs=title_attributes("repeated rolling of a line contact")
        | scene_attributes(rolling.description),
    )
    return with_quantities(dataset, quantities)


def _pass_variables(rolling: "RepeatedRolling") -> dict[str, xr.Variable]:
    """Return strain, stress and displacement after each pass."""

    def after(*labels: tuple[str, ...]) -> dict[str, xr.Variable]:
        return {
            name: labelled(("pass_number", *dimensions), getattr(rolling, name), units, long_name)
            for name, units, long_name, *dimensions in labels
        }

    stress = "stress far behind the contact, tension positive"
    distances = [each_pass.distance for each_pass in rolling.passes]
    states = [each_pass.status for each_pass in rolling.passes]
    return after(
        ("plastic_strain", "1", "plastic strain", "component", "z"),
        ("equivalent_plastic_strain", "1", "equivalent plastic strain", "z"),
        ("residual_stress", "Pa", stress, "component", "z"),
        ("shear_strain_increment", "1", "engineering plastic shear strain added by the pass", "z"),
        (
            "forward_displacement",
            "m",
            "forward displacement of the surface, opposite to the travel of the contact, by the pass",
        ),
        ("plastic_strain_increment", "1", "largest equivalent plastic strain added by the pass"),
        ("peak_pressure", "Pa", "peak pressure at the end of the pass"),
    ) | {
        "distance": labelled("pass_number", np.array(distances), "m", "distance rolled"),
        "status": _statuses("pass_number", states, "worst status of the steps"),
    }


def films_dataset(
    times: Array, contacts: Sequence[xr.Dataset], quantities: Quantities
) -> xr.Dataset:
    """Return the datasets of a film at `times` [s] with the dimension ``time``."""
    time = xr.Variable("time", times, TIME)
    dataset = xr.concat(
        contacts, time, data_vars="all", coords="minimal", compat="override",
        join="exact", combine_attrs="override",
    )  # fmt: skip
    return with_quantities(dataset, quantities)
