"""Outcomes -> one labelled Dataset."""

from collections import defaultdict
from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product
from math import prod
from typing import Any

import numpy as np
import xarray as xr

from contactstudy.domain.identity import Memory, canonical, key
from contactstudy.io.dataset import flags
from studies.model.axis import Axis, Value
from studies.model.outcome import CaseStatus, Failure, Outcome, Sample, timing_variables
from studies.model.study import Study
from studies.store.records import CaseIdentity, Contents
from studies.store.request import Request, point_text

# attributes by which two variables of one name are not one quantity
# a table of all points may take this many times what is stored of a variable, and this many bytes more
MOST_FILLED, ROOM = 4, 2**28
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
    for name, column in _chosen(columns, index.size, left_out):
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
    columns: Mapping[str, Mapping[Signature, _Column]], points: int, left_out: list[str]
) -> Iterator[tuple[str, _Column]]:
    """For each name the variable that most cases have, in dimensions that do not contradict another's."""
    sizes: dict[Hashable, int] = {}
    for name, alike in columns.items():
        column = max(alike.values(), key=lambda one: len(one.rows))
        count = sum(len(one.rows) for one in alike.values())
        whole, stored = points * column.kind.nbytes, len(column.rows) * column.kind.nbytes
        if whole > ROOM + MOST_FILLED * stored:
            left_out.append(
                f"{name} of {len(column.rows)} cases, since a table of all points would take {whole / 1e9:.3g} GB; "
                "the journal has it"
            )
            continue
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


LARGEST = 1_000_000  # points


@dataclass(frozen=True, eq=False)
class PointTable:
    """The axes, and the key of the case at every point, in the order of the axes (last one fastest)."""

    axes: tuple[Axis, ...]
    keys: Sequence[str]


def requested_table(study: Study, request: Request) -> PointTable:
    """The points asked for, and no others."""
    return PointTable(study.points, request.keys)


def stored_table(study: Study, request: Request, contents: Contents) -> PointTable:
    """The points asked for, and every value of an axis at which a case is stored.

    A combination of values of which nothing is stored is NOT_RUN. Where the whole table would be too
    large, it is the points asked for.
    """
    axes = tuple(_grown(axis, contents.axes.get(axis.name, ())) for axis in study.points)
    if axes == study.points or prod(len(axis.values) for axis in axes) > LARGEST:
        return requested_table(study, request)
    shape = tuple(len(axis.values) for axis in axes)
    asked = dict(zip(product(*(axis.values for axis in study.points)), request.keys, strict=True))
    memory = Memory()
    keys: list[str] = []
    is_kept = np.zeros(prod(shape), dtype=bool)
    for place, values in enumerate(product(*(axis.values for axis in axes))):
        name = asked.get(values, "")
        if name:
            is_kept[place] = True
        else:
            name, is_kept[place] = _stored(study, values, contents, memory)
        keys.append(name)
    is_kept = is_kept.reshape(shape)
    chosen = [
        np.asarray(
            is_kept.any(axis=tuple(other for other in range(len(axes)) if other != place))
        ).reshape(-1)
        for place in range(len(axes))
    ]
    kept = tuple(
        Axis(axis.name, tuple(v for v, is_in in zip(axis.values, mask, strict=True) if is_in),
             axis.long_name, axis.units)
        for axis, mask in zip(axes, chosen, strict=True)
    )  # fmt: skip
    left = np.array(keys, dtype=object).reshape(shape)[np.ix_(*chosen)]
    return PointTable(kept, left.ravel().tolist())


def _stored(
    study: Study, values: Sequence[Value], contents: Contents, memory: Memory
) -> tuple[str, bool]:
    """The key of the case at these values, and whether it is stored."""
    point = dict(zip((axis.name for axis in study.points), values, strict=True))
    try:
        tree = canonical(study.scene_at(point), memory)
        name = key(tree)
        record = contents.records.get(name)
        is_stored = record is not None and record.is_of(CaseIdentity(name, tree, point_text(point)))
    except Exception:  # noqa: BLE001 (a point that nobody asked for need not be one)
        return "", False
    return name, is_stored


def _grown(axis: Axis, stored: Iterable[Value]) -> Axis:
    """``axis`` with the ``stored`` values of its kind; numbers that rise go on rising."""
    kind = axis.kind
    before = [
        kind(value)
        for value in stored
        if type(value) is kind or (kind, type(value)) == (float, int)
    ]
    values = list(dict.fromkeys([*before, *axis.values]))
    if kind is not str and list(axis.values) == sorted(axis.values):
        values.sort()
    if values == list(axis.values) or set(values) == set(axis.values):
        return axis
    return Axis(axis.name, tuple(values), axis.long_name, axis.units)
