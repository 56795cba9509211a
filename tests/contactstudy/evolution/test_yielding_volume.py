"""Which cells may yield, counted by hand."""

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.elasticity.eigenstrain.volume import Volume
from contactstudy.evolution.plastic import (
    embedded,
    layers,
    union,
)

# Cells of 1 m.
GRID = cs.Grid((40, 2), (40.0, 2.0))


def test_two_volumes_are_held_by_one_and_a_field_keeps_its_cells_in_it() -> None:
    flat, deep = (
        Volume(GRID, 10, 20, layers(GRID, 9.0, 2.0)),
        Volume(GRID, 12, 26, layers(GRID, 9.0, 6.0)),
    )
    whole = union(flat, deep)
    assert (whole.first, whole.last, whole.edges) == (10, 26, deep.edges)
    assert union(deep, flat) == whole
    field = 1 + np.arange(5 * 3 * 14 * 2, dtype=float).reshape(5, 3, 14, 2)
    there = embedded(field, 12, whole)
    assert there.shape == (5, *whole.shape)
    assert there[:, :3, 2:16] == pytest.approx(field)
    assert there.sum() == field.sum()
