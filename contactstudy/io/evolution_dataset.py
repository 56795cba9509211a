"""Evolution -> labelled xarray.Dataset."""

import numpy as np
import xarray as xr

from contactstudy.domain.version import VERSION
from contactstudy.evolution.evolution import Evolution
from contactstudy.io.dataset import X, Y, scene_attribute
from contactstudy.solvers.solution import Status


def evolution_dataset(evolution: Evolution) -> xr.Dataset:
    """``evolution`` with dimensions (time, x, y), units and long names; ``status`` as CF flags.

    What ``Scene.outputs`` asks for is found here, at every instant.
    """
    frames, grid = evolution.frames, evolution.grid
    fields = ("time", "x", "y")

    def series(name: str, units: str, long_name: str) -> tuple[str, object, dict[str, str]]:
        values = np.array([getattr(frame, name) for frame in frames])
        return "time", values, {"units": units, "long_name": long_name}

    statuses = list(Status)
    dataset = xr.Dataset(
        {
            "pressure": (
                fields,
                np.stack([one.pressure for one in frames]),
                _label("Pa", "contact pressure"),
            ),
            "gap": (
                fields,
                np.stack([one.gap for one in frames]),
                _label("m", "gap after deformation"),
            ),
            "load": series("load", "N m-1", "load per length"),
            "approach": series("approach", "m", "approach of the bodies"),
            "peak_pressure": series("peak_pressure", "Pa", "peak pressure"),
            "contact_area": (
                "time",
                evolution.contact_area,
                _label("m2", "area in contact, over the grid"),
            ),
            "step_error": series("step_error", "1", "estimated L1 error by steps in time"),
            "grid_error": series("grid_error", "1", "estimated L1 error by cells"),
            "residual": series("residual", "1", "residual of the solver"),
            "steps": series("steps", "1", "solves since the instant before"),
            "iterations": series("iterations", "1", "iterations since the instant before"),
            "convolutions": series("convolutions", "1", "transform pairs since the instant before"),
            "status": (
                "time",
                np.array([statuses.index(frame.status) for frame in frames], dtype=np.int8),
                {
                    "long_name": "worst status since the instant before",
                    "flag_values": np.arange(len(statuses), dtype=np.int8),
                    "flag_meanings": " ".join(one.name for one in statuses),
                },
            ),
        },
        coords={
            # an offset from the start of the march, not a date
            "time": (
                "time",
                evolution.times,
                {"long_name": "time since the start", "units": "s", "axis": "T"},
            ),
            "x": ("x", grid.x, X),
            "y": ("y", grid.y, Y),
        },
        attrs={
            "Conventions": "CF-1.11",
            "title": "evolution of a line contact",
            "source": f"contactstudy {VERSION}",
            "scene": scene_attribute(evolution.description),
        },
    )
    for name, first in frames[0].fields.items():
        values = np.stack([frame.fields[name].values for frame in frames])
        dataset[name] = ("time", *first.dimensions), values, _label(first.units, first.long_name)
    if evolution.joint is not None:
        kept = [one.kept for one in frames]
        shown = evolution.joint.over_time(kept, [one.pressure for one in frames])
        for name, one in shown.items():
            label = _label(one.units, one.long_name) | dict(one.attributes)
            dataset[name] = one.dimensions, one.values, label
    for output in evolution.outputs:
        found = [output.fields(frame.pressure) for frame in frames]
        for name, one in found[0].items():
            label = _label(one.units, one.long_name) | dict(one.attributes)
            if one.dimensions == (name,):  # a coordinate, the same at every instant
                dataset[name] = one.dimensions, one.values, label
            else:
                values = np.stack([fields_of[name].values for fields_of in found])
                dataset[name] = ("time", *one.dimensions), values, label
    return dataset


def _label(units: str, long_name: str) -> dict[str, str]:
    return {"units": units, "long_name": long_name}
