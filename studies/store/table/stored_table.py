"""The table of a study's file: the points asked for, and those that are stored beside them."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import product
from math import prod

import numpy as np

from studies.model.axis import Axis, Value
from studies.model.study import Study
from studies.store.identity import Memory, canonical, key
from studies.store.journal import CaseIdentity, Contents
from studies.store.request import Request, point_text

LARGEST = 1_000_000  # points


@dataclass(frozen=True, eq=False)
class Table:
    """The axes, and the key of the case at every point, in the order of the axes (last one fastest)."""

    axes: tuple[Axis, ...]
    keys: Sequence[str]


def requested_table(study: Study, request: Request) -> Table:
    """The points asked for, and no others."""
    return Table(study.points, request.keys)


def stored_table(study: Study, request: Request, contents: Contents) -> Table:
    """The points asked for, and every value of an axis at which a case is stored.

    A combination of values of which nothing is stored is NOT_RUN. Where the whole table would be too
    large, it is the points asked for.
    """
    axes = tuple(_grown(axis, contents.axes.get(axis.name, ())) for axis in study.points)
    if axes == study.points or prod(len(axis.values) for axis in axes) > LARGEST:
        return requested_table(study, request)
    shape = tuple(len(axis.values) for axis in axes)
    asked = dict(zip(product(*(axis.values for axis in study.points)), request.keys, strict=True))
    memory: Memory = {}
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
    return Table(kept, left.ravel().tolist())


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
