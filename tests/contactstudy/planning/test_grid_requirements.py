"""What a plan asks of a grid, by hand."""

from dataclasses import replace
from math import acosh, inf, pi, sqrt

import pytest

import contactstudy as cs
from contactstudy.planning.grid_requirements import requirements_of
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
