"""What shapes ask of a grid, of scales that are written here."""

from dataclasses import replace
from math import acosh, inf, pi, sqrt
from types import SimpleNamespace
from typing import Any

import pytest

import contactstudy as cs
from contactstudy.analytic import HertzLine
from contactstudy.planning.grid_requirements import (
    GridRequirements,
    _cells_per_wave,
    _common_period,
)
from contactstudy.scene.shapes.shape import Detail

# Half-width 2 m, peak pressure 100 Pa; beside the contact the gap grows by 0.2 m times a function of x / a.
HERTZ = HertzLine(100 * pi, 10.0, 1000.0)
FINE = Detail(finest=(0.5, 0.25), longest=1.0, height=0.3, slope=0.3, widest=12.0)
COARSE = Detail(finest=(0.3, 0.6), longest=0.75, height=0.1, slope=0.4, widest=9.0)


def requirements(*details: Detail, hardness: float = inf, **more: Any) -> GridRequirements:
    return GridRequirements(HERTZ, details, hardness, **more)


BOTH, SMOOTH = requirements(FINE, COARSE), requirements(Detail())


@pytest.mark.parametrize("t", [1.5, 10.0])
def test_the_contact_may_end_where_hertz_s_gap_is_as_high_as_the_highest(t: float) -> None:
    height = 0.2 * (t * sqrt(t**2 - 1) - acosh(t))
    assert requirements(Detail(height=height)).half_width == pytest.approx(2 * t)


def test_a_measured_surface_is_put_on_its_own_points() -> None:
    """A contact 9.6 m wide with its room, on points 0.5 m and 0.25 m apart."""
    spaced = Detail(finest=(1.0, 0.5), repeat=12.0, widest=20.0, spacing=(0.5, 0.25))
    asked = requirements(spaced)
    grid = asked.grid_of_points(None)
    assert grid.cell == pytest.approx((0.5, 0.25))
    assert grid.extent[0] >= 2 * 1.2 * asked.half_width > grid.extent[0] - 0.5
    assert grid.period == 12.0
    # no wider than the surface
    narrow = requirements(replace(spaced, widest=2.0)).grid_of_points(None)
    assert narrow.cells == (4, 48)


def test_a_grid_is_no_wider_than_the_surface_is_known() -> None:
    assert requirements(Detail(widest=4.0)).grid(0.1, None).extent[0] == 4
    assert requirements(Detail(widest=4.9)).grid(0.1, None).extent[0] == pytest.approx(4.8)


WAVES = Detail(finest=(inf, 0.2))


@pytest.mark.parametrize(
    ("details", "period"),
    [
        ((Detail(),), 4.8),
        ((Detail(roller=3.0), WAVES), 3.0),
        # four of the longest, in whole numbers of what repeats
        ((replace(WAVES, repeat=0.5, longest=0.75),), 3.0),
        ((replace(WAVES, repeat=0.5, longest=0.7),), 3.0),
        ((replace(WAVES, repeat=0.5), replace(WAVES, repeat=0.75, longest=0.75)), 3.0),
        ((replace(WAVES, repeat=0.5),), 0.5),
        # without any, of a quarter of the width or of the longest
        ((replace(WAVES, longest=1.0),), 4.8),
        ((replace(WAVES, longest=10.0),), 40.0),
    ],
)
def test_a_period_holds_four_of_the_longest_and_whole_numbers_of_what_repeats(
    details: tuple[Detail, ...], period: float
) -> None:
    assert requirements(*details).length(None, 4.8) == pytest.approx(period)
    assert requirements(*details).length(7.0, 4.8) == 7


def test_a_period_is_checked_against_what_it_has_to_hold() -> None:
    waves = requirements(replace(WAVES, repeat=0.25, longest=0.125))
    assert "holds what repeats" in waves.period_check(0.5)
    assert "no whole number of 0.25 m" in waves.period_check(0.6)
    assert "holds 2 of the longest wavelength 0.125 m: give 0.5 m" in waves.period_check(0.25)
    rough = requirements(replace(WAVES, longest=0.25))
    for share, enough in ((1, True), (1 - 0.5e-9, True), (1 - 1.5e-9, False), (0.5, False)):
        assert ("holds what repeats" in rough.period_check(share)) == enough
    assert "any period" in SMOOTH.period_check(0.1)
    assert "from end to end 0.5 m" in requirements(Detail(roller=0.5)).period_check(0.5)


def test_reasons_count_cells_in_half_widths_and_waves_and_say_the_dimension() -> None:
    grid = cs.Grid((64, 32), (8.0, 4.0))
    _, cells, dimension, padding = BOTH.reasons(grid, 0.1)
    assert "64 x 32 cells: 16 in a half-width, 2 in the finest wavelength, for" in cells
    assert dimension.startswith("dimension 2: the gap varies")
    assert padding.startswith("padding exact")
    _, cells, dimension, _ = SMOOTH.reasons(cs.Grid((64, 2), (8.0, 4.0)), 0.1)
    assert "16 in a half-width, for" in cells
    assert dimension.startswith("dimension 2: as asked")
    assert SMOOTH.reasons(cs.Grid((64, 1), (8.0, 4.0)), 0.1)[2].startswith("dimension 1")
    assert requirements(Detail(roller=3.0)).reasons(grid, 0.1)[3].startswith("padding zero")


def coat(stiffer: float) -> Any:
    """Of 0.4 m, so many times as stiff as a substrate of 50 Pa."""
    return SimpleNamespace(
        thickness=0.4,
        compliance=1 / (50 * stiffer),
        compliance_at=lambda half_width: half_width / 200,
        substrate=SimpleNamespace(compliance=1 / 50),
    )


def test_a_coat_is_felt_as_a_modulus_between_its_own_and_the_substrate_s() -> None:
    said = requirements(coatings=(coat(4.0),)).reasons(cs.Grid((80, 1), (8.0, 4.0)), 0.1)[4]
    assert "coating 0.4 m: 0.2 half-widths and 4 cells across thick" in said
    assert "about 100 Pa, between 200 Pa of the coating and 50 Pa" in said


@pytest.mark.parametrize(
    ("stiffer", "cells", "warned"),
    [(4.0, 40, False), (4.0, 39, True), (2.0, 10, False), (2.1, 10, True), (0.25, 10, False)],
)
def test_a_coat_more_than_twice_as_stiff_needs_two_cells(
    stiffer: float,
    cells: int,
    warned: bool,  # noqa: FBT001
) -> None:
    posed = replace(requirements(coatings=(coat(stiffer),)), hertz=THICK)
    said = posed.warnings(cs.Grid((cells, 1), (8.0, 4.0)))
    assert len(said) == warned
    assert all("give 40 for a bound" in one for one in said)


# As wide as a tenth of the radius.
THICK: Any = SimpleNamespace(half_width=2.0, radius=20.0)


def test_a_contact_wider_than_a_tenth_of_the_radius_is_not_one_of_half_spaces() -> None:
    grid = cs.Grid((64, 1), (8.0, 4.0))
    assert GridRequirements(THICK, (), inf).warnings(grid) == ()
    wider: Any = SimpleNamespace(half_width=2.01, radius=20.0)
    (said,) = GridRequirements(wider, (), inf).warnings(grid)
    assert "too large a fraction for half-spaces" in said


def test_a_wave_needs_two_cells_along_each_axis() -> None:
    waves = GridRequirements(THICK, (Detail(finest=(0.5, 0.25)),), inf)
    assert waves.warnings(cs.Grid((32, 32), (8.0, 4.0))) == ()
    (said,) = waves.warnings(cs.Grid((31, 32), (8.0, 4.0)))
    assert said.startswith("Grid.cells[0] is 31")
    assert "give 32 or more" in said
    (said,) = waves.warnings(cs.Grid((32, 31), (8.0, 4.0)))
    assert said.startswith("Grid.cells[1] is 31")
    assert _cells_per_wave(cs.Grid((64, 32), (8.0, 4.0)), (0.5, 0.25)) == 2
    assert _cells_per_wave(cs.Grid((32, 64), (8.0, 4.0)), (0.5, 0.25)) == 2
    odd = replace(waves, details=(replace(WAVES, repeat=0.3),))
    assert ": give a multiple" in odd.warnings(cs.Grid((32, 64), (8.0, 4.0)))[0]


def test_lengths_share_the_shortest_that_is_a_whole_number_of_each() -> None:
    assert _common_period({0.5, 0.75}) == 1.5
    assert _common_period({2.0, 3.0, 5.0}) == 30
    # ratios of numbers up to 64
    assert _common_period({1.0, 65 / 64}) == 65
    with pytest.raises(cs.InvalidInput, match="share no period"):
        _common_period({1.0, 66 / 65})
