"""Outcomes as one labelled Dataset."""

from collections import defaultdict
from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import astuple, dataclass, field
from itertools import product
from math import prod
from typing import Any

import numpy as np
import xarray as xr

from contactstudy.domain.identity import CanonicalMemo
from contactstudy.io.dataset import flags
from studies.model.axis import Axis, Value
from studies.model.outcome import CaseStatus, Failure, Outcome, Sample, timing_variables
from studies.model.study import Study
from studies.store.records import Contents
from studies.store.request import CaseStates, Request

# a table of all points may take this many times the bytes stored of a variable, and this many bytes more
MAX_FILL_FACTOR, FREE_BYTES = 4, 2**28
# attributes in which variables of one quantity agree
MEANING_ATTRIBUTES = ("units", "standard_name", "flag_values", "flag_meanings", "positive")
Signature = Hashable


@dataclass(eq=False)
class _Column:
    """A variable of several cases with equal dimensions, type and meaning."""

    kind: xr.Variable
    rows: list[int] = field(default_factory=list)
    values: list[Any] = field(default_factory=list)
    dtypes: set[np.dtype] = field(default_factory=set)

    @property
    def is_text(self) -> bool:
        return bool(self.kind.dtype.kind == "U")

    def filled(self, count: int) -> np.ndarray:
        """Return the values of `count` cases; nan or empty text where a case has none."""
        stored = np.array(self.values, object if self.is_text else np.result_type(*self.dtypes))
        stored = stored.reshape(len(self.rows), *self.kind.shape)
        if len(self.rows) == count:
            return stored
        # integers and booleans have no nan
        dtype = stored.dtype if stored.dtype.kind in "fO" else np.dtype(float)
        filled = np.full((count, *self.kind.shape), "" if self.is_text else np.nan, dtype)
        filled[self.rows] = stored
        return filled


def assemble(
    axes: Sequence[Axis],
    cases: Sequence[Hashable],
    outcome_of: Callable[[Any], Outcome | None],
    samples_of: Callable[[Any], Sequence[Sample]],
    attributes: Mapping[str, Any],
) -> xr.Dataset:
    """Return every point of the axes with the outcome of its case; points of one case share its numbers.

    A variable's own dimensions follow those of the axes. Where a case has no numbers (NaN, or no text),
    ``case_status`` says so, ``error`` why. Where cases give one name to values of different dimensions, types or
    units, those of most cases are stored; the attribute ``left_out`` names the others.

    Parameters
    ----------
    axes
        Axes of the study.
    cases
        Key of the case at every point, in the order of the axes (last one fastest).
    outcome_of
        Returns the outcome of a case; None if there is none.
    samples_of
        Returns the timed runs of a case.
    attributes
        Attributes of the Dataset.
    """
    shape = tuple(len(axis.values) for axis in axes)
    names = tuple(axis.name for axis in axes)
    rows: dict[Hashable, int] = {}
    index = np.array([rows.setdefault(case, len(rows)) for case in cases], dtype=int).reshape(shape)
    outcomes = [outcome_of(case) for case in rows]
    coords: dict[str, xr.Variable] = {}
    for axis in axes:
        units = {} if axis.kind is str else {"units": axis.units}
        attrs = {"long_name": axis.long_name} | units
        coords[axis.name] = xr.Variable((axis.name,), list(axis.values), attrs)
    data: dict[str, xr.Variable] = {}
    left_out: list[str] = []
    for name, column in _chosen(_columns(outcomes), index.size, left_out):
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
    times = timing_variables(names, index, [samples_of(case) for case in rows])
    about_cases = _about_cases(names, index, [str(case) for case in rows], outcomes)
    notes = {"left_out": "; ".join(left_out)} if left_out else {}
    return xr.Dataset({**times, **data, **about_cases}, coords, dict(attributes) | notes)


def _columns(outcomes: Sequence[Outcome | None]) -> dict[str, dict[Signature, _Column]]:
    """Return the variables of all cases, by name and by signature."""
    columns: dict[str, dict[Signature, _Column]] = defaultdict(dict)
    for row, outcome in enumerate(outcomes):
        for name, variable in outcome.variables.items() if outcome is not None else ():
            column = columns[name].setdefault(_signature(variable), _Column(variable))
            column.rows.append(row)
            column.dtypes.add(variable.dtype)
            column.values.append(variable.values.item() if variable.ndim == 0 else variable.values)
    return columns


def _about_cases(
    names: tuple[str, ...],
    index: np.ndarray,
    keys: Sequence[str],
    outcomes: Sequence[Outcome | None],
) -> dict[str, xr.Variable]:
    """Return the variables on the status and the failure of each case."""
    statuses = [
        CaseStatus.NOT_RUN if outcome is None else outcome.case_status for outcome in outcomes
    ]
    meanings = [status.name.lower() for status in CaseStatus]
    data = {
        "case_status": flags(
            names, np.array(statuses, dtype=np.int8)[index], meanings, "what became of the case"
        )
    }
    nothing = Failure("", "", "")
    failures = [(outcome and outcome.failure) or nothing for outcome in outcomes]
    texts = [
        ("case_key", keys, "key of the case, also in the journal and of the group of its fields")
    ]
    if any(failure is not nothing for failure in failures):
        kinds, sentences, stages = zip(*map(astuple, failures), strict=True)
        texts += [
            ("error", sentences, "why the case has no numbers"),
            ("error_type", kinds, "type of the error"),
            ("error_stage", stages, "whether set-up, solve or measure failed"),
        ]
    for name, values, long_name in texts:
        column = np.array(values, dtype=object)[index]
        data[name] = xr.Variable(names, column, {"long_name": long_name})
    return data


def points_of(dataset: xr.Dataset, study: Study) -> xr.Dataset:
    """Return the points of `dataset` that `study` requests; for numbers, those nearest to its values."""
    for axis in study.points:
        method = None if axis.kind is str else "nearest"
        dataset = dataset.sel({axis.name: list(axis.values)}, method=method)
    return dataset


def _signature(variable: xr.Variable) -> Signature:
    """Return what two variables of one quantity share: dimensions, shape, type and meaning."""
    attrs = variable.attrs
    meaning = tuple(str(attrs[name]) if name in attrs else None for name in MEANING_ATTRIBUTES)
    return variable.dims, variable.shape, variable.dtype.kind == "U", meaning


def _chosen(
    columns: Mapping[str, Mapping[Signature, _Column]], points: int, left_out: list[str]
) -> Iterator[tuple[str, _Column]]:
    """Yield for each name the variable that most cases have, unless its dimensions contradict those of another."""
    sizes: dict[Hashable, int] = {}
    for name, alike in columns.items():
        column = max(alike.values(), key=lambda candidate: len(candidate.rows))
        count = sum(len(candidate.rows) for candidate in alike.values())
        filled, stored = points * column.kind.nbytes, len(column.rows) * column.kind.nbytes
        if filled > FREE_BYTES + MAX_FILL_FACTOR * stored:
            left_out.append(
                f"{name} of {len(column.rows)} cases, since a table of all points would take {filled / 1e9:.3g} GB; "
                "the journal has it"
            )
            continue
        if len(column.rows) < count:
            left_out.append(
                f"{name} of {count - len(column.rows)} of {count} cases, which differs from the others' in "
                "dimensions, type or units"
            )
        clash = [
            dim
            for dim, size in column.kind.sizes.items()
            if sizes.get(dim, size) != size
            or (dim in columns and dim != name and not _is_coordinate(columns, dim))
        ]
        if clash:
            left_out.append(f"{name}, since another variable has another {clash[0]}")
            continue
        sizes.update(column.kind.sizes)
        yield name, column


def _is_coordinate(columns: Mapping[str, Mapping[Signature, _Column]], dim: Hashable) -> bool:
    """Return whether every variable of this name is a coordinate."""
    return all(column.kind.dims == (dim,) for column in columns[str(dim)].values())


MAX_POINTS = 1_000_000  # points


@dataclass(frozen=True, eq=False)
class PointTable:
    """Axes of a table, and the key of the case at every point, in the order of the axes (last one fastest)."""

    axes: tuple[Axis, ...]
    keys: Sequence[str]


def stored_table(study: Study, request: Request, contents: Contents) -> PointTable:
    """Return the requested points, with every value of an axis at which a case is stored.

    A combination of values at which nothing is stored is NOT_RUN. Where this table would be too
    large, it has the requested points only.
    """
    axes = tuple(_grown(axis, contents.axes.get(axis.name, ())) for axis in study.points)
    if axes == study.points or prod(len(axis.values) for axis in axes) > MAX_POINTS:
        return PointTable(study.points, request.keys)
    shape = tuple(len(axis.values) for axis in axes)
    requested = dict(
        zip(product(*(axis.values for axis in study.points)), request.keys, strict=True)
    )
    memory, states = CanonicalMemo(), CaseStates()
    keys: list[str] = []
    is_kept = np.zeros(prod(shape), dtype=bool)
    for index, values in enumerate(product(*(axis.values for axis in axes))):
        name = requested.get(values, "")
        if name:
            is_kept[index] = True
        else:
            name, is_kept[index] = _stored(study, values, contents, memory, states)
        keys.append(name)
    chosen = [np.unique(indices) for indices in is_kept.reshape(shape).nonzero()]
    axes_in_use = tuple(
        Axis(axis.name, tuple(axis.values[index] for index in indices), axis.long_name, axis.units)
        for axis, indices in zip(axes, chosen, strict=True)
    )
    keys_in_use = np.array(keys, dtype=object).reshape(shape)[np.ix_(*chosen)]
    return PointTable(axes_in_use, keys_in_use.ravel().tolist())


def _stored(
    study: Study,
    values: Sequence[Value],
    contents: Contents,
    memory: CanonicalMemo,
    states: CaseStates,
) -> tuple[str, bool]:
    """Return the key of the case at these values, and whether it is stored."""
    point = dict(zip((axis.name for axis in study.points), values, strict=True))
    try:
        identity = states.identity(point, study.scene_at(point), memory)
    except Exception:  # noqa: BLE001 (a point that was not requested may be invalid)
        return "", False
    record = contents.records.get(identity.key)
    return identity.key, record is not None and record.is_of(identity)


def _grown(axis: Axis, stored: Iterable[Value]) -> Axis:
    """Return the axis with stored values of its type added; numbers in rising order stay in rising order."""
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
