"""Outcomes -> one labelled Dataset -> one netCDF file, whole or not at all."""

import os
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import xarray as xr

from contactstudy import InvalidInput
from studies.axis import Axis
from studies.case import Computation
from studies.outcome import Fate, Outcome


def assemble(
    axes: Sequence[Axis],
    cases: Sequence[Computation],
    outcomes: Mapping[Computation, Outcome],
    times: Mapping[Computation, tuple[float, float]],
    attributes: Mapping[str, str],
) -> xr.Dataset:
    """Every point of the axes with the outcome of its case; points of one case share its numbers.

    ``cases`` are in the order of the axes, last one fastest. A variable's own dimensions follow those
    of the axes. Where a case failed, numbers are missing (NaN), ``status`` says so, ``error`` why.
    """
    shape = tuple(len(axis.values) for axis in axes)
    names = tuple(axis.name for axis in axes)
    at = [outcomes[case] for case in cases]
    data: dict[str, xr.Variable] = {}
    coords: dict[str, xr.Variable] = {
        axis.name: xr.Variable(
            (axis.name,), list(axis.values), {"long_name": axis.long_name} | _units(axis)
        )
        for axis in axes
    }
    left_out: list[str] = []
    kinds = {name: variable for outcome in at for name, variable in outcome.variables.items()}
    for name, kind in kinds.items():
        if kind.dims == (name,):
            same = all(kind.equals(o.variables[name]) for o in at if name in o.variables)
            coords.update({name: kind} if same else {})
            left_out += [] if same else [name]
            continue
        there = [o.variables[name] for o in at if name in o.variables]
        if any(variable.shape != kind.shape for variable in there):
            left_out.append(name)
            continue
        values = [np.asarray(o.variables.get(name, np.nan)) for o in at]
        if len(there) < len(at):  # neither a whole number nor a truth has a nan
            values = [np.broadcast_to(value.astype(float), kind.shape) for value in values]
        stacked = np.reshape(values, shape + kind.shape)
        data[name] = xr.Variable(names + kind.dims, stacked, kind.attrs)
    for column, (name, long_name) in enumerate(
        (
            ("setup_time", "wall time to set up coefficients and transforms"),
            ("solve_time", "wall time to solve, or to apply an operator once"),
        )
    ):
        seconds = [times.get(case, (np.nan, np.nan))[column] for case in cases]
        attrs = {"units": "s", "long_name": f"{long_name}, one thread, least of the repeats"}
        data[name] = xr.Variable(names, np.reshape(seconds, shape), attrs)
    flags = {
        "long_name": "what became of the case",
        "flag_values": np.array(list(Fate), dtype=np.int8),
        "flag_meanings": " ".join(fate.name.lower() for fate in Fate),
    }
    fates = np.reshape([outcome.fate for outcome in at], shape).astype(np.int8)
    data["status"] = xr.Variable(names, fates, flags)
    if any(outcome.error for outcome in at):
        errors = np.reshape(np.array([outcome.error for outcome in at], dtype=object), shape)
        data["error"] = xr.Variable(names, errors, {"long_name": "why the case failed"})
    noted = {"left_out": f"not the same at every point: {', '.join(left_out)}"} if left_out else {}
    return xr.Dataset(data, coords, dict(attributes) | noted)


def _units(axis: Axis) -> dict[str, str]:
    return {} if axis.kind is str else {"units": axis.units}


def open_folder(path: Path) -> Path:
    """``path`` as a folder that can be written to, made if need be.

    Raises :class:`~contactstudy.InvalidInput` where it cannot.
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=path):
            pass
    except OSError as error:
        raise InvalidInput(
            f"Output folder {str(path)!r} cannot be written to ({_reason(path, error)}): "
            "give another with --out."
        ) from None
    return path


def _reason(path: Path, error: OSError) -> str:
    return "it is a file" if path.is_file() else str(error.strerror)


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """A path to write to, which takes the place of ``path`` once all is written."""
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = path.with_name(f".{path.name}.{os.getpid()}.partial{path.suffix}")
    try:
        yield partial
        partial.replace(path)
    finally:
        partial.unlink(missing_ok=True)


def write(dataset: xr.Dataset, path: Path) -> None:
    """``dataset`` as netCDF; a file that was there stays until the new one is whole."""
    with replacing(path) as partial:
        dataset.to_netcdf(partial, engine="netcdf4")


def read(path: Path) -> xr.Dataset:
    """The Dataset in ``path``, in memory; raises :class:`~contactstudy.InvalidInput` without one."""
    try:
        return xr.load_dataset(path, engine="netcdf4")
    except OSError as error:
        raise InvalidInput(
            f"Study file {str(path)!r} cannot be read ({error.strerror or error}): run the study first."
        ) from None
