"""Differences between two runs of a study."""

from collections.abc import Iterator, Sequence
from math import inf, prod

import numpy as np
import xarray as xr

from contactstudy import InvalidInput
from studies.model.outcome import is_time
from studies.model.plain_text import counted

STATUSES = ("case_status", "solver_status")
# Variables that are not compared: texts of the store, and numbers of the solver that change within its tolerance.
LEFT_OUT = ("case_key", "error", "residual", "iterations", "linear_iterations", "outer_iterations", "convolutions")
# Ends of the names of further numbers that change within the tolerance of the solver.
LEFT_OUT_ENDS = ("_estimate_residual", "_bound")


def changes(first: xr.Dataset, second: xr.Dataset) -> Sequence[str]:
    """Return sentences on statuses and flags that differ, measures that changed (the largest change first), and times.

    The points that both have are compared, and measures of further dimensions value by value.
    Raises :class:`~contactstudy.InvalidInput` for studies of other axes.
    """
    axes = [str(name) for name in first["case_status"].dims]
    second_axes = [str(name) for name in second["case_status"].dims]
    if set(axes) != set(second_axes):
        raise InvalidInput(f"The studies have the axes {axes} and {second_axes}: compare two runs of one study.")
    unindexed = {dim for run in (first, second) for dim in run.dims if dim not in run.indexes}
    a, b = xr.align(first, second, join="inner", exclude=unindexed)
    points = prod(a.sizes[axis] for axis in axes)
    sentences = [f"{counted(points, 'point')} in both, of {first['case_status'].size} and {second['case_status'].size}"]
    if not points:
        disjoint = [axis for axis in axes if not np.isin(first[axis], second[axis]).any()]
        return [f"{sentences[0]}: no value of {' or '.join(disjoint)} is in both"]
    variables = [
        change
        for name in sorted({str(n) for run in (a, b) for n in run.data_vars})
        if name not in LEFT_OUT and not is_time(name) and not name.endswith(LEFT_OUT_ENDS)
        for change in _changes_of(name, a, b, axes)
    ]
    differences = [sentence for _, sentence in sorted(variables, key=lambda change: -change[0])] or [
        "no measure differs"
    ]
    return [*sentences, *differences, *_speed(a, b)]


def _changes_of(name: str, a: xr.Dataset, b: xr.Dataset, axes: Sequence[str]) -> Iterator[tuple[float, str]]:
    """Yield sentences on a variable of the points of two runs, each with its relative change, infinite without one."""
    runs = [run[name] for run in (a, b) if name in run]
    if not all(set(axes) <= set(run.dims) for run in runs):
        return
    if len(runs) == 1:
        yield inf, f"{name} is in the {'first' if name in a else 'second'} run alone"
        return
    dims = [*axes, *(str(dim) for dim in runs[0].dims if dim not in axes)]
    if dict(runs[0].sizes) != dict(runs[1].sizes) or not runs[0].size:
        yield inf, f"{name} is not compared: its values along {dims[-1]} do not correspond"
        return
    before, after = (run.transpose(*dims).values for run in runs)
    is_text = any(run.dtype.kind not in "biuf" for run in runs)
    if is_text or name in STATUSES or "flag_meanings" in runs[0].attrs:
        # two values that are both nan do not differ
        differ = np.count_nonzero((before != after) & ((before == before) | (after == after)))
        if differ:
            points = counted(prod(a.sizes[axis] for axis in axes), "point")
            yield inf, f"{name} differs at {differ} of {points}"
        return
    before, after = before.astype(float), after.astype(float)
    is_missing = runs[0].isnull() != runs[1].isnull()
    if missing := int((is_missing & (a["case_status"] == b["case_status"])).sum()):
        yield inf, f"{name} is nan at {counted(missing, 'point')} of one run alone"
    with np.errstate(invalid="ignore"):  # the difference of two infinite values is nan, and counts as none
        change = np.abs(after - before)
    if not np.nan_to_num(change).any():
        return
    scale = float(np.abs(before[np.isfinite(before)]).max(initial=0.0))
    index = np.unravel_index(int(np.nanargmax(change)), change.shape)
    where = ", ".join(f"{dim} {a[dim].values[k]}" for dim, k in zip(dims, index, strict=True))
    x, y = float(before[index]), float(after[index])
    relative = abs(y - x) / scale if scale else inf
    yield relative, f"{name}: from {x:.6g} to {y:.6g} at {where}, {relative:.2g} of the largest value"


def _speed(first: xr.Dataset, second: xr.Dataset) -> Sequence[str]:
    """Return sentences on the ratio of the times of the cases, if both ran on the same model of processor and cores."""
    sentences = []
    for name in ("solve_time", "solve_time_cpu"):
        if name not in first or name not in second:
            continue
        ratio = (second[name] / first[name]).values.ravel()
        ratio = ratio[np.isfinite(ratio)]
        if ratio.size == 0:
            continue
        if any(first.attrs.get(key) != second.attrs.get(key) for key in ("cpu", "cpu_count")):
            return ["times were taken on different processors and are not compared"]
        low, middle, high = np.quantile(ratio, (0, 0.5, 1))
        sentences.append(
            f"{name}: median ratio of second to first {middle:.3g} over "
            f"{counted(ratio.size, 'point')} ({low:.3g} to {high:.3g})"
        )
    return sentences
