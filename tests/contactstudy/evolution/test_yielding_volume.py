"""Which cells may yield, counted by hand."""

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.elasticity.eigenstrain.volume import Volume
from contactstudy.evolution.plastic import (
    embedded,
    enlarged,
    first_volume,
    layers,
    union,
)

# Cells of 1 m.
GRID = cs.Grid((40, 2), (40.0, 2.0))


def test_layers_are_as_thick_as_cells_down_to_the_length_and_double_from_there() -> None:
    # 1 m down to 4 m, 2 m down to 12 m, 4 m down to 28 m; one more below the depth
    assert layers(GRID, 4.0, 3.5) == (0, 1, 2, 3, 4, 6)
    assert layers(GRID, 4.0, 13.0) == (0, 1, 2, 3, 4, 6, 8, 10, 12, 16, 20)
    assert layers(GRID, 4.0, 27.0)[-3:] == (24, 28, 36)
    assert layers(GRID, 4.0, 4.0) == (0, 1, 2, 3, 4, 6)
    assert layers(GRID, 4.0, 0.0) == (0, 1)


def pressed(first: int, last: int) -> np.ndarray:
    pressure = np.zeros((40, 2))
    pressure[first:last, 0] = 1.0
    return pressure


def yields_down_to(depth: float, cells: tuple[int, int]):  # noqa: ANN201
    """A share of 2 in these cells of layers that begin above the depth, of 0.5 elsewhere."""

    def share(volume: Volume) -> np.ndarray:
        found = np.full(volume.shape, 0.5)
        deep = np.array(volume.edges[:-1]) < depth
        found[np.ix_(deep, range(*cells), [1])] = 2.0
        return found

    return share


def test_the_first_volume_holds_the_contact_or_what_is_stressed_and_a_sixth_more() -> None:
    """Of eight cells in contact, a first depth of four; 15 % of the width, rounded up, and a cell on each side."""
    narrow = first_volume(GRID, 10.0, pressed(16, 24), yields_down_to(2.0, (18, 22)))
    assert (narrow.first, narrow.last) == (16 - 3, 24 + 3)
    assert narrow.edges == layers(GRID, 10.0, 4.0)
    wide = first_volume(GRID, 10.0, pressed(16, 24), yields_down_to(2.0, (12, 32)))
    assert (wide.first, wide.last) == (12 - 4, 32 + 4)
    # no deeper than the length to begin with, and within the grid
    short = first_volume(GRID, 2.0, pressed(2, 24), yields_down_to(1.0, (4, 8)))
    assert short.edges == layers(GRID, 2.0, 2.0)
    assert (short.first, short.last) == (0, 24 + 5)
    # stress down to 6.5: depths of 4, 5.2, and 6.76, of which the layer below begins at 7
    deep = first_volume(GRID, 10.0, pressed(16, 24), yields_down_to(6.5, (18, 22)))
    assert deep.edges == layers(GRID, 10.0, 4 * 1.3**2)


def test_without_pressure_all_cells_may_yield_and_no_volume_is_deeper_than_the_grid_is_wide() -> (
    None
):
    found = first_volume(GRID, 10.0, np.zeros((40, 2)), yields_down_to(2.0, (18, 22)))
    assert (found.first, found.last) == (0, 40)
    endless = first_volume(GRID, 10.0, pressed(16, 24), yields_down_to(1e9, (18, 22)))
    assert 40 < endless.edges[-1] < 2 * 52


def test_a_volume_is_made_three_tenths_larger_where_it_flows_at_an_end() -> None:
    volume = Volume(GRID, 10, 20, layers(GRID, 10.0, 5.0))
    flows = np.zeros(volume.shape, dtype=bool)
    flows[1, 4, 0] = True
    assert enlarged(volume, 10.0, flows) == volume
    flows[2, 0, 1] = True
    assert (enlarged(volume, 10.0, flows).first, enlarged(volume, 10.0, flows).last) == (7, 20)
    flows[2, -1, 0] = True
    assert (enlarged(volume, 10.0, flows).first, enlarged(volume, 10.0, flows).last) == (7, 23)
    flows[-1, 5, 1] = True
    assert enlarged(volume, 10.0, flows).edges == layers(GRID, 10.0, 1.3 * 6.0)
    # within the grid
    at_ends = Volume(GRID, 1, 39, volume.edges)
    assert (enlarged(at_ends, 10.0, np.ones(at_ends.shape, dtype=bool)).first) == 0
    assert (enlarged(at_ends, 10.0, np.ones(at_ends.shape, dtype=bool)).last) == 40


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
