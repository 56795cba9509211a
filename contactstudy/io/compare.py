"""Two contacts on two grids: by how much they differ, and where."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from contactstudy.domain.checks import InvalidInput
from contactstudy.domain.fields import Array
from contactstudy.domain.imports import presentation
from contactstudy.solvers.solution import Solution

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, eq=False)
class Comparison:
    """How the contact b differs from a; relative to a.

    ``l1``: ``sum |p_b - p_a| / sum p_a`` over areas; ``peak_pressure``, ``contact_area`` and ``load``:
    ``b / a - 1``; ``approach`` [m]: ``b - a``, if both count from one place, as they do on one grid with one load.
    ``largest`` [Pa] is the largest ``|p_b - p_a|``, ``at`` (x, y) [m] where it is. ``difference`` has the pressures
    ``a``, ``b`` and ``b - a`` (x, y) [Pa] on the cells that the edges of both grids make.
    """

    l1: float
    peak_pressure: float
    contact_area: float
    load: float
    approach: float
    largest: float
    at: tuple[float, float]
    difference: xr.Dataset

    def __str__(self) -> str:
        x, y = self.at
        return "\n".join(
            (
                f"pressure in L1: {self.l1:.3g} of all pressure",
                f"peak pressure: {self.peak_pressure:+.3g} of it",
                f"contact area: {self.contact_area:+.3g} of it",
                f"load: {self.load:+.3g} of it",
                f"approach: {self.approach:+.4g} m",
                f"largest difference: {self.largest:.4g} Pa at x = {x:.4g} m, y = {y:.4g} m",
            )
        )

    def plot(self) -> "Figure":
        """The difference as a map, and both pressures across the place where it is largest."""
        figure: Figure = presentation("Comparison.plot")(self)
        return figure


def compare(a: Solution | xr.Dataset, b: Solution | xr.Dataset) -> Comparison:
    """How ``b`` differs from ``a``: solutions, or their datasets, on any two grids of one period.

    Pressures are constant in each cell, so that all integrals over both grids are exact; beyond the width of
    a grid there is no pressure. A contact of one cell along the length is the same at any period. Raises
    :class:`~contactstudy.InvalidInput` for two periods, and for a dataset that is of no contact.
    """
    first, second = _labelled("a", a), _labelled("b", b)
    edges = []
    for axis in ("x", "y"):
        ours, theirs = _edges(first, axis), _edges(second, axis)
        if axis == "y":
            ours, theirs = _one_period(first, second, ours, theirs)
        edges.append((ours, theirs, _union(ours, theirs)))
    (x_a, x_b, x), (y_a, y_b, y) = edges
    p_a = _on(first["pressure"].values, x_a, y_a, x, y)
    p_b = _on(second["pressure"].values, x_b, y_b, x, y)
    area = np.diff(x)[:, None] * np.diff(y)[None, :]
    total = float((p_a * area).sum())
    if not total:
        raise InvalidInput(
            "compare.a has no pressure anywhere: give a contact that carries a load."
        )
    change = p_b - p_a
    centres = (x[1:] + x[:-1]) / 2, (y[1:] + y[:-1]) / 2
    place = np.unravel_index(int(np.abs(change).argmax()), change.shape)
    touching = [float(((p > 0) * area).sum()) for p in (p_a, p_b)]
    labels = {"units": "Pa"}
    difference = xr.Dataset(
        {
            "a": (("x", "y"), p_a, labels | {"long_name": "pressure of a"}),
            "b": (("x", "y"), p_b, labels | {"long_name": "pressure of b"}),
            "difference": (
                ("x", "y"),
                change,
                labels | {"long_name": "pressure of b less that of a"},
            ),
        },
        {"x": ("x", centres[0], first["x"].attrs), "y": ("y", centres[1], first["y"].attrs)},
    )
    return Comparison(
        l1=float((np.abs(change) * area).sum()) / total,
        peak_pressure=float(p_b.max() / p_a.max() - 1),
        contact_area=touching[1] / touching[0] - 1,
        load=float((p_b * area).sum()) / total - 1,
        approach=float(second["approach"] - first["approach"]),
        largest=float(np.abs(change[place])),
        at=(float(centres[0][place[0]]), float(centres[1][place[1]])),
        difference=difference,
    )


def _labelled(name: str, one: Any) -> xr.Dataset:
    if isinstance(one, Solution):
        return one.to_dataset()
    if (
        not isinstance(one, xr.Dataset)
        or "pressure" not in one
        or one["pressure"].dims != ("x", "y")
    ):
        raise InvalidInput(
            f"compare.{name} is {type(one).__name__} without a pressure over (x, y): give a Solution or its "
            "dataset."
        )
    return one


def _edges(dataset: xr.Dataset, axis: str) -> Array:
    """Of the cells whose centres the dataset has; one cell alone along the length has the period of the file."""
    centres = dataset[axis].values
    if len(centres) > 1:
        step = float(centres[-1] - centres[0]) / (len(centres) - 1)
        return np.asarray(centres[0] + step * (np.arange(len(centres) + 1) - 0.5))
    return np.array([-0.5, 0.5])


def _one_period(first: xr.Dataset, second: xr.Dataset, a: Array, b: Array) -> tuple[Array, Array]:
    if first.sizes["y"] == 1:
        a = np.array([b[0], b[-1]])
    if second.sizes["y"] == 1:
        b = np.array([a[0], a[-1]])
    lengths = a[-1] - a[0], b[-1] - b[0]
    if abs(lengths[1] / lengths[0] - 1) > 1e-6:
        raise InvalidInput(
            f"The contacts have the periods {lengths[0]:.4g} m and {lengths[1]:.4g} m: compare contacts of one period."
        )
    return a, b


def _union(a: Array, b: Array) -> Array:
    """The edges of both, where those that differ in rounding are one."""
    edges = np.unique(np.concatenate([a, b]))
    near = np.diff(edges) > 1e-9 * (edges[-1] - edges[0])
    return np.asarray(edges[np.concatenate([[True], near])])


def _on(pressure: Array, x: Array, y: Array, to_x: Array, to_y: Array) -> Array:
    """``pressure`` on finer cells: that of the cell around each centre, nothing beyond the grid."""
    rows, row_is_there = _places(x, to_x)
    columns, column_is_there = _places(y, to_y)
    there = row_is_there[:, None] & column_is_there[None, :]
    return np.where(there, pressure[np.ix_(rows, columns)], 0.0)


def _places(edges: Array, finer: Array) -> tuple[np.ndarray, np.ndarray]:
    centres = (finer[1:] + finer[:-1]) / 2
    places = np.searchsorted(edges, centres) - 1
    there = (places >= 0) & (places < len(edges) - 1)
    return np.clip(places, 0, len(edges) - 2), there
