"""What a drawing plots and says, for tests that compare it with numbers written by hand."""

from collections.abc import Mapping
from math import prod
from typing import Any

import numpy as np
import pytest
import xarray as xr
from matplotlib.axes import Axes

from studies.model.drawing import Row
from studies.registry import load_drawing

# Width and height [inch] of figures: the columns and rows of their panels, each of a size in which its labels fit.
SIZES = {
    ("effect_cost", 0): (7.2, 4.4),
    ("grid", 0): (8.8, 4.4),
    ("images", 0): (10.2, 2.9),
    ("images", 1): (6.0, 3.0),
    ("kernels", 0): (10.2, 2.9),
    ("kernels", 1): (6.0, 3.0),
    ("padding", 0): (8.8, 3.6),
    ("padding", 1): (6.0, 3.4),
    ("paper", 0): (8.4, 3.2),
    ("paper", 1): (9.2, 3.2),
    ("peers", 0): (6.8, 3.2),
    ("period", 0): (8.8, 2.9),
    ("plastic", 0): (8.0, 8.1),
    ("roughness", 0): (7.2, 8.1),
    ("roughness", 1): (8.4, 4.0),
    ("roughness", 2): (7.2, 2.9),
    ("solvers", 0): (10.2, 3.2),
    ("speed", 0): (10.2, 3.2),
    ("stability", 0): (8.5, 2.1),
}


def numbered(axes: Mapping[str, Any], *variables: str) -> xr.Dataset:
    """Variables over all the axes; every number is another one."""
    shape = tuple(len(values) for values in axes.values())
    count = prod(shape)
    return xr.Dataset(
        {
            name: (
                tuple(axes),
                1e-4 * (1 + np.arange(n * count, (n + 1) * count)).reshape(shape),
            )
            for n, name in enumerate(variables)
        },
        coords={name: list(values) for name, values in axes.items()},
    )


def panels(name: str, dataset: xr.Dataset, figure: int = 0) -> list[Axes]:
    shown = load_drawing(name).figure(dataset)[figure].figure
    assert shown.get_size_inches() == pytest.approx(SIZES[name, figure])
    return shown.axes


def curves(ax: Axes) -> list[np.ndarray]:
    """x and y of every line, in the order in which they are drawn."""
    return [np.asarray(line.get_xydata(), dtype=float).T for line in ax.lines]


def labelled(ax: Axes) -> dict[str, np.ndarray]:
    """x and y of the lines that have a label."""
    return {
        str(line.get_label()): np.asarray(line.get_xydata(), dtype=float).T
        for line in ax.lines
        if not str(line.get_label()).startswith("_")
    }


def bands(ax: Axes) -> list[np.ndarray]:
    """Lowest and highest y of every filled area, at each of its x."""
    found = []
    for area in ax.collections:
        points = np.concatenate([np.asarray(path.vertices) for path in area.get_paths()])
        ends = [points[points[:, 0] == x, 1] for x in np.unique(points[:, 0])]
        found.append(np.array([[some.min() for some in ends], [some.max() for some in ends]]))
    return found


def named(ax: Axes) -> tuple[str, str, str]:
    """What stands at x, at y and above a panel."""
    return ax.get_xlabel(), ax.get_ylabel(), ax.get_title() or ax.get_title(loc="right")


def same(found: object, x: object, y: object) -> bool:
    """Whether a line has these x and y, to rounding."""
    wanted = np.array([x, y], dtype=float)
    return bool(np.shape(found) == wanted.shape and found == pytest.approx(wanted, rel=1e-9))


def words(text: str) -> str:
    """A text with spaces that may break."""
    return text.replace("\u00a0", " ")


def caption(name: str, dataset: xr.Dataset, figure: int = 0) -> str:
    return words(load_drawing(name).figure(dataset)[figure].caption)


def findings(name: str, dataset: xr.Dataset) -> list[str]:
    """Claim and measurement of each."""
    return [words(f"{one.claim} {one.measured}") for one in load_drawing(name).findings(dataset)]


def rows(name: str, dataset: xr.Dataset, table: int = 0) -> list[Row]:
    return [
        tuple(words(cell) for cell in row) for row in load_drawing(name).tables(dataset)[table].rows
    ]
