"""Solution -> labelled xarray.Dataset."""

import shlex
import sys
from collections.abc import Mapping
from dataclasses import asdict
from datetime import UTC, datetime

import numpy as np
import xarray as xr

from contactstudy.accuracy.estimate import ErrorEstimate
from contactstudy.domain.checks import InvalidInput
from contactstudy.domain.version import VERSION
from contactstudy.io.scene_writer import scene_text
from contactstudy.problem.problem import Sheared
from contactstudy.scene.scene import PosedScene
from contactstudy.scene.surfaces.measured_surface import MeasuredSurface
from contactstudy.solvers.solution import Solution, Status, Traction

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
