"""Outcomes -> one labelled Dataset."""

from collections import defaultdict
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import xarray as xr

from studies.model.axis import Axis
from studies.model.case import flags
from studies.model.outcome import CaseStatus, Failure, Outcome, Sample, timing_variables

# attributes by which two variables of one name are not one quantity
MEANING = ("units", "standard_name", "flag_values", "flag_meanings", "positive")
Signature = Hashable


@dataclass(eq=False)
class _Column:
    """One variable of several cases, alike in dimensions, type and meaning."""

    kind: xr.Variable
    rows: list[int] = field(default_factory=list)
    values: list[Any] = field(default_factory=list)
    dtypes: set[np.dtype] = field(default_factory=set)

    @property
    def is_text(self) -> bool:
        return bool(self.kind.dtype.kind == "U")

    def filled(self, count: int) -> np.ndarray:
        """The values of ``count`` cases; where one has none, it is nan, or no text."""
        held = np.array(self.values, dtype=object if self.is_text else np.result_type(*self.dtypes))
        held = held.reshape(len(self.rows), *self.kind.shape)
        if len(self.rows) == count:
            return held
        if self.is_text:
            whole = np.full((count, *self.kind.shape), "", dtype=object)
        else:  # neither a whole number nor a truth has a nan
            dtype = held.dtype if held.dtype.kind == "f" else np.dtype(float)
            whole = np.full((count, *self.kind.shape), np.nan, dtype)
        whole[self.rows] = held
        return whole


def assemble(
    axes: Sequence[Axis],
    cases: Sequence[Hashable],
    outcome_of: Callable[[Any], Outcome | None],
    samples: Mapping[Any, Sequence[Sample]],
    attributes: Mapping[str, Any],
) -> xr.Dataset:
    """Every point of the axes with the outcome of its case; points of one case share its numbers.

    ``cases`` are in the order of the axes, last one fastest: whatever ``outcome_of`` and ``samples`` go by.
    A variable's own dimensions follow those of the axes. Where a case has no numbers (NaN, or no text),
    ``case_status`` says so, ``error`` why. Where cases give one name to values of different dimensions, types or
    units, those of the most are kept; the attribute ``left_out`` says which are not.
    """
    shape = tuple(len(axis.values) for axis in axes)
    names = tuple(axis.name for axis in axes)
    rows: dict[Hashable, int] = {}
    index = np.array([rows.setdefault(case, len(rows)) for case in cases], dtype=int).reshape(shape)
    columns: dict[str, dict[Signature, _Column]] = defaultdict(dict)
    statuses: list[CaseStatus] = []
    failures: dict[int, Failure] = {}
    for case, row in rows.items():
        outcome = outcome_of(case)
        statuses.append(CaseStatus.NOT_RUN if outcome is None else outcome.case_status)
        if outcome is None:
            continue
        if outcome.failure:
            failures[row] = outcome.failure
        for name, variable in outcome.variables.items():
            column = columns[name].setdefault(_signature(variable), _Column(variable))
            column.rows.append(row)
            column.dtypes.add(variable.dtype)
            column.values.append(variable.values.item() if variable.ndim == 0 else variable.values)
    coords: dict[str, xr.Variable] = {
        axis.name: xr.Variable(
            (axis.name,), list(axis.values), {"long_name": axis.long_name} | _units(axis)
        )
        for axis in axes
    }
    data: dict[str, xr.Variable] = {}
    left_out: list[str] = []
    for name, column in _chosen(columns, left_out):
        kind = column.kind
        if kind.dims == (name,):
            if all(np.array_equal(kind.values, values) for values in column.values):
                coords[name] = kind
            else:
                left_out.append(f"{name}, a coordinate that is not the same at every point")
            continue
        data[name] = xr.Variable(
            names + kind.dims, column.filled(len(rows))[index], dict(kind.attrs)
        )
    taken = [samples.get(case, ()) for case in rows]
    data |= {
        name: variable
        for name, variable in timing_variables(names, index, taken).items()
        if name not in data
    }
    data["case_status"] = flags(
        names, np.array(statuses, dtype=np.int8)[index], [status.name.lower() for status in CaseStatus],
        "what became of the case",
    )  # fmt: skip
    data["case_key"] = xr.Variable(
        names,
        np.array([str(case) for case in rows], dtype=object)[index],
        {"long_name": "key of the case, also in the journal and of the group of its fields"},
    )
    if failures:
        none = Failure("", "", "")
        for name, part, long_name in (
            ("error", "sentence", "why the case has no numbers"),
            ("error_type", "kind", "type of the error"),
            ("error_stage", "stage", "whether set-up, solve or measure failed"),
        ):
            texts = [getattr(failures.get(row, none), part) for row in range(len(rows))]
            values = np.array(texts, dtype=object)[index]
            data[name] = xr.Variable(names, values, {"long_name": long_name})
    noted = {"left_out": "; ".join(left_out)} if left_out else {}
    return xr.Dataset(data, coords, dict(attributes) | noted)


def _signature(variable: xr.Variable) -> Signature:
    attrs = variable.attrs
    meaning = tuple(str(attrs[name]) if name in attrs else None for name in MEANING)
    return variable.dims, variable.shape, variable.dtype.kind == "U", meaning


def _chosen(
    columns: Mapping[str, Mapping[Signature, _Column]], left_out: list[str]
) -> Iterator[tuple[str, _Column]]:
    """For each name the variable that most cases have, in dimensions that do not contradict another's."""
    sizes: dict[Hashable, int] = {}
    for name, alike in columns.items():
        column = max(alike.values(), key=lambda one: len(one.rows))
        count = sum(len(one.rows) for one in alike.values())
        if len(column.rows) < count:
            left_out.append(
                f"{name} of {count - len(column.rows)} of {count} cases, which differs from the others' in "
                "dimensions, type or units"
            )
        own = column.kind.sizes
        clash = [dim for dim, size in own.items() if sizes.get(dim, size) != size]
        clash += [
            dim
            for dim in own
            if dim in columns and dim != name and not _is_coordinate(columns, dim)
        ]
        if clash:
            left_out.append(f"{name}, since another variable has another {clash[0]}")
            continue
        sizes.update(own)
        yield name, column


def _is_coordinate(columns: Mapping[str, Mapping[Signature, _Column]], dim: Hashable) -> bool:
    return all(column.kind.dims == (dim,) for column in columns[str(dim)].values())


def _units(axis: Axis) -> dict[str, str]:
    return {} if axis.kind is str else {"units": axis.units}
