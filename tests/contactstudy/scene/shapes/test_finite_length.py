from dataclasses import replace

import numpy as np
import pytest

import contactstudy as cs
from tests.conftest import LineContact

FREE = (cs.ZeroPadding(), cs.ZeroPadding())


def solved(contact: LineContact, cells: int, period: float, *more: cs.Shape) -> cs.Solution:
    """A roller 8 half-widths long under a load that is the same in all."""
    load = cs.LineLoad(contact.scene.load.per_length * 8 / period)
    scene = replace(contact.scene, load=load, shapes=contact.scene.shapes + more)
    grid = contact.grid((32, cells), period, width=3.0)
    return cs.solve(scene.problem(grid, FREE), tolerance=1e-9)


def test_a_roller_longer_than_the_grid_has_no_end(line_contact: LineContact) -> None:
    length = 8 * line_contact.hertz.half_width
    ended = solved(line_contact, 64, 8.0, cs.FiniteLength(length))
    np.testing.assert_array_equal(ended.pressure, solved(line_contact, 64, 8.0).pressure)


def test_a_roller_ends_in_the_middle_of_a_grid_as_at_the_end_of_one(
    line_contact: LineContact,
) -> None:
    """Both stop at a residual of 1e-9, whose error is no more than its root."""
    length = 8 * line_contact.hertz.half_width
    own = solved(line_contact, 64, 8.0)
    longer = solved(line_contact, 96, 12.0, cs.FiniteLength(length))
    assert longer.status is cs.Status.CONVERGED
    assert not longer.pressure[:, :16].any()
    assert not longer.pressure[:, -16:].any()
    np.testing.assert_allclose(
        longer.pressure[:, 16:-16], own.pressure, rtol=0, atol=3e-5 * own.pressure.max()
    )


def test_an_end_inside_a_cell_goes_by_its_centre() -> None:
    grid = cs.Grid(cells=(4, 10), extent=(1e-3, 1e-2))
    gap = cs.FiniteLength(6.2e-3).gap(grid)
    assert gap.shape == (1, 10)
    assert (gap[0] == 0).tolist() == [False] * 2 + [True] * 6 + [False] * 2


def test_the_mean_gap_is_that_of_the_roller_and_not_of_the_grid_beyond_its_ends(
    line_contact: LineContact,
) -> None:
    """Also where the ends lie inside cells: the grid of 12 half-widths has cells of 0.125 and 0.1263 half-widths."""
    length = 8 * line_contact.hertz.half_width
    own = solved(line_contact, 64, 8.0).mean_gap
    assert solved(line_contact, 96, 12.0, cs.FiniteLength(length)).mean_gap == pytest.approx(
        own, rel=1e-4
    )
    divided = solved(line_contact, 95, 12.0, cs.FiniteLength(length))
    assert divided.problem.row_lengths is not None
    assert divided.problem.row_lengths.sum() * 12 / 95 == pytest.approx(8)
    # the pressure ends at the border of a cell, up to half a cell from the end
    assert divided.mean_gap == pytest.approx(own, rel=0.126 / 8)
    # the rows beyond the ends are recessed by the roller's length
    assert divided.gap.mean() > 100 * own


@pytest.mark.parametrize("length", [0.0, -1.0, np.nan, np.inf])
def test_a_length_that_cannot_be_is_refused(length: float) -> None:
    with pytest.raises(cs.InvalidInput, match=r"^FiniteLength\.length is .*: give the roller's"):
        cs.FiniteLength(length)
