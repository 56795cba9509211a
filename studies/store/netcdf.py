"""Outcomes -> one labelled Dataset -> one netCDF file, whole or not at all."""

import os
import tempfile
from collections.abc import Hashable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from contactstudy import InvalidInput
from studies.model.axis import Axis
from studies.model.case import flags
from studies.model.outcome import CaseStatus, Failure, Outcome
from studies.model.timing_samples import Sample, timing_variables
from studies.store.interrupt import interrupts_deferred

NOT_RUN = Outcome(CaseStatus.NOT_RUN)


def assemble(
    axes: Sequence[Axis],
    cases: Sequence[Hashable],
    outcomes: Mapping[Any, Outcome],
    samples: Mapping[Any, Sequence[Sample]],
    attributes: Mapping[str, Any],
) -> xr.Dataset:
    """Every point of the axes with the outcome of its case; points of one case share its numbers.

    ``cases`` are in the order of the axes, last one fastest: whatever ``outcomes`` and ``samples`` go by.
    A variable's own dimensions follow those of the axes. Where a case has no numbers (NaN, or no text),
    ``case_status`` says so, ``error`` why.
    """
    shape = tuple(len(axis.values) for axis in axes)
    names = tuple(axis.name for axis in axes)
    at = [outcomes.get(case, NOT_RUN) for case in cases]
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
        present = [o.variables[name] for o in at if name in o.variables]
        if any(variable.shape != kind.shape for variable in present):
            left_out.append(name)
            continue
        missing = "" if kind.dtype.kind in "US" else np.nan
        lack = xr.Variable((), missing)
        values = [o.variables.get(name, lack).values for o in at]
        if len(present) < len(at) and missing:  # neither a whole number nor a truth has a nan
            values = [np.broadcast_to(value.astype(float), kind.shape) for value in values]
        stacked = np.reshape(np.array(np.broadcast_arrays(*values)), shape + kind.shape)
        data[name] = xr.Variable(names + kind.dims, stacked, kind.attrs)
    data |= timing_variables(names, shape, [samples.get(case, ()) for case in cases])
    data["case_status"] = flags(
        names, np.reshape([o.case_status for o in at], shape), [case_status.name.lower() for case_status in CaseStatus],
        "what became of the case",
    )  # fmt: skip
    data["case_key"] = xr.Variable(
        names,
        np.array([str(case) for case in cases], dtype=object).reshape(shape),
        {"long_name": "key of the case, also in the journal and of the group of its fields"},
    )
    if any(outcome.failure for outcome in at):
        failures = [outcome.failure or Failure("", "", "") for outcome in at]
        for name, part, long_name in (
            ("error", "sentence", "why the case has no numbers"),
            ("error_type", "kind", "type of the error"),
            ("error_stage", "stage", "whether set-up, solve or measure failed"),
        ):
            texts = np.array([getattr(failure, part) for failure in failures], dtype=object)
            data[name] = xr.Variable(names, texts.reshape(shape), {"long_name": long_name})
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


def write(dataset: xr.Dataset, path: Path, groups: Iterable[tuple[str, xr.Dataset]] = ()) -> None:
    """``dataset`` as netCDF, with ``groups`` below it; a file that was there stays until all is whole."""
    try:
        with interrupts_deferred(), replacing(path) as partial:
            dataset.to_netcdf(partial, engine="netcdf4", encoding=_encoding(dataset))
            for name, group in groups:
                group.to_netcdf(
                    partial, engine="netcdf4", group=name, mode="a", encoding=_encoding(group)
                )
            with partial.open("rb") as file:
                os.fsync(file.fileno())
    except OSError as error:
        raise InvalidInput(
            f"Study file {str(path)!r} cannot be written ({error.strerror or error}): what was stored is kept; "
            "make room or give another folder with --out, and run the same command again."
        ) from None


def _encoding(dataset: xr.Dataset) -> dict[Hashable, dict[str, None]]:
    """CF: a coordinate is nowhere missing, and so names no value that would mean so."""
    return {name: {"_FillValue": None} for name in dataset.coords}


def read(path: Path) -> xr.Dataset:
    """The Dataset in ``path``, in memory; raises :class:`~contactstudy.InvalidInput` without one."""
    try:
        with interrupts_deferred():
            return xr.load_dataset(path, engine="netcdf4")
    except OSError as error:
        raise InvalidInput(
            f"Study file {str(path)!r} cannot be read ({error.strerror or error}): run the study first."
        ) from None
