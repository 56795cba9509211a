"""Differences between two runs of a study."""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from contactstudy import InvalidInput

# Times differ between runs; numbers of the solver change within its tolerance.
STATUSES = ("case_status", "solver_status")
LEFT_OUT = ("_time", "residual", "iterations", "convolutions", "_estimate_residual", "_bound")


def changes(first: xr.Dataset, second: xr.Dataset) -> Sequence[str]:
    """Return sentences on statuses and flags that differ, measures that changed (the largest change first), and times.

    Points are compared that both have. Raises :class:`~contactstudy.InvalidInput` for studies of other axes.
    """
    axes = [str(name) for name in first["case_status"].dims]
    second_axes = [str(name) for name in second["case_status"].dims]
    if set(axes) != set(second_axes):
        raise InvalidInput(
            f"The studies have the axes {axes} and {second_axes}: compare two runs of one study."
        )
    a, b = xr.align(first, second, join="inner")
    points = int(np.prod([a.sizes[axis] for axis in axes], dtype=int))
    sentences = [
        f"{points} points in both, of {first['case_status'].size} and {second['case_status'].size}"
    ]
    if not points:
        return sentences
    changed = []
    for name in sorted({str(n) for n in a.data_vars} & {str(n) for n in b.data_vars}):
        is_measure = not any(part in name for part in LEFT_OUT) and set(a[name].dims) == set(axes)
        if not is_measure or not {a[name].dtype.kind, b[name].dtype.kind} <= set("biuf"):
            continue
        before, after = (run[name].transpose(*axes).values.astype(float) for run in (a, b))
        if name in STATUSES or "flag_meanings" in a[name].attrs:
            differ = np.count_nonzero((before != after) & ~(np.isnan(before) & np.isnan(after)))
            sentences += [f"{name} differs at {differ} of {points} points"] * bool(differ)
            continue
        with np.errstate(invalid="ignore"):  # two infinite bounds are equal
            change = np.abs(after - before)
        if not np.nan_to_num(change).any():
            continue
        scale = float(np.nanmax(np.abs(before)))
        index = np.unravel_index(int(np.nanargmax(change)), change.shape)
        at = {axis: a[axis].values[k] for axis, k in zip(axes, index, strict=True)}
        x, y = float(before[index]), float(after[index])
        where = ", ".join(f"{axis} {value}" for axis, value in at.items())
        relative = abs(y - x) / scale if scale else np.inf
        sentence = (
            f"{name}: from {x:.6g} to {y:.6g} at {where}, {relative:.2g} of the largest value"
        )
        changed.append((relative, sentence))
    sentences += [sentence for _, sentence in sorted(changed, key=lambda run: -run[0])]
    sentences += ["no measure differs"] * (len(sentences) == 1)
    return [*sentences, *_speed(a, b)]


def _speed(first: xr.Dataset, second: xr.Dataset) -> Sequence[str]:
    """Compare the times of the cases, where one machine timed both."""
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
            f"{name}: median ratio of second to first {middle:.3g} over {ratio.size} points ({low:.3g} to {high:.3g})"
        )
    return sentences
