"""What a plan asks of a grid, by hand."""

from dataclasses import replace
from math import acosh, erf, inf, pi, sqrt

import pytest

import contactstudy as cs
from contactstudy.accuracy.expected_error import smooth_l1
from contactstudy.planning.grid_requirements import ROUGH, requirements_of
from tests.conftest import LineContact


def with_shapes(contact: LineContact, *shapes: cs.Shape) -> cs.Scene:
    return replace(contact.scene, shapes=(*contact.scene.shapes, *shapes))


def width(scene: cs.Scene, contact: LineContact) -> float:
    """Half-width that is expected of the contact, over that of Hertz."""
    return requirements_of(scene).half_width / contact.hertz.half_width


def test_a_smooth_contact_is_as_wide_as_hertz_s(line_contact: LineContact) -> None:
    assert width(line_contact.scene, line_contact) == pytest.approx(1, rel=1e-12)


def test_a_wave_may_touch_out_to_where_hertz_s_gap_is_as_high(line_contact: LineContact) -> None:
    """Beside the contact the gap is ``a^2 / 2R (t sqrt(t^2 - 1) - acosh t)`` (Johnson 1985, sect. 4.2)."""
    a, radius = line_contact.hertz.half_width, 0.01
    height = a**2 / (2 * radius) * (2 * sqrt(3) - acosh(2))
    scene = with_shapes(line_contact, cs.Waviness(height, along=a))
    assert width(scene, line_contact) == pytest.approx(2, rel=1e-9)


def test_a_roller_is_given_half_as_much_again(line_contact: LineContact) -> None:
    """Its middle or its ends bear more than the mean; small solutions then show how much of that it needs."""
    scene = with_shapes(line_contact, cs.FiniteLength(10 * line_contact.hertz.half_width))
    requirements = requirements_of(scene)
    assert requirements.half_width == pytest.approx(1.5 * line_contact.hertz.half_width, rel=1e-12)
    plan = cs.plan(scene, error=0.1)
    assert plan.grid.period == pytest.approx(10 * line_contact.hertz.half_width)


def test_what_yields_needs_room_for_the_load(line_contact: LineContact) -> None:
    """Under a hardness of p_H / 4 the load, pi a p_H / 2, needs a half-width of pi a."""
    soft = replace(line_contact.scene, hardness=line_contact.hertz.peak_pressure / 4)
    assert width(soft, line_contact) == pytest.approx(pi, rel=1e-12)


def test_a_smooth_contact_s_error_follows_the_measured_law(line_contact: LineContact) -> None:
    """0.446 (cell / a)^1.5 + 0.1 (cell / a)^2."""
    requirements, a = requirements_of(line_contact.scene), line_contact.hertz.half_width
    for cell in (0.1, 0.01):
        error = requirements.error((cell * a, a))
        assert error == pytest.approx(0.446 * cell**1.5 + 0.1 * cell**2, rel=1e-2)


def test_a_wave_s_error_is_that_of_its_share_in_contact(line_contact: LineContact) -> None:
    """Persson's share of area for the rms slope ``sqrt 2 pi A / wavelength``, to the power -0.65."""
    a = line_contact.hertz.half_width
    amplitude = 3e-7
    scene = with_shapes(line_contact, cs.Waviness(amplitude, along=a / 2))
    grid = cs.Grid((64, 32), (2.4 * a, a))
    slope = sqrt(2) * pi * amplitude / (a / 2)
    mean = pi / 4 * line_contact.hertz.peak_pressure / line_contact.scene.contact_modulus
    share = erf(sqrt(2) * mean / slope)
    assert 0.1 < share < 0.99
    # 16 cells along in a wave, 64 / 2.4 across in a half-width
    expected = smooth_l1(2.4 / 64) + ROUGH * share**-0.65 * (1 / 16) ** 1.5
    assert requirements_of(scene).error(grid.cell) == pytest.approx(expected, rel=1e-9)


def test_a_period_holds_four_of_the_longest_waves(line_contact: LineContact) -> None:
    a = line_contact.hertz.half_width
    rough = cs.Roughness(1e-8, hurst=0.8, roll_off=a, cut_off=0.3 * a, seed=1)
    plan = cs.plan(with_shapes(line_contact, rough), error=0.1)
    assert plan.grid.period >= 4 * a * (1 - 1e-9)
    wave = cs.Waviness(1e-8, along=0.5 * a)
    assert cs.plan(with_shapes(line_contact, wave), error=0.1).grid.period == pytest.approx(0.5 * a)


def test_what_varies_across_alone_needs_one_cell_along(line_contact: LineContact) -> None:
    a = line_contact.hertz.half_width
    across = cs.Waviness(1e-8, across=0.3 * a, along=inf)
    assert cs.plan(with_shapes(line_contact, across), error=0.1).grid.cells[1] == 1
