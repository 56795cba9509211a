"""Labelled datasets (xarray) of a solution, of a march in time and of repeated rolling."""

import shlex
import sys
from collections.abc import Mapping
from dataclasses import asdict
from datetime import UTC, datetime
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from contactstudy.accuracy.estimate import ErrorEstimate
from contactstudy.domain.checks import InvalidInput
from contactstudy.domain.fields import Array
from contactstudy.domain.version import VERSION
from contactstudy.elasticity.kernels.stress_cell import COMPONENTS
from contactstudy.io.scene_writer import scene_text
from contactstudy.problem.problem import Sheared
from contactstudy.scene.scene import PosedScene
from contactstudy.scene.surfaces.measured_surface import MeasuredSurface
from contactstudy.solvers.solution import Solution, Status, Traction

if TYPE_CHECKING:
    from contactstudy.evolution.evolution import Evolution
    from contactstudy.evolution.repeated_rolling import RepeatedRolling

X = {"units": "m", "axis": "X", "long_name": "position across the contact"}
Y = {"units": "m", "axis": "Y", "long_name": "position along the contact"}


def to_dataset(solution: Solution, error: ErrorEstimate | None = None) -> xr.Dataset:
    """``solution`` with dimensions (x, y), units, long names, and where it came from.

    Coordinates are cell centres [m]. What may differ between two solutions is a variable without dimensions:
    load, Hertz's values, contact area, approach, ``status`` (a CF flag). The attribute ``scene`` is
    the scene as TOML with its grid and padding, which :func:`~contactstudy.read_scene` reads back.
    With ``error``, an estimate of the errors, those too, along a dimension ``cause`` over which they
    add up. What ``Scene.outputs`` asks for is computed here.
    """
    grid = solution.problem.grid
    fields = {
        "pressure": (solution.pressure, "Pa", "contact pressure"),
        "displacement": (solution.displacement, "m", "surface displacement"),
        "gap": (solution.gap, "m", "gap after deformation"),
    }
    dataset = xr.Dataset(
        {
            name: (("x", "y"), values, {"units": units, "long_name": long_name})
            for name, (values, units, long_name) in fields.items()
        },
        coords={"x": ("x", grid.x, X), "y": ("y", grid.y, Y)},
        attrs={
            "Conventions": "CF-1.11",
            "title": "line contact",
            "source": f"contactstudy {VERSION}",
            "history": f"{datetime.now(UTC).isoformat(timespec='seconds')} {shlex.join(sys.argv)}",
        },
    )
    numbers = {
        "approach": (solution.approach, "m", "approach of the bodies"),
        "contact_area": (
            float(np.count_nonzero(solution.pressure) * grid.cell_area),
            "m2",
            "area of the cells in contact",
        ),
        "residual": (solution.residual, "1", "residual of the solver"),
        "iterations": (solution.iterations, "1", "solver iterations"),
        "convolutions": (solution.convolutions, "1", "transform pairs of the full grid"),
        **_of_scene(solution.problem.description),
    }
    for name, (value, units, long_name) in numbers.items():
        dataset[name] = (), value, {"units": units, "long_name": long_name}
    dataset["status"] = _status(solution.status)
    if isinstance(solution.problem.description, PosedScene):
        dataset.attrs.update(_measured(solution.problem.description))
        dataset.attrs["scene"] = scene_attribute(solution.problem.description)
    traction = solution.traction
    if traction is not None:
        dataset = dataset.assign(_sheared(traction))
    for output in solution.problem.outputs:
        if traction is not None and isinstance(output, Sheared):
            output = output.under(traction.shear)
        for name, one in output.fields(solution.pressure).items():
            labels = {"units": one.units, "long_name": one.long_name, **one.attributes}
            dataset[name] = one.dimensions, one.values, labels
    return dataset if error is None else _with(dataset, error)


def _sheared(traction: Traction) -> dict[str, xr.Variable]:
    """Shear by its two components, and where it sticks."""
    across, along = traction.shear
    named = {
        "shear_x": (across, "Pa", "shear across the contact, on the first body"),
        "shear_y": (along, "Pa", "shear along the contact, on the first body"),
        "stick": (traction.stick.astype(np.int8), "1", "1 where the bodies stick, 0 elsewhere"),
    }
    return {
        name: xr.Variable(("x", "y"), values, {"units": units, "long_name": long_name})
        for name, (values, units, long_name) in named.items()
    }


def _of_scene(source: object) -> Mapping[str, tuple[float, str, str]]:
    """Load and Hertz's values, where the problem was made from a scene."""
    if not isinstance(source, PosedScene):
        return {}
    found = {"load_per_length": (source.scene.load.largest, "N m-1", "load per length")}
    if (hertz := source.scene.hertz) is not None:
        found["hertz_half_width"] = hertz.half_width, "m", "half-width of Hertz's line contact"
        found["hertz_peak_pressure"] = (
            hertz.peak_pressure,
            "Pa",
            "peak pressure of Hertz's line contact",
        )
    return found


def _measured(source: PosedScene) -> Mapping[str, str]:
    """The files of measured surfaces, and the digests of their heights."""
    found = [
        f"shapes[{number}]: {shape.file or 'no file'}, digest {shape.digest}"
        for number, shape in enumerate(source.scene.shapes)
        if isinstance(shape, MeasuredSurface)
    ]
    return {"measured_surfaces": "\n".join(found)} if found else {}


def _status(status: Status) -> xr.Variable:
    """A CF flag, with the sentence as its comment."""
    names = [one.name for one in Status]
    attributes = {
        "units": "1",
        "long_name": "how the solver ended",
        "flag_values": np.arange(len(names), dtype=np.int8),
        "flag_meanings": " ".join(names),
        "comment": str(status),
    }
    return xr.Variable((), np.int8(names.index(status.name)), attributes)


def scene_attribute(source: PosedScene) -> str:
    """The scene as TOML, or as Python where a shape or a body is not of this package."""
    try:
        return scene_text(source.scene, grid=source.grid, padding=source.padding)
    except InvalidInput as error:  # a shape or a body that is not of this package
        return f"# {error}\n# {source!r}\n"


def _with(dataset: xr.Dataset, estimate: ErrorEstimate) -> xr.Dataset:
    """``dataset`` with the estimate, and with its warnings as one text where there are any."""
    found = dataset.assign(_estimated(estimate))
    if estimate.warnings:
        found.attrs["warnings"] = " ".join(estimate.warnings)
    return found


def _estimated(estimate: ErrorEstimate) -> dict[str, xr.DataArray]:
    named = {
        "peak_pressure": ("peak pressure", estimate.peak_pressure),
        "pressure_l1": ("pressure in L1", estimate.l1),
        "contact_area": ("contact area", estimate.contact_area),
        "mean_gap": ("mean gap", estimate.mean_gap),
    }
    return {
        f"{metric}_error_estimate": xr.DataArray(
            list(asdict(parts).values()),
            {
                "cause": (
                    "cause",
                    list(asdict(parts)),
                    {"units": "1", "long_name": "cause of the error"},
                )
            },
            ("cause",),
            attrs={"units": "1", "long_name": f"estimated relative error of the {what}"},
        )
        for metric, (what, parts) in named.items()
    }


def evolution_dataset(evolution: "Evolution") -> xr.Dataset:
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


def rolling_dataset(rolling: "RepeatedRolling") -> xr.Dataset:
    """What each pass leaves, over (pass, component, z), and the window at its end over (component, z, x)."""
    passes, track, volume = rolling.passes, rolling.track, rolling.track.operator.volume
    tensors = "pass", "component", "z"
    statuses = list(Status)
    window = np.einsum("ct,cl...->tl...", track.operator.basis, track.strain)

    def labelled(values: Array, units: str, long_name: str, *dimensions: str) -> xr.Variable:
        return xr.Variable(dimensions, values, {"units": units, "long_name": long_name})

    return xr.Dataset(
        {
            "plastic_strain": labelled(rolling.plastic_strain, "1", "plastic strain", *tensors),
            "equivalent_plastic_strain": labelled(
                rolling.equivalent_plastic_strain, "1", "equivalent plastic strain", "pass", "z"
            ),
            "residual_stress": labelled(
                rolling.residual_stress, "Pa", "stress far behind the contact, tension positive", *tensors
            ),
            "shear": labelled(rolling.shear, "1", "shear strain added by the pass", "pass", "z"),
            "forward_displacement": labelled(
                rolling.forward_displacement, "m", "surface moved against the travel by the pass", "pass"
            ),
            "yielding": labelled(
                rolling.yielding, "1", "largest equivalent plastic strain added by the pass", "pass"
            ),
            "peak_pressure": labelled(
                rolling.peak_pressure, "Pa", "peak pressure at the end of the pass", "pass"
            ),
            "distance": labelled(
                np.array([one.distance for one in passes]), "m", "distance rolled", "pass"
            ),
            "status": xr.Variable(
                "pass",
                np.array([statuses.index(one.status) for one in passes], dtype=np.int8),
                {
                    "long_name": "worst status of the steps",
                    "flag_values": np.arange(len(statuses), dtype=np.int8),
                    "flag_meanings": " ".join(one.name for one in statuses),
                },
            ),
            "pressure": labelled(
                passes[-1].solution.pressure[:, 0], "Pa", "contact pressure in the last pass", "x"
            ),
            "window_plastic_strain": labelled(
                window[..., 0], "1", "plastic strain below the contact in the last pass",
                "component", "z", "x",
            ),
            "window_residual_stress": labelled(
                rolling.removed.residual_stress()[..., 0], "Pa",
                "stress where the last contact was lifted off, tension positive",
                "component", "z", "x",
            ),
        },
        coords={
            "pass": ("pass", np.arange(1, len(passes) + 1), {"long_name": "number of the pass"}),
            "component": ("component", list(COMPONENTS)),
            "z": ("z", volume.depths, {"units": "m", "long_name": "depth", "axis": "Z", "positive": "down"}),
            "x": ("x", volume.grid.x, X),
        },
        attrs={
            "Conventions": "CF-1.11",
            "title": "repeated rolling of a line contact",
            "source": f"contactstudy {VERSION}",
            "scene": scene_attribute(rolling.description),
        },
    )  # fmt: skip
