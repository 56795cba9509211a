"""Comparison of two contacts, a and b, on two grids: differences of their pressures, quantities and scenes.

Both pressures are brought to the common refinement of both grids, whose cells lie in one cell of each. The pressure is
the net one: with adhesion less the attraction. Edges are coordinates [m] of the borders of the cells along an axis, one
more than there are cells.
"""

import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from math import isfinite
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from contactstudy.domain.grid import Array
from contactstudy.domain.imports import needed_for
from contactstudy.domain.validation import InvalidInput, readable
from contactstudy.io.dataset import labelled

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Relative differences up to this are rounding: those of quantities are not printed, edges closer together are one.
ROUNDING = 1e-9
# Relative difference of two periods up to which they are the same: files have their lengths with seven digits or more.
SAME_PERIOD = 1e-6
# Quantities that a comparison has as fields of its own.
COMPARED = "peak_pressure", "contact_area", "approach", "load_per_length", "total_load"


@dataclass(frozen=True, eq=False)
class Comparison:
    """Difference of the contact b from the contact a, with the pressures p_a and p_b.

    Parameters
    ----------
    l1
        ``sum |p_b - p_a| / sum |p_a|`` of the means over the larger cells of both grids, as in error estimates.
    peak_pressure, contact_area, load
        ``b / a - 1`` of the net peak pressure, the area of cells in contact, and the load of the net pressure. The area
        is NaN for films. Where the bodies of a do not touch, area and peak are NaN.
    approach
        ``b - a`` [m], meaningful if both are counted from the same point, as on one grid with one load. NaN for films.
    largest, position
        Largest ``|p_b - p_a|`` [Pa], and the place (x, y) [m] where it is.
    difference
        Pressures ``a``, ``b`` and ``b - a`` (x, y) [Pa] on the common refinement of both grids.
    differing
        Sentences on the keys of the scenes that differ.
    quantities
        ``b / a - 1`` of each further quantity that both datasets have, by its long name.
    time
        Instant [s] at which two evolutions are compared: that of the highest pressure of a. None for others.
    """

    l1: float
    peak_pressure: float
    contact_area: float
    load: float
    approach: float
    largest: float
    position: tuple[float, float]
    difference: xr.Dataset
    differing: tuple[str, ...] = ()
    quantities: Mapping[str, float] = field(default_factory=dict)
    time: float | None = None

    def __str__(self) -> str:
        x, y = (readable(coordinate, "m") for coordinate in self.position)
        lines = [
            f"pressure in L1: {100 * self.l1:.3g} %",
            *[f"peak pressure: {100 * self.peak_pressure:+.3g} %"] * isfinite(self.peak_pressure),
            *[f"contact area: {100 * self.contact_area:+.3g} %"] * isfinite(self.contact_area),
            f"load: {100 * round(self.load, 9) + 0.0:+.3g} %",  # without rounding errors
            f"largest difference: {readable(self.largest, 'Pa')} at x = {x}, y = {y}",
        ]
        if isfinite(self.approach):
            lines.append(f"approach: {'+' * (self.approach > 0)}{readable(self.approach)}")
        for name, ratio in self.quantities.items():
            lines += [f"{name}: {100 * ratio:+.3g} %"] * (abs(ratio) > ROUNDING)
        if self.time is not None:
            lines.insert(0, f"at {self.time:.6g} s, the instant of the highest pressure of the first")
        return "\n".join(lines + [f"scenes differ in {text}" for text in self.differing])

    def plot(self) -> "Figure":
        """Draw the difference as a map, and both pressures across the place where it is largest."""
        with needed_for("Comparison.plot"):
            from contactstudy.io.pictures import comparison_picture

        return comparison_picture(self.difference, self.position)


def compare(a: Any, b: Any) -> Comparison:
    """Return how the contact `b` differs from the contact `a`.

    Pressures are constant in each cell, so that all integrals over both grids are exact; beyond the width of a grid the
    pressure is 0. The difference in L1 is that of means over the larger cells along each axis. For two answers to one
    contact it is at most the sum of their bounds. A contact of one cell along is the same at any period.

    Parameters
    ----------
    a, b
        Answers, or their datasets, on any two grids of the same period. Two evolutions are compared at the instant of
        the highest pressure of `a`, which both must have recorded.

    Raises
    ------
    InvalidInput
        For contacts of different periods or kinds, such as a roller with free ends and one period of an infinite
        one, and for a dataset that does not hold a contact.
    """
    first, second, time = _at_one_instant(_labelled("a", a), _labelled("b", b))
    tables = _scene(first), _scene(second)
    _check_kinds(*tables)
    x_a, x_b = _edges(first, "x"), _edges(second, "x")
    y_a, y_b = _one_period(first, second, _edges(first, "y"), _edges(second, "y"))
    x, y = _merged_edges(x_a, x_b), _merged_edges(y_a, y_b)
    area = np.diff(x)[:, None] * np.diff(y)[None, :]
    pressures, areas = [], []
    for name, contact, edges in (("a", first, (x_a, y_a)), ("b", second, (x_b, y_b))):
        pressures.append(_resampled(_net_pressure(contact), *edges, x, y))
        touching = _resampled(contact["pressure"].values, *edges, x, y) > 0
        areas.append(np.nan if "film" in contact else float((touching * area).sum()))
        if not np.isfinite(pressures[-1]).all():
            raise InvalidInput(f"compare.{name} has a pressure that is no number: solve it again.")
    p_a, p_b = pressures
    if not (total := float((np.abs(p_a) * area).sum())):
        raise InvalidInput("compare.a has no pressure anywhere: give a contact that carries a load.")
    change = p_b - p_a
    centres = (x[1:] + x[:-1]) / 2, (y[1:] + y[:-1]) / 2
    index = np.unravel_index(int(np.abs(change).argmax()), change.shape)
    loads = [float((pressure * area).sum()) for pressure in pressures]
    difference = xr.Dataset(
        {
            "a": labelled(("x", "y"), p_a, "Pa", "pressure of a"),
            "b": labelled(("x", "y"), p_b, "Pa", "pressure of b"),
            "difference": labelled(("x", "y"), change, "Pa", "pressure of b less that of a"),
        },
        {"x": ("x", centres[0], first["x"].attrs), "y": ("y", centres[1], first["y"].attrs)},
    )
    across = _sums_over_larger_cells(change * area, x, x_a, x_b)
    forces = _sums_over_larger_cells(across, y, y_a, y_b, axis=1)
    return Comparison(
        l1=float(np.abs(forces).sum()) / total,
        peak_pressure=float(p_b.max() / p_a.max() - 1) if p_a.max() > 0 else np.nan,
        contact_area=areas[1] / areas[0] - 1 if areas[0] else np.nan,
        load=loads[1] / loads[0] - 1 if loads[0] else np.nan,
        approach=float(second.get("approach", np.nan) - first.get("approach", np.nan)),
        largest=float(np.abs(change[index])),
        position=(float(centres[0][index[0]]), float(centres[1][index[1]])),
        difference=difference,
        differing=_differing(_scene(first, "scene_file"), _scene(second, "scene_file")) or _differing(*tables),
        quantities=_quantities(first, second),
        time=time,
    )


def _net_pressure(dataset: xr.Dataset) -> Array:
    """Return the pressure (x, y) [Pa] of the contact in a `dataset`, with adhesion less the attraction."""
    return np.asarray((dataset["pressure"] - dataset.get("attraction", 0.0)).values)


def _quantities(first: xr.Dataset, second: xr.Dataset) -> dict[str, float]:
    """Return ``second / first - 1`` of the quantities that both have, by long name, unless it is 0 in the first."""
    names = [str(name) for name in first if f"{name}_bound" in first and name not in COMPARED]
    values = {
        first[name].attrs.get("long_name", name): (float(first[name]), float(second[name]))
        for name in names
        if name in second and first[name].attrs == second[name].attrs
    }
    return {name: b / a - 1 for name, (a, b) in values.items() if a and isfinite(b / a)}


def _scene(dataset: xr.Dataset, attribute: str = "scene") -> dict[str, object]:
    """Return the values of the scene in a dataset by their paths, without its grid; empty if it has no scene.

    The scene is the TOML text of an attribute: ``scene``, of every answer, or ``scene_file``, with the keys which the
    user wrote.
    """
    try:
        return _flattened(tomllib.loads(str(dataset.attrs.get(attribute, ""))), "")
    except tomllib.TOMLDecodeError:
        return {}


def _flattened(value: object, path: str) -> dict[str, object]:
    """Return the values in nested tables at `path` by their paths, such as "shapes.0.radius", less those of a grid."""
    entries: Iterable[tuple[object, object]]
    if isinstance(value, dict):
        entries = value.items()
    elif isinstance(value, list) and any(isinstance(entry, dict) for entry in value):
        entries = enumerate(value)
    else:
        return {} if path.startswith("grid.") else {path: value}
    flat: dict[str, object] = {}
    for key, entry in entries:
        flat |= _flattened(entry, f"{path}.{key}" if path else str(key))
    return flat


def _check_kinds(first: Mapping[str, object], second: Mapping[str, object]) -> None:
    """Raise InvalidInput if only one contact ends at the ends of its grid, or only one is lubricated."""
    ends = [table.get("padding.kind", table.get("padding")) == "ZeroPadding" for table in (first, second)]
    if first and second and ends[0] != ends[1]:
        ended, endless = ("a", "b") if ends[0] else ("b", "a")
        raise InvalidInput(
            f"The contacts are of different kinds: {ended} ends at both ends of its grid (ZeroPadding), and {endless} "
            "is one period of an endless contact: compare contacts with the same padding along the length."
        )
    films = [any(key.startswith("lubrication") for key in table) for table in (first, second)]
    if films[0] != films[1]:
        raise InvalidInput(
            "The contacts are of different kinds: one is lubricated, the other is dry: compare two of the same kind."
        )


def _differing(first: Mapping[str, object], second: Mapping[str, object]) -> tuple[str, ...]:
    """Return path and both values, as text, for each key in which the `first` scene differs from the `second`.

    There is none if one of them is not known.
    """
    keys = [key for key in {**first, **second} if first.get(key) != second.get(key)] if first and second else []
    return tuple(f"{key}: {_value_text(first.get(key))} and {_value_text(second.get(key))}" for key in keys)


def _value_text(value: object) -> str:
    """Return a value of a scene as a comparison prints it."""
    return "none" if value is None else f"{value:.6g}" if isinstance(value, float) else str(value)


def _labelled(name: str, contact: Any) -> xr.Dataset:
    """Return the dataset of the contact `name`, "a" or "b"; raise InvalidInput if it has no pressure over (x, y)."""
    if hasattr(contact, "to_dataset"):
        contact = contact.to_dataset()
    if (
        not isinstance(contact, xr.Dataset)
        or "pressure" not in contact
        or contact["pressure"].dims not in (("x", "y"), ("time", "x", "y"))
    ):
        raise InvalidInput(
            f"compare.{name} is {type(contact).__name__} without a pressure over (x, y): give an answer or its dataset."
        )
    return contact


def _at_one_instant(first: xr.Dataset, second: xr.Dataset) -> tuple[xr.Dataset, xr.Dataset, float | None]:
    """Return both contacts at the instant of the highest pressure of the first, and that time [s]; None without times.

    An instant at which the load jumps stands twice, before and after the jump. Where both contacts have it twice, the
    same one of the two is taken; where one has it once, it is compared with that after the jump.
    """
    if ("time" in first["pressure"].dims) != ("time" in second["pressure"].dims):
        raise InvalidInput(
            "The contacts are of different kinds: one changes in time, the other does not: compare two evolutions, or "
            "a contact with one of the frames."
        )
    if "time" not in first["pressure"].dims:
        return first, second, None
    times = first["time"].values
    number = int(first["pressure"].max(("x", "y")).argmax("time"))
    time, rounding = float(times[number]), 1e-9 * float(np.ptp(times))
    same = np.flatnonzero(np.abs(second["time"].values - time) <= rounding)
    if not len(same):
        raise InvalidInput(
            f"compare.b has no instant at {time:g} s, where the pressure of a is highest: record both at the same "
            "instants."
        )
    later = int(np.count_nonzero(np.abs(times[number + 1 :] - time) <= rounding))
    at = int(same[max(len(same) - 1 - later, 0)])
    return first.isel(time=number), second.isel(time=at), time


def _edges(dataset: xr.Dataset, axis: str) -> Array:
    """Return the edges of the cells along an axis; those of a single cell, whose size is unknown, are -0.5 and 0.5."""
    centres = dataset[axis].values
    if len(centres) > 1:
        step = float(centres[-1] - centres[0]) / (len(centres) - 1)
        return np.asarray(centres[0] + step * (np.arange(len(centres) + 1) - 0.5))
    return np.array([-0.5, 0.5])


def _one_period(first: xr.Dataset, second: xr.Dataset, a: Array, b: Array) -> tuple[Array, Array]:
    """Return the edges `a` and `b` of the cells along y; a contact of one cell there takes the period of the other."""
    if first.sizes["y"] == 1:
        a = np.array([b[0], b[-1]])
    if second.sizes["y"] == 1:
        b = np.array([a[0], a[-1]])
    lengths = a[-1] - a[0], b[-1] - b[0]
    if abs(lengths[1] / lengths[0] - 1) > SAME_PERIOD:
        raise InvalidInput(
            f"The contacts have the periods {readable(lengths[0])} and {readable(lengths[1])}: compare contacts of "
            "the same period."
        )
    return a, b


def _merged_edges(a: Array, b: Array) -> Array:
    """Return the edges `a` and `b` of both grids together, ascending; of those that differ by rounding, one."""
    edges = np.unique(np.concatenate([a, b]))
    is_separate = np.diff(edges) > ROUNDING * (edges[-1] - edges[0])
    return np.asarray(edges[np.concatenate([[True], is_separate])])


def _resampled(pressure: Array, x: Array, y: Array, to_x: Array, to_y: Array) -> Array:
    """Return a `pressure` from cells with the edges `x` and `y` on finer ones with other edges; 0 beyond its grid."""
    cells = (np.searchsorted(edges, (to[1:] + to[:-1]) / 2) for edges, to in ((x, to_x), (y, to_y)))
    return np.asarray(np.pad(pressure, 1)[np.ix_(*cells)])  # with a border of cells without pressure


def _sums_over_larger_cells(values: Array, edges: Array, a: Array, b: Array, axis: int = 0) -> Array:
    """Return the sums of `values` on fine cells over the larger cells of two grids, and over what lies beyond these.

    The fine cells have the `edges` along the `axis`, those of both grids the edges `a` and `b`.
    """
    larger = a if np.diff(a).max() >= np.diff(b).max() else b
    cells = np.searchsorted(larger, (edges[1:] + edges[:-1]) / 2)
    return np.asarray(np.add.reduceat(values, np.flatnonzero(np.diff(cells, prepend=-1)), axis=axis))
