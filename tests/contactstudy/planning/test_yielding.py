"""What a plan says of bodies that yield, by the measured laws that its source states."""

from dataclasses import replace

import pytest

import contactstudy as cs
from contactstudy.planning.in_time import Yielding, yielding
from tests.conftest import STEEL, LineContact

# Hertz's peak pressure is four times the yield stress, the half-width one unit; both bodies yield.
TWO = Yielding(ratio=4.0, half_width=1.0, bodies=2)
GRID = cs.Grid((64, 1), (8.0, 1.0))


def test_the_zone_grows_with_the_square_of_the_ratio_and_gets_a_quarter_more_room() -> None:
    assert TWO.reach == pytest.approx(1.25 * (0.62 + 0.07 * 16))
    assert replace(TWO, half_width=2.0).reach == pytest.approx(2 * TWO.reach)


def test_the_volume_spans_the_zone_and_goes_down_to_its_depth() -> None:
    volume = TWO.volume(GRID)
    # 2.175 half-widths of eight cells each, on both sides
    assert (volume.first, volume.last) == (32 - 17, 32 + 17)
    assert volume.edges[0] == 0
    # down to 1.2 times 4, less one, and one layer more
    assert volume.edges[-3] < 3.8 <= volume.edges[-2]
    shallow = replace(TWO, ratio=1.0).volume(GRID)
    assert shallow.edges[-3] < 1.0 <= shallow.edges[-2]
    # no wider than the grid
    narrow = TWO.volume(cs.Grid((16, 1), (2.0, 1.0)))
    assert (narrow.first, narrow.last) == (0, 16)


def test_steps_and_cells_follow_their_laws() -> None:
    # 0.09 (4/3)^3 / error steps, 2.5 solves each, and 18 more
    assert TWO.steps(0.01) == round(18 + 2.5 * 0.09 * (4 / 3) ** 3 / 0.01)
    assert TWO.cells_error == pytest.approx((4 / 3) ** 1.5)
    assert replace(TWO, ratio=2.0).cells_error == 1.0


def test_a_step_costs_120_solves_or_nine_a_layer_where_strain_varies_along() -> None:
    along = cs.Grid((64, 8), (8.0, 1.0))
    layers = len(TWO.volume(along).edges) - 1
    assert TWO.contacts(GRID) == 120
    assert TWO.contacts(along) == 9 * layers


def test_memory_is_that_of_the_waves_operators_and_of_the_fields() -> None:
    """Of each body: 3 x 3 components of each pair of layers for half of the waves and one; 24 times 3 fields."""
    layers = len(TWO.volume(GRID).edges) - 1
    across = 34
    assert TWO.bytes(GRID) == 2 * 8 * (35 * (3 * layers) ** 2 + 24 * 3 * layers * across)
    along = cs.Grid((64, 8), (8.0, 1.0))
    assert TWO.bytes(along) == 2 * 8 * 36 * 5 * layers * across * 8


def test_the_body_that_yields_first_counts_and_both_take_memory(
    line_contact: LineContact,
) -> None:
    highest = line_contact.hertz.peak_pressure
    soft, hard = (
        cs.ElasticPlasticHalfSpace(STEEL.youngs_modulus, STEEL.poisson_ratio, highest / ratio, 1e9)
        for ratio in (3.0, 2.0)
    )
    found = yielding(replace(line_contact.scene, solids=(hard, soft)))
    assert found is not None
    assert found.ratio == pytest.approx(3)
    assert found.half_width == pytest.approx(line_contact.hertz.half_width)
    assert found.bodies == 2
    one = yielding(replace(line_contact.scene, solids=(STEEL, hard)))
    assert one is not None
    assert (round(one.ratio, 9), one.bodies) == (2, 1)
    assert yielding(line_contact.scene) is None
    assert "2 times the lowest yield stress" in one.reason(line_contact.grid(64, 2.4, 6.0))
