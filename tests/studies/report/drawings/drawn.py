"""What a drawing plots and says, for tests that compare it with numbers written by hand."""

from collections.abc import Mapping
from math import prod
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from studies.model.drawing import Row
from studies.registry import load_drawing


def numbered(axes: Mapping[str, Any], *variables: str) -> xr.Dataset:
    """Variables over all the axes; no two numbers are the same."""
    shape = tuple(len(values) for values in axes.values())
    count = prod(shape)
    return xr.Dataset(
        {
            name: (tuple(axes), 1e-4 * (1 + np.arange(n * count, (n + 1) * count)).reshape(shape))
            for n, name in enumerate(variables)
        },
        coords={name: list(values) for name, values in axes.items()},
    )


def labelled(ax: Axes) -> dict[str, np.ndarray]:
    """x and y of the lines that have a label."""
    return {
        str(line.get_label()): np.asarray(line.get_xydata(), dtype=float).T
        for line in ax.lines
        if not str(line.get_label()).startswith("_")
    }


def words(text: str) -> str:
    """A text with its non-breaking spaces made plain."""
    return text.replace("\u00a0", " ")


def findings(name: str, dataset: xr.Dataset) -> list[str]:
    """Claim and measurement of each."""
    return [words(f"{one.claim} {one.measured}") for one in load_drawing(name).findings(dataset)]


def rows(name: str, dataset: xr.Dataset, table: int = 0) -> list[Row]:
    return [tuple(words(cell) for cell in row) for row in load_drawing(name).tables(dataset)[table].rows]
