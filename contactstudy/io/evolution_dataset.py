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
    contact_fields,
    field_variable,
    flags,
    known_or_nan,
    labelled,
    scene_attributes,
    title_attributes,
)
from contactstudy.solvers.solution import Status

if TYPE_CHECKING:
    from contactstudy.evolution.rolling.repeated_rolling import RepeatedRolling
    from contactstudy.evolution.trajectory import Frame, Trajectory

Z = {"units": "m", "long_name": "depth", "axis": "Z", "positive": "down"}
# a time of the scene's histories, not a date
TIME = {"long_name": "time", "units": "s"}


def _statuses(dimension: str, statuses: Sequence[Status], long_name: str) -> xr.Variable:
    """Return the statuses of solves along `dimension`, as CF flags."""
    values = [list(Status).index(status) for status in statuses]
    return flags((dimension,), values, list(Status.__members__), long_name)


# Numbers of an instant beside its quantities, with unit and label.
NUMBERS = {
    "load": ("N m-1", "load per length"),
    "residual": ("1", "residual of the solver"),
    "solves": ("1", "contact solves since the previous instant"),
    "iterations": ("1", "iterations since the previous instant"),
    "convolutions": ("1", "FFT convolutions since the previous instant"),
}


def evolution_dataset(evolution: "Trajectory", contacts: Sequence[Any]) -> xr.Dataset:
    """Return the instants of a dry scene along time, with the strain of bodies that yield; ``status`` as CF flags.

    The `contacts` are the answers at the instants.
    """
    frames, posed = evolution.frames, evolution.description
    # the last one has no outputs where a coating is worn through
    highest = max(contacts, key=lambda one: (len(one.problem.outputs), one.peak_pressure))
    instants = [_instant(*pair, highest) for pair in zip(frames, contacts, strict=True)]
    dataset = over_time(evolution.times, instants)
    dataset.attrs = title_attributes("evolution of a line contact") | scene_attributes(posed)
    statuses = [frame.status for frame in frames]
    dataset["status"] = _statuses("time", statuses, "worst status since the previous instant")
    if evolution.coupled is not None:
        strains = evolution.coupled.over_time([frame.coupled_state for frame in frames])
        dataset = dataset.assign({name: field_variable(of) for name, of in strains.items()})
    return dataset


def _instant(frame: "Frame", contact: Any, highest: Any) -> xr.Dataset:
    """Return one instant of a dry scene: fields of the `contact`, its state and its outputs, and numbers.

    The displacement is left out, which follows from gap and approach. Depths of outputs are those of the contact with
    the `highest` pressure.
    """
    fields = contact.state | contact.derived_at_depths_of(highest)
    variables = {name: field_variable(field) for name, field in fields.items()}
    for name in ("approach", "peak_pressure", "contact_area"):
        if name in contact.quantities:
            number = contact.quantities[name]
            variables[name] = labelled((), number.value, number.unit, number.label)
    for name, (unit, label) in NUMBERS.items():
        variables[name] = labelled((), getattr(frame, name), unit, label)
    error = contact.error.l1
    for name, of, size in (
        ("time_discretisation_error", "time-discretisation", error.steps or 0.0),
        ("grid_error", "discretisation", replace(error, steps=None).total),
    ):
        label, comment = f"estimated {of} error in L1", "NaN where it is not known"
        variables[name] = labelled((), known_or_nan(size), "1", label, comment=comment)
    return contact_fields(contact).drop_vars("displacement").assign(variables)


def over_time(times: Array, instants: Sequence[xr.Dataset]) -> xr.Dataset:
    """Return the datasets of instants [s] along the dimension ``time``.

    A field that an instant lacks is zero there without pressure, and else not a number.
    """
    everywhere = {name: variable for instant in reversed(instants) for name, variable in instant.items()}
    filled = []
    for instant in instants:
        lacks = np.nan if instant["pressure"].any() else 0.0
        missing = {name: of for name, of in everywhere.items() if name not in instant}
        filled.append(instant.assign({name: xr.full_like(of, lacks) for name, of in missing.items()}))
    dataset = xr.concat(
        filled, xr.Variable("time", times, TIME), data_vars="all", coords="minimal",
        compat="override", join="exact", combine_attrs="override",
    )  # fmt: skip
    dataset["status"].attrs.pop("comment", None)  # it would be that of the first instant
    return dataset


# What each pass leaves behind, by attribute: dimensions beside that of the passes, unit and label.
OF_PASSES: Mapping[str, tuple[tuple[str, ...], str, str]] = {
    "plastic_strain": (("component", "z"), "1", "plastic strain"),
    "equivalent_plastic_strain": (("z",), "1", "equivalent plastic strain"),
    "residual_stress": (("component", "z"), "Pa", "stress far behind the contact, tension positive"),
    "shear_strain_increment": (("z",), "1", "engineering plastic shear strain added by the pass"),
    "forward_displacement": (
        (), "m", "forward displacement of the surface, opposite to the travel of the contact, by the pass",
    ),
    "plastic_strain_increment": ((), "1", "largest equivalent plastic strain added by the pass"),
    "peak_pressure": ((), "Pa", "peak pressure at the end of the pass"),
}  # fmt: skip


def passes_dataset(rolling: "RepeatedRolling") -> xr.Dataset:
    """Return the state after each pass over (pass_number, component, z), and the last window over (component, z, x)."""
    passes, track, volume = rolling.passes, rolling.track, rolling.track.operator.volume
    window = "component", "z", "x"
    pressure = passes[-1].solution.pressure[:, 0]
    strain = np.einsum("ct,cl...->tl...", track.operator.basis, track.strain)[..., 0]
    below = "plastic strain below the contact in the last pass"
    stress = rolling.unloaded.residual_stress()[..., 0]
    unloaded = "residual stress after unloading, tension positive"
    variables = {
        name: labelled(("pass_number", *dimensions), getattr(rolling, name), unit, label)
        for name, (dimensions, unit, label) in OF_PASSES.items()
    } | {
        "distance": labelled("pass_number", np.array([one.distance for one in passes]), "m", "distance rolled"),
        "status": _statuses("pass_number", [one.status for one in passes], "worst status of the steps"),
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
