"""``contactstudy show FILE.nc --format vtk``: the fields of a file for ParaView."""

import tomllib
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

import contactstudy as cs
from contactstudy import InvalidInput
from contactstudy.domain.imports import import_for
from contactstudy.domain.units import Metres
from studies.store.netcdf import fields_of

if TYPE_CHECKING:
    import xarray as xr


def write_vtk(dataset: "xr.Dataset", file: Path, stem: Path) -> list[Path]:
    """Write the fields of a solution, of each instant or of each case of a study as VTK; return the files to open.

    Fields of the surface are a rectilinear grid of cells, ``STEM.vtr``, those below it one of points,
    ``STEM-stress.vtr``. Instants are a series with their times, ``STEM.pvd``, cases one with their numbers.

    Parameters
    ----------
    dataset, file
        A stored solution or study, and its file.
    stem
        Path of the files to write, without their endings.
    """
    frames: list[tuple[float, xr.Dataset]] = [(0.0, dataset)]
    if "case_status" in dataset:
        frames = [(float(number), fields) for number, (_, fields) in enumerate(fields_of(dataset, file))]
    elif "time" in dataset.dims:
        times = dataset["time"].values
        frames = [(float(time), dataset.isel(time=number)) for number, time in enumerate(times)]
    if not frames or not {"x", "y"} <= set(frames[0][1].dims):
        raise InvalidInput(f"--format has vtk, and {str(file)!r} has no fields over (x, y): run a study with --fields.")
    # a cell alone is as long as the scene's grid, or square where that is not known
    extent = tomllib.loads(str(dataset.attrs.get("scene", ""))).get("grid", {}).get("extent")
    length = None if extent is None else cs.Grid((2, 1), extent).length
    if len(frames) == 1:
        return _write_frame(frames[0][1], stem, "", length)
    numbers = [f"-{number:0{len(str(len(frames)))}d}" for number in range(len(frames))]
    written = [_write_frame(fields, stem, number, length) for number, (_, fields) in zip(numbers, frames, strict=True)]
    group, series = import_for("--format vtk", "pyevtk.vtk").VtkGroup, []
    for number, path in enumerate(written[0]):
        series.append(path.with_name(path.name.replace(f"{numbers[0]}.vtr", ".pvd")))
        collection = group(str(series[-1].with_suffix("")))
        for (time, _), paths in zip(frames, written, strict=True):
            collection.addFile(str(paths[number]), time)
        collection.save()
    return series


def _write_frame(fields: "xr.Dataset", stem: Path, number: str, length: Metres | None) -> list[Path]:
    """Write the fields at one instant, and return the files: that of the surface, and one for each body's depths."""
    write = import_for("--format vtk", "pyevtk.hl").gridToVTK
    edges = [_edges(fields[axis].values) for axis in ("x", "y")]
    if len(edges[1]) == 2:
        edges[1] *= length or np.diff(edges[0])[0]
    # its cells lie between edges: one thin layer, so that the map is seen from above
    flat = np.array([0.0, min(np.diff(edge).min() for edge in edges)])
    on_surface = {
        str(name): np.ascontiguousarray(field.transpose("x", "y").values[:, :, None])
        for name, field in fields.data_vars.items()
        if set(field.dims) == {"x", "y"}
    }
    # the library adds the ending
    files = [write(f"{stem}{number}", edges[0], edges[1], flat, cellData=on_surface)]
    axes = [np.ascontiguousarray(fields[axis].values, dtype=float) for axis in ("x", "y")]
    for axis in [str(name) for name in fields.dims if str(name).startswith("z")]:
        order = np.argsort(-fields[axis].values)
        below: dict[str, np.ndarray] = {}
        for name, field in fields.data_vars.items():
            if not {"x", "y", axis} <= set(field.dims):
                continue
            parts = (
                {f"{name}_{part}": field.sel(component=part) for part in fields["component"].values}
                if "component" in field.dims
                else {str(name): field}
            )
            for key, part in parts.items():
                values = part.transpose("x", "y", axis).values
                below[key] = np.ascontiguousarray(values[:, :, order])
        depths = np.ascontiguousarray(-fields[axis].values[order])
        path = f"{stem}-stress{axis.removeprefix('z')}{number}"
        files.append(write(path, axes[0], axes[1], depths, pointData=below))
    return [Path(path) for path in files]


def _edges(centres: np.ndarray) -> np.ndarray:
    """Return the edges of cells with these centres [m]; of a single one those of a cell of length 1."""
    step = float(centres[-1] - centres[0]) / (len(centres) - 1) if len(centres) > 1 else 1.0
    return np.asarray(centres[0] + step * (np.arange(len(centres) + 1) - 0.5))
