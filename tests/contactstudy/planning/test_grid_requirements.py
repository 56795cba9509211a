from dataclasses import replace
from math import acosh, inf, pi, sqrt
from typing import Any

import pytest

import contactstudy as cs
from contactstudy.analytic import HertzLine
from contactstudy.planning.grid_requirements import GridRequirements, grid_requirements
from contactstudy.scene.shapes.shape import LengthScales
from tests.conftest import LineContact


def width(scene: cs.Scene, contact: LineContact) -> float:
    """Half-width that is expected of the contact, over that of Hertz."""
    return grid_requirements(scene).half_width / contact.hertz.half_width


def test_a_wave_may_touch_out_to_where_hertz_s_gap_is_as_high(line_contact: LineContact) -> None:
    """Beside the contact the gap is ``a^2 / 2R (t sqrt(t^2 - 1) - acosh t)`` (Johnson 1985, sect. 4.2)."""
    a, radius = line_contact.hertz.half_width, 0.01
    height = a**2 / (2 * radius) * (2 * sqrt(3) - acosh(2))
    scene = line_contact.with_shapes(cs.Waviness(height, along=a))
    assert width(line_contact.scene, line_contact) == pytest.approx(1, rel=1e-12)
    assert width(scene, line_contact) == pytest.approx(2, rel=1e-9)


def test_what_yields_needs_room_for_the_load(line_contact: LineContact) -> None:
    """Under a hardness of p_H / 4 the load, pi a p_H / 2, needs a half-width of pi a."""
    soft = replace(line_contact.scene, hardness=line_contact.hertz.peak_pressure / 4)
    assert width(soft, line_contact) == pytest.approx(pi, rel=1e-12)


# Half-width 2 m, peak pressure 100 Pa; beside the contact the gap grows by 0.2 m times a function of x / a.
HERTZ = HertzLine(100 * pi, 10.0, 1000.0)


def requirements(*length_scales: LengthScales, hardness: float = inf, **more: Any) -> GridRequirements:
    return GridRequirements(HERTZ, length_scales, hardness, **more)


WAVES = LengthScales(shortest_wavelengths=(inf, 0.2))


def test_a_period_is_checked_against_what_it_has_to_hold() -> None:
    waves = requirements(replace(WAVES, period=0.25, longest_wavelength=0.125))
    assert waves.period_fault(0.5) == ""
    assert "not a multiple of 250 mm" in waves.period_fault(0.6)
    short = "is only 2 longest wavelengths (125 mm) long, too short to be representative: give 500 mm"
    assert short in waves.period_fault(0.25)
    rough = requirements(replace(WAVES, longest_wavelength=0.25))
    for fraction, enough in ((1, True), (1 - 0.5e-9, True), (1 - 1.5e-9, False), (0.5, False)):
        assert (rough.period_fault(fraction) == "") == enough
    assert requirements(LengthScales()).period_fault(0.1) == ""
    roller = requirements(LengthScales(roller=0.5))
    assert roller.period_fault(0.5) == ""
    assert "shorter than the roller" in roller.period_fault(0.4)
    assert roller.warnings(cs.Grid((64, 64), (8.0, 0.4)))[-1] == roller.period_fault(0.4)
    with pytest.raises(cs.InvalidInput, match="share no period"):
        requirements(replace(WAVES, period=0.25), replace(WAVES, period=0.25 * pi)).length(None, 1.0)
