"""Whether heights and sizes are those of a rough surface, and which points were not measured."""

import numpy as np

from contactstudy.domain.grid import Array
from contactstudy.domain.validation import InvalidInput, readable
from contactstudy.scene.surfaces.preparation import polynomial
from contactstudy.scene.surfaces.text_surface import FileContent, Reading, unit_name

# Numbers, of either sign, that instruments write for a point that was not measured; any from VOID on is one.
MARKS = (999, 9999, 99999, 999999, 32767, 32768, 65535, 2147483648)
VOID = 1e30


def measured_points(name: str, content: FileContent, reading: Reading) -> tuple[Array, list[str]]:
    """Return the numbers of a file, nan at each point that was not measured, and notes on these."""
    values, notes = np.array(content.values, dtype=np.float64), []
    number = content.invalid if reading.invalid is None else reading.invalid
    if number != content.invalid is not None and reading.sizes == "checked":
        raise InvalidInput(
            f"MeasuredSurface.invalid of {name!r} is {number!r}: leave it out, since the file says {content.invalid!r}."
        )
    with np.errstate(invalid="ignore"):
        values[~(np.abs(values) < VOID)] = np.nan
        if number is not None:
            values[np.isclose(values, number, rtol=1e-6, atol=0)] = np.nan
    while reading.sizes == "checked":
        heights, counts = np.unique(values[np.isfinite(values)], return_counts=True)
        if len(heights) < 4:
            break
        gaps, spread = np.diff(heights), (heights[-1] - heights[1], heights[-2] - heights[0])
        lone = [place for place in (-1, 0) if gaps[place] > spread[place]]
        marks = [place for place in lone if abs(heights[place]) in MARKS]
        if marks:
            values[values == heights[marks[0]]] = np.nan
            notes.append(f"not measured, as {heights[marks[0]]:g} in the file says: {counts[marks[0]]} of the points")
            continue
        second, most = (int(place) for place in np.argsort(counts)[-2:])
        is_frequent = counts[most] >= max(8, 10 * counts[second]) and 0 < most < len(heights) - 1
        for place in [place for place in lone if counts[place] > 1] + [most] * int(is_frequent):
            height = heights[place] + 0.0
            raise InvalidInput(
                f"path is {name!r}, in which {counts[place]} points have the one height {height:g}, as points that were "
                f'not measured: give invalid = {height:g}, or sizes = "confirmed" if they were measured.'
            )
        break
    return values, notes


def check_plausible(name: str, points: Array, sizes: tuple[float, float] | None, unit: float) -> None:
    """Raise :class:`~contactstudy.InvalidInput` if no rough surface has these sizes, with the unit that is likely."""
    level = _levelled(points)
    if not (fault := _fault(level, sizes)):
        return
    powers = (1e-3, 1e-6, 1e-9, 1e3, 1e6, 1e9)
    trials = [(p, 1.0) for p in powers] + [(1.0, p) for p in powers] + [(p, p) for p in powers]
    likely = ""
    calm = np.clip(level, *np.nanquantile(level, (0.005, 0.995)))
    if not _fault(calm, sizes):
        steps = "; ".join(steps_between(points)) or "a few points far from the others"
        likely, trials = f" ({steps}: spikes, or points that were not measured)", []
    for up, side in trials:
        if not _fault(level * up, sizes and (sizes[0] * side, sizes[1] * side)):
            what = "heights" if side == 1 else "sizes across and along" if up == 1 else "all numbers"
            likely = f" (likely {what} {side:g} times these)"
            if side == 1 or side == up:
                likely = f" (likely {what} in {unit_name(unit * up)}, not {unit_name(unit)})"
            break
    raise InvalidInput(
        f'path is {name!r}, with {fault}{likely}: give unit and extent that are right, with sizes = "confirmed" if the '
        "file itself is wrong, or if they are right."
    )


def _levelled(points: Array) -> Array:
    """Return heights less the plane through the measured points."""
    if not np.isfinite(points).any():
        return points
    level = points - polynomial(points, 1)[0]
    return np.asarray(np.where(np.abs(level) < 1e-12 * np.nanmax(np.abs(points)), 0.0, level))


def _fault(level: Array, sizes: tuple[float, float] | None) -> str:
    """Return what is implausible about levelled heights and sizes [m], nothing if they are plausible."""
    height = float(np.nanmax(level) - np.nanmin(level)) if np.isfinite(level).any() else 0.0
    if 0 < height < 1e-11:
        return f"heights of {height:.2g} m in all, less than an atom"
    if sizes is None:
        return f"heights of {readable(height)} in all" if height > 1e-2 else ""
    steps = [size / count for size, count in zip(sizes, level.shape, strict=True)]
    if max(steps) > 1e-3 or max(sizes) > 1:
        return f"points {readable(max(steps))} apart over {readable(max(sizes))}"
    if min(steps) < 1e-10:
        return f"points {readable(min(steps))} apart, closer than atoms"
    if height > 0.1 * max(sizes):
        return f"heights of {readable(height)} over {readable(max(sizes))}"
    slopes = [np.diff(level, axis=axis) / steps[axis] for axis in (0, 1) if level.shape[axis] > 1]
    slope = sum(float(np.nanmean(each**2)) for each in slopes if np.isfinite(each).any()) ** 0.5
    return f"an rms slope of {slope:.3g}" if slope > 1 else ""


def steps_between(points: Array) -> list[str]:
    """Return a note on steps between neighbours that no surface of these slopes has."""
    steps = [np.abs(np.diff(points, axis=axis)).ravel() for axis in (0, 1)]
    steps = [step[np.isfinite(step)] for step in steps]
    typical = [float(np.median(step)) if len(step) else 0.0 for step in steps]
    high = [step[step > 50 * usual] for step, usual in zip(steps, typical, strict=True) if usual]
    if not sum(map(len, high)):
        return []
    return [
        f"{sum(map(len, high))} steps between neighbours of up to {readable(float(np.concatenate(high).max()))}, where "
        f"{readable(max(typical))} is typical"
    ]
