"""What shapes ask of a grid, of scales that are written here."""

from dataclasses import replace
from math import inf, pi
from types import SimpleNamespace
from typing import Any

import pytest

import contactstudy as cs
from contactstudy.analytic import HertzLine
from contactstudy.planning.grid_requirements import (
    GridRequirements,
    _cells_per_wave,
)
from contactstudy.scene.shapes.shape import Detail

# Half-width 2 m, peak pressure 100 Pa; beside the contact the gap grows by 0.2 m times a function of x / a.
HERTZ = HertzLine(100 * pi, 10.0, 1000.0)
FINE = Detail(finest=(0.5, 0.25), longest=1.0, height=0.3, slope=0.3, widest=12.0)
COARSE = Detail(finest=(0.3, 0.6), longest=0.75, height=0.1, slope=0.4, widest=9.0)


def requirements(*details: Detail, hardness: float = inf, **more: Any) -> GridRequirements:
    return GridRequirements(HERTZ, details, hardness, **more)


BOTH, SMOOTH = requirements(FINE, COARSE), requirements(Detail())


WAVES = Detail(finest=(inf, 0.2))


def test_a_period_is_checked_against_what_it_has_to_hold() -> None:
    waves = requirements(replace(WAVES, repeat=0.25, longest=0.125))
    assert "holds what repeats" in waves.period_check(0.5)
    assert "no whole number of 0.25 m" in waves.period_check(0.6)
    assert "holds 2 of the longest wavelength 0.125 m: give 0.5 m" in waves.period_check(0.25)
    rough = requirements(replace(WAVES, longest=0.25))
    for fraction, enough in ((1, True), (1 - 0.5e-9, True), (1 - 1.5e-9, False), (0.5, False)):
        assert ("holds what repeats" in rough.period_check(fraction)) == enough
    assert "any period" in SMOOTH.period_check(0.1)
    assert "from end to end 0.5 m" in requirements(Detail(roller=0.5)).period_check(0.5)


def coat(stiffer: float) -> Any:
    """Of 0.4 m, so many times as stiff as a substrate of 50 Pa."""
    return SimpleNamespace(
        thickness=0.4,
        compliance=1 / (50 * stiffer),
        compliance_at=lambda half_width: half_width / 200,
        substrate=SimpleNamespace(compliance=1 / 50),
    )


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
